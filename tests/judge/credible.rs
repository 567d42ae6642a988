//! Nonsense is never called physical, and sense is: every doubt where it must be and where it must
//! not, through the program; its bounds at either side.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use enact::motion::{
    About, Doubt, Estimate, FreeParameter, LinkIndex, PoseSample, Quantity, Scene, Stamp,
    TakeEvent, TrackIndex, Verdict,
};
use enact::pipeline::{Outcome, Pipeline, Preview};
use enact::verify::credible;
use enact_tools::nonsense::{Asked, faults, real};
use enact_tools::tosses::real_folder;
use nalgebra::Vector3;

/// The answer to a row of the study at a seed.
fn answer(name: &str, seed: u64) -> Outcome {
    let mut rows = faults::rows().into_iter();
    let row = rows.find(|row| row.name == name);
    let asked = (row.unwrap_or_else(|| panic!("no row {name}")).make)(seed);
    asked.expect("a take").answered().expect("an answer")
}

fn abouts(estimate: &Estimate) -> Vec<About> {
    estimate.doubts.iter().map(|doubt| doubt.about).collect()
}

/// Doubts that take `physical` back, but for those about shapes.
fn alarms(estimate: &Estimate) -> Vec<&Doubt> {
    let is_of_shape = |about| matches!(about, About::Overlap | About::WrongFeature);
    let is_alarm =
        |doubt: &&Doubt| doubt.about.best() != Verdict::Physical && !is_of_shape(doubt.about);
    estimate.doubts.iter().filter(is_alarm).collect()
}

#[test]
fn wrong_models_are_doubted_for_what_is_wrong() {
    for (name, about, expected) in [
        ("toss: table 30 mm off", About::Residual, Verdict::Plausible),
        ("toss: table 8 mm off", About::Misfit, Verdict::Plausible),
        (
            "toss: quaternions conjugated",
            About::Residual,
            Verdict::Plausible,
        ),
        (
            "toss: y up taken for z up",
            About::FallDirection,
            Verdict::Plausible,
        ),
        (
            "toss: restitution 0.3 less",
            About::Misfit,
            Verdict::Plausible,
        ),
        (
            "toss: 1.2 times slower taken for physical",
            About::Residual,
            Verdict::Plausible,
        ),
        (
            "toss: 2.5 times slower taken for physical",
            About::Fall,
            Verdict::Plausible,
        ),
        (
            "pencil 1×, known: restitution 0.3 less",
            About::Misfit,
            Verdict::Plausible,
        ),
        (
            "pencil 1×: 2.5 times slower taken for physical",
            About::Fall,
            Verdict::Plausible,
        ),
        (
            "pencil 1×, known: table 8 mm off",
            About::Overlap,
            Verdict::Plausible,
        ),
        (
            "pencil 1×, known: y up taken for z up",
            About::FallDirection,
            Verdict::Plausible,
        ),
    ] {
        let estimate = answer(name, 0).estimate;
        assert!(
            abouts(&estimate).contains(&about),
            "{name}: {:?}",
            estimate.doubts
        );
        assert!(estimate.verdict >= expected, "{name}");
        let first = estimate.doubts[0].about.best();
        assert!(
            estimate
                .doubts
                .iter()
                .all(|doubt| doubt.about.best() <= first)
        );
    }
}

#[test]
fn right_models_are_not_doubted() {
    let rows = faults::rows();
    let is_usual = |name: &str| !name.ends_with("8×");
    let mut asked = 0;
    for row in rows
        .iter()
        .filter(|row| row.is_right && is_usual(&row.name))
    {
        for seed in [20, 21] {
            let Ok(take) = (row.make)(seed) else { continue };
            let estimate = take.answered().expect("an answer").estimate;
            let alarms = alarms(&estimate);
            assert!(alarms.is_empty(), "{}, seed {seed}: {alarms:?}", row.name);
            asked += 1;
        }
    }
    assert!(asked > 50, "{asked}");
}

/// Eight times the usual wander is still somebody's performance: nearly all pencils are `physical`, and
/// all are said to be ambiguous.
/// Short flights do not show a hand's wander, but what is left of these is far more than weights say a hand
/// leaves. Kinks alone let a wrong table pass at some of these seeds; the bound was chosen on them.
#[test]
fn a_wrong_table_shows_in_short_flights_too() {
    for seed in 5000..5010 {
        for name in ["toss: table 8 mm off", "toss: table 30 mm off"] {
            let outcome = answer(name, seed);
            let is_alarmed = !alarms(&outcome.estimate).is_empty();
            let is_physical = outcome.estimate.verdict == Verdict::Physical;
            assert!(is_alarmed && !is_physical, "{name}, seed {seed}");
        }
    }
}

