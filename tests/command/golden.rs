//! The recordings that come along: what they become, and how much work it takes.
//!
//! The work is counted, not timed. A change of the counters is no error by itself: it says that
//! the solver goes another way. If that is meant, run
//!
//! ```text
//! cargo test --test golden
//! ```
//!
//! take the numbers from its message, and say in the commit why they changed. The event times
//! must not change with them by more than a microsecond, unless the problem itself is another one.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::{Counters, FitUntold, LinkIndex, Scene, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use serde::Deserialize;

/// Event times are the same to this [s].
const SAME_S: f64 = 1e-6;
/// Beside three reported standard deviations: where the wander is slower than an arc, residuals
/// cannot show how long it lasts [s].
const MARGIN_S: f64 = 0.005;

struct Golden {
    file: &'static str,
    verdict: Verdict,
    counters: Counters,
    event_times_s: &'static [f64],
}

/// `hat_box_bent.mcap` takes hundreds of iterations, which rounding may change.
fn golden() -> [Golden; 4] {
    [
        Golden {
            file: "pencil_tip.mcap",
            verdict: Verdict::Physical,
            counters: Counters {
                iterations: 17,
                evaluations: 21,
                factorisations: 17,
                fit_iterations: 12,
                assignment_rounds: 1,
                starts: 1,
            },
            event_times_s: &[0.3451364, 0.7946853],
        },
        Golden {
            file: "pencil_eraser.mcap",
            verdict: Verdict::Physical,
            counters: Counters {
                iterations: 24,
                evaluations: 31,
                factorisations: 24,
                fit_iterations: 12,
                assignment_rounds: 2,
                starts: 2,
            },
            event_times_s: &[0.3475341, 0.7750379],
        },
        Golden {
            file: "hat_box.mcap",
            verdict: Verdict::Physical,
            counters: Counters {
                iterations: 28,
                evaluations: 35,
                factorisations: 29,
                fit_iterations: 24,
                assignment_rounds: 4,
                starts: 2,
            },
            event_times_s: &[0.2731295, 0.5661924, 0.8736925],
        },
        Golden {
            file: "die.mcap",
            verdict: Verdict::Plausible,
            counters: Counters {
                iterations: 12,
                evaluations: 16,
                factorisations: 12,
                fit_iterations: 32,
                assignment_rounds: 0,
                starts: 1,
            },
            event_times_s: &[
                0.2145407, 0.3942213, 0.5588449, 0.7211546, 0.8796053, 1.0096242,
            ],
        },
    ]
}

/// What the tests need of the attachment `truth.json`.
#[derive(Deserialize)]
struct TrueMotion {
    events: Vec<TrueEvent>,
    samples: Vec<TrueSamples>,
}

#[derive(Deserialize)]
struct TrueEvent {
    name: String,
    time_s: f64,
}

#[derive(Deserialize)]
struct TrueSamples {
    stamps_ns: Vec<i64>,
    times_s: Vec<f64>,
}

fn open(file: &str) -> Recording {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
    Recording::open(&folder.join(file)).unwrap()
}

fn scene(recording: &Recording) -> Scene {
    let text = recording
        .scene_toml()
        .expect("the recording carries its scene");
    scene_from_toml(std::str::from_utf8(text).unwrap()).unwrap()
}

fn estimated(recording: &Recording) -> Outcome {
    let scene = scene(recording);
    let take = recording.take(&scene).unwrap();
    Pipeline::of(scene, take.events).finish(&mut ()).unwrap()
}

fn truth(recording: &Recording) -> TrueMotion {
    let container = recording.container();
    let mut attachments = container.attachments().iter();
    let attachment = attachments.find(|attachment| attachment.name == "truth.json");
    serde_json::from_slice(container.attachment_data(attachment.unwrap())).unwrap()
}

/// Those of one pencil.
fn pencils() -> impl Iterator<Item = Golden> {
    let is_pencil = |golden: &Golden| golden.file.starts_with("pencil");
    golden().into_iter().filter(is_pencil)
}

