//! `enact mark` from outside, and takes whose marks are absent, too many or far off.

#[allow(dead_code)]
use enact_tools::perform::recording;
use std::process::Output;

use enact::motion::{DropReason, Mark, Stamp, TakeEvent, TrackIndex, Verdict};
use enact::pipeline::{Outcome, Pipeline, PipelineError};
use enact::segment::{propose, refine, relocate_marks};
use enact_tools::perform::{Acting, Outliers, Performance, Style, bounces, perform};
use tempfile::TempDir;

use crate::program::enact;

/// What a person may be off by in marking, and more.
const NEAR_SAMPLES: f64 = 8.5;

fn estimated(performance: &Performance) -> Result<Outcome, PipelineError> {
    let scene = performance.truth.scene.clone();
    Pipeline::of(scene, performance.events.clone()).finish(&mut ())
}

/// Acted times of the events [s since the first sample].
fn acted_s(performance: &Performance) -> Vec<f64> {
    let times_s = performance.truth.event_times_s.iter();
    times_s
        .map(|time_s| performance.tempo.acted_s(*time_s))
        .collect()
}

fn assert_near(performance: &Performance, marks_s: &[f64], what: &str) {
    let collisions = marks_s.len() - 1;
    for (mark_s, time_s) in marks_s.iter().zip(acted_s(performance)).take(collisions) {
        let off = (mark_s - time_s) * performance.acting.rate_hz;
        assert!(off.abs() <= NEAR_SAMPLES, "{what}: {off} samples");
    }
}

fn acted(acting: Acting) -> Vec<Performance> {
    let mut performances: Vec<Performance> = Style::ALL
        .iter()
        .map(|style| perform(&style.truth(), &acting, 3))
        .collect();
    performances.push(perform(&bounces(3, 1).unwrap(), &acting, 1));
    performances.into_iter().map(ending_with_samples).collect()
}

/// A recorder that stops with the motion has no mark after its last sample.
fn ending_with_samples(mut performance: Performance) -> Performance {
    let stamps = performance.events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    });
    let last = stamps.max().unwrap();
    for event in &mut performance.events {
        if let TakeEvent::Mark(mark) = event {
            mark.stamp = mark.stamp.min(last);
        }
    }
    performance
}

fn without_marks(performance: &Performance) -> Performance {
    let mut performance = performance.clone();
    let is_pose = |event: &TakeEvent| matches!(event, TakeEvent::Pose { .. });
    let (events, arrivals) = performance
        .events
        .into_iter()
        .zip(performance.arrivals)
        .filter(|(event, _)| is_pose(event))
        .unzip();
    performance.events = events;
    performance.arrivals = arrivals;
    performance
}

#[test]
fn kinks_are_proposed_where_the_collisions_are() {
    for acting in [Acting::timing_known(), Acting::default()] {
        for performance in acted(acting) {
            let scene = &performance.truth.scene;
            let proposals = propose(scene, &performance.sketch(), None);
            assert_eq!(proposals.len(), scene.events.len() - 1);
            let mut marks_s: Vec<f64> = proposals.iter().map(|p| p.acted_s).collect();
            marks_s.push(0.0);
            assert_near(&performance, &marks_s, "proposed");
            assert!(proposals.iter().all(|p| p.score > 2.0), "{proposals:?}");
        }
    }
}

#[test]
fn a_flight_without_a_collision_has_no_kink_that_stands_out() {
    let performance = perform(&bounces(2, 1).unwrap(), &Acting::default(), 1);
    let scene = &performance.truth.scene;
    let right = propose(scene, &performance.sketch(), None);
    let many = propose(scene, &performance.sketch(), Some(5));
    assert_eq!(many.len(), 5);
    assert!(many.iter().all(|p| p.event.is_none()));
    let least = |proposals: &[enact::segment::Proposal]| {
        proposals
            .iter()
            .map(|p| p.score)
            .fold(f64::INFINITY, f64::min)
    };
    assert!(least(&many) < least(&right), "{many:?} {right:?}");
}

#[test]
fn takes_without_marks_are_estimated_and_say_so() {
    for performance in acted(Acting::default()) {
        let outcome = estimated(&without_marks(&performance)).unwrap();
        let all: Vec<usize> = (0..performance.truth.scene.events.len()).collect();
        assert_eq!(outcome.counts.marks.proposed, all);
        assert_near(&performance, &outcome.sketch.marks_s, "absent");
        assert_eq!(outcome.estimate.verdict, Verdict::Physical);
    }
}

