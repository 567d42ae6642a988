//! The impact of one link of a tree with the static world, by generalised impulses.
//!
//! With the Jacobian `J` of the contact point's velocity, `v = J u`, an impulse `P` on the link changes the rates
//! by `M⁻¹ Jᵀ P` and the contact's velocity by `W P` with `W = J M⁻¹ Jᵀ`. The law is that of bodies by themselves
//! ([`Law`]), with this `W`. Joints may hold the contact along some directions, a pin's tip along all but one: `W`
//! then is singular, and what the law says of `W⁻¹` is said of its pseudo-inverse.

pub(super) mod derivative;
mod point;

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::snapshot::Snapshot;
use super::state::TreeState;
use crate::physics::contact::{Contact, Frame, Touch};
use crate::physics::impact::{Coulomb, ImpactError, Law, tilted};

/// The result of an impact of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeImpact {
    /// Gap of the contact \[m\].
    pub gap_m: f64,
    /// Speed along the untilted normal before [m/s]: the rate of the gap, negative approaching.
    pub speed_m_s: f64,
    /// Impulse on the link [N s, world].
    pub impulse_n_s: Vector3<f64>,
    /// Its part along the tilted normal [N s]: negative where the contact recedes, which no contact can exert.
    pub normal_impulse_n_s: f64,
    /// Whether the contact sticks.
    pub sticks: bool,
    /// Rates after the impact.
    pub rates: Vec<f64>,
}

/// An impact solved for its impulse.
struct Solved {
    touch: Touch,
    law: Coulomb,
    /// Derivatives of the tilted normal by the tilts; none where the normal cannot be tilted.
    normal_by_tilt: Option<[Vector3<f64>; 2]>,
    /// Velocity of the contact point before [m/s, world].
    velocity_m_s: Vector3<f64>,
    impulse_n_s: Vector3<f64>,
    /// `M⁻¹ Jᵀ`.
    response: DMatrix<f64>,
}

impl Snapshot<'_> {
    /// The impact of a link with the static world where the tree is set to `state`; A of the contact is the link.
    ///
    /// Fails where the contact is degenerate or the joints hold it along the normal. A contact that recedes is
    /// treated by the same formulas without friction. Panics where the law tilts the normal of no face.
    pub fn impact(
        &self,
        state: &TreeState,
        (link, contact): (usize, &Contact),
        law: &Law,
    ) -> Result<TreeImpact, ImpactError> {
        Ok(self.solved(link, contact, law)?.impact(state))
    }

    fn solved(&self, link: usize, contact: &Contact, law: &Law) -> Result<Solved, ImpactError> {
        let frame = Frame::of(&self.link_state(link));
        let touch = contact
            .touch(&frame, &Frame::world())
            .map_err(|reason| ImpactError::Degenerate { contact: 0, reason })?;
        let (normal, normal_by_tilt) = match contact.tilt_axes() {
            Some(axes) => {
                let (normal, by_tilt) = tilted(&touch.normal, axes, law);
                (normal, Some(by_tilt))
            }
            None => {
                assert!(law.tilt_rad == [0.0; 2], "a tilt where no face is touched");
                (touch.normal, None)
            }
        };
        let (delassus, response) = self.response_at(link, &touch.on_a_m);
        let velocity_m_s = self.point_velocity(link, &touch.on_a_m);
        let law = Coulomb::of_joined(law, &normal, &velocity_m_s, &delassus)?;
        Ok(Solved {
            impulse_n_s: law.impulse(),
            touch,
            law,
            normal_by_tilt,
            velocity_m_s,
            response,
        })
    }

    /// `W = J M⁻¹ Jᵀ` of a link's point [m, link], and `M⁻¹ Jᵀ`.
    pub(super) fn response_at(
        &self,
        link: usize,
        point_m: &Vector3<f64>,
    ) -> (Matrix3<f64>, DMatrix<f64>) {
        let freedoms = self.tree.freedoms();
        let mut jacobian = DMatrix::zeros(3, freedoms);
        self.point_jacobian(link, point_m, &mut jacobian);
        let mut response = DMatrix::zeros(freedoms, 3);
        for axis in 0..3 {
            let mut column = response.column_mut(axis);
            let unit = Vector3::ith(axis, 1.0);
            self.impulse_response(link, point_m, &unit, column.as_mut_slice());
        }
        let product = jacobian * &response;
        let product: Matrix3<f64> = product.fixed_view::<3, 3>(0, 0).into_owned();
        ((product + product.transpose()) * 0.5, response)
    }
}

impl Solved {
    fn impact(&self, state: &TreeState) -> TreeImpact {
        let changes = &self.response * self.impulse_n_s;
        let rates = state.rates.iter().zip(changes.iter());
        TreeImpact {
            gap_m: self.touch.gap_m,
            speed_m_s: self.touch.normal.dot(&self.velocity_m_s),
            impulse_n_s: self.impulse_n_s,
            normal_impulse_n_s: self.law.normal().dot(&self.impulse_n_s),
            sticks: self.law.sticks(),
            rates: rates.map(|(rate, change)| rate + change).collect(),
        }
    }
}
