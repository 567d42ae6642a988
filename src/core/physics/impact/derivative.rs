//! Derivatives of an impact.

use nalgebra::{RowSVector, SMatrix, SVector};

use super::contact_state::{ContactState, PoseChange};
use super::error::ImpactError;
use super::law::MOST_CONTACTS;
use super::rows::Change;
use super::solution::ImpactSolution;
use crate::physics::state::part;

/// Derivatives of an [`Impact`](super::Impact). Columns of a state are those of
/// [`StateTangent`](crate::physics::state::StateTangent); rows of velocities are `v` [m/s,
/// world], then `ω` [rad/s, body].
///
/// Exact on each side of the switches between sticking and sliding and between approaching and
/// receding; on a switch, the derivative of the reported branch. It is large: make one and reuse it
/// ([`ContactSet::derivative`](super::ContactSet::derivative)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactDerivative {
    /// Gap `[contact]` by the state `[body]` before.
    pub gap: [[RowSVector<f64, 12>; 2]; MOST_CONTACTS],
    /// Speed along the untilted normal `[contact]` by the state `[body]` before.
    pub speed: [[RowSVector<f64, 12>; 2]; MOST_CONTACTS],
    /// Velocities `[i]` after by the state `[j]` before.
    pub after: [[SMatrix<f64, 6, 12>; 2]; 2],
    /// Velocities after by the restitution.
    pub after_by_restitution: [SVector<f64, 6>; 2],
    /// Velocities after by the coefficient of friction.
    pub after_by_friction: [SVector<f64, 6>; 2],
    /// Velocities after by the tangential restitution.
    pub after_by_tangential_restitution: [SVector<f64, 6>; 2],
    /// Velocities after by the two tilts; zero where
    /// [`ContactSet::check_tilt`](super::ContactSet::check_tilt) refuses them.
    pub after_by_tilt: [SMatrix<f64, 6, 2>; 2],
}

impl ImpactDerivative {
    /// All zero.
    #[inline]
    pub fn zeros() -> Self {
        Self {
            gap: [[RowSVector::zeros(); 2]; MOST_CONTACTS],
            speed: [[RowSVector::zeros(); 2]; MOST_CONTACTS],
            after: [[SMatrix::zeros(); 2]; 2],
            after_by_restitution: [SVector::zeros(); 2],
            after_by_friction: [SVector::zeros(); 2],
            after_by_tangential_restitution: [SVector::zeros(); 2],
            after_by_tilt: [SMatrix::zeros(); 2],
        }
    }
}

impl Default for ImpactDerivative {
    fn default() -> Self {
        Self::zeros()
    }
}

