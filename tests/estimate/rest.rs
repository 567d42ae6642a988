//! Goals at rest, through the program: what is asked for is shown by the poses that are written, or
//! it is said that it cannot be.

use std::path::Path;

use enact::estimate::{Recipe, estimate};
use enact::ingest::Recording;
use enact::motion::{LinkIndex, MechanismIndex, Performance, TakeEvent, Verdict};
use enact::pipeline::Outcome;
use enact_tools::case::{Case, Posed};
use enact_tools::perform::recording::write;
use enact_tools::perform::{Acting, Roll};
use enact_tools::replay::Program;
use nalgebra::{DVector, Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// What the program made of a roll.
struct Replayed {
    code: Option<i32>,
    account: String,
    report: Value,
    /// Orientation of the last pose that it wrote.
    last: UnitQuaternion<f64>,
}

fn replayed(roll: &Roll, seed: u64, goal: &str) -> Replayed {
    let (truth, scene_toml) = roll.truth(goal, "physical").expect("a throw");
    let case = Case::new(&truth, &Acting::timing_known(), seed);
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("take.mcap");
    write(&case.performance, &scene_toml, &path).expect("a recording");
    let (account, report) = (ENACT.account(&path, &[]), ENACT.report(&path, &[]));
    assert_eq!(account.code, report.code);
    Replayed {
        code: account.code,
        account: account.said,
        last: last_written(&case, &report.output),
        report: report.said,
    }
}

/// The last estimated pose of the cube in a file.
fn last_written(case: &Case, file: &Path) -> UnitQuaternion<f64> {
    let mut scene = case.scene().clone();
    for track in &mut scene.tracks {
        track.topic = "/estimate/cube/pose".to_owned();
    }
    let take = Recording::open(file).and_then(|written| written.take(&scene));
    let poses = take.expect("a take").events.into_iter();
    let poses = poses.filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample),
        TakeEvent::Mark(_) => None,
    });
    let last = poses.max_by_key(|sample| sample.stamp).expect("poses");
    let [x, y, z, w] = last.quaternion_xyzw;
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// Angle of a named axis from up at the last pose \[deg\].
fn off_deg(last: &UnitQuaternion<f64>, face: &str) -> f64 {
    let axis = ["x", "y", "z"].iter().position(|axis| face.ends_with(axis));
    let sign = if face.starts_with('-') { -1.0 } else { 1.0 };
    let up = last * Vector3::ith(axis.expect("an axis"), sign);
    up.angle(&Vector3::z()).to_degrees()
}

#[test]
fn the_face_that_is_asked_for_is_up_in_what_is_written() {
    let mut searched = 0;
    for (seed, face) in [(5100, "+x"), (5101, "-y"), (5102, "+z")] {
        let roll = Roll {
            face,
            ..Roll::of(seed)
        };
        let replayed = replayed(&roll, seed, "");
        let rest = &replayed.report["rest"];
        assert_eq!(rest["reached"], true, "{seed}: {}", replayed.account);
        assert_eq!(rest["goals"][0]["asked"], face);
        assert_eq!(rest["goals"][0]["face_up"], face);
        // The simulation calls a die that tilts by a fraction of a degree at rest.
        let off_deg = off_deg(&replayed.last, face);
        assert!(off_deg < 0.5, "{seed}: {off_deg}");
        let said = format!("rest      cube: {face} up as asked");
        assert!(replayed.account.contains(&said), "{}", replayed.account);
        let best = rest["best_objective"].as_f64().expect("a number");
        let own = replayed.report["objective"].as_f64().expect("a number");
        if rest["tried"].as_u64() > Some(0) {
            searched += 1;
            assert!(own > best, "{seed}: {own} {best}");
            assert_eq!(replayed.report["termination"]["kind"], "simulated");
            // It is a motion like any other: continuous, and no part of it was let go.
            let shot = &replayed.report["verification"]["single_shot"];
            assert!(shot["position_m"].as_f64() < Some(1e-6), "{seed}: {shot}");
        }
    }
    assert!(searched > 0, "every die fell as asked by itself");
}

#[test]
fn what_cannot_be_is_said_by_name() {
    // No cube rests on a corner.
    let seed = 5103;
    let roll = Roll {
        face: "+x",
        ..Roll::of(seed)
    };
    let replayed = replayed(&roll, seed, "direction = [1, 1, 1]\n");
    assert_eq!(replayed.code, Some(3), "{}", replayed.account);
    let first = replayed.account.lines().next().unwrap_or_default();
    let said = ": no motion near the performance ends with +x of `cube` there: tried ";
    assert!(first.contains(": failed, "), "{first}");
    assert!(first.contains(said), "{first}");
    assert_eq!(replayed.report["verdict"], "failed");
    assert_eq!(replayed.report["rest"]["reached"], false);
    assert_eq!(replayed.report["doubts"][0]["quantity"], "rest");
}

