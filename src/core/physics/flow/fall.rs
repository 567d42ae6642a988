//! The centre of mass of a body in flight.
//!
//! ```text
//! x' = v,   v' = p + Ω × v − k v − c|v| v,   p = g + f,   Ω = ℓ R ω
//! ```
//!
//! with gravity `g`, the body's constant force per mass `f`, its drag `k`, `c` and, of a ball, its lift `ℓ`. Without
//! drag and lift it is the parabola `x + v s + ½ p s²`; with them it is integrated ([`super::glide`]). The position
//! at the start is only added to the way.

use nalgebra::{Matrix3, Matrix3x2, UnitQuaternion, Vector3};

use super::glide::{Change, Glide, column};
use crate::math::so3;
use crate::physics::body::Body;
use crate::physics::state::State;

/// Centre of mass after a flight, with derivatives. All vectors are in world axes. Its derivative by
/// the position at the start is the identity, that of the velocity is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fallen {
    /// `x(s)` \[m\].
    pub position_m: Vector3<f64>,
    /// `v(s)` [m/s].
    pub velocity_m_s: Vector3<f64>,
    /// Of `x(s)` by `v(0)` \[s\].
    pub position_by_velocity: Matrix3<f64>,
    /// Of `x(s)` by the pull `p = g + f` \[s²\]: by gravity as by the force.
    pub position_by_pull: Matrix3<f64>,
    /// Of `x(s)` by `k` [m s] and by `c` \[m²\], a column each.
    pub position_by_drag: Matrix3x2<f64>,
    /// Of `v(s)` by `v(0)`.
    pub velocity_by_velocity: Matrix3<f64>,
    /// Of `v(s)` by the pull \[s\].
    pub velocity_by_pull: Matrix3<f64>,
    /// Of `v(s)` by `k` \[m\] and by `c` [m²/s], a column each.
    pub velocity_by_drag: Matrix3x2<f64>,
    /// Those of what spins, where there is lift or derivatives by it are wanted.
    pub by_spinning: Option<FallenBySpinning>,
}

/// Derivatives of a centre of mass after a flight with lift by what lifts it: of its position and of its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FallenBySpinning {
    /// By the orientation at the start [m, m/s per rad].
    pub by_orientation: [Matrix3<f64>; 2],
    /// By the angular velocity at the start [m, m/s per rad/s].
    pub by_angular_velocity: [Matrix3<f64>; 2],
    /// By the lift `ℓ` [m, m/s].
    pub by_lift: [Vector3<f64>; 2],
}

/// The flight of a centre of mass from one start, for many durations of either sign.
///
/// The result does not depend on the order in which durations are asked for; steps computed for one
/// serve the next. With drag it is not a number where `k + c|v|` exceeds 128/s on the way: forwards
/// drag that stops a body within centimetres, and backwards a quadratic drag, which reaches infinite
/// speed within `1/(c|v|)` seconds at most.
#[derive(Clone, Debug)]
pub struct Fall {
    position_m: Vector3<f64>,
    velocity_m_s: Vector3<f64>,
    pull_m_s2: Vector3<f64>,
    is_ballistic: bool,
    /// Whether derivatives by drag are wanted.
    drag_is_free: bool,
    /// Whether those by lift are.
    lift_is_free: bool,
    lift: f64,
    orientation: UnitQuaternion<f64>,
    angular_velocity_rad_s: Vector3<f64>,
    /// Of a body without drag and lift, needed for derivatives by them only.
    glide: Glide,
}

impl Fall {
    /// The flight of a body from a state, of which only position and velocity count unless there is lift.
    pub fn new(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State) -> Self {
        let pull_m_s2 = body.pull_m_s2(gravity_m_s2);
        let mut glide = Glide::new(pull_m_s2, body.drag(), &state.velocity_m_s);
        if body.lift() != 0.0 {
            let spin = state.orientation * state.angular_velocity_rad_s;
            glide = glide.lifted(spin * body.lift());
        }
        Self {
            position_m: state.position_m,
            velocity_m_s: state.velocity_m_s,
            pull_m_s2,
            is_ballistic: body.feels_no_air(),
            drag_is_free: true,
            lift_is_free: false,
            lift: body.lift(),
            orientation: state.orientation,
            angular_velocity_rad_s: state.angular_velocity_rad_s,
            glide,
        }
    }

