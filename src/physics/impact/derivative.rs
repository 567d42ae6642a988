//! Derivatives of an impact.

use nalgebra::{RowSVector, SMatrix, SVector};

use super::assembly::{Assembly, Variation};
use super::meeting::{Impact, MOST_CONTACTS, Velocities};
use crate::physics::state::part;

/// Derivatives of an [`Impact`]. Columns of a state are those of
/// [`StateTangent`](crate::physics::state::StateTangent); rows of velocities are `v` [m/s,
/// world], then `ω` [rad/s, body]. Entries beyond the number of contacts or bodies are zero.
///
/// Exact on each side of the switches between sticking and sliding and between approaching and
/// receding; on a switch, that of the reported branch.
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
    /// Velocities after by the two tilts; zero where [`Meeting::check_tilt`] refuses them.
    ///
    /// [`Meeting::check_tilt`]: super::Meeting::check_tilt
    pub after_by_tilt: [SMatrix<f64, 6, 2>; 2],
}

impl ImpactDerivative {
    pub(super) fn zeros() -> Self {
        Self {
            gap: [[RowSVector::zeros(); 2]; MOST_CONTACTS],
            speed: [[RowSVector::zeros(); 2]; MOST_CONTACTS],
            after: [[SMatrix::zeros(); 2]; 2],
            after_by_restitution: [SVector::zeros(); 2],
            after_by_friction: [SVector::zeros(); 2],
            after_by_tilt: [SMatrix::zeros(); 2],
        }
    }
}

fn stacked(v: &Velocities) -> SVector<f64, 6> {
    let mut result = SVector::<f64, 6>::zeros();
    result.fixed_rows_mut::<3>(0).copy_from(&v.velocity_m_s);
    result
        .fixed_rows_mut::<3>(3)
        .copy_from(&v.angular_velocity_rad_s);
    result
}

impl Assembly {
    /// The impact and its derivatives; the assembly must have been made with rates.
    pub(super) fn derivative(&self) -> (Impact, ImpactDerivative) {
        let mut derivative = ImpactDerivative::zeros();
        for body in 0..self.bodies {
            for column in 0..6 {
                self.pose_column(body, column, &mut derivative);
                self.velocity_column(body, column, &mut derivative);
            }
        }
        let by_restitution = self.kicks(&self.by_restitution());
        let by_friction = self.kicks(&self.by_friction());
        for body in 0..self.bodies {
            derivative.after_by_restitution[body] = stacked(&by_restitution[body]);
            derivative.after_by_friction[body] = stacked(&by_friction[body]);
        }
        if self.encounters().iter().all(|e| e.is_on_face) {
            for tilt in 0..2 {
                let after = self.after_change(&self.tilt_variation(tilt));
                for body in 0..self.bodies {
                    derivative.after_by_tilt[body].set_column(tilt, &stacked(&after[body]));
                }
            }
        }
        (self.impact(), derivative)
    }

    /// Columns 0 to 5 of a state are its pose's.
    fn pose_column(&self, body: usize, column: usize, derivative: &mut ImpactDerivative) {
        let mut variations = [Variation::none(); MOST_CONTACTS];
        for (contact, encounter) in self.encounters().iter().enumerate() {
            let rates = encounter.rates();
            let column_of_touch = 6 * body + column;
            let mut by = Variation::none();
            by.arms[0].point = rates.on_a.column(column_of_touch).into();
            by.arms[1].point = rates.on_b.column(column_of_touch).into();
            by.normal = rates.normal.column(column_of_touch).into();
            if column >= part::ORIENTATION {
                let axis = column - part::ORIENTATION;
                by.arms[body].turn = encounter.arms[body].rotation.column(axis).into();
            }
            derivative.gap[contact][body][column] = rates.gap[column_of_touch];
            derivative.speed[contact][body][column] =
                by.normal.dot(&encounter.relative(&self.before))
                    + encounter
                        .touch
                        .normal
                        .dot(&encounter.relative_change(&self.before, &by));
            if encounter.is_on_face {
                // A tilted normal turns with the face as the untilted one does.
                by.normal = by.arms[1].turn.cross(&encounter.normal);
            }
            variations[contact] = by;
        }
        for (i, after) in self.after_change(&variations).iter().enumerate() {
            if i < self.bodies {
                derivative.after[i][body].set_column(column, &stacked(after));
            }
        }
    }

    /// Columns 6 to 11 of a state are its velocities'.
    fn velocity_column(&self, body: usize, column: usize, derivative: &mut ImpactDerivative) {
        let mut change = [Velocities::default(); 2];
        let axis = column % 3;
        if column < 3 {
            change[body].velocity_m_s[axis] = 1.0;
        } else {
            change[body].angular_velocity_rad_s[axis] = 1.0;
        }
        let of_state = part::VELOCITY + column;
        for (contact, encounter) in self.encounters().iter().enumerate() {
            derivative.speed[contact][body][of_state] =
                encounter.touch.normal.dot(&encounter.relative(&change));
        }
        let kicks = self.kicks(&self.impulses_by_velocities(&change));
        for i in 0..self.bodies {
            let mut after = change[i];
            after.add_scaled(&kicks[i], 1.0);
            derivative.after[i][body].set_column(of_state, &stacked(&after));
        }
    }

    fn tilt_variation(&self, tilt: usize) -> [Variation; MOST_CONTACTS] {
        let mut variations = [Variation::none(); MOST_CONTACTS];
        for (variation, encounter) in variations.iter_mut().zip(self.encounters()) {
            variation.normal = encounter.normal_by_tilt[tilt];
        }
        variations
    }
}
