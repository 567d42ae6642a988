//! Continuity through an impact (paper eq. 3, 8, §5.2): a body continues from the pose in which it
//! arrives, with the velocities after the impact:
//!
//! ```text
//! x⁺ − x⁻ = 0,   Log(R⁻ᵀ R⁺) = 0,   (v⁺, ω⁺) − Impact(q⁻, u) = 0
//! ```
//!
//! with `q⁻ = Φ(q_before, τ − epoch)` and `q⁺` likewise of the arc after.

use nalgebra::{Matrix3, Vector3};

use super::rows::{CollisionRows, HALF, Half, STATE};
use crate::estimate::problem::{ArcCollision, unit};
use crate::estimate::reach::arc_end::{ArcEnd, ByState};
use crate::math::so3;
use crate::physics::impact::ImpactDerivative;
use crate::physics::state::part;

impl CollisionRows<'_> {
    /// The difference of a body's positions after and before, `gap`, and its derivatives.
    pub(super) fn fill_positions(
        &mut self,
        side: usize,
        gap: &Vector3<f64>,
        before: &ArcEnd,
        after: &ArcEnd,
    ) {
        let (pattern, block) = &mut self.block;
        let (s, t) = (before.duration_s, after.duration_s);
        let scale = 1.0 / unit::POSITION_M;
        for axis in 0..3 {
            let row = self.places.of_side(side) + axis;
            block.values[row] = gap[axis] * scale;
            let speed = after.rate[axis] - before.rate[axis];
            let all = [-1.0, -s, speed, 1.0, t, 0.5 * (t * t - s * s)];
            let to = block.derivatives_mut(pattern, row);
            for (entry, by) in to.iter_mut().zip(all) {
                *entry = by * scale;
            }
        }
    }

    /// The rotation of a body from its orientation before to that after, `turn`, and its
    /// derivatives.
    pub(super) fn fill_orientations(
        &mut self,
        side: usize,
        turn: &Vector3<f64>,
        before: &ArcEnd,
        after: &ArcEnd,
    ) {
        let (pattern, block) = &mut self.block;
        let scale = 1.0 / unit::ORIENTATION_RAD;
        let by_after = so3::right_jacobian_inverse(turn) * scale;
        let by_before = -by_after.transpose();
        let rate = |arrival: &ArcEnd| -> Vector3<f64> {
            arrival.rate.fixed_rows::<3>(part::ORIENTATION).into()
        };
        let by_time = by_before * rate(before) + by_after * rate(after);
        let chained = [(&by_before, before), (&by_after, after)]
            .map(|(by, arrival)| [by * arrival.by_orientation, by * arrival.turn_by_spin]);
        for axis in 0..3 {
            let row = self.places.of_side(side) + part::ORIENTATION + axis;
            block.values[row] = turn[axis] * scale;
            let to = block.derivatives_mut(pattern, row);
            for ([by_orientation, by_spin], first) in chained.iter().zip([0, HALF + 1]) {
                for other in 0..3 {
                    to[first + other] = by_orientation[(axis, other)];
                    to[first + 3 + other] = by_spin[(axis, other)];
                }
            }
            to[HALF] = by_time[axis];
        }
    }

    /// The difference of a body's velocity or angular velocity after from the impact's, `gap`, and
    /// its derivatives.
    pub(super) fn fill_velocities(
        &mut self,
        side: usize,
        half: Half,
        gap: &Vector3<f64>,
        derivative: &ImpactDerivative,
        before: &[Option<ArcEnd>; 2],
        after: &ArcEnd,
    ) {
        let scale = match half {
            Half::Velocity => 1.0 / unit::VELOCITY_M_S,
            Half::Spin => 1.0 / unit::ANGULAR_VELOCITY_RAD_S,
        };
        let first = half as usize;
        let mut by_time: Vector3<f64> = after.rate.fixed_rows::<3>(HALF + first).into();
        let (by_after, mut by_gravity) = match half {
            Half::Velocity => (
                Matrix3::identity(),
                Matrix3::from_diagonal_element(after.duration_s),
            ),
            Half::Spin => (after.spin_by_spin, Matrix3::zeros()),
        };
        let from = self.places.first_part;
        let ((pattern, block), row) = if self.places.rows_per_side == STATE {
            (&mut self.block, self.places.of_side(side) + HALF + first)
        } else {
            (&mut self.gaps, side * HALF + first)
        };
        for (other, arrival) in before.iter().enumerate() {
            let Some(arrival) = arrival else { continue };
            let by = ByState::<3>::of(&derivative.after[side][other], first);
            let chained = arrival.chain(&by);
            for axis in 0..3 {
                let to = block.derivatives_mut(pattern, row + axis);
                let to = &mut to[(STATE - from) * other..][..STATE - from];
                chained.put(axis, -scale, from, to);
            }
            by_time -= arrival.by_time(&by);
            for axis in self.problem.free_gravity() {
                let mut column = by_gravity.column_mut(axis);
                column -= arrival.by_gravity(&by, axis);
            }
        }
        for axis in 0..3 {
            block.values[row + axis] = gap[axis] * scale;
            let to = block.derivatives_mut(pattern, row + axis);
            let states = (STATE - from) * self.places.states;
            let by_law = by_law(self.collision, derivative, side, first + axis);
            let gravity = self.problem.free_gravity();
            let rest = std::iter::once(by_time[axis])
                .chain((0..3).map(|other| by_after[(axis, other)]))
                .chain(gravity.map(|other| by_gravity[(axis, other)]))
                .chain(by_law.map(|by| -by));
            for (entry, by) in to[states..].iter_mut().zip(rest) {
                *entry = by * scale;
            }
        }
    }
}

/// Derivatives of a velocity after the impact by restitution, friction, tangential restitution and tilts,
/// where they are free.
fn by_law<'a>(
    collision: &'a ArcCollision,
    derivative: &'a ImpactDerivative,
    side: usize,
    row: usize,
) -> impl Iterator<Item = f64> + 'a {
    let restitution = collision.restitution_parameter;
    let friction = collision.friction_parameter;
    let tilts = collision.tilts.iter();
    let by_restitution = restitution.map(|_| derivative.after_by_restitution[side][row]);
    let by_friction = friction.map(|_| derivative.after_by_friction[side][row]);
    let tangential = collision.tangential_parameter;
    let by_tangential = tangential.map(|_| derivative.after_by_tangential_restitution[side][row]);
    let by_tilts = tilts.map(move |(tangent, _)| derivative.after_by_tilt[side][(row, *tangent)]);
    by_restitution
        .into_iter()
        .chain(by_friction)
        .chain(by_tangential)
        .chain(by_tilts)
}
