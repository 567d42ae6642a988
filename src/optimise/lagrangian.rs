//! The augmented Lagrangian: objective, multipliers and a quadratic penalty on constraints.
//!
//! For rows `lower ≤ v ≤ upper` with weight `w` and multiplier `ν` it adds
//! `½ w dist²(v + ν/w, [lower, upper])`: equalities, one-sided and two-sided rows follow one
//! rule, and the next multiplier is `w` times the signed distance.

use super::system::System;

/// Weight and multipliers.
#[derive(Clone, Debug)]
pub struct AugmentedLagrangian {
    /// Weight `w` of every row, per squared unit.
    pub weight: f64,
    /// Weight of rows that lead the way ([`Block::leads`](super::block::Block::leads)).
    pub leading_weight: f64,
    /// Multipliers `ν`, row by row.
    pub multipliers: Vec<f64>,
}

/// What the rows of a system contribute.
#[derive(Clone, Debug, Default)]
pub struct Acting {
    /// `w` of a row that acts, zero of one that does not.
    pub weights: Vec<f64>,
    /// Signed distance of `v + ν/w` from the bounds.
    pub distances: Vec<f64>,
}

impl AugmentedLagrangian {
    /// A weight and no multipliers yet.
    pub fn new(system: &System, weight: f64) -> Self {
        Self {
            weight,
            leading_weight: weight,
            multipliers: vec![0.0; system.row_count()],
        }
    }

    /// Weight and shifted distance of every row, and whether a bound acts on it.
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

    /// The augmented Lagrangian less `½ Σ ν²/w`: at its least it is at most the objective at any
    /// point where the constraints hold.
    pub fn dual(&self, system: &System) -> f64 {
        let rows = self.rows(system).zip(&self.multipliers);
        let shift = |((weight, ..), multiplier): ((f64, f64, bool), &f64)| {
            0.5 * multiplier * multiplier / weight
        };
        self.merit(system) - rows.map(shift).sum::<f64>()
    }

    /// What the rows contribute, into `acting`.
    pub fn act(&self, system: &System, acting: &mut Acting) {
        acting.weights.clear();
        acting.distances.clear();
        for (weight, distance, acts) in self.rows(system) {
            acting.weights.push(if acts { weight } else { 0.0 });
            acting.distances.push(distance);
        }
    }

    /// First-order update of the multipliers.
    pub fn update(&mut self, system: &System) {
        self.multipliers = self
            .rows(system)
            .map(|(weight, distance, _)| weight * distance)
            .collect();
    }
}
