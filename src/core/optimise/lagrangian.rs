//! The augmented Lagrangian (Nocedal and Wright, *Numerical Optimization*, chapter 17).
//!
//! For rows `lower ≤ c ≤ upper` with weight `w` and multiplier `ν`,
//!
//! ```text
//! L = f + Σ ½ w d²,   d = c + ν/w − clamp(c + ν/w, lower, upper)
//! ν ← w d                                                          first-order update
//! ```
//!
//! Equalities, one-sided and two-sided rows follow this one rule. The usual form differs by
//! `½ Σ ν²/w`, which is constant in the unknowns.

use super::system::System;

/// Weight and multipliers.
#[derive(Clone, Debug)]
pub struct AugmentedLagrangian {
    /// Weight `w` of every row, per squared unit.
    pub weight: f64,
    /// Weight of the rows in [`Block::leads`](super::block::Block::leads).
    pub leading_weight: f64,
    /// Multipliers `ν`, row by row.
    pub multipliers: Vec<f64>,
}

/// Weights and shifted distances of the rows of a system.
#[derive(Clone, Debug, Default)]
pub struct Acting {
    /// `w` of an active row, zero of an inactive one.
    pub weights: Vec<f64>,
    /// `d` of every row, in units.
    pub distances: Vec<f64>,
}

impl AugmentedLagrangian {
    /// One weight for all rows, and multipliers zero.
    pub fn new(system: &System, weight: f64) -> Self {
        Self {
            weight,
            leading_weight: weight,
            multipliers: vec![0.0; system.row_count()],
        }
    }

    /// `w` and `d` of every row, and whether it is active.
    fn rows<'s>(&'s self, system: &'s System) -> impl Iterator<Item = (f64, f64, bool)> + 's {
        let rows = system.blocks.iter().flat_map(|block| {
            let rows = block.values.iter().zip(&block.bounds).enumerate();
            rows.map(|(row, (v, bounds))| (block.leads.contains(&row), *v, *bounds))
        });
        rows.zip(&self.multipliers)
            .map(|((leads, value, (lower, upper)), multiplier)| {
                let weight = if leads {
                    self.leading_weight
                } else {
                    self.weight
                };
                let shifted = value + multiplier / weight;
                let distance = shifted - shifted.clamp(lower, upper);
                let acts = lower == upper || distance < 0.0 || distance > 0.0;
                (weight, distance, acts)
            })
    }

    /// Value of the augmented Lagrangian.
    pub fn merit(&self, system: &System) -> f64 {
        system.cost
            + self
                .rows(system)
                .map(|(w, d, _)| 0.5 * w * d * d)
                .sum::<f64>()
    }

    /// `L − ½ Σ ν²/w`. Its minimum is a lower bound of the objective over all points that satisfy
    /// the constraints, since `d² ≤ (ν/w)²` there (weak duality).
    pub fn dual(&self, system: &System) -> f64 {
        let rows = self.rows(system).zip(&self.multipliers);
        let shift = |((weight, ..), multiplier): ((f64, f64, bool), &f64)| {
            0.5 * multiplier * multiplier / weight
        };
        self.merit(system) - rows.map(shift).sum::<f64>()
    }

    /// Weights and distances at `system`, into `acting`.
    pub fn act(&self, system: &System, acting: &mut Acting) {
        acting.weights.clear();
        acting.distances.clear();
        for (weight, distance, acts) in self.rows(system) {
            acting.weights.push(if acts { weight } else { 0.0 });
            acting.distances.push(distance);
        }
    }

    /// First-order update of the multipliers, `ν ← w d`.
    pub fn update(&mut self, system: &System) {
        self.multipliers = self
            .rows(system)
            .map(|(weight, distance, _)| weight * distance)
            .collect();
    }
}
