use super::*;
use crate::fixture::{FIRST_NS, estimate, scene, sketch};
use crate::motion::TrackIndex;

/// Every pose is nearer to the one before than its negative would be.
fn assert_continuous(samples: &[PoseSample]) {
    assert!(samples.len() > 10);
    for pair in samples.windows(2) {
        let [before, after] = [0, 1].map(|k| nalgebra::Vector4::from(pair[k].quaternion_xyzw));
        assert!(before.dot(&after) > 0.0, "{before} to {after}");
    }
}

#[test]
fn signs_are_continuous_whatever_those_of_the_estimate_and_the_sketch_are() {
    let (scene, mut estimate, mut sketch) = (scene(), estimate(), sketch());
    let opposite = |q: UnitQuaternion<f64>| UnitQuaternion::new_unchecked(-q.into_inner());
    for sample in sketch.tracks[TrackIndex(0)].samples.iter_mut().step_by(3) {
        if let Seen::Pose { orientation, .. } = &mut sample.seen {
            *orientation = opposite(*orientation);
        }
    }
    let zero = Stamp(FIRST_NS);
    assert_continuous(&sketch_frames(
        &scene,
        &estimate,
        &sketch,
        LinkIndex(0),
        zero,
    ));
    estimate.arcs[1].state.orientation = opposite(estimate.arcs[1].state.orientation);
    let moved = estimate_frames(&scene, &estimate, LinkIndex(0), zero, 240.0);
    assert_continuous(&moved.expect("samples"));
}
