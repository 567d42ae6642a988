//! Compares the flow with a general integrator, with the reference to thirty digits, and with
//! itself.

use nalgebra::{Matrix3, Quaternion, SMatrix, UnitQuaternion, Vector3};

use super::reference::{self, Motion, Pair};
use super::*;
use crate::math::differentiate;
use crate::physics::body::Symmetry;
use crate::physics::state::StateTangent;
use crate::physics::{Body, State};

fn bodies() -> Vec<Body> {
    [
        Vector3::new(2e-4, 2e-4, 2e-4),
        Vector3::new(1.8e-5, 1.8e-5, 4e-8),
        Vector3::new(3e-3, 5e-3, 3e-3),
        Vector3::new(1.0, 0.6, 0.6),
        Vector3::new(1.0, 2.0, 2.5),
        Vector3::new(2.2e-4, 1e-4, 2e-4),
        Vector3::new(3e-6, 1.0e-6, 2.999_999e-6),
    ]
    .iter()
    .map(|moments| Body::new(0.01, *moments).unwrap())
    .collect()
}

fn state() -> State {
    State {
        position_m: Vector3::new(0.1, -0.2, 0.9),
        orientation: UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        velocity_m_s: Vector3::new(0.5, 1.5, -2.0),
        angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
    }
}

const GRAVITY: Vector3<f64> = Vector3::new(0.1, 0.2, -9.81);

/// Euler's equations and the quaternion's kinematics by classic Runge–Kutta: shares no
/// formula with the closed form.
fn integrate(body: &Body, state: &State, duration_s: f64) -> State {
    let moments = body.moments_kg_m2();
    let slope = |q: &Quaternion<f64>, w: &Vector3<f64>| {
        let torque_free = -w.cross(&moments.component_mul(w)).component_div(&moments);
        (q * Quaternion::from_imag(w * 0.5), torque_free)
    };
    let steps = 4000;
    let h = duration_s / f64::from(steps);
    let (mut q, mut w) = (state.orientation.into_inner(), state.angular_velocity_rad_s);
    for _ in 0..steps {
        let (q1, w1) = slope(&q, &w);
        let (q2, w2) = slope(&(q + q1 * (h / 2.0)), &(w + w1 * (h / 2.0)));
        let (q3, w3) = slope(&(q + q2 * (h / 2.0)), &(w + w2 * (h / 2.0)));
        let (q4, w4) = slope(&(q + q3 * h), &(w + w3 * h));
        q += (q1 + q2 * 2.0 + q3 * 2.0 + q4) * (h / 6.0);
        w += (w1 + w2 * 2.0 + w3 * 2.0 + w4) * (h / 6.0);
    }
    State {
        position_m: state.position_m
            + state.velocity_m_s * duration_s
            + GRAVITY * (duration_s * duration_s / 2.0),
        orientation: UnitQuaternion::new_normalize(q),
        velocity_m_s: state.velocity_m_s + GRAVITY * duration_s,
        angular_velocity_rad_s: w,
    }
}

#[test]
fn flow_agrees_with_numerical_integration() {
    for body in bodies() {
        for duration_s in [0.5, -0.3, 0.0] {
            let exact = advance(&body, &GRAVITY, &state(), duration_s);
            let numeric = integrate(&body, &state(), duration_s);
            assert!(
                exact.minus(&numeric).norm() < 1e-10,
                "{body:?} {duration_s}"
            );
        }
    }
}

#[test]
fn flow_composes_and_inverts_to_rounding() {
    for body in bodies() {
        let there = advance(&body, &GRAVITY, &state(), 0.4);
        let at_once = advance(&body, &GRAVITY, &state(), 1.1);
        assert!(advance(&body, &GRAVITY, &there, 0.7).minus(&at_once).norm() < 2e-14);
        assert!(
            advance(&body, &GRAVITY, &there, -0.4)
                .minus(&state())
                .norm()
                < 1e-14
        );
    }
}

