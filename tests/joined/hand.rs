//! Pendulums that hang from a handle in the hand, through the program.

use enact::motion::{LinkIndex, TakeEvent, TrackIndex, Verdict};
use enact::physics::tree::Snapshot;
use enact::pipeline::{Outcome, Pipeline};
use enact::sampling::SampledMotion;
use enact_tools::replay::Program;
use enact_tools::tree_hands::{self, HandActing, HandPerformance};
use enact_tools::trees::Jointed;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

const JOINTS: [Jointed; 3] = [Jointed::Pin, Jointed::Universal, Jointed::Ball];

fn finished(performance: &HandPerformance) -> Outcome {
    let events = performance.events.iter().cloned();
    let outcome = Pipeline::of(performance.scene.clone(), events).finish(&mut ());
    outcome.expect("an estimate")
}

/// Root mean square distance of the rods' centres from the true ones \[m\], at all samples.
fn off_m(performance: &HandPerformance, outcome: &Outcome) -> f64 {
    let (scene, estimate) = (&outcome.scene, &outcome.estimate);
    let (_, joined) = scene.joint_trees().next().expect("a tree");
    let tree = scene.tree_model_with(joined, &estimate.held);
    let gravity = &estimate.gravity_m_s2;
    let mut found = Snapshot::new(&tree, gravity);
    let mut truth = Snapshot::new(&performance.tree, gravity);
    let mut square = 0.0;
    for state in &performance.states {
        truth.set(state);
        found.set(&estimate.trees[0].state(&tree, gravity, state.time_s));
        for link in 0..2 {
            let apart = found.link_state(link).position_m - truth.link_state(link).position_m;
            square += apart.norm_squared();
        }
    }
    (square / (2.0 * performance.states.len() as f64)).sqrt()
}

/// From exact samples of the handle and of the tip the motion comes back.
#[test]
fn exact_samples_give_the_motion_back() {
    for joints in JOINTS {
        for seed in 8000..8003 {
            let performance = tree_hands::perform(joints, &HandActing::EXACT, seed);
            let outcome = finished(&performance);
            let estimate = &outcome.estimate;
            assert_eq!(estimate.verdict, Verdict::Physical, "{joints:?} {seed}");
            let off_m = off_m(&performance, &outcome);
            assert!(off_m < 5e-5, "{joints:?} {seed}: {off_m}");
        }
    }
}

/// A usual hand, whose tip wanders by 20 mm and whose handle is seen with 1 mm of noise: the rods are nearer to where they
/// were than what was acted of the tip.
#[test]
fn usual_hands_give_motions_near_the_true_ones() {
    for joints in JOINTS {
        let mut physical = 0;
        for seed in 8010..8015 {
            let performance = tree_hands::perform(joints, &HandActing::USUAL, seed);
            let outcome = finished(&performance);
            let off_m = off_m(&performance, &outcome);
            if outcome.estimate.verdict == Verdict::Physical {
                physical += 1;
                assert!(off_m < 0.02, "{joints:?} {seed}: {off_m}");
                stay_in_the_hand(&outcome);
            }
        }
        assert!(physical >= 4, "{joints:?}: {physical}");
    }
}

