//! Joined bodies that hit a table go on until they lie on it, through the program.

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{LinkIndex, PoseSample, Scene, Verdict};
use enact::physics::tree::JointKind;
use enact::pipeline::{Outcome, Pipeline};
use enact::sampling::SampledMotion;
use enact_tools::replay::Program;
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck, strike};
use enact_tools::trees::Jointed;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// Flying rods that hit the table once and fly on, with so many seconds to come to rest.
fn thrown(joints: Jointed, settle_s: f64, seed: u64) -> Strike {
    let flail = Struck {
        form: Form::Rod,
        links: 3,
        joints,
        hangs_m: None,
        impacts: 1,
        law: [0.5, 0.2],
    };
    let mut thrown = strike(&flail, &Acted::of(0.5), seed);
    let settles = format!("settle_s = {settle_s:?}\n\n[timing]");
    thrown.scene_toml = thrown.scene_toml.replace("[timing]", &settles);
    thrown.scene = scene_from_toml(&thrown.scene_toml).expect("a valid scene");
    thrown
}

fn finished(strike: &Strike) -> Outcome {
    let events = strike.events.iter().cloned();
    let outcome = Pipeline::of(strike.scene.clone(), events).finish(&mut ());
    outcome.expect("an estimate")
}

fn pose(sample: &PoseSample) -> Pose {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Pose::from_parts(sample.position_m.into(), turn)
}

/// How far the joints are from holding in a frame: places \[m\], and for universal joints the cosine between
/// their axes.
fn apart(scene: &Scene, motion: &SampledMotion, frame: usize) -> f64 {
    let (_, joined) = scene.joint_trees().next().expect("a tree");
    let at = |link: LinkIndex| pose(&motion.estimates[link][frame]);
    let joints = joined.joints.iter().map(|of| {
        let parent = at(of.parent.expect("rods that fly")) * of.joint.parent_from_joint;
        let child = at(of.child) * of.joint.link_from_joint;
        let gap_m = (parent.translation.vector - child.translation.vector).norm();
        let turned = match of.joint.kind {
            JointKind::Universal { axes: [a, b] } => {
                (parent.rotation * a).dot(&(child.rotation * b)).abs()
            }
            _ => 0.0,
        };
        gap_m.max(turned)
    });
    joints.fold(0.0, f64::max)
}

/// The motion goes on where it ended, stays joined in every frame that is written, and ends on the table, at rest.
#[test]
fn a_chain_that_hits_the_table_comes_to_lie_on_it() {
    for joints in [Jointed::Pin, Jointed::Ball] {
        let thrown = thrown(joints, 20.0, 8030);
        let outcome = finished(&thrown);
        assert_eq!(outcome.estimate.verdict, Verdict::Physical, "{joints:?}");
        let settled = outcome.settled.as_ref().expect("the scene asks for it");
        assert!(settled.at_rest, "{joints:?}: {}", settled.end_s());
        let [_, end_s] = outcome.estimate.trees[0].span_s();
        assert_eq!(settled.from_s, end_s);
        let motion = SampledMotion::new(
            &outcome.scene,
            &outcome.sketch,
            &outcome.estimate,
            outcome.settled.as_ref(),
            240.0,
        );
        let motion = motion.expect("frames");
        let frames = motion.estimates[LinkIndex(0)].len();
        assert!(frames > 240, "{frames}");
        for frame in 0..frames {
            let apart = apart(&outcome.scene, &motion, frame);
            assert!(apart < 1e-9, "{joints:?} {frame}: {apart}");
        }
        for (link, samples) in motion.estimates.iter_enumerated() {
            // No jump from one frame to the next, least of all at the end of the estimate.
            for pair in samples.windows(2) {
                let way_m = (pair[1].position_m - pair[0].position_m).norm();
                assert!(
                    way_m < 0.05,
                    "{joints:?} {link:?} at {:?}: {way_m}",
                    pair[0].stamp
                );
            }
            let last = pose(samples.last().expect("frames"));
            let solid = outcome.scene.links[link].shape.solid().expect("a shape");
            let lowest = solid.lowest(&last, &Vector3::zeros(), &Vector3::z());
            let gap_m = lowest.expect("a surface below").gap_m;
            // Thin rods that lie across each other, or flat.
            assert!(
                (-1e-3..5e-3).contains(&gap_m),
                "{joints:?} {link:?}: {gap_m}"
            );
        }
    }
}

/// What is written and said of it is as of bodies by themselves.
#[test]
fn the_account_says_that_it_rests() {
    let folder = TempDir::new().unwrap();
    let recording = folder.path().join("thrown.mcap");
    for (settle_s, said, at_rest) in [(20.0, "at rest", true), (0.05, "still moving", false)] {
        thrown(Jointed::Pin, settle_s, 8030)
            .write(&recording)
            .unwrap();
        let account = ENACT.account(&recording, &[]).said;
        let line = account.lines().find(|line| line.contains("settled"));
        assert!(line.is_some_and(|line| line.contains(said)), "{account}");
        let report = ENACT.report(&recording, &[]).said;
        assert_eq!(report["settled"]["at_rest"], at_rest, "{report}");
    }
}

/// How joined bodies rest is not led to.
#[test]
fn goals_at_rest_of_joined_bodies_are_refused() {
    let text = thrown(Jointed::Pin, 5.0, 8030).scene_toml;
    let goal = "\n[[goal]]\nevent = \"rest\"\nbody = \"rod 1\"\nface_up = \"+z\"\n";
    let error = scene_from_toml(&(text + goal)).unwrap_err().to_string();
    assert!(error.contains("expected no face_up"), "{error}");
}
