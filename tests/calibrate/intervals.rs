//! How often the intervals of calibrations contain the truth, on seeds that nothing was chosen by, with noise as
//! trackers and hands have it; and what is refused.

use enact::calibrate::{
    CalibrateError, Flight, LengthUnit, Stream, Touch, clock, flights, gravity, pivot, plane, rest,
    touch,
};
use enact::math::so3::exp;
use nalgebra::{Matrix3, Vector3};

use crate::performed::*;

/// Nothing was tuned on these.
const SEEDS: std::ops::Range<u64> = 7000..7100;

fn stream(samples: &[enact::motion::PoseSample]) -> Stream {
    Stream::of(samples, None, 2).expect("poses")
}

/// Share of intervals that contain the truth.
fn share(covered: &[bool]) -> f64 {
    covered.iter().filter(|covers| **covers).count() as f64 / covered.len() as f64
}

/// Of 95 % intervals, 90 to 99 % should contain the truth; one half more is the rounding of 300.
fn assert_honest(covered: &[bool], what: &str) {
    let share = share(covered);
    eprintln!("{what}: {:.1} % of {}", share * 100.0, covered.len());
    // Of 100 that are right 90 times, 88 is usual.
    assert!((0.88..=0.995).contains(&share), "{what}: {share}");
}

const HANDS: [(Hand, f64); 4] = [
    (Hand::None, 0.0),
    (Hand::Wanders(0.1), 5e-4),
    (Hand::Wanders(0.4), 5e-4),
    (Hand::Vibrates(7.0), 5e-4),
];

#[test]
fn tips_are_within_their_intervals() {
    for (hand, hand_m) in HANDS {
        let (mut tips, mut places) = (Vec::new(), Vec::new());
        for seed in SEEDS {
            let fit = pivot(&stream(&swing(seed, hand, hand_m, 20.0))).expect("a swing");
            assert!(fit.tip_m.half.iter().all(|half| *half < 2e-3), "{fit:?}");
            tips.extend(fit.tip_m.covers(TIP_M.as_slice()));
            places.extend(fit.place_m.covers(PLACE_M.as_slice()));
        }
        assert_honest(&tips, &format!("tip, {hand:?}"));
        assert_honest(&places, &format!("place, {hand:?}"));
    }
}

#[test]
fn a_tip_that_wanders_as_slowly_as_the_recording_is_long_is_said() {
    let samples = swing(3, Hand::Wanders(8.0), 1e-3, 12.0);
    let fit = pivot(&stream(&samples)).expect("a swing");
    assert!(fit.spread.is_slow, "{:?}", fit.spread);
}

#[test]
fn a_tip_that_slips_for_a_while_is_left_out() {
    let mut samples = swing(4, Hand::None, 0.0, 20.0);
    for sample in &mut samples[300..360] {
        sample.position_m += Vector3::new(0.02, 0.0, 0.01);
    }
    let fit = pivot(&stream(&samples)).expect("a swing");
    assert!(fit.outliers >= 60 && fit.outliers < 80, "{}", fit.outliers);
    let off_m = Vector3::from_column_slice(&fit.tip_m.value) - TIP_M;
    assert!(off_m.norm() < 1e-4, "{off_m}");
}

#[test]
fn a_swing_about_one_axis_is_refused() {
    let samples = (0..600).map(|at| {
        let time_s = f64::from(at) * 0.01;
        let turn = exp(&Vector3::new(0.6 * (2.0 * time_s).sin(), 0.0, 0.0));
        sample(time_s, PLACE_M - turn * TIP_M, &turn)
    });
    let refused = pivot(&stream(&samples.collect::<Vec<_>>())).unwrap_err();
    assert!(
        matches!(refused, CalibrateError::NoSwing { .. }),
        "{refused}"
    );
    let few = pivot(&stream(&swing(1, Hand::None, 0.0, 0.2))).unwrap_err();
    assert!(
        matches!(few, CalibrateError::TooFew { usable: 20, .. }),
        "{few}"
    );
}

