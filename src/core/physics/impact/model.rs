//! Derivatives of an impact by the model: by the inertia of the bodies and by where features are, on
//! the bodies and in the static world.

use nalgebra::{RowSVector, RowVector3, SMatrix, SVector};

use super::contact_state::{ContactState, PoseChange};
use super::error::ImpactError;
use super::law::MOST_CONTACTS;
use super::rows::Change;
use super::solution::ImpactSolution;
use crate::math::so3;
use crate::physics::contact::TouchDerivative;

/// Derivatives of an [`Impact`](super::Impact) by the model, all states fixed. Rows of velocities
/// are `v` [m/s, world], then `ω` [rad/s, body]. Entries for contacts and bodies that do not exist
/// are zero.
///
/// On switches of the law it is as [`ImpactDerivative`](super::ImpactDerivative). Gaps and speeds do
/// not depend on inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactByModel {
    /// Velocities `[i]` after by `ln` of the mass of body `[j]`, its moments fixed.
    pub after_by_mass: [[SVector<f64, 6>; 2]; 2],
    /// Velocities `[i]` after by `ln` of the moments of body `[j]`, its mass fixed; a column each
    /// about body axes 0, 1, 2.
    pub after_by_moments: [[SMatrix<f64, 6, 3>; 2]; 2],
    /// Gap `[contact]` by a shift of all touching features of body `[j]` [m, axes of `j`] relative to
    /// its centre of mass. A centre of mass that lies elsewhere in the body by `d` is a shift of its
    /// features by `−d`.
    pub gap_by_shift: [[RowVector3<f64>; 2]; MOST_CONTACTS],
    /// Speed along the untilted normal `[contact]` by that shift [1/s].
    pub speed_by_shift: [[RowVector3<f64>; 2]; MOST_CONTACTS],
    /// Velocities `[i]` after by the shift of the features of body `[j]`.
    pub after_by_shift: [[SMatrix<f64, 6, 3>; 2]; 2],
    /// Gap `[contact]` by a motion of the feature of the static world that this contact touches, the
    /// others at rest: by its displacement [m, world], then by its rotation [rad, world] about the
    /// feature's own point ([`Feature::place_m`](crate::physics::contact::Feature::place_m)). The law's
    /// tilt axes turn with a face. Zero between two bodies.
    ///
    /// Height and tilts of a surface are
    /// [`Contact::with_surface`](crate::physics::contact::Contact::with_surface)'s columns of such
    /// motions; of contacts with one surface the products are to be added.
    pub gap_by_place: [RowSVector<f64, 6>; MOST_CONTACTS],
    /// Speed along the untilted normal `[contact]` by the same motion.
    pub speed_by_place: [RowSVector<f64, 6>; MOST_CONTACTS],
    /// Velocities of A after by the motion of the feature of `[contact]`.
    pub after_by_place: [SMatrix<f64, 6, 6>; MOST_CONTACTS],
}

impl ImpactByModel {
    fn zeros() -> Self {
        Self {
            after_by_mass: [[SVector::zeros(); 2]; 2],
            after_by_moments: [[SMatrix::zeros(); 2]; 2],
            gap_by_shift: [[RowVector3::zeros(); 2]; MOST_CONTACTS],
            speed_by_shift: [[RowVector3::zeros(); 2]; MOST_CONTACTS],
            after_by_shift: [[SMatrix::zeros(); 2]; 2],
            gap_by_place: [RowSVector::zeros(); MOST_CONTACTS],
            speed_by_place: [RowSVector::zeros(); MOST_CONTACTS],
            after_by_place: [SMatrix::zeros(); MOST_CONTACTS],
        }
    }
}

