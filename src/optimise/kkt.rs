//! Steps on the optimality conditions, linearised.
//!
//! `[H Jᵀ; J 0][d; ν] = [−g; −c]` is solved by the method of multipliers on the quadratic
//! model: one factorisation of `H + w JᵀJ`, which keeps the envelope and is positive definite
//! where the solution is unique, then a few back-substitutions, each of which shrinks the
//! error by the ratio of `H` to `w JᵀJ`.

use nalgebra::DVector;

use super::active::ActiveSet;
use super::envelope::Envelope;
use super::program::Program;
use super::system::{Structure, System};

/// Damping of the factorised matrix, so small that it only keeps undetermined unknowns still.
pub const DAMPING: f64 = 1e-9;
/// The linearised constraints hold well enough at this share of their violation (the next step
/// leaves more by curvature), or at rounding.
const EXACT: f64 = 1e-5;
const ROUNDING: f64 = 1e-14;
/// Back-substitutions at most.
const REFINEMENTS: usize = 8;

/// A solution of the linearised optimality conditions.
pub struct KktStep {
    /// The step.
    pub delta: DVector<f64>,
    /// The multipliers after it, row by row.
    pub multipliers: Vec<f64>,
}

/// The factorised `H + w JᵀJ` of a system, for steps and for covariances.
pub struct Kkt {
    matrix: Envelope,
    /// What the curvature of active rows adds to the diagonal of `H`.
    curvature: Vec<(usize, f64)>,
    /// Weight of every row, zero of those that do not act.
    weights: Vec<f64>,
    /// Signed distance of every row from the bound that acts.
    violations: Vec<f64>,
    multipliers: Vec<f64>,
    /// What keeps undetermined unknowns still: added to the diagonal.
    damping: Vec<f64>,
}

impl Kkt {
    /// Factorises with the rows active that `multipliers` say; `None` where an unknown is
    /// undetermined beyond the damping.
    pub fn new<P: Program>(program: &P, system: &System, multipliers: &[f64]) -> Option<Self> {
        let active = ActiveSet::of(system, multipliers, program.information().1);
        Self::with(program, (system, &system.hessian), multipliers, &active)
    }

    /// `hessian` is the system's, or that with the curvature of its constraints where steps need it.
    pub fn with<P: Program>(
        program: &P,
        (system, hessian): (&System, &Envelope),
        multipliers: &[f64],
        active: &ActiveSet,
    ) -> Option<Self> {
        let structure = program.structure();
        let weighed = active.weights_and_violations(system, program.information().1);
        let damping = vec![DAMPING; structure.size()];
        let multipliers = multipliers.to_vec();
        Self::weighed(structure, (system, hessian), multipliers, weighed, damping)
    }

    /// Factorises with rows of those weights and violations, and with `damping` as a share of
    /// `1 + Hᵢᵢ` on the diagonal.
    pub fn weighed(
        structure: &Structure,
        (system, hessian): (&System, &Envelope),
        multipliers: Vec<f64>,
        (weights, violations): (Vec<f64>, Vec<f64>),
        mut damping: Vec<f64>,
    ) -> Option<Self> {
        let pattern = &structure.pattern;
        let pull = |row: usize| {
            if weights[row] > 0.0 {
                multipliers[row]
            } else {
                0.0
            }
        };
        let curvature = system.curvature(structure, pull);
        let mut matrix = hessian.clone();
        for (at, value) in &curvature {
            matrix.add(pattern, *at, *at, *value);
        }
        for (row, damping) in damping.iter_mut().enumerate() {
            *damping *= 1.0 + system.hessian.get(pattern, row, row);
            matrix.add(pattern, row, row, *damping);
        }
        system.add_square(structure, &weights, &mut matrix);
        matrix.factorise(pattern).ok()?;
        Some(Self {
            matrix,
            curvature,
            weights,
            violations,
            multipliers,
            damping,
        })
    }

    /// The step to the optimum of the model at `system`, whose Hessian is `hessian`.
    pub fn step(&self, structure: &Structure, (system, hessian): (&System, &Envelope)) -> KktStep {
        let (weights, violations) = (&self.weights, &self.violations);
        let mut multipliers = self.multipliers.clone();
        let mut delta = DVector::zeros(structure.size());
        let mut residual = DVector::zeros(structure.size());
        let mut rows = vec![0.0; multipliers.len()];
        let largest = violations
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        for refinement in 0..REFINEMENTS {
            // Minus the gradient of the model's augmented Lagrangian at delta.
            residual.copy_from(&system.gradient);
            if refinement > 0 {
                hessian.multiply_add(&structure.pattern, &delta, &mut residual);
                for (at, value) in &self.curvature {
                    residual[*at] += value * delta[*at];
                }
            }
            let pull = |row: usize| {
                if weights[row] > 0.0 {
                    multipliers[row] + weights[row] * (violations[row] + rows[row])
                } else {
                    0.0
                }
            };
            system.add_pull(structure, pull, &mut residual);
            residual.neg_mut();
            self.matrix.solve(&structure.pattern, &mut residual);
            delta += &residual;
            system.along(structure, &delta, &mut rows);
            let mut worst: f64 = 0.0;
            for (row, multiplier) in multipliers.iter_mut().enumerate() {
                let error = if weights[row] > 0.0 {
                    violations[row] + rows[row]
                } else {
                    0.0
                };
                *multiplier += weights[row] * error;
                worst = worst.max(error.abs());
            }
            if worst <= (EXACT * largest).max(ROUNDING) {
                break;
            }
        }
        for (multiplier, weight) in multipliers.iter_mut().zip(weights) {
            if *weight == 0.0 {
                *multiplier = 0.0;
            }
        }
        KktStep { delta, multipliers }
    }

    /// The step that also removes what the constraints depart from their linearisation.
    pub fn correct(
        &self,
        structure: &Structure,
        (system, trial): (&System, &System),
        delta: &DVector<f64>,
    ) -> DVector<f64> {
        delta + system.correction(structure, trial, delta, &self.weights, &self.matrix)
    }

    /// The damping's share of `xᵀ (H + w JᵀJ) x`.
    pub fn damped(&self, x: &DVector<f64>) -> f64 {
        x.iter().zip(&self.damping).map(|(x, d)| d * x * x).sum()
    }

    /// Solves `(H + w JᵀJ) x = b` in place.
    pub fn solve(&self, structure: &Structure, b: &mut DVector<f64>) {
        self.matrix.solve(&structure.pattern, b);
    }
}
