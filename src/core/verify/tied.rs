//! The motion of a body that is tied to a place, independent of [`crate::physics::flow`]: what the pivot bears is found
//! with the accelerations, so that its point has none,
//!
//! ```text
//! v̇ = p + λ,   I ω̇ = (I ω) × ω + p̂ × Rᵀ λ + B μ − d ω        per mass, p̂ the body's point
//! v̇ + R (ω̇ × p̂) = −R (ω × (ω × p̂)),   Bᵀ ω̇ = 0              B across the axis of a pin
//! ```
//!
//! integrated by the classic Runge–Kutta method.

use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};

use crate::math::so3;
use crate::physics::contact::Feature;
use crate::physics::support::{Pivot, PivotAxes};
use crate::physics::{Body, State};

/// Length of a step \[s\].
const STEP_S: f64 = 1.0 / 1024.0;

/// Greatest number of steps.
const STEPS: f64 = 1e5;

/// Velocity, angular velocity \[body\], and their rates.
struct TiedRate {
    velocity_m_s: Vector3<f64>,
    angular_velocity_rad_s: Vector3<f64>,
    acceleration_m_s2: Vector3<f64>,
    angular_acceleration_rad_s2: Vector3<f64>,
}

/// State after `duration_s` (negative: before).
pub(super) fn advance(
    body: &Body,
    pivot: &Pivot,
    gravity_m_s2: &Vector3<f64>,
    state: &State,
    duration_s: f64,
) -> State {
    if pivot.axes == PivotAxes::None {
        return *state;
    }
    let steps = (duration_s.abs() / STEP_S).ceil().min(STEPS);
    let h = duration_s / steps.max(1.0);
    let rate = |of: &State| rate(body, pivot, gravity_m_s2, of);
    let mut now = *state;
    for _ in 0..steps as usize {
        let first = rate(&now);
        let second = rate(&moved(&now, &first, 0.5 * h));
        let third = rate(&moved(&now, &second, 0.5 * h));
        let fourth = rate(&moved(&now, &third, h));
        let mean = |of: fn(&TiedRate) -> Vector3<f64>| {
            (of(&first) + (of(&second) + of(&third)) * 2.0 + of(&fourth)) / 6.0
        };
        // Of the rotation with the part that does not commute, to the fourth order in the step.
        let across = first
            .angular_velocity_rad_s
            .cross(&fourth.angular_velocity_rad_s)
            * (h * h / 12.0);
        let angle = mean(|of| of.angular_velocity_rad_s) * h + across;
        now = State {
            position_m: now.position_m + mean(|of| of.velocity_m_s) * h,
            orientation: now.orientation * UnitQuaternion::from_scaled_axis(angle),
            velocity_m_s: now.velocity_m_s + mean(|of| of.acceleration_m_s2) * h,
            angular_velocity_rad_s: now.angular_velocity_rad_s
                + mean(|of| of.angular_acceleration_rad_s2) * h,
        };
    }
    now
}

fn moved(from: &State, rate: &TiedRate, h: f64) -> State {
    let angle = rate.angular_velocity_rad_s * h;
    State {
        position_m: from.position_m + rate.velocity_m_s * h,
        orientation: from.orientation * UnitQuaternion::from_scaled_axis(angle),
        velocity_m_s: from.velocity_m_s + rate.acceleration_m_s2 * h,
        angular_velocity_rad_s: from.angular_velocity_rad_s + rate.angular_acceleration_rad_s2 * h,
    }
}

/// State in which what arrives at a pivot in motion is caught: the impulse at the pivot, and a moment across the axis of
/// a pin, end what it does not allow.
pub(super) fn caught(body: &Body, pivot: &Pivot, state: &State) -> State {
    let (still, omega) = (Vector3::zeros(), state.angular_velocity_rad_s);
    let mut after = State {
        velocity_m_s: still,
        angular_velocity_rad_s: still,
        ..*state
    };
    if pivot.axes == PivotAxes::None {
        return after;
    }
    let inertia = Matrix3::from_diagonal(&body.gyration_m2());
    let found = borne(
        body,
        pivot,
        state,
        [state.velocity_m_s, inertia * omega, still],
    );
    after.velocity_m_s = found[0];
    after.angular_velocity_rad_s = found[1];
    after
}

/// The velocity and angular velocity, or their rates, that have these momenta and what the pivot bears, such that its
/// point has the velocity, or acceleration, given last.
fn borne(body: &Body, pivot: &Pivot, state: &State, given: [Vector3<f64>; 3]) -> [Vector3<f64>; 2] {
    let to_world = so3::matrix(&state.orientation);
    let inertia = Matrix3::from_diagonal(&body.gyration_m2());
    let arm = so3::hat(&pivot.at_m);
    let across: Vec<Vector3<f64>> = match pivot.axes {
        PivotAxes::One(axis) => Feature::tangents(&axis).to_vec(),
        _ => Vec::new(),
    };
    let size = 9 + across.len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    let mut put = |row: usize, column: usize, block: Matrix3<f64>| {
        matrix.view_mut((row, column), (3, 3)).copy_from(&block);
    };
    put(0, 0, Matrix3::identity());
    put(0, 6, -Matrix3::identity());
    put(3, 3, inertia);
    put(3, 6, -arm * to_world.transpose());
    put(6, 0, Matrix3::identity());
    put(6, 3, -to_world * arm);
    for (place, axis) in (9..).zip(&across) {
        matrix.view_mut((3, place), (3, 1)).copy_from(&-axis);
        matrix
            .view_mut((place, 3), (1, 3))
            .copy_from(&axis.transpose());
    }
    for (row, of) in given.iter().enumerate() {
        right.rows_mut(3 * row, 3).copy_from(of);
    }
    let found = matrix.lu().solve(&right).expect("a body with mass");
    [0, 3].map(|row| Vector3::new(found[row], found[row + 1], found[row + 2]))
}

