//! The impact of one link with the static world or with another link, of its tree or of another one, by
//! generalised impulses.
//!
//! With the Jacobians of both contact points' velocities in the rates `u` of all trees, `J = J_A − J_B`, the relative
//! velocity is `v = J u`; an impulse `P` on A, reversed on B, changes the rates by `M⁻¹ Jᵀ P` and that velocity by
//! `W P` with `W = J M⁻¹ Jᵀ`. Of the static world `J_B` is zero. The law is that of bodies by themselves
//! ([`Law`]), with this `W`. Joints may hold the contact along some directions, a pin's tip along all but one: `W`
//! then is singular, and what the law says of `W⁻¹` is said of its pseudo-inverse.

pub(super) mod derivative;
mod point;

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::forest::snapshot::ForestSnapshot;
use super::state::TreeState;
use crate::physics::contact::{Contact, Frame, Touch};
use crate::physics::impact::{Coulomb, ImpactError, Law, tilted};

/// What touches: A is a link, B another one or the static world.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkContact {
    /// A's place among the links of the forest.
    pub place: usize,
    /// B's place; none: the static world.
    pub other: Option<usize>,
    /// Their features.
    pub contact: Contact,
}

/// The result of an impact of trees.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeImpact {
    /// Gap of the contact \[m\].
    pub gap_m: f64,
    /// Speed along the untilted normal before [m/s]: the rate of the gap, negative approaching.
    pub speed_m_s: f64,
    /// Impulse on A [N s, world]; on B it is the opposite.
    pub impulse_n_s: Vector3<f64>,
    /// Its part along the tilted normal [N s]: negative where the contact recedes, which no contact can exert.
    pub normal_impulse_n_s: f64,
    /// Whether the contact sticks.
    pub sticks: bool,
    /// Rates of all trees after the impact.
    pub rates: Vec<f64>,
}

/// A link that takes part in an impact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Its place among the links of the forest.
    pub place: usize,
    /// One of A, minus one of B.
    pub sign: f64,
    /// Where it is touched [m, link].
    pub point_m: Vector3<f64>,
}

/// An impact solved for its impulse.
struct Solved {
    frames: [Frame; 2],
    touch: Touch,
    sides: Vec<Side>,
    law: Coulomb,
    /// Derivatives of the tilted normal by the tilts; none where the normal cannot be tilted.
    normal_by_tilt: Option<[Vector3<f64>; 2]>,
    /// Velocity of A's contact point against B's before [m/s, world].
    velocity_m_s: Vector3<f64>,
    impulse_n_s: Vector3<f64>,
    /// `J`,
    jacobian: DMatrix<f64>,
    /// and `M⁻¹ Jᵀ`.
    response: DMatrix<f64>,
}

impl ForestSnapshot<'_> {
    /// The impact of a link where the trees are set to `state`.
    ///
    /// Fails where the contact is degenerate or the joints hold it along the normal. A contact that recedes is
    /// treated by the same formulas without friction. Panics where the law tilts the normal of no face.
    pub fn impact(
        &self,
        state: &TreeState,
        contact: &LinkContact,
        law: &Law,
    ) -> Result<TreeImpact, ImpactError> {
        Ok(self.solved(contact, law)?.impact(state))
    }

    /// Kinetic energy of the trees that take part \[J\].
    pub fn kinetic_energy_at(&self, contact: &LinkContact) -> f64 {
        let (tree, _) = self.forest.tree_of(contact.place);
        let other = contact.other.map(|place| self.forest.tree_of(place).0);
        let other = other.filter(|other| *other != tree);
        let all = [tree].into_iter().chain(other);
        all.map(|tree| self.trees[tree].kinetic_energy()).sum()
    }

    fn solved(&self, of: &LinkContact, law: &Law) -> Result<Solved, ImpactError> {
        let frames = [
            Frame::of(&self.link_state(of.place)),
            match of.other {
                Some(other) => Frame::of(&self.link_state(other)),
                None => Frame::world(),
            },
        ];
        let touch = of
            .contact
            .touch(&frames[0], &frames[1])
            .map_err(|reason| ImpactError::Degenerate { contact: 0, reason })?;
        let (normal, normal_by_tilt) = match of.contact.tilt_axes() {
            Some(axes) => {
                let axes = axes.map(|axis| frames[1].orientation * axis);
                let (normal, by_tilt) = tilted(&touch.normal, &axes, law);
                (normal, Some(by_tilt))
            }
            None => {
                assert!(law.tilt_rad == [0.0; 2], "a tilt where no face is touched");
                (touch.normal, None)
            }
        };
        let of_a = (Some(of.place), 1.0, touch.on_a_m);
        let of_b = (of.other, -1.0, touch.on_b_m);
        let sides = [of_a, of_b].into_iter();
        let sides = sides.filter_map(|(place, sign, point_m)| {
            Some(Side {
                place: place?,
                sign,
                point_m,
            })
        });
        let sides: Vec<Side> = sides.collect();
        let (delassus, jacobian, response) = self.response(&sides);
        let velocities = sides.iter().map(|side| {
            let (tree, link) = self.forest.tree_of(side.place);
            self.trees[tree].point_velocity(link, &side.point_m) * side.sign
        });
        let velocity_m_s = velocities.sum();
        let law = Coulomb::of_joined(law, &normal, &velocity_m_s, &delassus)?;
        Ok(Solved {
            impulse_n_s: law.impulse(),
            frames,
            touch,
            sides,
            law,
            normal_by_tilt,
            velocity_m_s,
            jacobian,
            response,
        })
    }

    /// `W = J M⁻¹ Jᵀ` of the sides' points [1/kg], `J`, and `M⁻¹ Jᵀ`.
    pub(super) fn response(&self, sides: &[Side]) -> (Matrix3<f64>, DMatrix<f64>, DMatrix<f64>) {
        let freedoms = self.forest.freedoms();
        let mut jacobian = DMatrix::zeros(3, freedoms);
        let mut response = DMatrix::zeros(freedoms, 3);
        for side in sides {
            let (tree, link) = self.forest.tree_of(side.place);
            let rates = self.forest.rates_of(tree);
            let mut own = DMatrix::zeros(3, rates.len());
            self.trees[tree].point_jacobian(link, &side.point_m, &mut own);
            let mut columns = jacobian.columns_range_mut(rates.clone());
            columns += own * side.sign;
            let mut changes = vec![0.0; rates.len()];
            for axis in 0..3 {
                let unit = Vector3::ith(axis, side.sign);
                self.trees[tree].impulse_response(link, &side.point_m, &unit, &mut changes);
                for (rate, change) in rates.clone().zip(&changes) {
                    response[(rate, axis)] += change;
                }
            }
        }
        let product = &jacobian * &response;
        let product: Matrix3<f64> = product.fixed_view::<3, 3>(0, 0).into_owned();
        ((product + product.transpose()) * 0.5, jacobian, response)
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
