use nalgebra::UnitQuaternion;

use super::*;
use crate::config::scene_from_toml;
use crate::motion::{LinkIndex, Sample, Seen, Stamp};

const TEMPO: &str = include_str!("../../../../config/hat_box.toml");

/// Ten samples, a tenth of a second apart.
fn samples(pose: impl Fn(f64) -> (Vector3<f64>, UnitQuaternion<f64>)) -> TrackSketch {
    let sample = |i: i64| {
        let acted_s = 0.1 * i as f64;
        let (position_m, orientation) = pose(acted_s);
        Sample::of_pose(Stamp(i * 100_000_000), acted_s, position_m, orientation)
    };
    TrackSketch::new((0..10).map(sample).collect())
}

#[test]
fn where_the_tempo_is_unknown_all_falls_are_one_and_no_rise_is() {
    let scene = scene_from_toml(TEMPO).expect("a scene");
    assert!(matches!(scene.timing, Timing::Unknown { .. }));
    let curved = |factor: f64| {
        let place = |t: f64| scene.gravity_m_s2 * (factor * t * t) + Vector3::new(t, 2.0 * t, 0.3);
        let track = samples(|t| (place(t), UnitQuaternion::identity()));
        PrefixSums::of_positions(&scene, TrackIndex(0), &track).cost(0, 10)
    };
    for falls in [0.0, 0.05, 0.5] {
        assert!(curved(falls) < 1e-12, "{falls}: {}", curved(falls));
    }
    assert!(curved(-0.05) > 1e-3, "{}", curved(-0.05));
}

/// One radian about an axis of the largest moment, between the fifth sample and the sixth.
#[test]
fn turns_are_radians_of_the_largest_moment() {
    let scene = scene_from_toml(TEMPO).expect("a scene");
    let moments = scene.links[LinkIndex(0)].body.moments_kg_m2();
    let axis = Vector3::ith(moments.imax(), 1.0);
    let turned = |angle: f64| UnitQuaternion::from_scaled_axis(axis * angle);
    let track = samples(|t| (Vector3::zeros(), turned(if t < 0.45 { 0.0 } else { 1.0 })));
    let cost = PrefixSums::of_turns(&scene, TrackIndex(0), &track).cost(0, 10);
    // A step of one, about its best line: 5/2 − 12.5²/82.5.
    assert!((cost - (2.5 - 12.5 * 12.5 / 82.5)).abs() < 1e-9, "{cost}");
    // A quaternion's sign is no turn.
    let mut signs = track;
    for sample in signs.samples.iter_mut().step_by(2) {
        if let Seen::Pose { orientation, .. } = &mut sample.seen {
            *orientation = UnitQuaternion::new_unchecked(-orientation.into_inner());
        }
    }
    assert!((PrefixSums::of_turns(&scene, TrackIndex(0), &signs).cost(0, 10) - cost).abs() < 1e-9);
}
