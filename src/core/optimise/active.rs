//! The active set of a step: equalities always, inequalities that the step would violate.
//!
//! Multipliers follow the sign of `∇f + Jᵀ ν = 0`: positive at an upper bound, negative at a lower
//! one. This is the primal–dual active-set rule: [`ActiveSet::revise`] until nothing changes.

use nalgebra::DVector;

use super::system::{Structure, System};

/// Weight of active rows in the factorised matrix, per squared unit and
/// [`information`](super::Program::information).
const WEIGHT: f64 = 1e9;
/// Weight `w` in the first guess of the active set, per squared unit and information.
const FIRST_WEIGHT: f64 = 1e3;
/// Greatest violation of an inactive bound after a step, in units.
const BROKEN: f64 = 1e-12;

/// Which bound of a row is active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Acts {
    Always,
    Lower,
    Upper,
    Not,
}

/// Which bound of every row is active.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveSet {
    rows: Vec<Acts>,
}

impl ActiveSet {
    /// First guess from the multipliers: a bound is active where `c + ν/w` lies beyond it, with `w`
    /// in proportion to the program's `information`.
    pub fn of(system: &System, multipliers: &[f64], information: f64) -> Self {
        let weight = FIRST_WEIGHT * information;
        let rows = system.bounded().zip(multipliers);
        let rows = rows.map(|((value, (lower, upper)), multiplier)| {
            let shifted = value + multiplier / weight;
            match () {
                () if lower == upper => Acts::Always,
                () if shifted < lower => Acts::Lower,
                () if shifted > upper => Acts::Upper,
                () => Acts::Not,
            }
        });
        Self {
            rows: rows.collect(),
        }
    }

    /// Weight of every row and its signed distance from its active bound in units; both are zero
    /// where no bound is active.
    pub fn weights_and_violations(
        &self,
        system: &System,
        information: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let weight = WEIGHT * information;
        let rows = system.bounded().zip(&self.rows);
        rows.map(|((value, (lower, upper)), acts)| match acts {
            Acts::Always | Acts::Lower => (weight, value - lower),
            Acts::Upper => (weight, value - upper),
            Acts::Not => (0.0, 0.0),
        })
        .unzip()
    }

    /// Adds the bounds that the step `delta` would violate and drops those whose `multipliers`
    /// after it have the wrong sign. Returns whether anything changed.
    pub fn revise(
        &mut self,
        structure: &Structure,
        system: &System,
        delta: &DVector<f64>,
        multipliers: &[f64],
    ) -> bool {
        if self.rows.iter().all(|acts| *acts == Acts::Always) {
            return false;
        }
        let mut change = Vec::new();
        system.along(structure, delta, &mut change);
        system.add_curved(structure, delta, &mut change);
        let mut changed = false;
        for (row, (value, (lower, upper))) in system.bounded().enumerate() {
            let after = value + change[row];
            let pull = multipliers[row];
            let next = match self.rows[row] {
                Acts::Not if after < lower - BROKEN => Acts::Lower,
                Acts::Not if after > upper + BROKEN => Acts::Upper,
                Acts::Lower if pull > 0.0 => Acts::Not,
                Acts::Upper if pull < 0.0 => Acts::Not,
                same => same,
            };
            changed |= next != self.rows[row];
            self.rows[row] = next;
        }
        changed
    }
}