#[test]
fn work_and_events_are_as_they_were() {
    let mut found = Vec::new();
    let mut is_same = true;
    for golden in golden() {
        let outcome = estimated(&open(golden.file));
        let estimate = &outcome.estimate;
        let (verdict, file) = (golden.verdict, golden.file);
        assert_eq!(estimate.verdict, verdict, "{file}: {:?}", estimate.reason);
        let times_s: Vec<f64> = estimate.events.iter().map(|event| event.time_s).collect();
        is_same &= estimate.counters == golden.counters;
        let pairs = times_s.iter().zip(golden.event_times_s);
        is_same &= times_s.len() == golden.event_times_s.len();
        is_same &= pairs.fold(true, |same, (a, b)| same && (a - b).abs() < SAME_S);
        found.push(format!(
            "{}: {:#?}, event times {times_s:.8?}",
            golden.file, estimate.counters
        ));
    }
    assert!(is_same, "changed; now they are\n{}", found.join("\n"));
}

#[test]
fn events_are_where_they_really_were() {
    for golden in pencils() {
        let recording = open(golden.file);
        let outcome = estimated(&recording);
        let (scene, truth) = (scene(&recording), truth(&recording));
        let estimate = &outcome.estimate;
        // The zero of physical time is a convention: the first sample that is used has it.
        let first = estimate.sample_times[0];
        let samples = &truth.samples[0];
        let index = samples.stamps_ns.binary_search(&first.stamp.0).unwrap();
        let offset_s = first.time_s - samples.times_s[index];
        for event in &estimate.events {
            let name = &scene.events[event.event].name;
            let known = truth
                .events
                .iter()
                .find(|other| other.name == *name)
                .unwrap();
            let error_s = event.time_s - offset_s - known.time_s;
            let sd_s = event.sd_s.expect("both events are estimated");
            assert!(
                error_s.abs() <= 3.0 * sd_s + MARGIN_S,
                "{} {name}: off by {error_s} s, reported {sd_s} s",
                golden.file
            );
        }
    }
}

#[test]
fn independent_checks_agree_and_the_pencil_rests_in_the_mug() {
    for golden in pencils() {
        let recording = open(golden.file);
        let outcome = estimated(&recording);
        let checked = outcome.verification.expect("physical motions are checked");
        assert!(checked.doubts().is_empty(), "{}: {checked:#?}", golden.file);
        // The feature is the middle of the pencil's end, and the pencil leans: the rim leads.
        let [touch] = &checked.touches[..] else {
            panic!("one collision")
        };
        assert!((1e-4..1e-3).contains(&touch.lead_m), "{touch:?}");
        let end = checked.single_shot.at_end().expect("an end");
        assert!(
            end.position_m < 1e-10 && end.orientation_rad < 1e-9,
            "{end:?}"
        );
        assert!(end.velocity_m_s < 1e-10 && end.angular_velocity_rad_s < 1e-8);

        let settled = outcome.settled.expect("the scene asks for it");
        assert!(settled.at_rest && settled.end_s() - settled.from_s < 2.5);
        let poses = &settled.links[LinkIndex(0)].poses;
        let last = poses.last().expect("poses");
        // Its lower end is within the walls and on the floor, its upper end above the rim.
        let lower = last * nalgebra::Point3::new(0.0, 0.0, -0.095);
        let upper = last * nalgebra::Point3::new(0.0, 0.0, 0.095);
        assert!(lower.coords.xy().norm() < 0.04 && lower.z > 0.0, "{lower}");
        assert!(lower.z < 0.02 && upper.z > 0.095, "{lower} {upper}");
        let landing_m_s = settled.largest_speed_m_s;
        let arc = outcome.estimate.arcs.last().expect("arcs");
        let speed =
            arc.state.velocity_m_s + outcome.estimate.gravity_m_s2 * (arc.end_s - arc.epoch_s);
        assert!(landing_m_s <= speed.norm() * (1.0 + 1e-9), "{landing_m_s}");
    }
}

#[test]
fn an_estimate_alone_is_the_same_without_checks() {
    let recording = open(golden()[0].file);
    let scene = scene(&recording);
    let pipeline = Pipeline::of(scene.clone(), recording.take(&scene).unwrap().events);
    let (alone, whole) = (
        pipeline.estimate(&mut ()).unwrap(),
        pipeline.finish(&mut ()).unwrap(),
    );
    let mut unchecked = whole.estimate.clone();
    assert!(unchecked.fit.is_ok());
    unchecked.fit = Err(FitUntold::NotAsked);
    unchecked.suspects.clear();
    for event in &mut unchecked.events {
        event.leaning = None;
    }
    assert_eq!(alone.estimate, unchecked);
    assert!(alone.verification.is_none() && alone.settled.is_none());
    assert_eq!(pipeline.finish(&mut ()).unwrap(), whole);
}
