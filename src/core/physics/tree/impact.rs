//! The impact of one link with the static world or with another link, of its tree or of another one, by
//! generalised impulses.
//!
//! With the Jacobians of both contact points' velocities in the rates `u` of all trees, `J = J_A − J_B`, the relative
//! velocity is `v = J u`; an impulse `P` on A, reversed on B, changes the rates by `M⁻¹ Jᵀ P` and that velocity by
//! `W P` with `W = J M⁻¹ Jᵀ`. Of the static world `J_B` is zero. The law is that of bodies by themselves
//! ([`Law`]), with this `W`, at one contact or at several at once. Joints may hold the one contact along some
//! directions, a pin's tip along all but one: `W` then is singular, and what the law says of `W⁻¹` is said of its
//! pseudo-inverse.

pub(super) mod derivative;
mod met;
mod point;
mod rule;

use nalgebra::{DMatrix, DVector, Vector3};

pub(super) use self::met::Side;
use self::met::{Met, thirds};
use self::rule::Rule;
use super::forest::snapshot::ForestSnapshot;
use super::state::TreeState;
use crate::physics::contact::{Contact, Frame, Touch};
use crate::physics::impact::{ContactSet, ImpactError, Knock, Law, tilted};

/// What touches: A is a link, B another one or the static world.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkContact {
    /// A's place among the links of the forest.
    pub place: usize,
    /// B's place; none: the static world.
    pub other: Option<usize>,
    /// Their features; of several pairs, which touch at once, without friction.
    pub contacts: ContactSet,
}

impl LinkContact {
    /// Places of the links that touch.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        [self.place].into_iter().chain(self.other)
    }
}

/// The result of an impact of trees: of each contact, and the rates after.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeImpact {
    /// Gaps \[m\].
    pub gaps_m: Vec<f64>,
    /// Speeds along the untilted normals before [m/s]: rates of the gaps, negative approaching.
    pub speeds_m_s: Vec<f64>,
    /// Impulses on A [N s, world]; on B they are the opposite.
    pub impulses_n_s: Vec<Vector3<f64>>,
    /// Their parts along the tilted normals [N s]: negative where a contact recedes, or others of several lift it
    /// off, which no contact can exert.
    pub normal_impulses_n_s: Vec<f64>,
    /// Whether the one contact sticks.
    pub sticks: bool,
    /// Rates of all trees after the impact.
    pub rates: Vec<f64>,
}

/// An impact solved for its impulses. Rows of all contacts are one below the other, three of each along the world's
/// axes.
struct SolvedImpulses {
    frames: [Frame; 2],
    met: Vec<Met>,
    rule: Rule,
    /// On A [N s].
    impulses_n_s: DVector<f64>,
    /// `J`,
    jacobian: DMatrix<f64>,
    /// `M⁻¹ Jᵀ`,
    response: DMatrix<f64>,
    /// and `W`.
    delassus: DMatrix<f64>,
}

