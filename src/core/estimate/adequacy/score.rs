//! Rao's score test of quantities that a scene keeps fixed (C. R. Rao, Proceedings of the Cambridge
//! Philosophical Society 44, 1948; with constraints: Aitchison and Silvey, Annals of Mathematical Statistics 29,
//! 1958).
//!
//! At a solution with Hessian `H`, constraints' derivative `C` and multipliers `λ`, let `g_θ`, `h`, `H_θ`
//! and `c_θ` be the objective's derivative by a quantity `θ`, its mixed and second derivatives, and the
//! constraints' derivative. What the motion can follow of a change of `θ` is `z`:
//!
//! ```text
//! [H Cᵀ; C 0] [z; ·] = [h; c_θ],   d = (θ: 1, motion: −z)
//! s = g_θ + c_θᵀ λ,   V = |J d|²,   Δθ = −s/V,   decrease s²/2V
//! s² / (dᵀ Jᵀ Σ J d) ~ χ²₁ under the model
//! ```
//!
//! with the residuals' derivative `J` and the errors' covariance `Σ`; matrices in place of numbers for
//! several quantities at once. No further solve is made.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::hand::{ResidualKind, Wander};
use crate::estimate::covariance::bins::{Bins, Six, products};
use crate::estimate::covariance::trace::Design;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::unknowns::point::Point;
use crate::optimise::kkt::Kkt;
use crate::optimise::{Program, System};

/// Greatest number of refinements of a direction; they end where one changes less than this share.
const REFINEMENTS: usize = 3;
const REFINED: f64 = 1e-6;
/// The same where samples err in time: what holds a motion there pulls by much more than what a direction changes.
const EXACTLY: (usize, f64) = (12, 1e-11);

/// The solution of the problem in which the suspected quantities are parameters too, at the values
/// that the scene gives them.
pub(super) struct Extended<'a> {
    pub(super) context: &'a SolveContext<'a>,
    pub(super) point: &'a Point,
    /// Multipliers of the constraints, which are those of the problem without them.
    pub(super) multipliers: &'a [f64],
}

/// Scores of some parameters, each with its direction.
pub(super) struct Scores {
    /// Values `s`.
    slopes: Vec<f64>,
    /// `J d`, sample by sample.
    changes: Vec<Vec<Six>>,
    /// Sums of `J d` over the bins.
    sums: Vec<Vec<Six>>,
    /// `d`.
    directions: Vec<DVector<f64>>,
    /// `H d` of the objective's Hessian.
    curved: Vec<DVector<f64>>,
}

/// What a group of parameters would explain.
pub(super) struct Scored {
    /// Their changes `Δθ`.
    pub(super) changes: Vec<f64>,
    /// Predicted decrease of the objective.
    pub(super) decrease: f64,
    /// Probability of a larger score under the model.
    pub(super) probability: f64,
}

impl Scores {
    /// The scores of the parameters from the `first` on; `base` is the factorised system without them.
    pub(super) fn new(
        extended: &Extended,
        base: &SolveContext,
        kkt: &Kkt,
        bins: &Bins,
        first: usize,
    ) -> Self {
        let context = extended.context;
        let system = context.evaluated(&Guidance::none(), extended.point);
        let design = Design::new(context, extended.point, bins);
        let parameters = first..context.problem.parameters.len();
        let directions = directions(context, &system, base, kkt, first);
        let slopes = parameters.map(|parameter| {
            let at = context.layout.parameters[parameter];
            let mut gradient = system.gradient.clone();
            let pull = |row: usize| extended.multipliers[row];
            system.add_pull(context.structure(), pull, &mut gradient);
            gradient[at]
        });
        let slopes: Vec<f64> = slopes.collect();
        let changes = directions.iter().map(|direction| {
            let mut changes = Vec::new();
            design.each_change(direction, |change| changes.push(*change));
            changes
        });
        let changes: Vec<Vec<Six>> = changes.collect();
        let curved = directions.iter().map(|direction| {
            let mut product = DVector::zeros(direction.len());
            let pattern = &context.structure().pattern;
            system
                .hessian
                .multiply_add(pattern, direction, &mut product);
            product
        });
        Self {
            slopes,
            sums: directions.iter().map(|d| design.sums(d)).collect(),
            changes,
            curved: curved.collect(),
            directions,
        }
    }

