//! Does a motion explain its performance, what is to blame where it does not, and what is then set
//! free: cubes that are really thrown, with a tracker's noise and one thing wrong in the scene.

use assert_cmd::Command;
use enact::motion::{Fits, Suspect};
use enact::pipeline::Outcome;
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::perform::{Acting, bounces, perform, recording};
use serde_json::Value;
use tempfile::TempDir;

const SEEDS: std::ops::Range<u64> = 6000..6006;

fn thrown() -> Acting {
    Acting {
        distortion: 0.0,
        mark_error_s: 0.002,
        ..Acting::timing_known()
    }
}

fn answered(wrong: Wrong, seed: u64) -> Outcome {
    let asked = wrong.asked(&thrown(), seed).expect("a throw");
    asked.answered().expect("an answer")
}

fn freed(wrong: Wrong, seed: u64) -> Outcome {
    let asked = wrong.asked(&thrown(), seed).expect("a throw");
    asked.freed().expect("an answer")
}

fn is_culprit(wrong: Wrong, suspect: &Suspect) -> bool {
    let mut values = suspect.values.iter();
    values.any(|(quantity, _)| wrong.is_of(*quantity))
}

#[test]
fn a_right_scene_fits_and_nothing_is_suspected() {
    for seed in SEEDS {
        let outcome = freed(Wrong::Nothing, seed);
        let fit = outcome.estimate.fit.as_ref().expect("tested");
        assert_eq!(fit.fits, Fits::Yes, "{seed}: {fit:?}");
        assert!(outcome.estimate.suspects.is_empty(), "{seed}");
        assert!(outcome.freed.is_empty(), "{seed}");
        for event in &fit.events {
            assert!(event.by_noise.statistic < 4.0, "{seed}: {event:?}");
        }
    }
}

#[test]
fn the_wrong_quantity_is_the_first_suspect() {
    for wrong in Wrong::ALL {
        let mut first = 0;
        for seed in SEEDS {
            let outcome = answered(wrong, seed);
            let fit = outcome.estimate.fit.as_ref().expect("tested");
            let Some((likeliest, others)) = outcome.estimate.suspects.split_first() else {
                continue;
            };
            assert_ne!(fit.fits, Fits::Yes, "{wrong:?} {seed}");
            let rivals = others
                .iter()
                .filter(|other| likeliest.is_rivalled_by(other));
            let mut likely = [likeliest].into_iter().chain(rivals);
            first += usize::from(likely.any(|suspect| is_culprit(wrong, suspect)));
        }
        assert!(first >= 5, "{wrong:?}: {first} of 6");
    }
}

#[test]
fn a_wrong_bounce_does_not_fit() {
    let outcome = answered(Wrong::Inertia, 6001);
    let fit = outcome.estimate.fit.expect("tested");
    assert_eq!(fit.fits, Fits::No, "{fit:?}");
    assert!(fit.joint[0] > 3.0 * fit.alone[0], "{fit:?}");
}

#[test]
fn what_is_told_is_set_free_and_what_is_not_stays() {
    for seed in SEEDS {
        let outcome = freed(Wrong::Inertia, seed);
        let [one] = &outcome.freed[..] else {
            panic!("{seed}: {:?}", outcome.freed);
        };
        assert!(is_culprit(Wrong::Inertia, one), "{seed}: {one:?}");
        // Half of what it is: the factor is two.
        let [factor] = &outcome.estimate.parameters[..] else {
            panic!("{seed}");
        };
        let sd = factor.sd.expect("it is determined");
        assert!((factor.value - 2.0).abs() < 4.0 * sd, "{seed}: {factor:?}");
        let fit = outcome.estimate.fit.as_ref().expect("tested");
        assert_ne!(fit.fits, Fits::No, "{seed}: {fit:?}");
        // A slow clock and weak gravity are the same to a motion.
        for wrong in [Wrong::Clock, Wrong::Gravity] {
            let outcome = freed(wrong, seed);
            assert!(outcome.freed.is_empty(), "{seed}: {:?}", outcome.freed);
        }
    }
}

/// The account and the object of a replay.
fn replayed(path: &std::path::Path, options: &[&str]) -> (Option<i32>, String, Value) {
    let run = |format: &str| {
        let mut command = Command::cargo_bin("enact").expect("the program");
        command.env_remove("RUST_LOG").env("NO_COLOR", "1");
        let output = path.with_extension("out.mcap");
        let command = command.arg("replay").arg(path).arg("-o").arg(output);
        let command = command.args(["--format", format]).args(options);
        command.output().expect("it ran")
    };
    let text = run("text");
    let object = serde_json::from_slice(&run("ndjson").stdout).expect("an object");
    let account = String::from_utf8(text.stdout).expect("text");
    (text.status.code(), account, object)
}

#[test]
fn a_replay_says_what_it_set_free() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("take.mcap");
    let truth = bounces(1, 6001).expect("a motion");
    let performance = perform(&truth, &thrown(), 6001);
    let toml = bounces::scene_toml(&truth).replace("\"tempo\"", "\"physical\"");
    let moments = toml.lines().find(|line| line.starts_with("moments_kg_m2"));
    let moments = moments.expect("moments are given").to_owned();
    let factor: f64 = 0.5;
    let link = &truth.scene.links[enact::motion::LinkIndex(0)];
    let half = link.body.moments_kg_m2().x * factor;
    let wrong = format!("moments_kg_m2 = [{half:?}, {half:?}, {half:?}]");
    recording::write(&performance, &toml.replace(&moments, &wrong), &path).expect("written");

    let (code, account, object) = replayed(&path, &[]);
    assert_eq!(code, Some(3), "{account}");
    assert_eq!(object["fits"], "no");
    assert_eq!(object["freed"], serde_json::json!([]));
    assert_eq!(object["suspects"][0]["quantity"], "cube.moment.x");
    assert!(account.contains("does not fit"), "{account}");
    assert!(account.contains("suspect: cube.moment.x"), "{account}");

    let (code, account, object) = replayed(&path, &["--free", "auto"]);
    assert_eq!(code, Some(0), "{account}");
    assert_eq!(object["freed"][0]["quantity"], "cube.moment.x");
    let found = object["parameters"]["cube.moment.x"]["value"].as_f64();
    let found = found.expect("a value");
    assert!((found - factor.recip()).abs() < 0.05, "{found}");
    assert!(account.contains("freed: cube.moment.x"), "{account}");
}