impl ForestSnapshot<'_> {
    /// The impact of a link where the trees are set to `state`.
    ///
    /// Fails where a contact is degenerate, the joints hold it along the normal, or several depend on each other. A
    /// contact that recedes is treated by the same formulas without friction. Panics where the law tilts the normal
    /// of no face, or has friction at several contacts.
    pub fn impact(
        &self,
        state: &TreeState,
        contact: &LinkContact,
        law: &Law,
    ) -> Result<TreeImpact, ImpactError> {
        Ok(self.solved(contact, law)?.impact(state))
    }

    /// What happens at each contact of an impact where the trees are set to the state before it.
    ///
    /// Fails and panics as [`ForestSnapshot::impact`] does.
    pub fn knocks(&self, contact: &LinkContact, law: &Law) -> Result<Vec<Knock>, ImpactError> {
        Ok(self.solved(contact, law)?.knocks())
    }

    /// Kinetic energy of the trees that take part \[J\].
    pub fn kinetic_energy_at(&self, contact: &LinkContact) -> f64 {
        let (tree, _) = self.forest.tree_of(contact.place);
        let other = contact.other.map(|place| self.forest.tree_of(place).0);
        let other = other.filter(|other| *other != tree);
        let all = [tree].into_iter().chain(other);
        all.map(|tree| self.trees[tree].kinetic_energy()).sum()
    }

    fn solved(&self, of: &LinkContact, law: &Law) -> Result<SolvedImpulses, ImpactError> {
        let frames = [
            Frame::of(&self.link_state(of.place)),
            match of.other {
                Some(other) => Frame::of(&self.link_state(other)),
                None => Frame::world(),
            },
        ];
        let pairs = of.contacts.as_slice().iter().enumerate();
        let met = pairs.map(|(contact, pair)| {
            let touch = pair.touch(&frames[0], &frames[1]);
            let touch = touch.map_err(|reason| ImpactError::Degenerate { contact, reason })?;
            Ok(self.met(of, pair, touch, &frames[1], law))
        });
        let met: Vec<Met> = met.collect::<Result<_, ImpactError>>()?;
        let sides: Vec<&[Side]> = met.iter().map(|met| met.sides.as_slice()).collect();
        let (jacobian, response) = self.response(&sides);
        let delassus = &jacobian * &response;
        let rule = Rule::new(law, &met, &delassus)?;
        Ok(SolvedImpulses {
            impulses_n_s: rule.impulses(&met),
            frames,
            met,
            rule,
            jacobian,
            response,
            delassus,
        })
    }

    fn met(
        &self,
        of: &LinkContact,
        pair: &Contact,
        touch: Touch,
        frame_of_b: &Frame,
        law: &Law,
    ) -> Met {
        let (normal, normal_by_tilt) = match pair.tilt_axes() {
            Some(axes) => {
                let axes = axes.map(|axis| frame_of_b.orientation * axis);
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
        let velocities = sides.iter().map(|side| {
            let (tree, link) = self.forest.tree_of(side.place);
            self.trees[tree].point_velocity(link, &side.point_m) * side.sign
        });
        Met {
            velocity_m_s: velocities.sum(),
            touch,
            sides,
            normal,
            normal_by_tilt,
        }
    }

    /// `J` of the sides of all contacts, and `M⁻¹ Jᵀ`.
    pub(super) fn response(&self, contacts: &[&[Side]]) -> (DMatrix<f64>, DMatrix<f64>) {
        let freedoms = self.forest.freedoms();
        let mut jacobian = DMatrix::zeros(3 * contacts.len(), freedoms);
        let mut response = DMatrix::zeros(freedoms, 3 * contacts.len());
        let all = contacts.iter().enumerate();
        for (contact, side) in all.flat_map(|(at, sides)| sides.iter().map(move |of| (at, of))) {
            let (tree, link) = self.forest.tree_of(side.place);
            let rates = self.forest.rates_of(tree);
            let mut own = DMatrix::zeros(3, rates.len());
            self.trees[tree].point_jacobian(link, &side.point_m, &mut own);
            let mut block = jacobian.view_mut((3 * contact, rates.start), (3, rates.len()));
            block += own * side.sign;
            let mut changes = vec![0.0; rates.len()];
            for axis in 0..3 {
                let unit = Vector3::ith(axis, side.sign);
                self.trees[tree].impulse_response(link, &side.point_m, &unit, &mut changes);
                for (rate, change) in rates.clone().zip(&changes) {
                    response[(rate, 3 * contact + axis)] += change;
                }
            }
        }
        (jacobian, response)
    }
}

impl SolvedImpulses {
    fn knocks(&self) -> Vec<Knock> {
        let gained_m_s = thirds(&(&self.delassus * &self.impulses_n_s));
        let impulses_n_s = thirds(&self.impulses_n_s);
        let knocks = self.met.iter().enumerate().map(|(at, met)| {
            let arm_m = self.frames[0].orientation * met.touch.on_a_m;
            Knock {
                point_m: self.frames[0].position_m + arm_m,
                normal: met.normal,
                velocities_m_s: [met.velocity_m_s, met.velocity_m_s + gained_m_s[at]],
                impulse_n_s: impulses_n_s[at],
                moment_n_m_s: Vector3::zeros(),
            }
        });
        knocks.collect()
    }

    fn impact(&self, state: &TreeState) -> TreeImpact {
        let changes = &self.response * &self.impulses_n_s;
        let rates = state.rates.iter().zip(changes.iter());
        let impulses_n_s = thirds(&self.impulses_n_s);
        let normal = |(met, impulse): (&Met, &Vector3<f64>)| met.normal.dot(impulse);
        TreeImpact {
            gaps_m: self.met.iter().map(|met| met.touch.gap_m).collect(),
            speeds_m_s: self.met.iter().map(Met::speed_m_s).collect(),
            normal_impulses_n_s: self.met.iter().zip(&impulses_n_s).map(normal).collect(),
            impulses_n_s,
            sticks: self.rule.sticks(),
            rates: rates.map(|(rate, change)| rate + change).collect(),
        }
    }
}
