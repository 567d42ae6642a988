//! Free flight, independent of [`crate::physics::flow`]: the rotation by Taylor series of Euler's
//! equations, the centre of mass by a parabola or, with drag or lift, by the classic Runge–Kutta method.
//!
//! ```text
//! I ω' = (I ω) × ω,   q' = ½ q (0, ω),   x' = v,   v' = g + f + ℓ ω × v − k v − c|v| v
//! ```
//!
//! The first two right sides are products of two series, so that every coefficient follows from earlier
//! ones by one sum of products. For any three moments; lifted is only a ball, whose `ω` in world axes is constant.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::tied;
use crate::physics::{Body, OnPlane, PlaneSupport, State, Support, Sustained};

/// Order of the series.
const ORDER: usize = 16;

/// Greatest angle of one step \[rad\]. The poles of a free rotation are about π/2 away in the
/// complex plane of angles, so that the truncation error is (0.2/1.57)¹⁷ = 6e-16.
const STEP_RAD: f64 = 0.2;

/// Greatest number of steps: a longer rotation, of more than 30 000 turns, is less exact.
const STEPS: f64 = 1e6;

/// Length of a step with drag \[s\]: the error is below 2e-11 m over 1 s of a table-tennis ball at
/// 30 m/s, below 1e-9 m of one that stops in the air.
const DRAG_STEP_S: f64 = 1.0 / 1024.0;

/// Length of a step on a support \[s\].
const SUPPORT_STEP_S: f64 = 1.0 / 8192.0;

/// Greatest number of steps with drag, or on a support.
const DRAG_STEPS: f64 = 1e6;

/// State after `duration_s` of free flight (negative: before).
pub(super) fn advance(
    body: &Body,
    gravity_m_s2: &Vector3<f64>,
    state: &State,
    duration_s: f64,
) -> State {
    match body.support() {
        Some(Support::Plane(plane)) => {
            return supported(body, &plane, gravity_m_s2, state, duration_s);
        }
        Some(Support::Pivot(pivot)) => {
            return tied::advance(body, &pivot, gravity_m_s2, state, duration_s);
        }
        Some(Support::Stuck(part)) => {
            let whole = part.of_whole(state);
            let flown = advance(&part.whole(), gravity_m_s2, &whole, duration_s);
            return part.of_body(&flown);
        }
        None => {}
    }
    let (position_m, velocity_m_s) = fall(body, gravity_m_s2, state, duration_s);
    let mut now = State {
        position_m,
        velocity_m_s,
        ..*state
    };
    let mut left_s = duration_s;
    while left_s != 0.0 {
        let rate_rad_s = now.angular_velocity_rad_s.norm();
        let least_s = duration_s.abs() / STEPS;
        let step_s = (STEP_RAD / rate_rad_s.max(f64::MIN_POSITIVE)).max(least_s);
        let step_s = if left_s.abs() <= step_s {
            left_s
        } else {
            step_s.copysign(left_s)
        };
        turn(body, &mut now, step_s);
        left_s -= step_s;
    }
    now
}

/// On a plane, force by force: what friction does to a ball at its lowest point, or to what lies flat, by the
/// midpoint rule.
fn supported(
    body: &Body,
    support: &PlaneSupport,
    gravity_m_s2: &Vector3<f64>,
    state: &State,
    duration_s: f64,
) -> State {
    let steps = (duration_s.abs() / SUPPORT_STEP_S).ceil().min(DRAG_STEPS);
    let h = duration_s / steps.max(1.0);
    let n = support.normal;
    let pull = gravity_m_s2 + body.force_m_s2();
    let pressure = -pull.dot(&n);
    let along = pull + n * pressure;
    let per_mass = body.gyration_m2();
    let normal_in_body = state.orientation.inverse() * n;
    let gyration_m = normal_in_body
        .dot(&per_mass.component_mul(&normal_in_body))
        .sqrt();
    // A cylinder rolls across its axis alone, which stays as it is.
    let (way, about_m2) = match support.touching {
        OnPlane::Side { axis, .. } => {
            let way = n.cross(&(state.orientation * axis));
            (Some(way), axis.dot(&per_mass.component_mul(&axis)))
        }
        _ => (None, per_mass.x),
    };
    let taken = |of: Vector3<f64>| way.map_or(of, |way| way * way.dot(&of));
    // Accelerations of the centre of mass and about it \[world\].
    let forced = |velocity: &Vector3<f64>, spin: &Vector3<f64>| {
        let arm = support.touching.radius_m().map(|radius_m| n * -radius_m);
        let level = velocity - n * n.dot(velocity);
        let (slip, yaw) = match arm {
            Some(arm) => (level + spin.cross(&arm), 0.0),
            None => (level, gyration_m * n.dot(spin)),
        };
        let slip_m_s = slip.norm().hypot(yaw).max(f64::MIN_POSITIVE);
        match (support.sustained, arm) {
            (Sustained::Slide, Some(arm)) => {
                let friction = slip * (-support.friction * pressure / slip_m_s);
                (along + friction, arm.cross(&friction) / per_mass.x)
            }
            (Sustained::Slide, None) => {
                let per_slip = -support.friction * pressure / slip_m_s;
                let about = n * (per_slip * yaw / gyration_m);
                (along + slip * per_slip, about)
            }
            (Sustained::Roll, arm) => {
                let radius_m = support.touching.radius_m().unwrap_or(f64::INFINITY);
                let share = 1.0 / (1.0 + about_m2 / (radius_m * radius_m));
                let [along, level] = [along, level].map(taken);
                let speed_m_s = level.norm().max(f64::MIN_POSITIVE);
                let push = along * share - level * (support.friction * pressure / speed_m_s);
                let turning = arm.map_or(Vector3::zeros(), |_| n.cross(&push) / radius_m);
                (push, turning)
            }
            (Sustained::Rest, _) => (Vector3::zeros(), Vector3::zeros()),
        }
    };
    let mut now = *state;
    if support.sustained == Sustained::Rest {
        return now;
    }
    let mut spin = now.orientation * now.angular_velocity_rad_s;
    for _ in 0..steps as usize {
        let (a, about) = forced(&now.velocity_m_s, &spin);
        let middle = (now.velocity_m_s + a * (0.5 * h), spin + about * (0.5 * h));
        let (a, about) = forced(&middle.0, &middle.1);
        now.position_m += middle.0 * h;
        now.orientation = UnitQuaternion::from_scaled_axis(middle.1 * h) * now.orientation;
        now.velocity_m_s += a * h;
        spin += about * h;
    }
    now.angular_velocity_rad_s = now.orientation.inverse() * spin;
    now
}

