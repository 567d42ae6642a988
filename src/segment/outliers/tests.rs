use nalgebra::UnitQuaternion;
use proptest::prelude::*;

use super::*;
use crate::math::Pose;
use crate::motion::Stamp;

const STEP: i64 = 8_333_333;

/// Falls, turns, and bounces at reading 30 with another velocity and another turn.
fn bouncing() -> Vec<PoseSample> {
    (0..60)
        .map(|i| {
            let s = (f64::from(i) - 30.3) / 120.0;
            let (up, rate) = if s < 0.0 { (-3.0, 14.0) } else { (2.5, -9.0) };
            let position_m = Vector3::new(0.4 * s, 0.1, up * s - 4.9 * s * s);
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.2, rate * s, 0.0));
            let stamp = Stamp(1_700_000_000_000_000_000 + i64::from(i) * STEP);
            PoseSample::from_pose(stamp, &Pose::from_parts(position_m.into(), turn))
        })
        .collect()
}

fn found(stream: &[PoseSample]) -> Vec<usize> {
    let is_outlier = outliers(stream).into_iter().enumerate();
    is_outlier
        .filter_map(|(index, is)| is.then_some(index))
        .collect()
}

fn turned(sample: &mut PoseSample, about: Vector3<f64>) {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let q = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
        * UnitQuaternion::from_scaled_axis(about);
    sample.quaternion_xyzw = [q.i, q.j, q.k, q.w];
}

#[test]
fn a_bounce_is_no_outlier() {
    assert_eq!(found(&bouncing()), [0; 0]);
}

#[test]
fn the_sign_of_a_quaternion_is_no_jump() {
    let mut stream = bouncing();
    for sample in stream.iter_mut().step_by(3) {
        sample.quaternion_xyzw = sample.quaternion_xyzw.map(|x| -x);
    }
    assert_eq!(found(&stream), [0; 0]);
}

#[test]
fn jumps_are_found_alone_and_in_bursts_beside_a_bounce_and_at_the_ends() {
    let bursts: [&[usize]; 8] = [
        &[12],
        &[40, 41],
        &[20, 21, 22],
        &[30],
        &[31, 32],
        &[0],
        &[59],
        &[5, 25, 26, 45, 46, 47],
    ];
    for burst in bursts {
        // All by one jump, and each by its own.
        for spread in [0.0, 0.07] {
            let mut stream = bouncing();
            for (k, index) in burst.iter().enumerate() {
                stream[*index].position_m.x += 0.1 + spread * k as f64;
            }
            assert_eq!(found(&stream), burst, "{spread}");
            let mut stream = bouncing();
            for (k, index) in burst.iter().enumerate() {
                let angle = 0.8 + 5.0 * spread * k as f64;
                turned(&mut stream[*index], Vector3::new(angle, 0.0, 0.3));
            }
            assert_eq!(found(&stream), burst, "turned {spread}");
        }
    }
}

#[test]
fn a_place_that_is_kept_is_no_outlier() {
    // Five in a row elsewhere are a motion, however strange.
    let mut stream = bouncing();
    for sample in &mut stream[10..25] {
        sample.position_m.y += 0.5;
    }
    assert_eq!(found(&stream), [0; 0]);
}

#[test]
fn what_has_no_usual_distance_is_left_alone() {
    let mut stream = bouncing();
    stream.truncate(READINGS_MIN - 1);
    stream[3].position_m.x += 10.0;
    assert_eq!(found(&stream), [0; 0]);
    let mut stream = bouncing();
    for sample in stream.iter_mut().step_by(2) {
        sample.position_m.x += 10.0;
    }
    assert_eq!(found(&stream), [0; 0]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn any_stream_is_judged_and_most_of_it_kept(
        readings in prop::collection::vec(
            (1i64..40_000_000, prop::array::uniform3(-1e3..1e3), prop::array::uniform4(-1.0..1.0)),
            0..60,
        ),
        scale in prop::sample::select(vec![0.0, 1e-9, 1e-3, 1.0, 1e200]),
    ) {
        let mut stamp = 0;
        let stream: Vec<PoseSample> = readings
            .into_iter()
            .map(|(step, position, xyzw): (i64, [f64; 3], [f64; 4])| {
                stamp += step;
                let q = Vector4::from(xyzw);
                let q = if q.norm() > 0.1 { q.normalize() } else { Vector4::w() };
                PoseSample {
                    stamp: Stamp(stamp),
                    position_m: Vector3::from(position) * scale,
                    quaternion_xyzw: q.into(),
                }
            })
            .collect();
        let dropped = found(&stream);
        prop_assert!(dropped.len() as f64 <= SHARE_MAX * stream.len() as f64);
        let mut left = stream.clone();
        let mut counts = SampleCounts::default();
        drop_outliers(&mut left, &mut counts);
        prop_assert_eq!(left.len() + dropped.len(), stream.len());
        prop_assert_eq!(counts.dropped.values().sum::<usize>(), dropped.len());
    }
}
