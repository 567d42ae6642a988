//! The centre of mass of a body in flight.
//!
//! ```text
//! x' = v,   v' = p − k v − c|v| v,   p = g + f
//! ```
//!
//! with gravity `g`, the body's constant force per mass `f` and its drag `k`, `c`. Without drag it
//! is the parabola `x + v s + ½ p s²`; with drag it is integrated ([`super::glide`]). The position
//! at the start is only added to the way.

use nalgebra::{Matrix3, Matrix3x2, Vector3};

use super::glide::{Change, Glide, column};
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
    /// Of a body without drag, needed for derivatives by it only.
    glide: Glide,
}

impl Fall {
    /// The flight of a body from a state, of which only position and velocity count.
    pub fn new(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State) -> Self {
        let pull_m_s2 = body.pull_m_s2(gravity_m_s2);
        Self {
            position_m: state.position_m,
            velocity_m_s: state.velocity_m_s,
            pull_m_s2,
            is_ballistic: body.drag().is_none(),
            drag_is_free: true,
            glide: Glide::new(pull_m_s2, body.drag(), &state.velocity_m_s),
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
        if self.is_ballistic && !self.drag_is_free {
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
        }
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
