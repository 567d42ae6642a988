//! The augmented Lagrangian: objective, multipliers and a quadratic price on constraints.
//!
//! For rows `lower ≤ v ≤ upper` with weight `w` and multiplier `ν` it adds
//! `½ w dist²(v + ν/w, [lower, upper])`: equalities, one-sided and two-sided rows follow one
//! rule, and the next multiplier is `w` times the signed distance.

use nalgebra::DVector;

use super::constraint::{APPROACH_ROW, Block};
use super::layout::Layout;
use super::system::{Frame, System};
use crate::math::envelope::Envelope;

/// Weight and multipliers.
#[derive(Clone, Debug)]
pub struct Price {
    /// Weight `w` of every row, per squared unit.
    pub weight: f64,
    /// Weight of approach rows; another one while they lead the way.
    pub approach_weight: f64,
    /// Multipliers, block by block.
    pub multipliers: Vec<Vec<f64>>,
}

impl Price {
    /// A weight and no multipliers yet.
    pub fn new(system: &System, weight: f64) -> Self {
        let multipliers = system
            .blocks
            .iter()
            .map(|block| vec![0.0; block.values.len()])
            .collect();
        Self {
            weight,
            approach_weight: weight,
            multipliers,
        }
    }

    fn row_weight(&self, block: &Block, row: usize) -> f64 {
        // Only collisions have more than six rows, and only they have an approach row.
        if row == APPROACH_ROW && block.values.len() > 6 {
            self.approach_weight
        } else {
            self.weight
        }
    }

    /// `w` and the signed distance of a row's shifted value; zero where it does not act.
    fn act(&self, index: usize, block: &Block, row: usize) -> (f64, f64) {
        let weight = self.row_weight(block, row);
        let shifted = block.values[row] + self.multipliers[index][row] / weight;
        let (lower, upper) = block.bounds[row];
        (weight, shifted - shifted.clamp(lower, upper))
    }

    /// Value of the augmented Lagrangian.
    pub fn merit(&self, system: &System) -> f64 {
        let mut merit = system.cost;
        for (index, block) in system.blocks.iter().enumerate() {
            for row in 0..block.values.len() {
                let (weight, distance) = self.act(index, block, row);
                merit += 0.5 * weight * distance * distance;
            }
        }
        merit
    }

    /// First-order update of the multipliers.
    pub fn update(&mut self, system: &System) {
        for (index, block) in system.blocks.iter().enumerate() {
            for row in 0..block.values.len() {
                let (weight, distance) = self.act(index, block, row);
                self.multipliers[index][row] = weight * distance;
            }
        }
    }

    /// Adds the rows that act to a matrix and a gradient.
    pub fn add_to(
        &self,
        frame: &Frame,
        system: &System,
        matrix: &mut Envelope,
        gradient: &mut DVector<f64>,
    ) {
        let mut weights = Vec::new();
        for (index, block) in system.blocks.iter().enumerate() {
            let rows = block.values.len();
            weights.clear();
            weights.extend((0..rows).map(|row| {
                let (weight, distance) = self.act(index, block, row);
                let equality = block.bounds[row].0 == block.bounds[row].1;
                (
                    if equality || distance != 0.0 {
                        weight
                    } else {
                        0.0
                    },
                    weight * distance,
                )
            }));
            add_block(frame.layout, index, block, &weights, matrix, gradient);
        }
    }

    /// Adds `w Jᵀ e` for residuals `e` of the rows that act.
    pub fn add_pull(
        &self,
        layout: &Layout,
        system: &System,
        errors: &[Vec<f64>],
        gradient: &mut DVector<f64>,
    ) {
        for (index, block) in system.blocks.iter().enumerate() {
            let rows = block.values.len();
            for (column, at) in System::columns(layout, index).iter().enumerate() {
                let derivative = &block.jacobian[column * rows..][..rows];
                gradient[*at] += derivative
                    .iter()
                    .enumerate()
                    .map(|(row, d)| self.acting_weight(index, block, row) * d * errors[index][row])
                    .sum::<f64>();
            }
        }
    }

    /// Distance of every row that acts from the bound it acts on; `None` for the others.
    pub fn acting(&self, system: &System) -> Vec<Vec<Option<f64>>> {
        let blocks = system.blocks.iter().enumerate();
        blocks
            .map(|(index, block)| {
                let rows = 0..block.values.len();
                rows.map(|row| {
                    let (lower, upper) = block.bounds[row];
                    let distance = self.act(index, block, row).1;
                    if lower == upper || distance < 0.0 {
                        Some(block.values[row] - lower)
                    } else if distance > 0.0 {
                        Some(block.values[row] - upper)
                    } else {
                        None
                    }
                })
                .collect()
            })
            .collect()
    }

    /// Weight of a row that acts, zero of one that does not.
    fn acting_weight(&self, index: usize, block: &Block, row: usize) -> f64 {
        let (weight, distance) = self.act(index, block, row);
        if block.bounds[row].0 == block.bounds[row].1 || distance != 0.0 {
            weight
        } else {
            0.0
        }
    }
}

/// Adds `Jᵀ diag(w) J` and `Jᵀ p` for rows of (weight `w`, pull `p`).
fn add_block(
    layout: &Layout,
    index: usize,
    block: &Block,
    weights: &[(f64, f64)],
    matrix: &mut Envelope,
    gradient: &mut DVector<f64>,
) {
    let rows = weights.len();
    let columns = System::columns(layout, index);
    let mut weighted = [0.0; 16];
    for (i, at) in columns.iter().enumerate() {
        let derivative = &block.jacobian[i * rows..][..rows];
        let mut pull = 0.0;
        for row in 0..rows {
            weighted[row] = weights[row].0 * derivative[row];
            pull += weights[row].1 * derivative[row];
        }
        gradient[*at] += pull;
        for (j, other) in columns[..=i].iter().enumerate() {
            let partner = &block.jacobian[j * rows..][..rows];
            let value: f64 = weighted[..rows]
                .iter()
                .zip(partner)
                .map(|(a, b)| a * b)
                .sum();
            matrix.add(&layout.pattern, (*at).max(*other), (*at).min(*other), value);
        }
    }
}

/// `J d` for every block.
pub fn along(layout: &Layout, system: &System, delta: &DVector<f64>) -> Vec<Vec<f64>> {
    let blocks = system.blocks.iter().enumerate();
    blocks
        .map(|(index, block)| {
            let rows = block.values.len();
            let mut change = vec![0.0; rows];
            for (column, at) in System::columns(layout, index).iter().enumerate() {
                for (entry, d) in change
                    .iter_mut()
                    .zip(&block.jacobian[column * rows..][..rows])
                {
                    *entry += d * delta[*at];
                }
            }
            change
        })
        .collect()
}