impl ImpactSolution<'_> {
    pub(super) fn by_model(&self) -> Result<ImpactByModel, ImpactError> {
        let mut rates = Vec::with_capacity(MOST_CONTACTS);
        for (contact, state) in self.states().enumerate() {
            let touch = state
                .contact
                .touch_derivative(&self.frames[0], &self.frames[1])
                .map_err(|reason| ImpactError::Degenerate { contact, reason })?;
            rates.push(touch.1);
        }
        let mut by_model = ImpactByModel::zeros();
        for body in 0..self.rows.bodies {
            self.by_inertia(body, &mut by_model);
            self.by_shift(body, &rates, &mut by_model);
        }
        if self.rows.bodies == 1 {
            for contact in 0..rates.len() {
                self.by_place(contact, &rates, &mut by_model);
            }
        }
        Ok(by_model)
    }

    fn by_inertia(&self, body: usize, by_model: &mut ImpactByModel) {
        if let Some(landing) = self.landing() {
            by_model.after_by_mass[0][0] = landing.by_mass();
            by_model.after_by_moments[0][0] = landing.by_moments();
            return;
        }
        let impulses = self.impulses_by_inertia(body);
        let mut after = self.rows.velocity_changes_by_impulses(&impulses);
        after[body] += self.rows.velocity_changes_by_inertia(body, self.impulses());
        for (i, after) in after.iter().enumerate().take(self.rows.bodies) {
            by_model.after_by_mass[i][body] = after.column(0).into();
            by_model.after_by_moments[i][body] = after.fixed_columns::<3>(1).into();
        }
    }

    fn by_shift(&self, body: usize, rates: &[TouchDerivative], by_model: &mut ImpactByModel) {
        let rotation = so3::matrix(&self.frames[body].orientation);
        let mut poses = [const { None }; MOST_CONTACTS];
        let mut normals = [Change::zeros(); MOST_CONTACTS];
        for (contact, (state, rates)) in self.states().zip(rates).enumerate() {
            let by = PoseChange::of_shift(body, rates, &rotation);
            by_model.gap_by_shift[contact][body] =
                rates.gap.fixed_columns::<3>(6 * body) * rotation;
            by_model.speed_by_shift[contact][body] = self.speed_change(state, &by);
            normals[contact] = state.normal_change(&by);
            poses[contact] = Some(by);
        }
        let after = self.after_change(&normals, &poses);
        for (i, after) in after.iter().enumerate().take(self.rows.bodies) {
            by_model.after_by_shift[i][body] = *after;
        }
    }

    /// By the place of the world's feature that one contact touches: as if the world were a body
    /// that moves, for this contact only.
    fn by_place(&self, moved: usize, rates: &[TouchDerivative], by_model: &mut ImpactByModel) {
        let mut poses = [const { None }; MOST_CONTACTS];
        let mut normals = [Change::zeros(); MOST_CONTACTS];
        let mut pose = SMatrix::zeros();
        for (contact, (state, rates)) in self.states().zip(rates).enumerate() {
            if contact != moved {
                poses[contact] = Some(PoseChange::none());
                continue;
            }
            let by = PoseChange::of_body(1, rates);
            pose = pose_by_motion(state);
            by_model.gap_by_place[contact] = rates.gap.fixed_columns::<6>(6) * pose;
            by_model.speed_by_place[contact] = self.speed_change(state, &by) * pose;
            normals[contact] = state.normal_change(&by);
            poses[contact] = Some(by);
        }
        let after = match self.landing() {
            // All contacts are on one face, whose motion the first stands for.
            Some(landing) if moved == 0 => landing.by_normal() * normals[0],
            Some(_) => SMatrix::zeros(),
            None => self.after_change(&normals, &poses)[0],
        };
        by_model.after_by_place[moved] = after * pose;
    }
}

/// Displacement of the world's origin and rotation about it, of a displacement of a feature and a
/// rotation `ψ` about its own point `p`, which displaces the origin by `p × ψ`.
fn pose_by_motion(state: &ContactState) -> SMatrix<f64, 6, 6> {
    let mut result = SMatrix::<f64, 6, 6>::identity();
    result
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&so3::hat(&state.contact.b().place_m()));
    result
}