/// Touches of a tilted table, so many, each off by so much on its own.
fn touches(noise: &mut Noise, count: usize, normal: &Vector3<f64>, off_m: f64) -> Vec<Touch> {
    let tilt = enact::math::so3::between(&Vector3::z(), normal);
    let touch = |at: usize| {
        let (x, y) = (noise.uniform(-0.25, 0.25), noise.uniform(-0.15, 0.15));
        let point_m = PLACE_M + tilt * Vector3::new(x, y, 0.0) + noise.white() * off_m;
        Touch {
            time_s: at as f64,
            point_m,
            tracker_m: point_m + Vector3::new(0.0, 0.0, 0.1),
            turn: Matrix3::identity(),
        }
    };
    (0..count).map(touch).collect()
}

#[test]
fn planes_are_within_their_intervals() {
    let normal = Vector3::new(0.04, -0.02, 1.0).normalize();
    for count in [4, 5, 8, 20] {
        let (mut heights, mut tilts, mut refused) = (Vec::new(), Vec::new(), 0);
        for seed in SEEDS {
            let mut noise = Noise::new(seed, Hand::None);
            let touches = touches(&mut noise, count, &normal, 4e-4);
            let Ok(fit) = plane(&touches, &Vector3::zeros(), &Vector3::z()) else {
                refused += 1;
                continue;
            };
            assert!(fit.normal.z > 0.0);
            let off_m = normal.dot(&(fit.point_m - PLACE_M));
            heights.push(off_m.abs() <= fit.height_m.half[0]);
            let tilt = fit.axes.map(|axis| normal.dot(&axis));
            tilts.extend(fit.tilt_rad.covers(&tilt));
        }
        assert!(refused <= 10, "{count}: {refused} refused");
        assert_honest(&heights, &format!("height, {count} touches"));
        assert_honest(&tilts, &format!("tilt, {count} touches"));
    }
}

#[test]
fn the_uncertainty_of_the_tip_is_in_that_of_the_plane() {
    let mut noise = Noise::new(5, Hand::None);
    let touches = touches(&mut noise, 9, &Vector3::z(), 1e-4);
    let sure = plane(&touches, &Vector3::zeros(), &Vector3::z()).unwrap();
    let unsure = plane(&touches, &Vector3::new(0.0, 0.0, 1e-3), &Vector3::z()).unwrap();
    assert!(sure.height_m.half[0] < 3e-4);
    let half_m = unsure.height_m.half[0];
    assert!((half_m - 1.96e-3).abs() < 1e-4, "{half_m}");
}

#[test]
fn touches_in_a_line_or_too_few_are_refused_and_one_that_is_none_is_left_out() {
    let at = |x: f64, y: f64, z: f64| Touch {
        time_s: 0.0,
        point_m: Vector3::new(x, y, z),
        tracker_m: Vector3::new(x, y, z + 0.1),
        turn: Matrix3::identity(),
    };
    let fit = |touches: &[Touch]| plane(touches, &Vector3::zeros(), &Vector3::z());
    let line = [
        at(0.0, 0.0, 0.0),
        at(0.1, 0.001, 0.0),
        at(0.2, 0.0, 0.0),
        at(0.3, 0.001, 0.0),
    ];
    let refused = fit(&line).unwrap_err();
    let CalibrateError::Collinear { long_mm, wide_mm } = refused else {
        panic!("{refused}");
    };
    assert!((long_mm - 300.0).abs() < 2.0 && wide_mm < 2.0, "{refused}");
    assert_eq!(fit(&line[..2]).unwrap_err(), CalibrateError::FewTouches(2));
    let mut noise = Noise::new(6, Hand::None);
    let mut many = touches(&mut noise, 9, &Vector3::z(), 2e-4);
    many[4].point_m.z += 0.01;
    let fit = fit(&many).unwrap();
    assert_eq!(fit.outliers, [4]);
    assert!((fit.distances_m[4] - 0.01).abs() < 1e-3);
    // Three span a plane, and say nothing of how good it is.
    let three = plane(&many[..3], &Vector3::zeros(), &Vector3::z()).unwrap();
    assert!(three.residual_m.is_none() && three.height_m.half[0].is_infinite());
}