#[test]
fn turn_derivatives_are_exact() {
    for body in bodies() {
        for duration_s in [0.31, -0.2, 0.0] {
            let base = advance(&body, &GRAVITY, &state(), duration_s);
            let numeric = differentiate::jacobian(12, 12, |d| {
                let moved = state().retract(&StateTangent::from_column_slice(d));
                advance(&body, &GRAVITY, &moved, duration_s)
                    .minus(&base)
                    .as_slice()
                    .to_vec()
            });
            let turn = turn(
                &body,
                &state().orientation,
                &state().angular_velocity_rad_s,
                duration_s,
            );
            let mut exact = SMatrix::<f64, 12, 12>::identity();
            exact.fixed_view_mut::<3, 3>(0, 6).fill_diagonal(duration_s);
            exact
                .fixed_view_mut::<3, 3>(3, 3)
                .copy_from(&turn.orientation_by_orientation);
            exact
                .fixed_view_mut::<3, 3>(3, 9)
                .copy_from(&turn.orientation_by_angular_velocity);
            exact
                .fixed_view_mut::<3, 3>(9, 9)
                .copy_from(&turn.angular_velocity_by_angular_velocity);
            for i in 0..12 {
                for j in 0..12 {
                    assert!(
                        (numeric[i][j] - exact[(i, j)]).abs() < 2e-9,
                        "{body:?} {i} {j}"
                    );
                }
            }
        }
    }
}

#[test]
fn spin_agrees_with_turn_seen_from_the_epoch() {
    for body in bodies() {
        let omega = state().angular_velocity_rad_s;
        let mut spin = Spin::new(&body, &omega);
        for duration_s in [0.31, -0.2, 0.0] {
            let turn = turn(&body, &state().orientation, &omega, duration_s);
            let (rotation, k) = spin.turn_and_derivative(duration_s);
            assert!((state().orientation * rotation).angle_to(&turn.orientation) < 1e-14);
            let carried =
                turn.orientation_by_orientation.transpose() * turn.orientation_by_angular_velocity;
            assert!((carried - k * duration_s).norm() < 1e-14);
            let seen = turn.orientation_by_orientation.transpose() * turn.angular_velocity_rad_s;
            assert!((seen - k * omega).norm() < 1e-13);
        }
    }
}

#[test]
fn rate_is_the_time_derivative() {
    for body in bodies() {
        let there = advance(&body, &GRAVITY, &state(), 0.4);
        let numeric = differentiate::jacobian(12, 1, |d| {
            advance(&body, &GRAVITY, &state(), 0.4 + d[0])
                .minus(&there)
                .as_slice()
                .to_vec()
        });
        let exact = rate(&body, &GRAVITY, &there);
        for i in 0..12 {
            assert!((numeric[i][0] - exact[i]).abs() < 1e-8, "{body:?} {i}");
        }
    }
}

fn exactly(moments: [f64; 3], omega: [f64; 3], duration_s: f64) -> Motion {
    let start = reference::epoch(omega.map(Pair::from));
    reference::turn(moments, &start, duration_s)
}

/// Angle \[rad\] between a rotation and the reference's.
fn angle_to(rotation: &UnitQuaternion<f64>, exact: &Motion) -> f64 {
    let q = rotation.quaternion();
    let exact: [Pair; 4] = std::array::from_fn(|i| exact[i]);
    let dot = (q.w * exact[0].0 + q.i * exact[1].0) + (q.j * exact[2].0 + q.k * exact[3].0);
    let square = [q.w, q.i, q.j, q.k]
        .into_iter()
        .zip(exact)
        .map(|(got, exact)| (Pair::from(got * dot.signum()) - exact).0)
        .map(|difference| difference * difference)
        .sum::<f64>();
    2.0 * square.sqrt()
}

fn spin_error(omega: &Vector3<f64>, exact: &Motion) -> f64 {
    (0..3)
        .map(|i| (Pair::from(omega[i]) - exact[4 + i]).0)
        .map(|difference| difference * difference)
        .sum::<f64>()
        .sqrt()
}

/// Errors of a free rotation \[rad\] and of its angular velocity relative to the initial speed; and
/// the changes of both by half a rounding error of `ω(0)`.
struct Accuracy {
    angle: f64,
    spin: f64,
    conditioned_angle: f64,
    conditioned_spin: f64,
}

