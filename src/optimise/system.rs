//! Cost and constraints at a point, with derivatives: what one iteration works on.
//!
//! Rows are numbered through all blocks; vectors over them are flat.

use nalgebra::DVector;

use super::block::{Block, BlockPattern};
use super::envelope::{Envelope, Pattern};

/// Which unknowns meet in a term or in a row.
#[derive(Clone, Debug)]
pub struct Structure {
    /// In a term of the Hessian, or in a row.
    pub pattern: Pattern,
    /// In the rows of each block of constraints.
    pub blocks: Vec<BlockPattern>,
    /// In the rows of each block that costs its squares instead of being bounded.
    pub priced: Vec<BlockPattern>,
}

impl Structure {
    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.pattern.size()
    }
}

/// Cost and constraints at a point.
#[derive(Clone, Debug)]
pub struct System {
    /// Half the sum of squared residuals, guidance included.
    pub cost: f64,
    /// Its gradient.
    pub gradient: DVector<f64>,
    /// Its positive semidefinite Hessian.
    pub hessian: Envelope,
    /// Constraints, in the order of the structure's blocks.
    pub blocks: Vec<Block>,
    /// What is priced: already in cost, gradient and Hessian.
    pub priced: Vec<Block>,
}

impl System {
    /// All zero.
    pub fn new(structure: &Structure) -> Self {
        let zeros = |patterns: &[BlockPattern]| patterns.iter().map(Block::zeros).collect();
        Self {
            cost: 0.0,
            gradient: DVector::zeros(structure.size()),
            hessian: Envelope::zeros(&structure.pattern),
            blocks: zeros(&structure.blocks),
            priced: zeros(&structure.priced),
        }
    }

    /// Number of rows of all constraints.
    pub fn row_count(&self) -> usize {
        self.blocks.iter().map(|block| block.values.len()).sum()
    }

    /// Values of all rows, in units.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.blocks
            .iter()
            .flat_map(|block| block.values.iter().copied())
    }

    /// Value of every row with its least and its greatest, in units.
    pub fn bounded(&self) -> impl Iterator<Item = (f64, (f64, f64))> + '_ {
        self.blocks.iter().flat_map(|block| {
            let bounds = block.bounds.iter().copied();
            block.values.iter().copied().zip(bounds)
        })
    }

    /// Sum of all violations, in units.
    pub fn total_violation(&self) -> f64 {
        self.violations().sum()
    }

    fn violations(&self) -> impl Iterator<Item = f64> + '_ {
        let blocks = self.blocks.iter();
        blocks.flat_map(|block| (0..block.values.len()).map(|row| block.violation(row).abs()))
    }

    /// Largest violation of any constraint, in units.
    pub fn violation(&self) -> f64 {
        self.violations().fold(0.0, f64::max)
    }

    /// Adds `Jᵀ diag(w) J` to a matrix.
    pub fn add_square(&self, structure: &Structure, weights: &[f64], matrix: &mut Envelope) {
        let mut offset = 0;
        for (block, pattern) in self.blocks.iter().zip(&structure.blocks) {
            let weight = |row: usize| weights[offset + row];
            block.add_square(pattern, weight, (&structure.pattern, matrix));
            offset += block.values.len();
        }
    }

    /// Adds `Jᵀ p` for a pull `p` on every row.
    pub fn add_pull(
        &self,
        structure: &Structure,
        pull: impl Fn(usize) -> f64,
        gradient: &mut DVector<f64>,
    ) {
        let mut offset = 0;
        for (block, pattern) in self.blocks.iter().zip(&structure.blocks) {
            block.add_pull(pattern, |row| pull(offset + row), gradient);
            offset += block.values.len();
        }
    }

    /// What the curvature of rows adds to the diagonal under a pull on every row: unknown and value.
    pub fn curvature(
        &self,
        structure: &Structure,
        pull: impl Fn(usize) -> f64,
    ) -> Vec<(usize, f64)> {
        let mut diagonal = Vec::new();
        let mut offset = 0;
        for (block, pattern) in self.blocks.iter().zip(&structure.blocks) {
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
    pub fn along(&self, structure: &Structure, delta: &DVector<f64>, change: &mut Vec<f64>) {
        change.clear();
        change.resize(self.row_count(), 0.0);
        let mut offset = 0;
        for (block, pattern) in self.blocks.iter().zip(&structure.blocks) {
            let rows = block.values.len();
            block.along(pattern, delta, &mut change[offset..offset + rows]);
            offset += rows;
        }
    }

    /// Adds what curved rows change by beyond `J δ`, exactly, to `change`.
    pub fn add_curved(&self, structure: &Structure, delta: &DVector<f64>, change: &mut [f64]) {
        let mut row = 0;
        for (block, pattern) in self.blocks.iter().zip(&structure.blocks) {
            if block.curvature > 0.0 {
                let curved = pattern.unknowns(0).iter();
                let square: f64 = curved.map(|at| delta[*at] * delta[*at]).sum();
                change[row] += 0.5 * block.curvature * square;
            }
            row += block.values.len();
        }
    }

    /// What to add to `delta`, given that it led to `trial`, so that the constraints' departure from
    /// their linearisation here is removed: `factor` holds `H + Jᵀ diag(w) J`.
    pub fn correction(
        &self,
        structure: &Structure,
        trial: &System,
        delta: &DVector<f64>,
        weights: &[f64],
        factor: &Envelope,
    ) -> DVector<f64> {
        let mut departure = Vec::new();
        self.along(structure, delta, &mut departure);
        let rows = self.values().zip(trial.values());
        for (entry, (before, after)) in departure.iter_mut().zip(rows) {
            *entry = after - before - *entry;
        }
        let mut correction = DVector::zeros(delta.len());
        let pull = |row: usize| -weights[row] * departure[row];
        self.add_pull(structure, pull, &mut correction);
        factor.solve(&structure.pattern, &mut correction);
        correction
    }
}