#[test]
fn right_touches_are_left_out_as_seldom_as_is_said() {
    for count in [6, 7, 10] {
        let mut noise = Noise::new(900 + count as u64, Hand::None);
        let mut left_out = 0;
        for _ in 0..3000 {
            let touches = touches(&mut noise, count, &Vector3::z(), 4e-4);
            if let Ok(fit) = plane(&touches, &Vector3::zeros(), &Vector3::z()) {
                left_out += usize::from(!fit.outliers.is_empty());
            }
        }
        // One in a thousand, by more than chance.
        assert!(left_out <= 9, "{count} touches: {left_out} of 3000");
    }
}

#[test]
fn a_touch_is_where_the_tip_is_while_it_stays() {
    let samples = swing(8, Hand::None, 0.0, 4.0);
    let found = touch(&stream(&samples), 2.0, &TIP_M, 0.05).unwrap();
    assert!((found.point_m - PLACE_M).norm() < 5e-4, "{found:?}");
    let outside = touch(&stream(&samples), 9.0, &TIP_M, 0.05).unwrap_err();
    assert!(matches!(outside, CalibrateError::TouchOutside { .. }));
}

#[test]
fn noise_at_rest_is_within_its_intervals() {
    for (hand, hand_m) in [
        (Hand::None, 0.0),
        (Hand::Wanders(0.1), 3e-4),
        (Hand::Wanders(0.4), 3e-4),
    ] {
        let hand_rad = 0.5 * hand_m;
        let truth_m = 1e-4_f64.hypot(hand_m);
        let truth_rad = 0.02_f64.to_radians().hypot(hand_rad);
        let mut covered = Vec::new();
        for seed in SEEDS {
            let fit = rest(&stream(&still(seed, hand, (hand_m, hand_rad), 30.0))).expect("a rest");
            assert!(!fit.is_slow, "{fit:?}");
            let covers = |axis: &enact::calibrate::NoiseAxis, truth: f64| {
                axis.lower <= truth && truth <= axis.upper
            };
            covered.extend(fit.position_m.iter().map(|axis| covers(axis, truth_m)));
            covered.extend(
                fit.orientation_rad
                    .iter()
                    .map(|axis| covers(axis, truth_rad)),
            );
        }
        assert_honest(&covered, &format!("noise, {hand:?}"));
    }
    let slow = rest(&stream(&still(1, Hand::Wanders(10.0), (1e-3, 1e-3), 12.0))).unwrap();
    assert!(slow.is_slow && slow.moved_m > 1e-3, "{slow:?}");
}

#[test]
fn gravity_of_one_flight_is_within_its_interval() {
    for hand in [Hand::None, Hand::Wanders(0.02)] {
        for (samples, knows_centre) in [(14, true), (20, true), (30, false)] {
            let (mut covered, mut sizes) = (Vec::new(), Vec::new());
            let centre_m = Vector3::new(0.02, -0.01, 0.03);
            for seed in SEEDS {
                let mut noise = Noise::new(seed, hand);
                let readings = flight(&mut noise, 0.0, samples, (3e-5, 1.0), &centre_m);
                let flight = Flight {
                    readings: stream(&readings).readings,
                };
                let fit = gravity(&[flight], knows_centre.then_some(&centre_m)).expect("a flight");
                assert!(!fit.is_between_flights);
                covered.extend(fit.gravity.covers(GRAVITY_M_S2.as_slice()));
                sizes.extend(fit.size.covers(&[GRAVITY_M_S2.norm()]));
            }
            let what = format!("{hand:?}, {samples} samples, centre known {knows_centre}");
            assert_honest(&covered, &format!("gravity, {what}"));
            eprintln!("size, {what}: {}", share(&sizes));
        }
    }
}

