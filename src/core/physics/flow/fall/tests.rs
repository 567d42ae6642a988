use nalgebra::{Quaternion, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::math::differentiate;
use crate::physics::drag::Drag;
use crate::physics::flow::{self, Flown, WantedDerivatives};
use crate::physics::state::StateTangent;

const GRAVITY: Vector3<f64> = Vector3::new(0.1, 0.2, -9.81);

fn body(linear_per_s: f64, quadratic_per_m: f64) -> Body {
    let drag = Drag {
        linear_per_s,
        quadratic_per_m,
    };
    let body = Body::new(0.0027, Vector3::new(7e-7, 8e-7, 9e-7)).unwrap();
    body.with_drag(drag).unwrap()
}

fn thrown(velocity_m_s: [f64; 3]) -> State {
    State {
        position_m: Vector3::new(0.1, -0.2, 0.9),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: velocity_m_s.into(),
        angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
    }
}

/// By classic Runge–Kutta in steps five hundred times as fine.
fn integrated(body: &Body, state: &State, duration_s: f64) -> Vector3<f64> {
    let slope = |v: &Vector3<f64>| {
        let drag = body.drag();
        GRAVITY - v * (drag.linear_per_s + drag.quadratic_per_m * v.norm())
    };
    let steps = (duration_s.abs() * 64_000.0).ceil();
    let h = duration_s / steps;
    let (mut x, mut v) = (state.position_m, state.velocity_m_s);
    for _ in 0..steps as usize {
        let a1 = slope(&v);
        let a2 = slope(&(v + a1 * (0.5 * h)));
        let a3 = slope(&(v + a2 * (0.5 * h)));
        let a4 = slope(&(v + a3 * h));
        x += (v + (a1 + a2 + a3) * (h / 6.0)) * h;
        v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
    }
    x
}

#[test]
fn falls_agree_with_a_far_finer_integration() {
    let fast = [25.0, 5.0, 15.8];
    for (linear_per_s, quadratic_per_m, velocity_m_s, duration_s, tolerance_m) in [
        (0.0, 0.13, fast, 1.0, 1e-11),
        (0.0, 0.13, [20.0, 0.0, -5.0], -0.2, 1e-11),
        (5.0, 0.0, fast, 1.0, 1e-11),
        (5.0, 0.0, [1.0, 2.0, 3.0], -0.3, 1e-11),
        (5.0, 0.13, fast, 1.0, 1e-11),
        (0.4, 0.13, fast, 0.013, 1e-12),
        // A balloon.
        (0.0, 3.0, [8.0, 0.0, 6.0], 1.0, 1e-10),
        // Through a speed of zero.
        (0.0, 0.13, [0.0, 0.0, 4.0], 1.0, 1e-8),
    ] {
        let (body, state) = (body(linear_per_s, quadratic_per_m), thrown(velocity_m_s));
        let found = flow::position(&body, &GRAVITY, &state, duration_s);
        let off_m = (found - integrated(&body, &state, duration_s)).norm();
        assert!(
            off_m < tolerance_m,
            "{linear_per_s} {quadratic_per_m} {duration_s}: {off_m:e}"
        );
    }
}

#[test]
fn a_linear_drag_is_the_exponential() {
    let (k, state) = (2.0, thrown([3.0, -1.0, 4.0]));
    let mut fall = Fall::new(&body(k, 0.0), &GRAVITY, &state);
    for s in [0.7, -0.4] {
        let at_last = GRAVITY / k;
        let excess = state.velocity_m_s - at_last;
        let gone = (-k * s).exp();
        let exact = state.position_m + at_last * s + excess * ((1.0 - gone) / k);
        assert!((fall.position(s) - exact).norm() < 1e-13);
        let fallen = fall.fallen(s);
        assert!((fallen.velocity_m_s - (at_last + excess * gone)).norm() < 1e-13);
        let by_velocity = Matrix3::identity() * ((1.0 - gone) / k);
        assert!((fallen.position_by_velocity - by_velocity).norm() < 1e-13);
    }
}

/// Velocity, pull and drag, at random; every third without drag, every third linear.
fn draws() -> Vec<[f64; 8]> {
    let mut random = ChaCha8Rng::seed_from_u64(31);
    let mut draw = |low: f64, high: f64| random.random_range(low..high);
    (0..30)
        .map(|index| {
            let size = [0.3, 3.0, 20.0][index % 3];
            let mut all = [0.0; 8];
            for entry in &mut all[..3] {
                *entry = draw(-size, size);
            }
            for entry in &mut all[3..6] {
                *entry = draw(-10.0, 10.0);
            }
            if index % 9 > 2 {
                all[column::LINEAR_DRAG] = draw(0.0, 3.0);
            }
            if index % 9 > 5 {
                all[column::QUADRATIC_DRAG] = draw(0.0, 0.3);
            }
            all
        })
        .collect()
}

fn glide(all: &[f64]) -> Glide {
    let three = |at: usize| Vector3::from_column_slice(&all[at..at + 3]);
    let drag = Drag {
        linear_per_s: all[column::LINEAR_DRAG],
        quadratic_per_m: all[column::QUADRATIC_DRAG],
    };
    Glide::new(three(column::PULL), drag, &three(column::VELOCITY))
}

#[test]
fn derivatives_are_exact() {
    for all in draws() {
        for s in [0.0, 0.003, 0.2, 0.91, -0.004, -0.1] {
            // In a twentieth of each unit, so that no speed comes near zero.
            let at = |d: &[f64]| {
                let moved: Vec<f64> = all.iter().zip(d).map(|(x, d)| x + 0.05 * d).collect();
                glide(&moved).at(s)
            };
            let numeric = differentiate::jacobian(6, 8, |d| {
                let node = at(d);
                let both = node.way_m.iter().chain(&node.velocity_m_s);
                both.map(|x| 20.0 * x).collect()
            });
            let (node, change) = glide(&all).at_with_change(s);
            assert_eq!(node.way_m, at(&[0.0; 8]).way_m);
            for row in 0..3 {
                for by in 0..8 {
                    for (found, exact) in [
                        (numeric[row][by], change.way[(row, by)]),
                        (numeric[3 + row][by], change.velocity[(row, by)]),
                    ] {
                        assert!(
                            (found - exact).abs() < 1e-8 * (1.0 + exact.abs()),
                            "{all:?} {s}: {row} {by} {found} {exact}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn without_drag_the_state_is_the_parabola_and_derivatives_are_its() {
    let state = thrown([0.5, 1.5, -2.0]);
    let body = body(0.0, 0.0);
    let pushed = body.with_force(Vector3::new(0.3, -0.4, 0.1)).unwrap();
    let p = pushed.pull_m_s2(&GRAVITY);
    let mut fall = Fall::new(&pushed, &GRAVITY, &state);
    for s in [0.4, -1.1, 0.0] {
        let (position_m, velocity_m_s) = fall.position_and_velocity(s);
        assert_eq!(
            position_m,
            state.position_m + (state.velocity_m_s + p * (0.5 * s)) * s
        );
        assert_eq!(velocity_m_s, state.velocity_m_s + p * s);
        let fallen = fall.fallen(s);
        assert_eq!(
            (fallen.position_m, fallen.velocity_m_s),
            (position_m, velocity_m_s)
        );
        let (v, one) = (state.velocity_m_s, Matrix3::identity());
        let by_linear_drag = -(v * (s * s / 2.0) + p * (s * s * s / 6.0));
        assert!((fallen.position_by_velocity - one * s).norm() < 1e-14);
        assert!((fallen.position_by_pull - one * (0.5 * s * s)).norm() < 1e-14);
        assert!((fallen.position_by_drag.column(0) - by_linear_drag).norm() < 1e-13);
        assert!((fallen.velocity_by_velocity - one).norm() < 1e-14);
        assert!((fallen.velocity_by_pull - one * s).norm() < 1e-14);
        let of_velocity = -(v * s + p * (s * s / 2.0));
        assert!((fallen.velocity_by_drag.column(0) - of_velocity).norm() < 1e-13);
    }
}

#[test]
fn flights_with_drag_compose_and_have_their_rate() {
    let body = body(0.5, 0.13).with_force(Vector3::x()).unwrap();
    let state = thrown([4.0, 1.5, -2.0]);
    let there = flow::advance(&body, &GRAVITY, &state, 0.4);
    let at_once = flow::advance(&body, &GRAVITY, &state, 1.1);
    let in_two = flow::advance(&body, &GRAVITY, &there, 0.7);
    assert!(in_two.minus(&at_once).norm() < 1e-12);
    let back = flow::advance(&body, &GRAVITY, &there, -0.4);
    assert!(back.minus(&state).norm() < 1e-12);
    let later = |d: &[f64]| flow::advance(&body, &GRAVITY, &state, 0.4 + 0.1 * d[0]);
    let numeric = differentiate::jacobian(12, 1, |d| {
        (later(d).minus(&there) * 10.0).as_slice().to_vec()
    });
    let exact = flow::rate(&body, &GRAVITY, &there);
    for row in 0..12 {
        assert!((numeric[row][0] - exact[row]).abs() < 1e-8, "{row}");
    }
    assert_eq!(
        flow::velocity(&body, &GRAVITY, &state, 0.4),
        there.velocity_m_s
    );
}

#[test]
fn a_fall_answers_alike_in_any_order() {
    let (body, state) = (body(0.1, 0.13), thrown([4.0, 1.5, -2.0]));
    let times_s = [-0.3, -0.1, -1e-9, 0.0, 1e-3, 0.4, 1.9];
    let mut forward = Fall::new(&body, &GRAVITY, &state);
    let mut backward = Fall::new(&body, &GRAVITY, &state);
    let mut reversed: Vec<Fallen> = times_s.iter().rev().map(|s| backward.fallen(*s)).collect();
    reversed.reverse();
    for (s, reversed) in times_s.iter().zip(reversed) {
        assert_eq!(forward.fallen(*s), reversed);
        let alone = Fall::new(&body, &GRAVITY, &state).fallen(*s);
        assert_eq!(alone, reversed);
    }
}

#[test]
fn derivatives_of_a_parabola_are_those_of_the_limit() {
    let state = thrown([4.0, 1.5, -2.0]);
    for s in [-0.3, 0.0, 0.4, 1.9] {
        let limit = Fall::new(&body(0.0, 0.0), &GRAVITY, &state).fallen(s);
        let closed = Fall::new(&body(0.0, 0.0), &GRAVITY, &state)
            .with_drag_free(false)
            .fallen(s);
        assert_eq!(closed.position_m, limit.position_m);
        assert_eq!(closed.velocity_m_s, limit.velocity_m_s);
        let pairs = [
            (closed.position_by_velocity, limit.position_by_velocity),
            (closed.position_by_pull, limit.position_by_pull),
            (closed.velocity_by_velocity, limit.velocity_by_velocity),
            (closed.velocity_by_pull, limit.velocity_by_pull),
        ];
        for (closed, limit) in pairs {
            assert!((closed - limit).amax() < 1e-14, "{s}");
        }
        assert_eq!(closed.position_by_drag.amax(), 0.0);
    }
}

#[test]
fn what_cannot_be_followed_is_not_a_number() {
    let ball = body(0.0, 0.13);
    // Infinitely fast 0.26 s before.
    let fast = thrown([30.0, 0.0, 0.0]);
    assert!(!flow::advance(&ball, &GRAVITY, &fast, -0.4).is_finite());
    assert!(flow::advance(&ball, &GRAVITY, &fast, -0.1).is_finite());
    let honey = body(200.0, 0.0);
    assert!(!flow::advance(&honey, &GRAVITY, &fast, 0.1).is_finite());
    for s in [f64::NAN, f64::INFINITY, -1e9] {
        assert!(flow::position(&ball, &GRAVITY, &fast, s).x.is_nan());
    }
}

/// A ball that drag slows and lift bends.
fn ball(lift: f64) -> Body {
    let drag = Drag {
        linear_per_s: 0.2,
        quadratic_per_m: 0.13,
    };
    let body = Body::new(0.0027, Vector3::repeat(7e-7)).unwrap();
    body.with_drag(drag).unwrap().with_lift(lift).unwrap()
}

fn spinning() -> State {
    State {
        orientation: UnitQuaternion::from_euler_angles(0.4, -0.9, 1.3),
        angular_velocity_rad_s: Vector3::new(60.0, -150.0, 90.0),
        ..thrown([8.0, 1.5, 2.0])
    }
}

/// By classic Runge–Kutta in fine steps of place, velocity and orientation: the angular velocity is turned into world axes
/// wherever it is needed.
fn lifted(body: &Body, start: &State, duration_s: f64) -> Vector3<f64> {
    let omega = start.angular_velocity_rad_s;
    let rates = |v: &Vector3<f64>, q: &Quaternion<f64>| {
        let spin = (q * Quaternion::from_imag(omega) * q.conjugate()).imag() / q.norm_squared();
        let drag = body.drag();
        let slowed = v * (drag.linear_per_s + drag.quadratic_per_m * v.norm());
        let acceleration = GRAVITY + spin.cross(v) * body.lift() - slowed;
        (*v, acceleration, q * Quaternion::from_imag(omega) * 0.5)
    };
    let steps = (duration_s.abs() * 32_000.0).ceil();
    let h = duration_s / steps;
    let (mut x, mut v) = (start.position_m, start.velocity_m_s);
    let mut q = start.orientation.into_inner();
    for _ in 0..steps as usize {
        let one = rates(&v, &q);
        let two = rates(&(v + one.1 * (0.5 * h)), &(q + one.2 * (0.5 * h)));
        let three = rates(&(v + two.1 * (0.5 * h)), &(q + two.2 * (0.5 * h)));
        let four = rates(&(v + three.1 * h), &(q + three.2 * h));
        x += (one.0 + (two.0 + three.0) * 2.0 + four.0) * (h / 6.0);
        v += (one.1 + (two.1 + three.1) * 2.0 + four.1) * (h / 6.0);
        q += (one.2 + (two.2 + three.2) * 2.0 + four.2) * (h / 6.0);
    }
    x
}

#[test]
fn lifted_balls_agree_with_a_far_finer_integration() {
    let state = spinning();
    for (lift, duration_s) in [(0.006, 1.0), (0.006, -0.2), (-0.03, 0.4), (0.02, 0.013)] {
        let found = flow::position(&ball(lift), &GRAVITY, &state, duration_s);
        let off_m = (found - lifted(&ball(lift), &state, duration_s)).norm();
        assert!(off_m < 1e-10, "{lift} {duration_s}: {off_m:e}");
        let straight_m = flow::position(&ball(0.0), &GRAVITY, &state, duration_s);
        assert!((found - straight_m).norm() > 100.0 * off_m + 1e-6);
    }
}

/// Without gravity and drag, a ball goes on a helix as fast as it was thrown.
#[test]
fn lift_turns_the_velocity_and_does_no_work() {
    let body = Body::new(0.4, Vector3::repeat(2e-3)).unwrap();
    let (body, state) = (body.with_lift(0.05).unwrap(), spinning());
    let about = state.orientation * state.angular_velocity_rad_s * 0.05;
    for s in [0.3, 1.2, -0.5] {
        let found = flow::velocity(&body, &Vector3::zeros(), &state, s);
        let turned = UnitQuaternion::from_scaled_axis(about * s) * state.velocity_m_s;
        assert!((found - turned).norm() < 1e-10, "{s}: {found} {turned}");
    }
}

#[test]
fn derivatives_with_lift_are_exact() {
    // In these shares of each unit: of the state, the pull, both drags and the lift.
    let unit = |at: usize| match at {
        9..12 => 1.0,
        17 => 0.01,
        _ => 0.05,
    };
    for (lift, s) in [(0.006, 0.7), (0.006, -0.2), (-0.02, 0.3), (0.0, 0.5)] {
        let from = spinning();
        let moved = |d: &[f64]| {
            let d: Vec<f64> = d.iter().enumerate().map(|(at, d)| unit(at) * d).collect();
            let drag = Drag {
                linear_per_s: 0.2 + d[15],
                quadratic_per_m: 0.13 + d[16],
            };
            let body = ball(lift + d[17]).with_drag(drag).unwrap();
            let state = from.retract(&StateTangent::from_column_slice(&d[..12]));
            let gravity = GRAVITY + Vector3::from_column_slice(&d[12..15]);
            flow::advance(&body, &gravity, &state, s)
        };
        let base = moved(&[0.0; 18]);
        let numeric =
            differentiate::jacobian(12, 18, |d| moved(d).minus(&base).iter().copied().collect());
        let wanted = WantedDerivatives {
            by_drag: true,
            by_lift: true,
            by_moments: false,
        };
        let flown = Flown::new(&ball(lift), &GRAVITY, &from, s, wanted);
        assert!(flown.state().minus(&base).norm() < 1e-12);
        let by_state = flown.by_state();
        for column in 0..18 {
            let exact = match column {
                0..12 => by_state.column(column).into_owned(),
                12..15 => flown.by_pull(column - 12),
                15 | 16 => flown.by_drag(column - 15),
                _ => flown.by_lift(),
            };
            for row in 0..12 {
                let (found, exact) = (numeric[row][column] / unit(column), exact[row]);
                assert!(
                    (found - exact).abs() < 2e-7 * (1.0 + exact.abs()),
                    "{lift} {s}: {row} {column} {found} {exact}"
                );
            }
        }
    }
}
