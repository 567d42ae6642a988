//! Both reports say the same of an estimate, reasons say the same in words and in numbers, and what is written is
//! read back.

use serde_json::{Value, json};

use super::*;
use crate::fixture::{FIRST_NS, counts, estimate, scene, sketch};
use crate::motion::{End, Measured, MechanismIndex, Progress, Reason, Stamp};

mod read;

#[test]
fn the_reports_of_a_file_and_of_a_recording_say_the_same_of_the_estimate() {
    let (scene, sketch, counts, estimate) = (scene(), sketch(), counts(), estimate());
    let of = Reported {
        scene: &scene,
        inferred: &[0],
        sketch: &sketch,
        counts: &counts,
        estimate: &estimate,
        verification: None,
        settled: None,
        diagnoses: &[],
        seen: &[],
        freed: &[],
        rest: None,
    };
    let circumstances = Circumstances {
        recording: "in.mcap".to_owned(),
        output: "out.mcap".to_owned(),
        spent: Spent::of(0.1, &[]),
        phase_seconds: Vec::new(),
        ended_early: false,
        lost: Vec::new(),
        warnings: Vec::new(),
    };
    let value = |bytes: &[u8]| -> Value { serde_json::from_slice(bytes).expect("JSON") };
    let shared = value(&super::json(&EstimateReport::new(&of)));
    let file = EstimateMessage::new(&of, Stamp(FIRST_NS), None);
    let recording = RecordingReport::new(&of, circumstances);
    assert!(recording.is_whole());
    let (file, recording) = (value(&super::json(&file)), value(&super::json(&recording)));
    let fields = shared.as_object().expect("an object");
    assert!(fields.len() > 20);
    for (name, field) in fields {
        assert_eq!((&file[name], &recording[name]), (field, field), "{name}");
    }
    // Times: the bounce has a deviation, the landing is fixed; both are determined.
    let events = &shared["events"];
    assert_eq!(events[0]["contact_inferred"], true);
    assert_eq!(events[0]["bodies"], json!(["pencil"]));
    assert_eq!(events[1]["time_sd_s"], Value::Null);
    assert_eq!(events[1]["time_is_determined"], true);
    assert_eq!(shared["undetermined"], json!(["bounce.restitution"]));
}

#[test]
fn reasons_have_words_and_numbers() {
    let scene = scene();
    let measured = |value, bound| Measured { value, bound };
    let progress = Progress {
        violation: measured(2e-12, 1e-9),
        decrease: measured(3e-11, 1e-10),
    };
    let solved = json!([
        ["violation", 2e-12, 1e-9, ""],
        ["decrease", 3e-11, 1e-10, ""]
    ]);
    let numbers = "largest violation 2.0e-12 units, next decrease 3.0e-11 of the objective";
    let reversed = "relax the physics or change the order of collisions";
    let ends = [
        (End::Converged(progress), "converged: ", json!([]), &solved),
        (
            End::Stopped(progress),
            "stopped before it converged: ",
            json!([]),
            &solved,
        ),
        (
            End::NoProgress(progress),
            "no further progress: ",
            json!([]),
            &solved,
        ),
        (
            End::VelocityJumps {
                events: vec![0],
                progress,
            },
            "velocities jump at bounce; converged: ",
            json!(["bounce"]),
            &solved,
        ),
        (
            End::NotFinite,
            "the motion is not finite",
            json!([]),
            &json!([]),
        ),
        (
            End::EventsReversed {
                first: 0,
                last: 1,
                interval_s: -0.5,
            },
            "`landing` would come before `bounce`: ",
            json!(["bounce", "landing"]),
            &json!([["duration", -0.5, 0.0, "s"]]),
        ),
        (
            End::FlightReversed {
                mechanism: MechanismIndex(0),
                start_s: 1.0,
                end_s: 0.75,
            },
            "a flight of `pencil` would end at 0.750 s, before it begins at 1.000 s: ",
            json!(["pencil"]),
            &json!([["duration", -0.25, 0.0, "s"]]),
        ),
    ];
    for (end, words, at, expected) in ends {
        let kind = end.as_str();
        let follows = match (&end, end.progress()) {
            (_, Some(_)) => numbers,
            (End::NotFinite, None) => "",
            (_, None) => reversed,
        };
        let mut reason = Reason::from(end);
        let text = format!("{words}{follows}");
        assert_eq!(reason_text(&scene, &reason), text);
        let line = TerminationLine::new(&scene, &reason);
        let rows = line.measured.iter();
        let rows: Vec<Value> = rows
            .map(|row| json!([row.quantity, row.value, row.bound, row.unit]))
            .collect();
        assert_eq!((line.kind.as_str(), &json!(rows)), (kind, expected));
        assert_eq!(json!(line.at), at, "{kind}");
        assert_eq!(line.time_s.is_some(), kind == "flight_reversed");
        // A search without proof is said before it.
        reason.unproven_after_bounds = Some(7);
        let unproven = "the search ended after 7 bounds: other contacts may fit better; ";
        assert_eq!(reason_text(&scene, &reason), format!("{unproven}{text}"));
        let line = TerminationLine::new(&scene, &reason);
        assert_eq!(line.unproven_after_bounds, Some(7));
        // So are starts that were not tried to their ends.
        reason.unfinished_after_steps = Some(300);
        let unfinished = "the solver ended after 300 steps: with more work another motion may be found that fits better; ";
        assert_eq!(
            reason_text(&scene, &reason),
            format!("{unproven}{unfinished}{text}")
        );
        let line = TerminationLine::new(&scene, &reason);
        assert_eq!(line.unfinished_after_steps, Some(300));
    }
}
