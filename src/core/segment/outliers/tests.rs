use nalgebra::UnitQuaternion;
use proptest::prelude::*;

use super::*;
use crate::math::Pose;
use crate::motion::{PoseSample, Stamp};

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

fn delivered(stream: &[PoseSample]) -> Vec<Reading> {
    let samples = stream.iter().enumerate();
    samples
        .map(|(event, sample)| Reading::new(event, sample))
        .collect()
}

fn found(stream: &[PoseSample]) -> Vec<usize> {
    let is_outlier = outliers(&delivered(stream)).into_iter().enumerate();
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

/// White noise in all three directions \[m\], the same every time.
fn noisy(sd_m: f64) -> Vec<PoseSample> {
    let mut stream = bouncing();
    let mut state = 1_u64;
    // A sum of four uniform numbers is near enough to normal.
    let mut draw = || {
        let uniform = (0..4).map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / 2_f64.powi(31) - 0.5
        });
        uniform.sum::<f64>() * 3_f64.sqrt()
    };
    for sample in &mut stream {
        sample.position_m += Vector3::from_fn(|_, _| sd_m * draw());
    }
    stream
}

#[test]
fn a_centimetre_is_no_jump_and_three_are() {
    for (off_m, expected) in [(0.006, &[][..]), (0.03, &[12][..])] {
        let mut stream = bouncing();
        stream[12].position_m.x += off_m;
        assert_eq!(found(&stream), expected, "{off_m} m");
    }
    for (off_rad, expected) in [(0.03, &[][..]), (0.2, &[12][..])] {
        let mut stream = bouncing();
        turned(&mut stream[12], Vector3::new(off_rad, 0.0, 0.0));
        assert_eq!(found(&stream), expected, "{off_rad} rad");
    }
}

/// Where nothing moves the usual distance is zero, and the least limits apply.
#[test]
fn at_rest_a_centimetre_and_some_degrees_are_the_limits() {
    let resting = || {
        let mut stream = bouncing();
        let first = stream[0];
        for sample in &mut stream {
            *sample = PoseSample {
                stamp: sample.stamp,
                ..first
            };
        }
        stream
    };
    for (off_m, expected) in [(0.008, &[][..]), (0.013, &[12][..])] {
        let mut stream = resting();
        stream[12].position_m.x += off_m;
        assert_eq!(found(&stream), expected, "{off_m} m");
    }
    for (off_rad, expected) in [(0.05, &[][..]), (0.08, &[12][..])] {
        let mut stream = resting();
        turned(&mut stream[12], Vector3::new(off_rad, 0.0, 0.0));
        assert_eq!(found(&stream), expected, "{off_rad} rad");
    }
}

#[test]
fn what_is_a_jump_depends_on_the_noise() {
    let sd_m = 0.01;
    assert_eq!(found(&noisy(sd_m)), [0; 0]);
    for (deviations, expected) in [(4.0, &[][..]), (40.0, &[12][..])] {
        let mut stream = noisy(sd_m);
        stream[12].position_m.x += deviations * sd_m;
        assert_eq!(found(&stream), expected, "{deviations} standard deviations");
    }
}

#[test]
fn a_stream_of_which_nearly_half_would_be_left_out_is_kept() {
    // Quiet at first; then six readings of eight are elsewhere, each by itself.
    let stream = |bursts: usize| -> Vec<PoseSample> {
        (0..48 + 8 * bursts)
            .map(|i| {
                let mut position_m = Vector3::new(0.002 * i as f64, 0.1, 0.3);
                if i >= 48 && i % 8 < 6 {
                    position_m.y += 0.3 + 0.2 * ((7 * i) % 11) as f64;
                }
                let pose = Pose::from_parts(position_m.into(), UnitQuaternion::identity());
                PoseSample::from_pose(Stamp(i as i64 * STEP), &pose)
            })
            .collect()
    };
    // 36 of 96 readings, and 54 of 120.
    assert_eq!(found(&stream(6)).len(), 36);
    assert_eq!(found(&stream(9)), [0; 0]);
}

#[test]
fn a_sixth_of_jumps_is_found_and_one_of_two_readings_is_a_strange_stream() {
    let jumping = |period: usize| {
        let mut stream = bouncing();
        for (k, sample) in stream.iter_mut().skip(2).step_by(period).enumerate() {
            sample.position_m.x += 3.0 + k as f64;
        }
        found(&stream).len()
    };
    assert_eq!(jumping(6), 10);
    assert_eq!(jumping(2), 0);
}

proptest! {
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
                PoseSample::new(Stamp(stamp), Vector3::from(position) * scale, q.into())
            })
            .collect();
        let dropped = found(&stream);
        prop_assert!(dropped.len() as f64 <= SHARE_MAX * stream.len() as f64);
        let mut left = delivered(&stream);
        let mut counts = SampleCounts::default();
        drop_outliers(&mut left, &mut counts);
        prop_assert_eq!(left.len() + dropped.len(), stream.len());
        prop_assert_eq!(counts.dropped.values().sum::<usize>(), dropped.len());
    }
}