fn accuracy(moments: [f64; 3], omega: [f64; 3], duration_s: f64) -> Accuracy {
    let body = Body::new(1.0, moments.into()).unwrap();
    let turn = turn(
        &body,
        &UnitQuaternion::identity(),
        &omega.into(),
        duration_s,
    );
    let exact = exactly(moments, omega, duration_s);
    let rounding = 0.5 * f64::EPSILON;
    let speed = Vector3::from(omega).norm();
    Accuracy {
        angle: angle_to(&turn.orientation, &exact),
        spin: spin_error(&turn.angular_velocity_rad_s, &exact) / speed,
        conditioned_angle: turn.orientation_by_angular_velocity.norm() * speed * rounding,
        conditioned_spin: turn.angular_velocity_by_angular_velocity.norm() * rounding,
    }
}

#[test]
fn asymmetric_turns_agree_with_the_reference() {
    for moments in [
        [1.0, 2.0, 2.5],
        [2.5, 1.0, 2.0],
        [2.0, 1.0, 2.5],
        [1.0, 200.0, 200.5],
    ] {
        for omega in [
            [3.0, -7.0, 5.0],
            [-0.1, 0.2, 9.0],
            [9.0, 0.0, 0.3],
            [0.0, 8.0, 0.0],
        ] {
            for duration_s in [-1.3, 0.02, 4.0] {
                let found = accuracy(moments, omega, duration_s);
                let name = format!("{moments:?} {omega:?} {duration_s}");
                let angle = 10.0 * (found.conditioned_angle + 1e-16);
                assert!(found.angle < angle, "{name}: {:e}", found.angle);
                let spin = 10.0 * (found.conditioned_spin + 1e-16);
                assert!(found.spin < spin, "{name}: {:e}", found.spin);
            }
        }
    }
}