#[test]
fn great_distortion_is_said_and_not_refused() {
    let mut doubted = 0;
    for seed in 20..30 {
        for name in ["pencil, known, 8×", "pencil, unknown, 8×"] {
            let estimate = answer(name, seed).estimate;
            assert!(
                abouts(&estimate).contains(&About::Ambiguity),
                "{name}, {seed}"
            );
            doubted += usize::from(!alarms(&estimate).is_empty());
        }
    }
    assert!(doubted <= 6, "{doubted} of 20");
}

/// What is said of an estimate that was changed, beside what was said before.
fn said_of(
    outcome: &Outcome,
    change: impl Fn(&mut Scene, &mut Estimate, &mut Vec<Option<f64>>),
) -> Vec<Doubt> {
    let mut outcome = outcome.clone();
    change(
        &mut outcome.scene,
        &mut outcome.estimate,
        &mut outcome.marks_made_s,
    );
    let Outcome {
        scene,
        sketch,
        marks_made_s,
        estimate,
        ..
    } = &outcome;
    credible::doubts(scene, scene, sketch, marks_made_s, estimate)
}

fn has(doubts: &[Doubt], about: About) -> bool {
    doubts.iter().any(|doubt| doubt.about == about)
}

#[test]
fn speeds_and_spins_are_bounded() {
    let outcome = answer("pencil, known, 1×", 0);
    let radius_m = outcome.scene.links[LinkIndex(0)].shape.radius_m();
    for (spin_rad_s, is_absurd) in [(200.0, false), (990.0, false), (1010.0, true)] {
        let doubts = said_of(&outcome, |_, estimate, _| {
            estimate.arcs[0].state.angular_velocity_rad_s = Vector3::z() * spin_rad_s;
        });
        assert_eq!(has(&doubts, About::Spin), is_absurd, "{spin_rad_s}");
    }
    for (speed_m_s, is_absurd) in [(20.0, false), (78.0, false), (81.0, true)] {
        let doubts = said_of(&outcome, |_, estimate, _| {
            estimate.gravity_m_s2 = Vector3::zeros();
            let state = &mut estimate.arcs[0].state;
            state.angular_velocity_rad_s = Vector3::z() * (0.5 / radius_m);
            state.velocity_m_s = Vector3::x() * (speed_m_s - 0.5);
        });
        assert_eq!(has(&doubts, About::Speed), is_absurd, "{speed_m_s}");
        assert!(
            doubts
                .iter()
                .all(|d| d.about != About::Speed || d.about.best() == Verdict::Failed)
        );
    }
}

#[test]
fn a_motion_goes_about_as_far_as_it_was_acted() {
    let outcome = answer("pencil, known, 1×", 0);
    for (factor, is_absurd) in [(1.0, false), (3.0, false), (30.0, true)] {
        let doubts = said_of(&outcome, |_, estimate, _| {
            for arc in &mut estimate.arcs {
                arc.state.velocity_m_s *= factor;
            }
        });
        assert_eq!(has(&doubts, About::Way), is_absurd, "{factor}");
    }
}

#[test]
fn tempo_is_bounded_where_it_is_unknown() {
    let unknown = answer("pencil, unknown, 1×", 0);
    let acted_s = |outcome: &Outcome| {
        let first = outcome.estimate.sample_times.first().expect("samples");
        let last = outcome.estimate.sample_times.last().expect("samples");
        last.stamp.seconds_since(first.stamp)
    };
    let at_rate = |slowness: f64| {
        said_of(&unknown, |_, estimate, _| {
            let times = &estimate.sample_times;
            let first = times[0].stamp;
            let span_s = times[times.len() - 1].time_s - times[0].time_s;
            assert!(span_s > 0.0 && acted_s(&unknown) > 0.0);
            for time in &mut estimate.sample_times {
                time.time_s = time.stamp.seconds_since(first) / slowness;
            }
        })
    };
    for (slowness, is_slow, is_hasty) in [
        (0.3, false, true),
        (0.45, false, false),
        (1.0, false, false),
        (11.5, false, false),
        (13.0, true, false),
    ] {
        let doubts = at_rate(slowness);
        assert_eq!(has(&doubts, About::Slowness), is_slow, "{slowness}");
        assert_eq!(has(&doubts, About::Haste), is_hasty, "{slowness}");
    }
    let known = answer("pencil, known, 1×", 0);
    let doubts = said_of(&known, |_, estimate, _| {
        for time in &mut estimate.sample_times {
            time.time_s /= 100.0;
        }
    });
    assert!(
        !has(&doubts, About::Slowness),
        "physical stamps have no tempo"
    );
}