fn rate(body: &Body, pivot: &Pivot, gravity_m_s2: &Vector3<f64>, state: &State) -> TiedRate {
    let omega = state.angular_velocity_rad_s;
    let inertia = Matrix3::from_diagonal(&body.gyration_m2());
    let pull = gravity_m_s2 + body.force_m_s2();
    let gyroscopic = (inertia * omega).cross(&omega);
    let damped = omega * (pivot.damping_n_m_s / body.mass_kg());
    let central = state.orientation * omega.cross(&omega.cross(&pivot.at_m));
    let given = [pull, gyroscopic - damped, -central];
    let [acceleration_m_s2, angular_acceleration_rad_s2] = borne(body, pivot, state, given);
    TiedRate {
        velocity_m_s: state.velocity_m_s,
        angular_velocity_rad_s: omega,
        acceleration_m_s2,
        angular_acceleration_rad_s2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{Support, flow};

    #[test]
    fn a_pendulum_and_a_top_move_as_the_flow_says() {
        let gravity = Vector3::new(0.4, -0.2, -9.81);
        let at_m = Vector3::new(0.02, -0.05, 0.31);
        let axis = Vector3::new(0.3, -0.8, 0.2).normalize();
        for axes in [PivotAxes::All, PivotAxes::One(axis), PivotAxes::None] {
            for damping_n_m_s in [0.0, 4e-3] {
                let pivot = Pivot {
                    at_m,
                    axes,
                    damping_n_m_s,
                };
                let body = Body::new(0.4, Vector3::new(3e-3, 4e-3, 6e-3)).unwrap();
                let body = body.with_support(Some(Support::Pivot(pivot)));
                let omega = axes.allowed() * Vector3::new(3.0, -5.0, 6.0);
                let orientation = UnitQuaternion::from_euler_angles(0.4, -0.3, 2.0);
                let start = State {
                    position_m: Vector3::new(0.1, -0.2, 0.3),
                    orientation,
                    velocity_m_s: orientation * omega.cross(&-at_m),
                    angular_velocity_rad_s: omega,
                };
                for duration_s in [0.9, -0.7] {
                    let stepped = advance(&body, &pivot, &gravity, &start, duration_s);
                    let flown = flow::advance(&body, &gravity, &start, duration_s);
                    let off = stepped.minus(&flown).norm();
                    assert!(off < 1e-7, "{pivot:?} {duration_s}: {off:e}");
                    assert!(
                        duration_s < 0.0
                            || axes == PivotAxes::None
                            || stepped.minus(&start).norm() > 0.1
                    );
                }
            }
        }
    }

    /// The impulse goes through the point, so that it has no moment about it, and takes energy.
    #[test]
    fn what_is_caught_keeps_its_momentum_about_the_pivot() {
        let axis = Vector3::new(0.3, -0.8, 0.2).normalize();
        for axes in [PivotAxes::All, PivotAxes::One(axis), PivotAxes::None] {
            let pivot = Pivot {
                at_m: Vector3::new(0.02, -0.05, 0.31),
                axes,
                damping_n_m_s: 0.0,
            };
            let moments = Vector3::new(3e-3, 4e-3, 6e-3);
            let body = Body::new(0.4, moments).unwrap();
            let state = State {
                position_m: Vector3::new(0.1, -0.2, 0.3),
                orientation: UnitQuaternion::from_euler_angles(0.4, -0.3, 2.0),
                velocity_m_s: Vector3::new(1.5, 0.7, 0.1),
                angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
            };
            let after = caught(&body, &pivot, &state);
            let momentum = |of: &State| {
                let velocity = of.orientation.inverse() * of.velocity_m_s;
                let about = moments.component_mul(&of.angular_velocity_rad_s);
                about + 0.4 * (-pivot.at_m).cross(&velocity)
            };
            let energy = |of: &State| {
                let omega = of.angular_velocity_rad_s;
                0.2 * of.velocity_m_s.norm_squared()
                    + 0.5 * moments.component_mul(&omega).dot(&omega)
            };
            let kept = axes.allowed() * (momentum(&after) - momentum(&state));
            assert!(kept.norm() < 1e-12, "{axes:?}: {kept}");
            let moving = after.angular_velocity_rad_s.cross(&pivot.at_m);
            let moving = after.velocity_m_s + after.orientation * moving;
            assert!(moving.norm() < 1e-12);
            let omega = after.angular_velocity_rad_s;
            assert!((omega - axes.allowed() * omega).norm() < 1e-12);
            assert!(energy(&after) < energy(&state));
        }
    }
}