/// The intermediate moment's component changes sign at each flip.
fn flips(body: &Body, omega: &Vector3<f64>, middle: usize, duration_s: f64) -> usize {
    let mut spin = Spin::new(body, omega);
    let signs: Vec<bool> = (0..=2000)
        .map(|i| duration_s * f64::from(i) / 2000.0)
        .map(|s| {
            let (rotation, k) = spin.turn_and_derivative(s);
            rotation.inverse_transform_vector(&(k * omega))[middle] > 0.0
        })
        .collect();
    signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

#[test]
fn twenty_flips_are_exact() {
    for (moments, middle, omega, duration_s) in [
        ([1.0, 2.0, 2.5], 1, [0.01, 9.0, 0.01], 90.0),
        ([1.0, 2.0, 2.5], 1, [1e-4, 9.0, 0.0], 150.0),
        ([2.5, 1.0, 2.0], 2, [1e-3, -0.2, 9.0], -60.0),
    ] {
        let body = Body::new(1.0, moments.into()).unwrap();
        let count = flips(&body, &omega.into(), middle, duration_s);
        assert!(count >= 20, "{count}");
        let found = accuracy(moments, omega, duration_s);
        let name = format!("{omega:?}: {:e} rad, {:e}", found.angle, found.spin);
        assert!(found.angle < 1e-12 && found.spin < 1e-12, "{name}");
        assert!(found.angle < found.conditioned_angle, "{name}");
        assert!(found.spin < 2.0 * found.conditioned_spin, "{name}");
    }
}

#[test]
fn nearly_equal_moments_lose_no_digits() {
    for exponent in 3..=16 {
        let difference = 10.0_f64.powi(-exponent);
        for moments in [
            [1.0, 1.0 + difference, 1.7],
            [1.0, 1.7, 1.0 - difference],
            [0.4, 1.0 - difference, 1.0],
            [1.0, 1.0 + difference, 1.0 + 2.0 * difference],
        ] {
            for omega in [[3.0, -7.0, 5.0], [0.1, 9.0, -0.1]] {
                let found = accuracy(moments, omega, 2.0);
                let error = found.angle.max(found.spin);
                assert!(error < 1e-13, "{moments:?} {omega:?}: {error:e}");
            }
        }
    }
}

#[test]
fn near_a_separatrix_no_digits_are_lost() {
    // On it I₁(I₂ − I₁) ω₁² = I₃(I₃ − I₂) ω₃².
    let ratio = (1.0_f64 / 1.25).sqrt();
    for offset in [0.0, 1e-14, -1e-12, 1e-9, -1e-6, 1e-3, 0.1] {
        for omega in [
            [4.0, 9.0, 4.0 * ratio * (1.0 + offset)],
            [1e-3, 9.0, -1e-3 * ratio * (1.0 + offset)],
        ] {
            let found = accuracy([1.0, 2.0, 2.5], omega, 5.0);
            let name = format!("{omega:?}: {:e} {:e}", found.angle, found.spin);
            assert!(
                found.angle < 1e-13 + 10.0 * found.conditioned_angle,
                "{name}"
            );
            assert!(found.spin < 1e-13 + 10.0 * found.conditioned_spin, "{name}");
        }
    }
}

/// Derivatives of the reference by differences with a step of 1e-12, in right perturbations.
fn exact_derivatives(moments: [f64; 3], omega: [f64; 3], s: f64) -> (Matrix3<f64>, Matrix3<f64>) {
    let quaternion = |q: &[f64]| Quaternion::new(q[0], q[1], q[2], q[3]);
    let centre = exactly(moments, omega, s).map(|pair| pair.0);
    let (mut by_turn, mut by_spin) = (Matrix3::zeros(), Matrix3::zeros());
    for column in 0..3 {
        let moved = |step: f64| {
            let mut moved = omega.map(Pair::from);
            moved[column] = moved[column] + step.into();
            reference::turn(moments, &reference::epoch(moved), s)
        };
        let (ahead, back) = (moved(1e-12), moved(-1e-12));
        let change: [f64; 7] = std::array::from_fn(|i| (ahead[i] - back[i]).0 / 2e-12);
        let turned = (quaternion(&centre).conjugate() * quaternion(&change)).imag() * 2.0;
        by_turn.set_column(column, &turned);
        by_spin.set_column(column, &Vector3::from_column_slice(&change[4..]));
    }
    (by_turn, by_spin)
}

#[test]
fn derivatives_agree_with_the_reference() {
    for (moments, omega, tolerance) in [
        ([1.0, 2.0, 2.5], [3.0, -7.0, 5.0], 1e-13),
        ([1.0, 2.0, 2.5], [1e-9, 1e-9, 9.0], 1e-13),
        ([1.0, 2.0, 2.5], [1e-3, 9.0, 8.944e-4], 1e-11),
        ([1.0, 1.000_001, 1.7], [3.0, -7.0, 5.0], 1e-13),
        ([1.0, 1.0 + 1e-9, 1.0 - 1e-9], [3.0, -7.0, 5.0], 1e-13),
    ] {
        let body = Body::new(1.0, moments.into()).unwrap();
        for s in [0.05, -2.0] {
            let turn = turn(&body, &UnitQuaternion::identity(), &omega.into(), s);
            let (by_turn, by_spin) = exact_derivatives(moments, omega, s);
            let error =
                |got: &Matrix3<f64>, exact: &Matrix3<f64>| (got - exact).norm() / exact.norm();
            let errors = [
                error(&turn.orientation_by_angular_velocity, &by_turn),
                error(&turn.angular_velocity_by_angular_velocity, &by_spin),
            ];
            assert!(
                errors[0].max(errors[1]) < tolerance,
                "{omega:?} {s}: {errors:?}"
            );
        }
    }
}

#[test]
fn energy_and_angular_momentum_stay() {
    let moments = Vector3::new(1.0, 2.0, 2.5);
    let body = Body::new(1.0, moments).unwrap();
    for omega in [Vector3::new(0.01, 9.0, 0.01), Vector3::new(3.0, -7.0, 5.0)] {
        let state = State {
            angular_velocity_rad_s: omega,
            ..state()
        };
        let invariants = |state: &State| {
            let momentum = moments.component_mul(&state.angular_velocity_rad_s);
            let energy = momentum.dot(&state.angular_velocity_rad_s);
            (energy, state.orientation * momentum)
        };
        let (energy, momentum) = invariants(&state);
        for duration_s in [3.0, -40.0, 100.0] {
            let (e, m) = invariants(&advance(&body, &GRAVITY, &state, duration_s));
            assert!((e / energy - 1.0).abs() < 1e-13, "{:e}", e / energy - 1.0);
            assert!(
                (m - momentum).norm() < 1e-12 * momentum.norm(),
                "{:e}",
                (m - momentum).norm()
            );
        }
    }
}

#[test]
fn without_spin_nothing_turns_and_derivatives_are_plain() {
    for moments in [Vector3::new(1.0, 2.0, 2.5), Vector3::repeat(1.0)] {
        let body = Body::new(1.0, moments).unwrap();
        for omega in [Vector3::zeros(), Vector3::new(1e-300, -1e-310, 0.0)] {
            for s in [0.0, 3.0, -0.2] {
                let turn = turn(&body, &UnitQuaternion::identity(), &omega, s);
                assert!(turn.orientation.angle() < 1e-290);
                assert_eq!(turn.angular_velocity_rad_s, omega);
                let by_spin = turn.orientation_by_angular_velocity;
                assert!((by_spin - Matrix3::identity() * s).norm() < 1e-15);
                let still = turn.angular_velocity_by_angular_velocity - Matrix3::identity();
                assert!(still.norm() < 1e-15);
                let k = Spin::new(&body, &omega).turn_and_derivative(s).1;
                assert!((k - Matrix3::identity()).norm() < 1e-15);
            }
        }
    }
}

#[test]
fn a_thousand_radians_a_second_are_as_exact_as_any() {
    let found = accuracy([1.0, 2.0, 2.5], [400.0, -700.0, 600.0], 1.0);
    assert!(
        found.angle < 10.0 * found.conditioned_angle,
        "{:e}",
        found.angle
    );
    assert!(
        found.spin < 10.0 * found.conditioned_spin,
        "{:e}",
        found.spin
    );
    assert!(found.angle < 2e-12 && found.conditioned_angle < 2e-12);
}

#[test]
fn turns_too_long_or_not_finite_are_not_numbers() {
    let body = Body::new(1.0, Vector3::new(1.0, 2.0, 2.5)).unwrap();
    for (omega, s) in [
        (1e9, 1.0),
        (f64::NAN, 1.0),
        (f64::INFINITY, 1e-3),
        (1.0, f64::NAN),
    ] {
        let omega = Vector3::new(omega, 0.0, 1.0);
        let found = turn(&body, &UnitQuaternion::identity(), &omega, s);
        assert!(found.orientation.w.is_nan() && found.angular_velocity_rad_s.x.is_nan());
        let (rotation, k) = Spin::new(&body, &omega).turn_and_derivative(s);
        assert!(rotation.w.is_nan() && k[(0, 0)].is_nan());
        let state = State {
            angular_velocity_rad_s: omega,
            ..state()
        };
        assert!(!advance(&body, &GRAVITY, &state, s).is_finite());
    }
}

#[test]
fn a_spin_answers_alike_in_any_order() {
    let body = Body::new(1.0, Vector3::new(1.0, 2.0, 2.5)).unwrap();
    assert_eq!(body.symmetry(), Symmetry::Asymmetric);
    let omega = Vector3::new(3.0, -7.0, 5.0);
    let times_s = [-2.0, -0.7, -1e-9, 0.0, 1e-3, 0.4, 1.9];
    let mut forward = Spin::new(&body, &omega);
    let mut backward = Spin::new(&body, &omega);
    let mut reversed: Vec<_> = times_s
        .iter()
        .rev()
        .map(|s| backward.turn_and_derivative(*s))
        .collect();
    reversed.reverse();
    for (s, reversed) in times_s.iter().zip(reversed) {
        assert_eq!(forward.turn_and_derivative(*s), reversed);
    }
}