#[test]
fn an_event_is_near_its_mark() {
    for (name, later_s, earlier_s) in [
        ("pencil, known, 1×", 0.075, 0.075),
        ("pencil, unknown, 1×", 0.12, 0.15),
    ] {
        let outcome = answer(name, 0);
        // Where the estimate has the bounce on the acted time line.
        let acted_s = |doubts: &[Doubt], made_s: f64| {
            let late = doubts.iter().find(|doubt| doubt.about == About::AfterMark);
            made_s + late.expect("it is long after").value
        };
        let made = |made_s: Option<f64>| {
            said_of(&outcome, |_, _, marks_s| {
                marks_s[0] = made_s;
                marks_s[1] = None;
            })
        };
        let bounce_s = acted_s(&made(Some(-1.0)), -1.0);
        for (late_s, is_after, is_before) in [
            (0.0, false, false),
            (later_s - 0.001, false, false),
            (later_s + 0.001, true, false),
            (0.001 - earlier_s, false, false),
            (-0.001 - earlier_s, false, true),
        ] {
            let doubts = made(Some(bounce_s - late_s));
            assert_eq!(has(&doubts, About::AfterMark), is_after, "{name} {late_s}");
            assert_eq!(
                has(&doubts, About::BeforeMark),
                is_before,
                "{name} {late_s}"
            );
        }
        let unmarked = made(None);
        assert!(!has(&unmarked, About::AfterMark) && !has(&unmarked, About::BeforeMark));
    }
}

#[test]
fn a_gravity_that_was_freed_is_held_against_the_scenes() {
    let outcome = answer("pencil, known, 1×", 0);
    let freed = |off: f64, sd: Option<f64>| {
        said_of(&outcome, |scene, estimate, _| {
            scene.parameters = vec![FreeParameter {
                name: "gravity.z".into(),
                quantity: Quantity::Gravity { axis: 2 },
                initial: scene.gravity_m_s2.z,
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                prior_sd: None,
            }];
            estimate.gravity_m_s2 *= 1.0 + off;
            estimate.parameters = vec![enact::motion::ParameterEstimate {
                name: "gravity.z".into(),
                value: estimate.gravity_m_s2.z,
                sd,
                at_bound: None,
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
            }];
        })
    };
    for (off, is_far) in [(0.0, false), (0.07, false), (0.09, true), (-0.09, true)] {
        assert_eq!(has(&freed(off, Some(0.1)), About::Gravity), is_far, "{off}");
    }
    for (sd, is_wide) in [(Some(0.4), false), (Some(0.6), true), (None, true)] {
        assert_eq!(
            has(&freed(0.0, sd), About::GravitySpread),
            is_wide,
            "{sd:?}"
        );
    }
    assert!(
        !has(&said_of(&outcome, |_, _, _| {}), About::GravitySpread),
        "nothing is free"
    );
}

#[test]
fn a_parameter_at_the_end_of_its_range_is_said() {
    let outcome = answer("hat and box, known, 1×", 0);
    let at = |value: f64| {
        let doubts = said_of(&outcome, |_, estimate, _| {
            estimate.parameters[0].value = value
        });
        let mut ends = doubts.iter().filter(|doubt| doubt.about == About::AtBound);
        ends.any(|doubt| doubt.place == enact::motion::Place::Parameter(0))
    };
    let parameter = &outcome.estimate.parameters[0];
    assert!(at(parameter.lower) && at(parameter.upper));
    assert!(!at(0.5 * (parameter.lower + parameter.upper)));
}

/// A body that stands still, with a hand's sway, for two seconds.
fn hovering(stamps: &str) -> Asked {
    let scene = real::flight(
        "{ kind = \"cuboid\", size_mm = [200, 200, 100] }",
        0.5,
        stamps,
        "",
    );
    let sample = |index: i64| {
        let time_s = index as f64 * 0.01;
        TakeEvent::Pose {
            track: TrackIndex(0),
            stream: 0,
            sample: PoseSample::new(
                Stamp(index * 10_000_000),
                Vector3::new(
                    0.1 * time_s + 0.01 * (3.0 * time_s).sin(),
                    0.02 * time_s.cos(),
                    1.0 + 0.005 * (2.0 * time_s).sin(),
                ),
                [0.0, 0.0, (0.02 * time_s).sin(), (0.02 * time_s).cos()],
            ),
        }
    };
    Asked {
        scene,
        events: (0..200).map(sample).collect(),
    }
}

#[test]
fn what_hovers_does_not_fly() {
    for stamps in ["physical", "tempo"] {
        let estimate = hovering(stamps).answered().expect("an answer").estimate;
        assert_ne!(
            estimate.verdict,
            Verdict::Physical,
            "{stamps}: {:?}",
            estimate.doubts
        );
        assert!(!alarms(&estimate).is_empty(), "{stamps}");
    }
}

