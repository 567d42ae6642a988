//! Indices of a collision's rows and columns.

use super::kind::Filled;
use crate::estimate::problem::{ArcCollision, Problem};
use crate::physics::contact::Feature;
use crate::physics::state::{self, part};

/// Unknowns of the state of a free body: these are the rows of free bodies' collisions.
pub(super) const STATE: usize = state::DIMENSION;

/// Number of rows of a body's pose, and of its velocities.
pub(super) const HALF: usize = STATE / 2;

/// Indices of a collision's rows and columns.
pub(super) struct Places {
    pub(super) contacts: usize,
    pub(super) approaches: usize,
    /// Number of hard rows of every body.
    pub(super) rows_per_side: usize,
    pub(super) sides: usize,
    /// Number of states before it: of the bodies that it deflects, and of a held one.
    pub(super) states: usize,
    /// The first part of the states before on which the velocities after depend: the bounce of one
    /// body off a face does not depend on its position.
    pub(super) first_part: usize,
}

impl Places {
    pub(super) fn new(problem: &Problem, collision: &ArcCollision) -> Self {
        let sides = collision.sides.len();
        let contacts = collision.contacts.as_slice();
        let is_face = |feature: &Feature| matches!(feature, Feature::Face { .. });
        let states = sides + usize::from(collision.held.is_some());
        let is_alike = states == 1 && contacts.iter().all(|contact| is_face(contact.b()));
        Self {
            contacts: if collision.touches_by_goal {
                0
            } else {
                contacts.len()
            },
            approaches: contacts.len(),
            rows_per_side: if problem.velocity_gap_weight.is_some() {
                HALF
            } else {
                STATE
            },
            sides,
            states,
            first_part: if is_alike {
                part::ORIENTATION
            } else {
                part::POSITION
            },
        }
    }

    /// First row of a side.
    pub(super) fn of_side(&self, side: usize) -> usize {
        self.contacts + self.approaches + side * self.rows_per_side
    }
}

/// The two blocks of a collision while they are being filled.
pub(super) struct CollisionRows<'a> {
    pub(super) problem: &'a Problem,
    pub(super) collision: &'a ArcCollision,
    pub(super) places: Places,
    pub(super) block: Filled<'a>,
    pub(super) gaps: Filled<'a>,
}

/// One of a body's two velocities; the value is its first row among both.
#[derive(Clone, Copy)]
pub(super) enum Half {
    Velocity = 0,
    Spin = 3,
}