#[test]
fn one_mark_more_or_less_is_made_good() {
    let performance = acted(Acting::default()).pop().unwrap();
    let marks: Vec<usize> = (0..performance.events.len())
        .filter(|index| matches!(performance.events[*index], TakeEvent::Mark(_)))
        .collect();
    for less in 0..marks.len() {
        let mut performance = performance.clone();
        performance.events.remove(marks[less]);
        let outcome = estimated(&performance).unwrap();
        assert_eq!(outcome.counts.marks.proposed, [less]);
        assert_near(&performance, &outcome.sketch.marks_s, "one less");
    }
    let mut performance = performance;
    let times_s = acted_s(&performance);
    let between_s = 0.5 * (times_s[0] + times_s[1]);
    performance.events.push(TakeEvent::Mark(Mark {
        stamp: Stamp(performance.acting.start.0 + (between_s * 1e9) as i64),
        event: None,
    }));
    let outcome = estimated(&performance).unwrap();
    assert_eq!(outcome.counts.marks.ignored, 1);
    assert_near(&performance, &outcome.sketch.marks_s, "one more");
}

#[test]
fn a_mark_that_is_near_no_kink_is_no_help() {
    // One of two, far from everything.
    let performance = perform(&Style::Tip.truth(), &Acting::default(), 3);
    let mut astray = without_marks(&performance);
    astray.events.push(TakeEvent::Mark(Mark {
        stamp: Stamp(performance.acting.start.0 + 100_000_000),
        event: None,
    }));
    let error = estimated(&astray).unwrap_err().to_string();
    assert!(error.starts_with("1 marks, expected 2"), "{error}");
    assert!(
        error.contains("the stream suggests \"bounce\" at 0."),
        "{error}"
    );
}

#[test]
fn marks_far_off_come_back_and_good_ones_stay() {
    for acting in [Acting::timing_known(), Acting::default()] {
        for performance in acted(acting) {
            let scene = &performance.truth.scene;
            let last_s = performance.sketch().tracks[TrackIndex(0)]
                .samples
                .last()
                .unwrap()
                .acted_s;
            for off in [0.0, 5.0, -50.0] {
                let mut sketch = performance.sketch();
                sketch.marks_s = acted_s(&performance);
                for mark_s in sketch.marks_s.split_last_mut().unwrap().1 {
                    *mark_s = (*mark_s + off / acting.rate_hz).clamp(0.0, last_s);
                }
                refine(scene, &mut sketch);
                let moved = relocate_marks(scene, &mut sketch);
                assert!(off.abs() > 20.0 || moved.is_empty(), "{off}: {moved:?}");
                assert_near(&performance, &sketch.marks_s, &format!("{off}"));
            }
        }
    }
}

#[test]
fn outliers_are_found_and_nothing_else() {
    let mut all_made = 0;
    for acting in [Acting::timing_known(), Acting::default()] {
        for (good, bad) in acted(acting).iter().zip(acted(Acting {
            outliers: Some(Outliers::of_share(0.05)),
            ..acting
        })) {
            let dropped = |performance: &Performance| {
                let outcome = estimated(performance).unwrap();
                assert_eq!(outcome.estimate.verdict, Verdict::Physical);
                let dropped = outcome.counts.dropped.get(&DropReason::Outlier);
                dropped.copied().unwrap_or(0)
            };
            assert_eq!(dropped(good), 0);
            let differing = good.events.iter().zip(&bad.events).filter(|(a, b)| a != b);
            let (made, found) = (differing.count(), dropped(&bad));
            assert!(found <= made && found + 2 >= made, "{found} of {made}");
            all_made += made;
        }
    }
    assert!(all_made >= 10, "{all_made}");
}

#[test]
fn millimetres_are_refused() {
    for acting in [Acting::timing_known(), Acting::default()] {
        for mut performance in acted(acting) {
            for event in &mut performance.events {
                if let TakeEvent::Pose { sample, .. } = event {
                    sample.position_m *= 1000.0;
                }
            }
            let error = estimated(&performance).unwrap_err().to_string();
            assert!(
                error.contains("are the positions in millimetres?"),
                "{error}"
            );
        }
    }
}

