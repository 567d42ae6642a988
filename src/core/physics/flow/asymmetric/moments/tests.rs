use nalgebra::{Quaternion, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::math::{differentiate, so3};
use crate::physics::flow::reference::{self, Pair as Digits};
use crate::physics::flow::turn;

fn body(moments: [f64; 3]) -> Body {
    Body::new(1.0, moments.into()).unwrap()
}

/// Bodies of all classes and between them.
const MOMENTS: [[f64; 3]; 9] = [
    [2.0, 2.0, 2.0],
    [1.8, 1.8, 0.04],
    [3.0, 5.0, 3.0],
    [1.0, 0.6, 0.6],
    [1.0, 2.0, 2.5],
    [2.2, 1.0, 2.0],
    [1.0, 1.0 + 1e-9, 1.7],
    [1.0, 1.0 + 1e-13, 1.0 - 1e-13],
    [0.4, 1.0 - 1e-6, 1.0],
];

#[test]
fn they_are_those_of_the_turn() {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    for moments in MOMENTS {
        for speed_rad_s in [0.0_f64, 1e-6, 0.7, 12.0, 300.0] {
            let direction = Vector3::<f64>::from_fn(|_, _| random.random_range(-1.0..1.0));
            let omega = direction * speed_rad_s;
            for s in [0.0_f64, 0.01, 0.9, -0.4] {
                let exact = turn_by_moments(&body(moments), &omega, s);
                let size = exact.orientation.norm();
                // So small a change of moments that it turns by a fraction of a radian.
                let step = 0.3 / (1.0 + size);
                let at = |d: &[f64]| {
                    let moved = [0, 1, 2].map(|i| moments[i] * (step * d[i]).exp());
                    turn(&body(moved), &UnitQuaternion::identity(), &omega, s)
                };
                let base = turn(&body(moments), &UnitQuaternion::identity(), &omega, s);
                let numeric = differentiate::jacobian(6, 3, |d| {
                    let moved = at(d);
                    let turned = so3::log(&(base.orientation.inverse() * moved.orientation));
                    let both = turned.iter().chain(&moved.angular_velocity_rad_s);
                    both.map(|x| x / step).collect()
                });
                let spin_size = exact.angular_velocity.norm();
                let rounding = 3e-13 / step;
                for row in 0..3 {
                    for column in 0..3 {
                        for (found, known, tolerance) in [
                            (
                                numeric[row][column],
                                exact.orientation[(row, column)],
                                1e-8 * size + rounding,
                            ),
                            (
                                numeric[3 + row][column],
                                exact.angular_velocity[(row, column)],
                                1e-8 * spin_size + rounding * omega.norm(),
                            ),
                        ] {
                            assert!(
                                (found - known).abs() <= tolerance,
                                "{moments:?} {omega:?} {s}: {row} {column} {found} {known}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// By differences of the reference to thirty digits.
fn exactly(moments: [f64; 3], omega: [f64; 3], s: f64) -> TurnByMoments {
    const STEP: f64 = 1.0 / (1u64 << 30) as f64;
    let quaternion = |q: &[f64]| Quaternion::new(q[0], q[1], q[2], q[3]);
    let start = || reference::epoch(omega.map(Digits::from));
    let centre = reference::turn(moments, &start(), s).map(|digits| digits.0);
    let mut result = TurnByMoments {
        orientation: Matrix3::zeros(),
        angular_velocity: Matrix3::zeros(),
    };
    for column in 0..3 {
        let moved = |step: f64| {
            let mut moved = moments;
            moved[column] *= 1.0 + step;
            reference::turn(moved, &start(), s)
        };
        let (ahead, back) = (moved(STEP), moved(-STEP));
        let change: [f64; 7] = std::array::from_fn(|i| (ahead[i] - back[i]).0 / (2.0 * STEP));
        let turned = (quaternion(&centre).conjugate() * quaternion(&change)).imag() * 2.0;
        result.orientation.set_column(column, &turned);
        let spun = Vector3::from_column_slice(&change[4..]);
        result.angular_velocity.set_column(column, &spun);
    }
    result
}

#[test]
fn they_agree_with_the_reference() {
    for moments in [
        [2.0, 2.0, 2.0],
        [1.75, 1.75, 0.0625],
        [1.0, 2.0, 2.5],
        [1.0, 1.0 + 1.0 / (1u64 << 20) as f64, 1.75],
    ] {
        for omega in [[3.0, -7.0, 5.0], [1e-3, 2.0, 0.5], [0.0, 8.0, 0.0]] {
            for s in [0.05, -0.6] {
                let found = turn_by_moments(&body(moments), &omega.into(), s);
                let exact = exactly(moments, omega, s);
                let error = |found: &Matrix3<f64>, exact: &Matrix3<f64>| {
                    (found - exact).norm() / exact.norm().max(1e-9)
                };
                let errors = [
                    error(&found.orientation, &exact.orientation),
                    error(&found.angular_velocity, &exact.angular_velocity),
                ];
                assert!(
                    errors[0].max(errors[1]) < 1e-12,
                    "{moments:?} {omega:?} {s}: {errors:?}"
                );
            }
        }
    }
}

#[test]
fn only_ratios_count_and_a_ball_feels_the_first_order() {
    let omega = Vector3::new(3.0, -7.0, 5.0);
    for moments in MOMENTS {
        let found = turn_by_moments(&body(moments), &omega, 1.3);
        for of in [found.orientation, found.angular_velocity] {
            assert!(of.column_sum().norm() <= 1e-14 * of.norm());
        }
    }
    // ω is constant, and so is ω_j ω_k.
    let s = 2.0;
    let found = turn_by_moments(&body([0.3; 3]), &omega, s).angular_velocity;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let product = omega[j] * omega[k] * s;
        assert_eq!(found[(i, i)], 0.0);
        assert!((found[(i, j)] - product).abs() < 1e-13 * product.abs());
        assert!((found[(i, k)] + product).abs() < 1e-13 * product.abs());
    }
}

#[test]
fn they_do_not_depend_on_the_order_of_durations() {
    let (body, omega) = (body([1.0, 2.0, 2.5]), Vector3::new(3.0, -7.0, 5.0));
    let times_s = [-2.0, -0.7, -1e-9, 0.0, 1e-3, 0.4, 1.9];
    let mut forward = SpinByMoments::new(&body, &omega);
    let mut backward = SpinByMoments::new(&body, &omega);
    let mut reversed: Vec<_> = times_s.iter().rev().map(|s| backward.at(*s)).collect();
    reversed.reverse();
    for (s, reversed) in times_s.iter().zip(reversed) {
        assert_eq!(forward.at(*s), reversed);
    }
    let beyond = turn_by_moments(&body, &(omega * 1e9), 1.0);
    assert!(beyond.orientation[(0, 0)].is_nan() && beyond.angular_velocity[(0, 0)].is_nan());
}
