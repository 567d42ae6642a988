//! The motion of a whole state, centre of mass and rotation together: free flight, or on what supports the body.

use nalgebra::Vector3;

use super::asymmetric;
use super::axial::Turning;
use super::fall::{self, Fall};
use super::supported::Supported;
use crate::physics::body::{Body, Symmetry};
use crate::physics::state::{State, StateTangent, part};

/// State after `duration_s` of free flight, or on its support (negative: before).
///
/// Orientation and angular velocity are NaN where a body with three different moments would turn by
/// more than [`super::ANGLE_MAX_RAD`]; position and velocity where [`Fall`] gives NaN.
pub fn advance(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State, duration_s: f64) -> State {
    if let Some(mut supported) = Supported::new(body, gravity_m_s2, state) {
        return supported.at(duration_s);
    }
    let omega = &state.angular_velocity_rad_s;
    let (rotation, angular_velocity_rad_s) = match body.symmetry() {
        Symmetry::Asymmetric => asymmetric::advance(body, omega, duration_s),
        _ => Turning::of(body).advance(omega, duration_s),
    };
    let (position_m, velocity_m_s) =
        Fall::new(body, gravity_m_s2, state).position_and_velocity(duration_s);
    State {
        position_m,
        orientation: state.orientation * rotation,
        velocity_m_s,
        angular_velocity_rad_s,
    }
}

/// Centre of mass after `duration_s` [m, world]; for many durations with drag, see [`Fall`].
pub fn position(
    body: &Body,
    gravity_m_s2: &Vector3<f64>,
    state: &State,
    duration_s: f64,
) -> Vector3<f64> {
    if body.is_ballistic() {
        let pull_m_s2 = body.pull_m_s2(gravity_m_s2);
        return fall::parabola(
            &state.position_m,
            &state.velocity_m_s,
            &pull_m_s2,
            duration_s,
        );
    }
    if body.support().is_some() {
        return advance(body, gravity_m_s2, state, duration_s).position_m;
    }
    Fall::new(body, gravity_m_s2, state).position(duration_s)
}

/// Velocity of the centre of mass after `duration_s` [m/s, world].
pub fn velocity(
    body: &Body,
    gravity_m_s2: &Vector3<f64>,
    state: &State,
    duration_s: f64,
) -> Vector3<f64> {
    if body.is_ballistic() {
        return state.velocity_m_s + body.pull_m_s2(gravity_m_s2) * duration_s;
    }
    if body.support().is_some() {
        return advance(body, gravity_m_s2, state, duration_s).velocity_m_s;
    }
    Fall::new(body, gravity_m_s2, state)
        .position_and_velocity(duration_s)
        .1
}

/// Time derivative of the state in free flight, in its own tangent space:
/// `(v, ω, g + f + ℓ ω × v − k v − c|v| v, I⁻¹((I ω) × ω))`.
///
/// On a support: the rate there.
pub fn rate(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State) -> StateTangent {
    if let Some(mut supported) = Supported::new(body, gravity_m_s2, state) {
        return supported.carried(0.0).rate;
    }
    let omega = &state.angular_velocity_rad_s;
    let [a, b, c] = asymmetric::couplings(body);
    let euler = Vector3::new(
        a * omega.y * omega.z,
        b * omega.z * omega.x,
        c * omega.x * omega.y,
    );
    let mut rate = StateTangent::zeros();
    rate.fixed_rows_mut::<3>(part::POSITION)
        .copy_from(&state.velocity_m_s);
    rate.fixed_rows_mut::<3>(part::ORIENTATION).copy_from(omega);
    rate.fixed_rows_mut::<3>(part::VELOCITY)
        .copy_from(&body.acceleration_m_s2(
            gravity_m_s2,
            &state.velocity_m_s,
            &(state.orientation * omega),
        ));
    rate.fixed_rows_mut::<3>(part::ANGULAR_VELOCITY)
        .copy_from(&euler);
    rate
}