#[test]
fn labels_are_turned_only_where_they_are_free_and_nothing_else_changes() {
    let seed = 5104;
    let asked = |face: &'static str, goal: &str| {
        let roll = Roll {
            face,
            ..Roll::of(seed)
        };
        let (truth, _) = roll.truth(goal, "physical").expect("a throw");
        let case = Case::new(&truth, &Acting::timing_known(), seed);
        case.pipeline().finish(&mut ()).expect("an outcome")
    };
    let turned = |outcome: &Outcome| outcome.rest.as_ref().expect("goals").labels[0];
    let faces = ["+x", "-x", "+y", "-y", "+z", "-z"];
    let mut as_acted = 0;
    for face in faces {
        let outcome = asked(face, "labels = \"free\"\n");
        let rest = outcome.rest.as_ref().expect("goals");
        assert!(rest.is_reached(), "{face}");
        assert_ne!(outcome.estimate.verdict, Verdict::Failed, "{face}");
        // The motion is the best one, as near as errors of a hand are told again.
        let off = outcome.estimate.objective / rest.work.best_objective - 1.0;
        assert!(off.abs() < 1e-4, "{face}: {off}");
        let settled = outcome.settled.as_ref().expect("a continuation");
        let last = settled.links[LinkIndex(0)].poses.last().expect("poses");
        assert!(off_deg(&last.rotation, face) < 0.1, "{face}");
        as_acted += usize::from(turned(&outcome).is_none());
        if turned(&outcome).is_some() {
            assert_eq!(turned(&asked(face, "")), None, "{face}");
        }
    }
    assert_eq!(as_acted, 1);
}

/// A die that rolls far, asked for a face that no motion near its own shows: what is offered does it.
#[test]
fn labels_that_would_let_it_end_as_asked_are_offered() {
    let mut offered = 0;
    for (seed, face) in [(5108, "+x"), (5109, "-y")] {
        let roll = Roll {
            face,
            ..Roll::of(seed)
        };
        let kept = replayed(&roll, seed, "");
        let diagnosis = &kept.report["diagnoses"][0];
        let is_reached = kept.report["rest"]["reached"] == true;
        if is_reached && kept.report["verdict"] == "physical" {
            assert_eq!(diagnosis["cause"], Value::Null, "{seed}: {diagnosis}");
            continue;
        }
        offered += 1;
        assert_eq!(kept.code, Some(3));
        assert_eq!(
            diagnosis["cause"], "goal_labels",
            "{seed}: {}",
            kept.account
        );
        assert_eq!(diagnosis["key"], "goal.labels");
        let sentence = diagnosis["sentence"].as_str().expect("a sentence");
        let said = format!("  likely: {sentence}");
        assert!(kept.account.contains(&said), "{}", kept.account);
        let value = diagnosis["value"].as_str().expect("a value");
        let freed = replayed(&roll, seed, &format!("labels = {value}\n"));
        assert_eq!(freed.report["rest"]["reached"], true, "{}", freed.account);
        assert!(off_deg(&freed.last, face) < 0.1, "{seed}");
    }
    assert!(offered > 0, "every die was led to its face");
}

#[test]
fn motions_from_whitened_states_cost_what_they_say() {
    for (seed, stamps, acting) in [
        (5105, "physical", Acting::timing_known()),
        (5106, "physical", Acting::timing_known()),
        (5107, "tempo", Acting::default()),
    ] {
        let (truth, _) = Roll::of(seed).truth("", stamps).expect("a throw");
        let case = Case::new(&truth, &acting, seed);
        let outcome = case.estimated(&mut ()).expect("an estimate");
        let posed = Posed::without_marks(&outcome.scene, &outcome.sketch);
        let of = Performance {
            scene: &outcome.scene,
            sketch: &outcome.sketch,
            segments: &posed.segments,
        };
        let solved = estimate(
            of.scene,
            of.sketch,
            of.segments,
            &posed.guesses,
            &Recipe::default(),
            &mut (),
        );
        let least = solved.estimate.objective;
        let flights = solved.first_flights(&[MechanismIndex(0)]).expect("flights");
        let count = flights[0].dimension();
        assert!((10..=12).contains(&count), "{seed}: {count}");
        for k in 0..count {
            let at = |length: f64| {
                let mut z = DVector::zeros(count);
                z[k] = length;
                let moved = solved.simulated(of, &[(&flights[0], z)]).expect("a motion");
                assert_eq!(moved.estimate.verdict, Verdict::Physical, "{seed} {k}");
                let timed = moved.times_are_unknown();
                let timed = timed.then(|| moved.with_sample_times(of, &mut ()));
                timed.flatten().unwrap_or(moved).estimate.objective - least
            };
            assert!(at(0.0).abs() < 1e-7 * least, "{seed} {k}: {}", at(0.0));
            let grown = 0.5 * (at(0.1) + at(-0.1));
            assert!((grown / 0.01 - 1.0).abs() < 0.2, "{seed} {k}: {grown}");
        }
    }
}