    /// `aᵀ Jᵀ J b` of the directions of two parameters, of positions and of orientations, and what
    /// priors add to it in `aᵀ H b`.
    fn products(&self, a: usize, b: usize) -> [f64; 3] {
        let [x, y] = products(&self.changes[a], &self.changes[b]);
        let priors = self.curved[a].dot(&self.directions[b]) - x - y;
        [x, y, if a == b { priors.max(0.0) } else { priors }]
    }

    /// What some parameters (indices among those scored) would explain, with the noise's covariance;
    /// `None` where the performance does not tell them apart from what else may move.
    pub(super) fn of(
        &self,
        group: &[usize],
        lengths: &[f64],
        white: [f64; 2],
        hands: &[Wander; 2],
    ) -> Option<Scored> {
        let count = group.len();
        let mut information = DMatrix::zeros(count, count);
        let mut variance = DMatrix::zeros(count, count);
        for (i, a) in group.iter().enumerate() {
            for (j, b) in group.iter().enumerate() {
                let [x, y, prior] = self.products(*a, *b);
                let scale = lengths[i] * lengths[j];
                information[(i, j)] = (x + y + prior) * scale;
                let mut noise = x * white[0] + y * white[1] + prior;
                for (kind, hand) in ResidualKind::ALL.into_iter().zip(hands) {
                    noise += hand.covariance(kind, &self.sums[*a], &self.sums[*b]);
                }
                variance[(i, j)] = noise * scale;
            }
        }
        let slopes = DVector::from_fn(count, |i, _| self.slopes[group[i]] * lengths[i]);
        // What changes no sample by its own typical change is not told.
        let told = information.diagonal().min() > white[0].min(white[1]);
        let information = information.cholesky().filter(|_| told)?;
        let answer = information.solve(&slopes);
        let statistic = slopes.dot(&variance.cholesky()?.solve(&slopes));
        let law = ChiSquared::new(count as f64).ok()?;
        Some(Scored {
            changes: (0..count).map(|i| -answer[i] * lengths[i]).collect(),
            decrease: 0.5 * slopes.dot(&answer),
            probability: law.sf(statistic),
        })
    }
}

/// `d` of each parameter from the `first` on.
pub(super) fn directions(
    extended: &SolveContext,
    system: &System,
    base: &SolveContext,
    kkt: &Kkt,
    first: usize,
) -> Vec<DVector<f64>> {
    let of_each = extended.layout.parameters[first..].iter();
    of_each
        .map(|at| direction(extended, system, base, kkt, *at))
        .collect()
}

/// `d` of one parameter, over all unknowns of the extended problem, of which those of the base are the first.
fn direction(
    context: &SolveContext,
    system: &System,
    base: &SolveContext,
    kkt: &Kkt,
    at: usize,
) -> DVector<f64> {
    let size = base.layout.size();
    let pattern = &context.structure().pattern;
    let mut unit = DVector::zeros(context.layout.size());
    unit[at] = 1.0;
    let mut mixed = DVector::zeros(unit.len());
    system.hessian.multiply_add(pattern, &unit, &mut mixed);
    // Minus the derivative of the quadratic penalty's gradient along the direction so far.
    let mut direction = unit;
    let (refinements, refined) = match context.problem.weave {
        Some(_) => EXACTLY,
        None => (REFINEMENTS, REFINED),
    };
    for refinement in 0..refinements {
        let mut pulled = DVector::zeros(direction.len());
        if refinement == 0 {
            pulled += &mixed;
        }
        kkt.add_pulled(context.structure(), system, &direction, &mut pulled);
        let mut step = pulled.rows(0, size).into_owned();
        kkt.solve(base.structure(), &mut step);
        let is_refined = step.amax() <= refined * direction.amax();
        let mut own = direction.rows_mut(0, size);
        own -= step;
        if is_refined {
            break;
        }
    }
    direction
}