/// A folder with `take.mcap`, the tip performance without marks.
fn bench() -> (TempDir, Performance) {
    let folder = TempDir::new().unwrap();
    let performance = perform(&Style::Tip.truth(), &Acting::default(), 3);
    let path = folder.path().join("take.mcap");
    recording::write(&without_marks(&performance), Style::Tip.scene_toml(), &path).unwrap();
    recording::write(
        &performance,
        Style::Tip.scene_toml(),
        &folder.path().join("marked.mcap"),
    )
    .unwrap();
    (folder, performance)
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn proposals_are_printed_and_written_and_read_again() {
    let (folder, performance) = bench();
    let folder = folder.path();
    let ran = enact(folder, &["mark", "--propose", "take.mcap"]);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    assert!(stdout(&ran).contains("bounce"), "{}", stdout(&ran));

    let ran = enact(
        folder,
        &[
            "mark",
            "--propose",
            "take.mcap",
            "-o",
            "with.mcap",
            "--format",
            "ndjson",
        ],
    );
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    let json: serde_json::Value = serde_json::from_str(&stdout(&ran)).unwrap();
    let first = &json["proposals"][0];
    assert_eq!(
        (first["event"].as_str(), first["body"].as_str()),
        (Some("bounce"), Some("pencil"))
    );
    let off_s = first["time_s"].as_f64().unwrap() - acted_s(&performance)[0];
    assert!(
        off_s.abs() * performance.acting.rate_hz <= NEAR_SAMPLES,
        "{off_s}"
    );
    assert!(first["score"].as_f64().unwrap() > 2.0);
    assert_eq!(json["output"], "with.mcap");

    // The copy has two marks more, and is estimated as the recording itself is.
    let inspect = |name: &str| -> serde_json::Value {
        let ran = enact(folder, &["inspect", name, "--format", "ndjson"]);
        serde_json::from_str(&stdout(&ran)).unwrap()
    };
    let (bare, with) = (inspect("take.mcap"), inspect("with.mcap"));
    assert_eq!(bare["marks"].as_array().unwrap().len(), 0);
    assert_eq!(with["marks"].as_array().unwrap().len(), 2);
    let messages = |of: &serde_json::Value| of["messages"].as_u64().unwrap();
    assert_eq!(messages(&with), messages(&bare) + 2);
    let replay = |name: &str| -> serde_json::Value {
        let ran = enact(
            folder,
            &["replay", name, "-o", "out.mcap", "--format", "ndjson"],
        );
        serde_json::from_str(&stdout(&ran)).unwrap()
    };
    let (bare, with) = (replay("take.mcap"), replay("with.mcap"));
    assert_eq!(bare["verdict"], "physical");
    // A mark that is in the recording is a measurement, one that is proposed on the way is none: of little weight here.
    let events = |of: &serde_json::Value| of["events"].as_array().unwrap().clone();
    assert_eq!([events(&bare).len(), events(&with).len()], [2; 2]);
    for (bare, with) in events(&bare).iter().zip(&events(&with)) {
        let number = |of: &serde_json::Value, key: &str| of[key].as_f64().unwrap();
        let off_s = number(with, "time_s") - number(bare, "time_s");
        assert!(off_s.abs() < 0.1 * number(bare, "time_sd_s"), "{off_s}");
    }
    let note = bare["warnings"][0].as_str().unwrap();
    assert!(note.starts_with("no marks for some events"), "{note}");
    assert_eq!(with["warnings"].as_array().unwrap().len(), 0, "{with}");
}

#[test]
fn what_cannot_be_marked_is_refused_and_leaves_nothing() {
    let (folder, _) = bench();
    let folder = folder.path();
    for (arguments, code, message) in [
        (
            vec!["mark", "take.mcap", "-o", "x.mcap"],
            1,
            "nothing to write, expected --propose",
        ),
        (
            vec!["mark", "--propose", "take.mcap", "-o", "take.mcap"],
            1,
            "would replace",
        ),
        (
            vec!["mark", "--propose", "marked.mcap", "-o", "x.mcap"],
            1,
            "has 2 marks already",
        ),
        (
            vec![
                "mark",
                "--propose",
                "take.mcap",
                "--count",
                "61",
                "-o",
                "x.mcap",
            ],
            1,
            "too many",
        ),
        (
            vec!["mark", "--propose", "absent.mcap", "-o", "x.mcap"],
            1,
            "absent.mcap",
        ),
    ] {
        let ran = enact(folder, &arguments);
        assert_eq!(ran.status.code(), Some(code), "{arguments:?}");
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert!(stderr.contains(message), "{stderr}");
        assert!(!folder.join("x.mcap").exists());
    }
}

#[test]
fn another_count_gives_proposals_without_events() {
    let (folder, _) = bench();
    let ran = enact(
        folder.path(),
        &[
            "mark",
            "--propose",
            "take.mcap",
            "--count",
            "3",
            "--format",
            "ndjson",
        ],
    );
    let json: serde_json::Value = serde_json::from_str(&stdout(&ran)).unwrap();
    let kinks = json["proposals"].as_array().unwrap().iter();
    let kinks: Vec<_> = kinks.filter(|p| !p["body"].is_null()).collect();
    assert_eq!(kinks.len(), 3);
    assert!(kinks.iter().all(|p| p["event"].is_null()));
}