#[test]
fn gravity_of_many_flights_covers_how_they_differ() {
    for count in [6, 12] {
        let (mut alone, mut together) = (Vec::new(), Vec::new());
        for seed in SEEDS {
            let mut noise = Noise::new(seed, Hand::None);
            let flights: Vec<Flight> = (0..count)
                .map(|at| {
                    // Lengths are off by 0.5 % from place to place.
                    let scale = 1.0 + 0.005 * noise.white().x;
                    let readings = flight(
                        &mut noise,
                        f64::from(at),
                        24,
                        (3e-5, scale),
                        &Vector3::zeros(),
                    );
                    Flight {
                        readings: stream(&readings).readings,
                    }
                })
                .collect();
            let whole = gravity(&flights, Some(&Vector3::zeros())).expect("flights");
            assert!(whole.is_between_flights && whole.unit == Some(LengthUnit::Metre));
            together.extend(whole.size.covers(&[GRAVITY_M_S2.norm()]));
            let one = gravity(&flights[..1], Some(&Vector3::zeros())).expect("a flight");
            alone.extend(one.size.covers(&[GRAVITY_M_S2.norm()]));
        }
        assert_honest(&together, &format!("size of gravity, {count} flights"));
        // What the documentation says of one flight.
        assert!(share(&alone) < 0.8, "one flight alone: {}", share(&alone));
    }
}

#[test]
fn flights_are_found_among_rest_and_hand() {
    let mut noise = Noise::new(11, Hand::None);
    let mut samples = Vec::new();
    let still = |from_s: f64, count: usize, noise: &mut Noise| -> Vec<_> {
        let at = |at: usize| {
            let position_m = PLACE_M + noise.white() * 3e-5;
            sample(
                from_s + at as f64 / 150.0,
                position_m,
                &exp(&Vector3::zeros()),
            )
        };
        (0..count).map(at).collect()
    };
    samples.extend(still(0.0, 150, &mut noise));
    samples.extend(flight(&mut noise, 1.0, 30, (3e-5, 1.0), &Vector3::zeros()));
    samples.extend(still(1.2, 150, &mut noise));
    samples.extend(flight(&mut noise, 2.2, 40, (3e-5, 1.0), &Vector3::zeros()));
    samples.extend(still(2.2 + 40.0 / 150.0, 60, &mut noise));
    let found = flights(&stream(&samples), &Vector3::zeros());
    let truth = [150..180, 330..370];
    assert_eq!(found.len(), 2, "{found:?}");
    for (found, truth) in found.iter().zip(truth) {
        assert!(found.start.abs_diff(truth.start) <= 2, "{found:?}");
        assert!(found.end.abs_diff(truth.end) <= 2, "{found:?}");
    }
    let none = still(0.0, 300, &mut noise);
    assert!(flights(&stream(&none), &Vector3::zeros()).is_empty());
}

#[test]
fn clocks_are_within_their_intervals() {
    for (hand, wobble_rad) in [
        (Hand::None, 0.0),
        (Hand::Wanders(0.2), 2e-3),
        (Hand::Vibrates(5.0), 1e-3),
    ] {
        let (mut offsets, mut rates) = (Vec::new(), Vec::new());
        for seed in SEEDS {
            let [first, second] = turned(seed, hand, wobble_rad, 15.0);
            let first = stream(&first);
            let second = Stream::of(&second, Some(first.origin), 2).unwrap();
            let fit = clock(&first, &second).expect("a motion");
            assert!(
                (fit.offset_s.value[0] - OFFSET_S).abs() < 5e-3,
                "{seed}: {fit:?}"
            );
            offsets.extend(fit.offset_s.covers(&[OFFSET_S]));
            rates.extend(fit.rate.covers(&[RATE]));
        }
        assert_honest(&offsets, &format!("offset, {hand:?}"));
        assert_honest(&rates, &format!("drift, {hand:?}"));
    }
}

#[test]
fn clocks_of_two_motions_are_refused() {
    let [first, _] = turned(1, Hand::None, 0.0, 10.0);
    let [other, _] = turned(2, Hand::None, 0.0, 10.0);
    let first = stream(&first);
    let other = Stream::of(&other, Some(first.origin), 2).unwrap();
    let refused = clock(&first, &other).unwrap_err();
    assert!(
        matches!(refused, CalibrateError::NoAgreement(_)),
        "{refused}"
    );
    let short = Stream::of(&turned(1, Hand::None, 0.0, 1.0)[1], Some(first.origin), 2).unwrap();
    let refused = clock(&first, &short).unwrap_err();
    assert!(
        matches!(refused, CalibrateError::NoOverlap { .. }),
        "{refused}"
    );
}
