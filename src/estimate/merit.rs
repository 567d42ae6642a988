//! The augmented Lagrangian: objective, multipliers and a quadratic penalty on constraints.
//!
//! For rows `lower ≤ v ≤ upper` with weight `w` and multiplier `ν` it adds
//! `½ w dist²(v + ν/w, [lower, upper])`: equalities, one-sided and two-sided rows follow one
//! rule, and the next multiplier is `w` times the signed distance.
//!
//! Rows are numbered through all blocks; vectors over them are flat.

use nalgebra::DVector;

use super::layout::Layout;
use super::system::System;
use crate::math::envelope::Envelope;

/// Weight and multipliers.
#[derive(Clone, Debug)]
pub struct AugmentedLagrangian {
    /// Weight `w` of every row, per squared unit.
    pub weight: f64,
    /// Weight of approach rows; another one while they lead the way.
    pub approach_weight: f64,
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
    /// Signed distance of `v` from the bound that acts.
    pub violations: Vec<f64>,
}

impl AugmentedLagrangian {
    /// A weight and no multipliers yet.
    pub fn new(system: &System, weight: f64) -> Self {
        Self {
            weight,
            approach_weight: weight,
            multipliers: vec![0.0; system.row_count()],
        }
    }

    /// Weight, shifted distance and distance from the acting bound of every row.
    fn rows<'s>(
        &'s self,
        system: &'s System,
    ) -> impl Iterator<Item = (f64, f64, Option<f64>)> + 's {
        let rows = system.blocks.iter().flat_map(|block| {
            let rows = block.values.iter().zip(&block.bounds).enumerate();
            rows.map(|(row, (v, bounds))| (block.approach.contains(&row), *v, *bounds))
        });
        rows.zip(&self.multipliers)
            .map(|((is_approach, value, (lower, upper)), multiplier)| {
                let weight = if is_approach {
                    self.approach_weight
                } else {
                    self.weight
                };
                let shifted = value + multiplier / weight;
                let distance = shifted - shifted.clamp(lower, upper);
                let bound = if lower == upper || distance < 0.0 {
                    Some(lower)
                } else {
                    (distance > 0.0).then_some(upper)
                };
                (weight, distance, bound.map(|bound| value - bound))
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
        let shift = |((weight, ..), multiplier): ((f64, f64, Option<f64>), &f64)| {
            0.5 * multiplier * multiplier / weight
        };
        self.merit(system) - rows.map(shift).sum::<f64>()
    }

    /// What the rows contribute, into `acting`.
    pub fn act(&self, system: &System, acting: &mut Acting) {
        acting.weights.clear();
        acting.distances.clear();
        acting.violations.clear();
        for (weight, distance, violation) in self.rows(system) {
            acting
                .weights
                .push(if violation.is_some() { weight } else { 0.0 });
            acting.distances.push(distance);
            acting.violations.push(violation.unwrap_or(0.0));
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

/// Adds `Jᵀ diag(w) J` to a matrix.
pub fn add_square(layout: &Layout, system: &System, weights: &[f64], matrix: &mut Envelope) {
    let mut offset = 0;
    for (block, pattern) in system.blocks.iter().zip(&layout.blocks) {
        let weight = |row: usize| weights[offset + row];
        block.add_square(pattern, weight, (&layout.pattern, matrix));
        offset += block.values.len();
    }
}

/// Adds `Jᵀ p` for a pull `p` on every row.
pub fn add_pull(
    layout: &Layout,
    system: &System,
    pull: impl Fn(usize) -> f64,
    gradient: &mut DVector<f64>,
) {
    let mut offset = 0;
    for (block, pattern) in system.blocks.iter().zip(&layout.blocks) {
        block.add_pull(pattern, |row| pull(offset + row), gradient);
        offset += block.values.len();
    }
}

/// What the curvature of rows adds to the diagonal under a pull on every row: unknown and value.
pub fn curvature(
    layout: &Layout,
    system: &System,
    pull: impl Fn(usize) -> f64,
) -> Vec<(usize, f64)> {
    let mut diagonal = Vec::new();
    let mut offset = 0;
    for (block, pattern) in system.blocks.iter().zip(&layout.blocks) {
        if block.curvature > 0.0 {
            // A pull inwards would make the matrix indefinite; it is on its way out.
            let value = block.curvature * pull(offset).max(0.0);
            if value > 0.0 {
                diagonal.extend(pattern.unknowns(0).iter().map(|at| (*at, value)));
            }
        }
        offset += block.values.len();
    }
    diagonal
}

/// `J δ`, row by row, into `change`.
pub fn along(layout: &Layout, system: &System, delta: &DVector<f64>, change: &mut Vec<f64>) {
    change.clear();
    change.resize(system.row_count(), 0.0);
    let mut offset = 0;
    for (block, pattern) in system.blocks.iter().zip(&layout.blocks) {
        let rows = block.values.len();
        block.along(pattern, delta, &mut change[offset..offset + rows]);
        offset += rows;
    }
}

/// Adds what curved rows change by beyond `J δ`, exactly, to `change`.
pub fn add_curved(layout: &Layout, system: &System, delta: &DVector<f64>, change: &mut [f64]) {
    let mut row = 0;
    for (block, pattern) in system.blocks.iter().zip(&layout.blocks) {
        if block.curvature > 0.0 {
            let curved = pattern.unknowns(0).iter();
            let square: f64 = curved.map(|at| delta[*at] * delta[*at]).sum();
            change[row] += 0.5 * block.curvature * square;
        }
        row += block.values.len();
    }
}

/// What to add to `delta`, given that it led to `trial`, so that the constraints' departure from
/// their linearisation at `system` is removed: `factor` holds `H + Jᵀ diag(w) J`.
pub fn correction(
    layout: &Layout,
    (system, trial): (&System, &System),
    delta: &DVector<f64>,
    weights: &[f64],
    factor: &Envelope,
) -> DVector<f64> {
    let mut departure = Vec::new();
    along(layout, system, delta, &mut departure);
    let rows = system.values().zip(trial.values());
    for (entry, (before, after)) in departure.iter_mut().zip(rows) {
        *entry = after - before - *entry;
    }
    let mut correction = DVector::zeros(delta.len());
    let pull = |row: usize| -weights[row] * departure[row];
    add_pull(layout, system, pull, &mut correction);
    factor.solve(&layout.pattern, &mut correction);
    correction
}
