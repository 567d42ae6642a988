//! Cost and constraints at a point, with derivatives: the input of one iteration.
//!
//! Rows are numbered through all blocks; vectors over them are flat.

use nalgebra::DVector;

pub use super::block::Curvature;
use super::block::{Block, BlockPattern};
use super::envelope::{Envelope, Pattern};

/// The sparsity of a program: which unknowns occur together.
#[derive(Clone, Debug)]
pub struct Structure {
    /// In an entry of the Hessian or in a row of constraints: the envelope of `H + Jᵀ W J`.
    pub pattern: Pattern,
    /// In the rows of each block of constraints.
    pub blocks: Vec<BlockPattern>,
    /// In the rows of each block whose squares are part of the cost instead of being constrained.
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
    /// `f`: half the sum of squared residuals, guidance included.
    pub cost: f64,
    /// `g`, the gradient of the cost.
    pub gradient: DVector<f64>,
    /// `H`, a positive semidefinite Hessian of the cost.
    pub hessian: Envelope,
    /// Constraints, in the order of the structure's blocks.
    pub blocks: Vec<Block>,
    /// Rows whose squares are in the cost; cost, gradient and Hessian already contain them.
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

    /// Value of every row with its lower and its upper bound, in units.
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
            block.add_square(pattern, weight, &structure.pattern, matrix);
            offset += block.values.len();
        }
    }

    /// Adds `Jᵀ p` to `gradient`, with `p = pull(row)`: a multiplier, or weight times violation.
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

    /// Curvature `Σ p ∇²c` of the rows that have it in closed form, with `p = pull(row)`.
    pub fn curvature(&self, structure: &Structure, pull: impl Fn(usize) -> f64) -> Vec<Curvature> {
        let mut all = Vec::new();
        let mut offset = 0;
        for (block, pattern) in self.blocks.iter().zip(&structure.blocks) {
            if block.curvature > 0.0 {
                // A negative pull would make the matrix indefinite. It belongs to a bound that
                // is about to leave the active set.
                let value = block.curvature * pull(offset).max(0.0);
                if value > 0.0 {
                    let unknowns = pattern.unknowns(0).iter();
                    all.extend(unknowns.map(|at| Curvature {
                        row: *at,
                        column: *at,
                        value,
                    }));
                }
            }
            for second in &block.second {
                let curvature = second.pulled(pattern, pull(offset + second.row));
                if curvature.value != 0.0 {
                    all.push(curvature);
                }
            }
            offset += block.values.len();
        }
        all
    }

    /// Whether a row with second derivatives ([`Block::second`]) pulls; a priced one does where it is
    /// violated.
    pub fn has_pulled_curvature(&self, multipliers: &[f64]) -> bool {
        let mut first = 0;
        let mut pulled = self.blocks.iter().map(|block| {
            let mut rows = block.second.iter().map(|of| first + of.row);
            let pulled = rows.any(|row| multipliers[row] != 0.0);
            first += block.values.len();
            pulled
        });
        let mut priced = self.priced.iter();
        let priced = priced.any(|block| block.second.iter().any(|of| block.acts(of.row)));
        pulled.any(|pulled| pulled) || priced
    }

    /// `J δ`, the linearised change of every row, into `change`.
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

    /// Adds `½ δᵀ ∇²c δ` of rows with [`Block::curvature`] to `change`, which is then their exact
    /// change.
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

    /// Second-order correction of a step `δ` that led to `trial`:
    /// `−(H + Jᵀ W J)⁻¹ Jᵀ W (c(trial) − c − J δ)` with `W = diag(w)`. It removes the constraints'
    /// departure from their linearisation here; `factor` is the factorised matrix.
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