/// Centre of mass and its velocity.
fn fall(
    body: &Body,
    gravity_m_s2: &Vector3<f64>,
    state: &State,
    duration_s: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let pull = gravity_m_s2 + body.force_m_s2();
    let (mut x, mut v) = (state.position_m, state.velocity_m_s);
    if body.is_ballistic() {
        let fallen = pull * (0.5 * duration_s * duration_s);
        return (x + v * duration_s + fallen, v + pull * duration_s);
    }
    let drag = body.drag();
    let spin = state.orientation * state.angular_velocity_rad_s;
    let slope = |v: &Vector3<f64>| {
        pull - v * (drag.linear_per_s + drag.quadratic_per_m * v.norm())
            + spin.cross(v) * body.lift()
    };
    let steps = (duration_s.abs() / DRAG_STEP_S).ceil().min(DRAG_STEPS);
    let h = duration_s / steps.max(1.0);
    for _ in 0..steps as usize {
        let a1 = slope(&v);
        let a2 = slope(&(v + a1 * (0.5 * h)));
        let a3 = slope(&(v + a2 * (0.5 * h)));
        let a4 = slope(&(v + a3 * h));
        x += (v + (a1 + a2 + a3) * (h / 6.0)) * h;
        v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
    }
    (x, v)
}

/// One step of the rotation.
fn turn(body: &Body, state: &mut State, step_s: f64) {
    let moments = body.moments_kg_m2();
    let coupling = Vector3::from_fn(|axis, _| {
        (moments[(axis + 1) % 3] - moments[(axis + 2) % 3]) / moments[axis]
    });
    let mut omega = [Vector3::zeros(); ORDER + 1];
    let mut q = [Quaternion::from_parts(0.0, Vector3::zeros()); ORDER + 1];
    omega[0] = state.angular_velocity_rad_s;
    q[0] = state.orientation.into_inner();
    for k in 0..ORDER {
        let mut products = Vector3::zeros();
        let mut turned = Quaternion::from_parts(0.0, Vector3::zeros());
        for j in 0..=k {
            let (a, b) = (&omega[j], &omega[k - j]);
            products += Vector3::new(a.y * b.z, a.z * b.x, a.x * b.y);
            turned += q[j] * Quaternion::from_imag(*b);
        }
        let factor = 1.0 / (k + 1) as f64;
        omega[k + 1] = coupling.component_mul(&products) * factor;
        q[k + 1] = turned * (0.5 * factor);
    }
    let (mut omega_after, mut q_after) = (omega[ORDER], q[ORDER]);
    for k in (0..ORDER).rev() {
        omega_after = omega_after * step_s + omega[k];
        q_after = q_after * step_s + q[k];
    }
    state.angular_velocity_rad_s = omega_after;
    state.orientation = UnitQuaternion::new_normalize(q_after);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{Drag, flow};

    fn state() -> State {
        State {
            position_m: Vector3::new(0.1, -0.2, 0.3),
            orientation: UnitQuaternion::from_euler_angles(0.4, -0.3, 2.0),
            velocity_m_s: Vector3::new(0.5, 0.2, -2.0),
            angular_velocity_rad_s: Vector3::new(3.0, -17.0, 20.0),
        }
    }

    #[test]
    fn friction_does_what_the_flow_says() {
        let ball = OnPlane::Ball { radius_m: 0.03 };
        let side = OnPlane::Side {
            radius_m: 0.03,
            axis: Vector3::x(),
        };
        let face = OnPlane::Face {
            point_m: Vector3::new(0.0, 0.0, -0.03),
            normal: -Vector3::z(),
        };
        let cases = [
            (Sustained::Slide, ball, Vector3::repeat(7e-5)),
            (Sustained::Slide, face, Vector3::new(3e-4, 4e-4, 6e-4)),
            (Sustained::Roll, ball, Vector3::repeat(7e-5)),
            (Sustained::Roll, side, Vector3::new(9e-5, 4e-4, 4e-4)),
            (Sustained::Rest, face, Vector3::new(3e-4, 4e-4, 6e-4)),
        ];
        for (sustained, touching, moments) in cases {
            for normal in [Vector3::z(), Vector3::new(0.1, -0.2, 1.0).normalize()] {
                let support = Support::Plane(PlaneSupport {
                    normal,
                    sustained,
                    friction: 0.25,
                    touching,
                });
                let body = Body::new(0.2, moments).unwrap();
                let body = body.with_support(Some(support));
                let gravity = Vector3::new(0.0, 0.0, -9.81);
                let across = |of: Vector3<f64>| of - normal * normal.dot(&of);
                let level = UnitQuaternion::rotation_between(&Vector3::z(), &normal);
                let orientation = level.unwrap_or_default();
                let velocity_m_s = match touching {
                    OnPlane::Side { axis, .. } => normal.cross(&(orientation * axis)) * 1.5,
                    _ => across(Vector3::new(1.5, 0.7, 0.0)),
                };
                let spin = match (sustained, touching.radius_m()) {
                    (Sustained::Roll, Some(radius_m)) => normal.cross(&velocity_m_s) / radius_m,
                    (_, Some(_)) => Vector3::new(3.0, -7.0, 5.0),
                    _ => normal * 5.0,
                };
                let at_rest = sustained == Sustained::Rest;
                let moving = if at_rest { 0.0 } else { 1.0 };
                let start = State {
                    orientation,
                    velocity_m_s: velocity_m_s * moving,
                    angular_velocity_rad_s: orientation.inverse() * spin * moving,
                    ..State::at_rest()
                };
                let stepped = advance(&body, &gravity, &start, 0.15);
                let flown = flow::advance(&body, &gravity, &start, 0.15);
                // A ball's spin is that of its slip over its radius.
                let off = stepped.minus(&flown);
                let off = off.rows(0, 3).norm() + off.rows(6, 3).norm();
                assert!(off < 2e-3, "{support:?}: {off:e}");
            }
        }
    }

    #[test]
    fn it_agrees_with_the_closed_form() {
        let gravity = Vector3::new(0.3, 0.0, -9.8);
        for moments in [[1.8e-5, 1.8e-5, 4e-8], [2e-4, 3e-4, 3e-4], [1e-3; 3]] {
            let body = Body::new(0.006, Vector3::from(moments)).unwrap();
            for duration_s in [0.0, 1e-9, 0.5, -0.7] {
                let series = advance(&body, &gravity, &state(), duration_s);
                let closed = flow::advance(&body, &gravity, &state(), duration_s);
                let difference = series.minus(&closed).norm();
                assert!(
                    difference < 2e-12,
                    "{moments:?} {duration_s} {difference:e}"
                );
            }
        }
    }

    #[test]
    fn drag_is_that_of_the_flow() {
        let gravity = Vector3::new(0.3, 0.0, -9.8);
        let body = Body::new(0.006, Vector3::repeat(1e-3)).unwrap();
        let body = body.with_force(Vector3::new(0.5, -0.1, 0.0)).unwrap();
        for (linear_per_s, quadratic_per_m) in [(0.0, 0.13), (2.0, 0.0), (0.3, 0.4)] {
            let drag = Drag {
                linear_per_s,
                quadratic_per_m,
            };
            let body = body.with_drag(drag).unwrap();
            let lifts = [0.0, 0.02].into_iter();
            let cases =
                lifts.flat_map(|lift| [1e-9, 0.5, -0.3].map(|duration_s| (lift, duration_s)));
            for (lift, duration_s) in cases {
                let body = body.with_lift(lift).unwrap();
                let own = advance(&body, &gravity, &state(), duration_s);
                let flow = flow::advance(&body, &gravity, &state(), duration_s);
                let off = own.minus(&flow).norm();
                assert!(off < 1e-11, "{drag:?} {duration_s} {off:e}");
            }
        }
    }

    #[test]
    fn there_and_back_is_where_it_was() {
        let body = Body::new(1.0, Vector3::new(2.0, 2.0, 3.0)).unwrap();
        let there = advance(&body, &Vector3::x(), &state(), 1.3);
        let back = advance(&body, &Vector3::x(), &there, -1.3);
        assert!(back.minus(&state()).norm() < 1e-12);
    }
}
