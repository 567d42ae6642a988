//! Steps on the optimality conditions, linearised.
//!
//! `[H Jᵀ; J 0][d; ν] = [−g; −c]` is solved by the method of multipliers on the quadratic
//! model: one factorisation of `H + w JᵀJ`, which keeps the envelope and is positive definite
//! where the solution is unique, then a few back-substitutions, each of which shrinks the
//! error by the ratio of `H` to `w JᵀJ`.

use nalgebra::DVector;

use super::active::ActiveSet;
use super::merit;
use super::system::{SolveContext, System};
use crate::math::envelope::Envelope;

/// Damping of the factorised matrix, so small that it only keeps undetermined unknowns still.
pub(super) const DAMPING: f64 = 1e-9;
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
    pub fn new(context: &SolveContext, system: &System, multipliers: &[f64]) -> Option<Self> {
        let active = ActiveSet::of(context, system, multipliers);
        Self::with(context, (system, &system.hessian), multipliers, &active)
    }

    /// The same for covariances: what a parameter's bound keeps in place is not known for that. It
    /// weighs as half the width between the bounds for a standard deviation, or nothing where
    /// there is only one.
    pub fn with_soft_bounds(
        context: &SolveContext,
        system: &System,
        multipliers: &[f64],
    ) -> Option<Self> {
        let active = ActiveSet::of(context, system, multipliers);
        let (mut weights, violations) = active.weights_and_violations(context, system);
        let mut multipliers = multipliers.to_vec();
        let problem = context.problem;
        let bounds = problem.bounded.len() + problem.cones.len();
        let (hard, soft) = system.blocks.split_at(system.blocks.len() - bounds);
        let first: usize = hard.iter().map(|block| block.values.len()).sum();
        let rows = soft.iter().flat_map(|block| &block.bounds);
        for (row, (lower, upper)) in (first..).zip(rows) {
            if weights[row] > 0.0 {
                multipliers[row] = 0.0;
                // A cone's row goes as the square of the distance from its middle.
                let half_width = if lower.is_infinite() && row >= first + problem.bounded.len() {
                    2.0 * upper
                } else {
                    0.5 * (upper - lower)
                };
                weights[row] = half_width.powi(-2);
            }
        }
        // Samples hold every time that the tempo relates to others; a damping in proportion to how
        // stiffly neighbours are held together would hold all of them.
        let mut damping = vec![DAMPING; context.layout.size()];
        for node in context.layout.nodes.iter().flatten() {
            damping[*node] = 0.0;
        }
        let weighed = (weights, violations);
        Self::weighed(
            context,
            (system, &system.hessian),
            multipliers,
            weighed,
            damping,
        )
    }

    /// `hessian` is the system's, or that with the curvature of its constraints where steps need it.
    pub(super) fn with(
        context: &SolveContext,
        (system, hessian): (&System, &Envelope),
        multipliers: &[f64],
        active: &ActiveSet,
    ) -> Option<Self> {
        let weighed = active.weights_and_violations(context, system);
        let damping = vec![DAMPING; context.layout.size()];
        let multipliers = multipliers.to_vec();
        Self::weighed(context, (system, hessian), multipliers, weighed, damping)
    }

    fn weighed(
        context: &SolveContext,
        (system, hessian): (&System, &Envelope),
        multipliers: Vec<f64>,
        (weights, violations): (Vec<f64>, Vec<f64>),
        mut damping: Vec<f64>,
    ) -> Option<Self> {
        let pattern = &context.layout.pattern;
        let pull = |row: usize| {
            if weights[row] > 0.0 {
                multipliers[row]
            } else {
                0.0
            }
        };
        let curvature = merit::curvature(context.layout, system, pull);
        let mut matrix = hessian.clone();
        for (at, value) in &curvature {
            matrix.add(pattern, *at, *at, *value);
        }
        for (row, damping) in damping.iter_mut().enumerate() {
            *damping *= 1.0 + system.hessian.get(pattern, row, row);
            matrix.add(pattern, row, row, *damping);
        }
        merit::add_square(context.layout, system, &weights, &mut matrix);
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
    pub fn step(&self, context: &SolveContext, (system, hessian): (&System, &Envelope)) -> KktStep {
        let layout = context.layout;
        let (weights, violations) = (&self.weights, &self.violations);
        let mut multipliers = self.multipliers.clone();
        let mut delta = DVector::zeros(layout.size());
        let mut residual = DVector::zeros(layout.size());
        let mut rows = vec![0.0; multipliers.len()];
        let largest = violations
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        for refinement in 0..REFINEMENTS {
            // Minus the gradient of the model's augmented Lagrangian at delta.
            residual.copy_from(&system.gradient);
            if refinement > 0 {
                hessian.multiply_add(&layout.pattern, &delta, &mut residual);
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
            merit::add_pull(layout, system, pull, &mut residual);
            residual.neg_mut();
            self.matrix.solve(&layout.pattern, &mut residual);
            delta += &residual;
            merit::along(layout, system, &delta, &mut rows);
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
    pub(super) fn correct(
        &self,
        context: &SolveContext,
        system: &System,
        trial: &System,
        delta: &DVector<f64>,
    ) -> DVector<f64> {
        let weights = &self.weights;
        delta
            + merit::correction(
                context.layout,
                (system, trial),
                delta,
                weights,
                &self.matrix,
            )
    }

    /// The damping's share of `xᵀ (H + w JᵀJ) x`.
    pub fn damped(&self, x: &DVector<f64>) -> f64 {
        x.iter().zip(&self.damping).map(|(x, d)| d * x * x).sum()
    }

    /// Solves `(H + w JᵀJ) x = b` in place.
    pub fn solve(&self, context: &SolveContext, b: &mut DVector<f64>) {
        self.matrix.solve(&context.layout.pattern, b);
    }
}