/// A tip that bounces on a table while the hand swings on: from exact samples the motion comes back, and of a usual hand it is
/// physical, with the impact within four deviations.
#[test]
fn what_hangs_from_a_hand_may_hit_something() {
    let (mut exact, mut usual, mut physical) = (0, 0, 0);
    for joints in JOINTS {
        for seed in 8000..8025 {
            let Some(performance) = tree_hands::strike(joints, &HandActing::EXACT, seed) else {
                continue;
            };
            if exact < 4 {
                exact += 1;
                let outcome = finished(&performance);
                let off_m = off_m(&performance, &outcome);
                assert!(off_m < 2e-4, "{joints:?} {seed}: {off_m}");
                let off_s = outcome.estimate.events[1].time_s - performance.marked_s("hit");
                assert!(off_s.abs() < 1e-4, "{joints:?} {seed}: {off_s}");
            }
            let performance = tree_hands::strike(joints, &HandActing::USUAL, seed).expect("again");
            let outcome = finished(&performance);
            usual += 1;
            if outcome.estimate.verdict == Verdict::Physical {
                physical += 1;
                let hit = &outcome.estimate.events[1];
                let off_s = (hit.time_s - performance.marked_s("hit")).abs();
                let sd_s = hit.sd_s.expect("it is told");
                assert!(off_s < 4.0 * sd_s, "{joints:?} {seed}: {off_s} {hit:?}");
            }
        }
    }
    assert!(exact == 4 && usual > 8, "{exact} and {usual}");
    assert!(10 * physical >= 8 * usual, "{physical} of {usual}");
}

/// In every frame that is written the first rod's end is at the handle's joint, and the second's at the first's.
fn stay_in_the_hand(outcome: &Outcome) {
    let frames = SampledMotion::new(
        &outcome.scene,
        &outcome.sketch,
        &outcome.estimate,
        None,
        60.0,
    );
    let frames = frames.expect("frames").estimates;
    let place = |link: usize, frame: usize, z_m: f64| {
        let sample = &frames[LinkIndex(link)][frame];
        let [x, y, z, w] = sample.quaternion_xyzw;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let pose = Isometry3::from_parts(Translation3::from(sample.position_m), turn);
        pose * Point3::new(0.0, 0.0, z_m)
    };
    let count = frames[LinkIndex(0)].len();
    assert!(count >= 55, "{count}");
    for link in 1..3 {
        assert_eq!(frames[LinkIndex(link)].len(), count);
        let below_m = if link == 1 { -0.06 } else { -0.1 };
        for frame in 0..count {
            let apart = place(link - 1, frame, below_m) - place(link, frame, 0.1);
            assert!(apart.norm() < 1e-9, "{link} {frame}: {apart}");
        }
    }
}

/// A handle that is not seen for a while, or not at the end, is an error that says when.
#[test]
fn a_hand_that_is_not_seen_is_an_error() {
    let performance = tree_hands::perform(Jointed::Pin, &HandActing::USUAL, 8030);
    let without = |is_lost: &dyn Fn(f64) -> bool| {
        let events = performance.events.iter().filter(|event| match event {
            TakeEvent::Pose { track, sample, .. } => {
                *track != TrackIndex(0) || !is_lost(1e-9 * sample.stamp.0 as f64 - 1.0)
            }
            _ => true,
        });
        let pipeline = Pipeline::of(performance.scene.clone(), events.cloned());
        pipeline.finish(&mut ()).map(|_| ())
    };
    for (is_lost, said) in [
        (
            &|s: f64| s > 0.301 && s < 0.499,
            "\"handle\" is held, bodies hang from it, and it is not seen between 0.300 s and 0.500 s",
        ),
        (&|s: f64| s > 0.701, "not seen between 0.700 s and 0.900 s"),
        (&|s: f64| s < 0.199, "not seen between 0.000 s and 0.200 s"),
    ] as [(&dyn Fn(f64) -> bool, &str); 3]
    {
        let error = without(is_lost).expect_err("a gap").to_string();
        assert!(error.contains(said), "{error}");
    }
    assert!(without(&|s: f64| s > 0.301 && s < 0.35).is_ok());
}

/// The program tells of it and writes it, and what it writes can be looked at.
#[test]
fn the_program_writes_it() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("hand.mcap");
    let performance = tree_hands::perform(Jointed::Universal, &HandActing::EXACT, 8040);
    performance.write(&path).expect("a recording");
    let replayed = ENACT.account(&path, &[]);
    assert_eq!(replayed.code, Some(0), "{replayed:?}");
    assert!(replayed.said.contains("physical"), "{}", replayed.said);
    assert!(replayed.said.contains("handle, held"), "{}", replayed.said);
    assert!(replayed.output.exists());
}