    /// The flight without derivatives by drag unless it is free: they become zero, and what a body
    /// without drag has is in closed form.
    pub fn with_drag_free(self, drag_is_free: bool) -> Self {
        Self {
            drag_is_free,
            ..self
        }
    }

    /// The flight with derivatives by lift where that is free.
    pub fn with_lift_free(self, lift_is_free: bool) -> Self {
        Self {
            lift_is_free,
            ..self
        }
    }

    /// Centre of mass `x(s)` [m, world], the same bits as by [`super::position`].
    pub fn position(&mut self, duration_s: f64) -> Vector3<f64> {
        self.position_and_velocity(duration_s).0
    }

    /// `x(s)` [m, world] and `v(s)` [m/s, world].
    pub fn position_and_velocity(&mut self, duration_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        if self.is_ballistic {
            return self.ballistic(duration_s);
        }
        let node = self.glide.at(duration_s);
        (self.position_m + node.way_m, node.velocity_m_s)
    }

    /// `x(s)` and `v(s)` with their derivatives.
    ///
    /// Those by drag of a body that has none are of the limit from above.
    pub fn fallen(&mut self, duration_s: f64) -> Fallen {
        if self.is_ballistic && !self.drag_is_free && !self.lift_is_free {
            let (position_m, velocity_m_s) = self.ballistic(duration_s);
            return Fallen {
                position_m,
                velocity_m_s,
                position_by_velocity: Matrix3::from_diagonal_element(duration_s),
                position_by_pull: Matrix3::from_diagonal_element(0.5 * duration_s * duration_s),
                position_by_drag: Matrix3x2::zeros(),
                velocity_by_velocity: Matrix3::identity(),
                velocity_by_pull: Matrix3::from_diagonal_element(duration_s),
                velocity_by_drag: Matrix3x2::zeros(),
                by_spinning: None,
            };
        }
        let (node, change) = self.glide.at_with_change(duration_s);
        let (position_m, velocity_m_s) = if self.is_ballistic {
            self.ballistic(duration_s)
        } else {
            (self.position_m + node.way_m, node.velocity_m_s)
        };
        let three = |of: &Change, at: usize| of.fixed_columns::<3>(at).into_owned();
        let drag = |of: &Change| of.fixed_columns::<2>(column::LINEAR_DRAG).into_owned();
        Fallen {
            position_m,
            velocity_m_s,
            position_by_velocity: three(&change.way, column::VELOCITY),
            position_by_pull: three(&change.way, column::PULL),
            position_by_drag: drag(&change.way),
            velocity_by_velocity: three(&change.velocity, column::VELOCITY),
            velocity_by_pull: three(&change.velocity, column::PULL),
            velocity_by_drag: drag(&change.velocity),
            by_spinning: self.by_spinning(duration_s),
        }
    }

    /// By `Ω = ℓ R ω`, of which `δΩ = ℓ R (δω + θ × ω) + δℓ R ω` where `R` turns by `θ` on the right.
    fn by_spinning(&mut self, duration_s: f64) -> Option<FallenBySpinning> {
        if self.lift == 0.0 && !self.lift_is_free {
            return None;
        }
        let change = self.glide.by_lifting(duration_s);
        let turned = so3::matrix(&self.orientation);
        let omega = &self.angular_velocity_rad_s;
        let both = [change.way, change.velocity].map(|by| by * turned);
        Some(FallenBySpinning {
            by_orientation: both.map(|by| by * so3::hat(omega) * -self.lift),
            by_angular_velocity: both.map(|by| by * self.lift),
            by_lift: both.map(|by| by * omega),
        })
    }

    fn ballistic(&self, s: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (x, v) = (&self.position_m, &self.velocity_m_s);
        (parabola(x, v, &self.pull_m_s2, s), v + self.pull_m_s2 * s)
    }
}

/// `x + v s + ½ p s²`.
#[inline]
pub(super) fn parabola(
    position_m: &Vector3<f64>,
    velocity_m_s: &Vector3<f64>,
    pull_m_s2: &Vector3<f64>,
    s: f64,
) -> Vector3<f64> {
    position_m + (velocity_m_s + pull_m_s2 * (0.5 * s)) * s
}

#[cfg(test)]
mod tests;