impl ImpactSolution<'_> {
    /// Sets the entries for existing contacts and bodies.
    pub(super) fn derivative(&self, derivative: &mut ImpactDerivative) -> Result<(), ImpactError> {
        let mut rates = [const { None }; MOST_CONTACTS];
        for (contact, state) in self.states().enumerate() {
            let touch = state
                .contact
                .touch_derivative(&self.frames[0], &self.frames[1])
                .map_err(|reason| ImpactError::Degenerate { contact, reason })?;
            rates[contact] = Some(touch.1);
        }
        for body in 0..self.rows.bodies {
            let mut poses = [const { None }; MOST_CONTACTS];
            let mut normals = [Change::zeros(); MOST_CONTACTS];
            for (contact, state) in self.states().enumerate() {
                let Some(rates) = &rates[contact] else {
                    continue;
                };
                let by = PoseChange::of_body(body, rates);
                let gap = &mut derivative.gap[contact][body];
                gap.fill(0.0);
                gap.fixed_columns_mut::<6>(part::POSITION)
                    .copy_from(&rates.gap.fixed_columns::<6>(6 * body));
                derivative.speed[contact][body] = self.speed_by_state(state, body, &by);
                normals[contact] = state.normal_change(&by);
                poses[contact] = Some(by);
            }
            if let Some(landing) = self.landing() {
                derivative.after[0][0] = landing.by_state();
                continue;
            }
            self.after_by_pose(body, &normals, &poses, derivative);
            self.after_by_velocities(body, derivative);
        }
        if let Some(landing) = self.landing() {
            derivative.after_by_restitution[0] = landing.by_restitution();
            derivative.after_by_friction[0] = landing.by_friction();
            derivative.after_by_tangential_restitution[0].fill(0.0);
            let by_tilt = self.states().next().and_then(|first| first.normal_by_tilt);
            if let Some(by_tilt) = by_tilt {
                derivative.after_by_tilt[0] =
                    landing.by_normal() * Change::<2>::from_columns(&by_tilt);
            }
            return Ok(());
        }
        let by_law = self
            .rows
            .velocity_changes_by_impulses(&self.impulses_by_law());
        for body in 0..self.rows.bodies {
            derivative.after_by_restitution[body] = by_law[body].column(0).into();
            derivative.after_by_friction[body] = by_law[body].column(1).into();
            derivative.after_by_tangential_restitution[body] = by_law[body].column(2).into();
        }
        self.after_by_tilt(derivative);
        Ok(())
    }

    /// Derivative of the speed along the untilted normal.
    fn speed_by_state(
        &self,
        state: &ContactState,
        body: usize,
        by: &PoseChange<6>,
    ) -> RowSVector<f64, 12> {
        let normal = &state.touch.normal;
        let by_pose = self.speed_change(state, by);
        let sign = [1.0, -1.0][body];
        let lever = state.levers(normal)[body] * sign;
        let mut row = RowSVector::<f64, 12>::zeros();
        row.fixed_columns_mut::<6>(part::POSITION)
            .copy_from(&by_pose);
        row.fixed_columns_mut::<3>(part::VELOCITY)
            .tr_copy_from(&(normal * sign));
        row.fixed_columns_mut::<3>(part::ANGULAR_VELOCITY)
            .tr_copy_from(&lever);
        row
    }

    /// Change of the speed along the untilted normal with the geometry.
    pub(super) fn speed_change<const C: usize>(
        &self,
        state: &ContactState,
        by: &PoseChange<C>,
    ) -> RowSVector<f64, C> {
        let normal = &state.touch.normal;
        let [a, b] = &self.before;
        let mut change = (a.velocity_m_s - b.velocity_m_s).tr_mul(&by.normal);
        for (side, motion) in self.before.iter().enumerate().take(self.rows.bodies) {
            let lever = state.lever_change(side, normal, Some(&by.normal), by);
            let sign = [1.0, -1.0][side];
            change += (motion.angular_velocity_rad_s * sign).tr_mul(&lever);
        }
        change
    }

    /// Changes of the velocities after with the geometry, given those of the tilted normals.
    pub(super) fn after_change<const C: usize>(
        &self,
        normals: &[Change<C>; MOST_CONTACTS],
        poses: &[Option<PoseChange<C>>; MOST_CONTACTS],
    ) -> [SMatrix<f64, 6, C>; 2] {
        let rows = self.rows_change(normals, poses);
        let impulses = self.impulses_change(normals, &rows);
        self.rows
            .velocity_changes_by(self.impulses(), Some(&impulses), &rows)
    }

    fn after_by_pose(
        &self,
        body: usize,
        normals: &[Change<6>; MOST_CONTACTS],
        poses: &[Option<PoseChange<6>>; MOST_CONTACTS],
        derivative: &mut ImpactDerivative,
    ) {
        let after = self.after_change(normals, poses);
        for i in 0..self.rows.bodies {
            derivative.after[i][body]
                .fixed_columns_mut::<6>(part::POSITION)
                .copy_from(&after[i]);
        }
    }

    fn after_by_velocities(&self, body: usize, derivative: &mut ImpactDerivative) {
        let impulses = self.impulses_by_speeds(self.rows.of_body(body));
        let mut after = self.rows.velocity_changes_by_impulses(&impulses);
        after[body] += SMatrix::<f64, 6, 6>::identity();
        for i in 0..self.rows.bodies {
            derivative.after[i][body]
                .fixed_columns_mut::<6>(part::VELOCITY)
                .copy_from(&after[i]);
        }
    }

    fn after_by_tilt(&self, derivative: &mut ImpactDerivative) {
        let mut poses = [const { None }; MOST_CONTACTS];
        let mut normals = [Change::<2>::zeros(); MOST_CONTACTS];
        for (contact, state) in self.states().enumerate() {
            let Some(by_tilt) = &state.normal_by_tilt else {
                for by_tilt in &mut derivative.after_by_tilt[..self.rows.bodies] {
                    by_tilt.fill(0.0);
                }
                return;
            };
            normals[contact] = Change::from_columns(by_tilt);
            poses[contact] = Some(PoseChange::none());
        }
        let after = self.after_change(&normals, &poses);
        derivative.after_by_tilt[..self.rows.bodies].copy_from_slice(&after[..self.rows.bodies]);
    }
}