#[test]
fn previews_say_it_too() {
    let Asked { scene, events } = hovering("physical");
    let mut preview = Preview::new(scene);
    // The end is not marked: the flight is open.
    events.into_iter().for_each(|event| preview.push(event));
    let previewed = preview
        .estimate(&mut ())
        .expect("an estimate")
        .expect("it has begun");
    let estimate = &previewed.outcome.estimate;
    assert_eq!(estimate.verdict, Verdict::Failed, "{:?}", estimate.doubts);
    assert!(has(&estimate.doubts, About::Fall) && has(&estimate.doubts, About::Way));
}

#[test]
fn the_unchecked_verdict_is_that_of_the_gaps_alone() {
    let Asked { scene, events } = hovering("physical");
    let outcome = Pipeline::of(scene, events)
        .estimate(&mut ())
        .expect("an estimate");
    assert_eq!(outcome.estimate.verdict, Verdict::Physical);
    assert!(outcome.estimate.doubts.is_empty());
}

#[test]
fn the_program_says_it_first_with_numbers_and_with_its_exit_code() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::TempDir::new().expect("a folder");
    let toml = fs::read_to_string(root.join("config/pencil_tip.toml")).expect("a scene");
    let scene = folder.path().join("scene.toml");
    let slow = toml.replace("stamps = \"tempo\"", "stamps = \"physical\"");
    assert_ne!(slow, toml);
    fs::write(&scene, slow).expect("written");
    let output = folder.path().join("out.mcap");
    let ran = |format: &[&str]| {
        let mut command = Command::cargo_bin("enact").expect("the program");
        command
            .arg("replay")
            .arg(root.join("recordings/pencil_tip.mcap"));
        command
            .arg("--scene")
            .arg(&scene)
            .arg("-o")
            .arg(&output)
            .args(format);
        let output = command.output().expect("it ran");
        assert_eq!(output.status.code(), Some(3));
        String::from_utf8(output.stdout).expect("text")
    };
    let account = ran(&[]);
    let first = account.lines().next().expect("a line");
    assert!(
        first.contains(": plausible, ") && first.contains(": `pencil` is "),
        "{first}"
    );
    let json: serde_json::Value =
        serde_json::from_str(&ran(&["--format", "ndjson"])).expect("json");
    let doubts = json["doubts"].as_array().expect("doubts");
    assert!(
        first.ends_with(doubts[0]["text"].as_str().expect("a sentence")),
        "{first}"
    );
    for doubt in doubts {
        assert!(
            doubt["quantity"].is_string() && doubt["value"].is_number(),
            "{doubt}"
        );
    }
    let fall = doubts
        .iter()
        .find(|doubt| doubt["quantity"] == "fall")
        .expect("no free fall");
    assert!(fall["value"].as_f64() > fall["bound"].as_f64());
    // The file says the same, typed.
    let bytes = fs::read(&output).expect("written");
    let recording = enact::ingest::Recording::from_bytes(&output, bytes).expect("a recording");
    let report = report(&recording);
    let typed = report["doubts"].as_array().expect("doubts");
    assert_eq!(typed.len(), doubts.len());
    for (typed, doubt) in typed.iter().zip(doubts) {
        for key in ["quantity", "value", "bound", "unit", "at", "time_s", "best"] {
            assert_eq!(typed[key], doubt[key], "{key}");
        }
    }
    assert_eq!(report["verdict"], json["verdict"]);
}

/// The report in a file that was written.
fn report(recording: &enact::ingest::Recording) -> serde_json::Value {
    let container = recording.container();
    let channels = container.channels();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        if channels[&message.channel_id].topic == enact::write::topics::REPORT {
            return serde_json::from_slice(message.data).expect("json");
        }
    }
    panic!("no report");
}

#[test]
fn real_takes_of_no_flight_are_never_physical() {
    let Some(folder) = real_folder() else { return };
    for file in real::files(&folder.join("not_throws"), "mcap") {
        let estimate = real::carried(&file).answered().expect("an answer").estimate;
        assert_eq!(estimate.verdict, Verdict::Failed, "{}", file.display());
    }
    let file = folder.join("mcap/cub_stabilize_2025_11_13.mcap");
    for stamps in ["physical", "tempo"] {
        for (index, asked) in real::hovering(&file, stamps, 4.0).iter().enumerate() {
            let Ok(outcome) = asked.answered() else {
                continue;
            };
            let estimate = &outcome.estimate;
            let what = format!("{stamps}, window {index}: {:?}", estimate.doubts);
            assert_ne!(estimate.verdict, Verdict::Physical, "{what}");
        }
    }
}

/// Two hinged boxes whose gravity is free: in three of four tosses that shows.
#[test]
fn real_hinged_boxes_are_mostly_not_one_body() {
    let Some(folder) = real_folder() else { return };
    let files = real::files(&folder.join("elbow"), "csv");
    let physical = files.iter().filter(|file| {
        let estimate = real::elbow(file).answered().expect("an answer").estimate;
        estimate.verdict == Verdict::Physical
    });
    assert!(4 * physical.count() <= files.len());
}
