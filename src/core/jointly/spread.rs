//! The spread over takes of parameters that are drawn, by restricted maximum likelihood (Patterson and Thompson, Biometrika
//! 58, 1971) of the takes' quadratic models: Fisher scoring in the variances, none of which is negative.

use nalgebra::{DMatrix, DVector};

use super::parameter::JointParameter;
use super::part::{MeanPart, PlainPart, Total};

/// Greatest number of steps, and of halvings of one.
const STEPS: usize = 100;
const HALVINGS: usize = 30;
/// A step that changes no standard deviation by more, in lengths or relative to it, is the last.
const SAME: f64 = 1e-10;
/// By how much less twice the logarithm of the likelihood is at the ends of an interval of 95 %: the quantile of χ² with
/// one degree of freedom.
const AT_ENDS: f64 = 3.841_459;

/// The takes' models, and what is known beforehand.
pub(super) struct TakesField<'a> {
    pub(super) parameters: &'a [JointParameter],
    pub(super) mean: &'a DVector<f64>,
    pub(super) parts: &'a [PlainPart],
}

/// What variances make of the takes.
struct Likely {
    /// Restricted log-likelihood, but for a constant.
    log: f64,
    /// Derivative by the variances, and Fisher's information.
    score: DVector<f64>,
    fisher: DMatrix<f64>,
}

impl TakesField<'_> {
    /// `Σ f_k + ½ Σ bᵀT⁻¹b` with the priors: what a step must not increase.
    pub(super) fn objective(&self, variances: &DVector<f64>) -> f64 {
        let of_take = |part: &PlainPart| {
            let off = part.off.iter().zip(variances);
            let drawn = off.filter(|(_, variance)| **variance > 0.0);
            part.cost
                + 0.5
                    * drawn
                        .map(|(off, variance)| off * off / variance)
                        .sum::<f64>()
        };
        let takes: f64 = self.parts.iter().map(of_take).sum();
        let priors = self.parameters.iter().zip(self.mean);
        let priors = priors.map(|(of, mean)| of.prior() * (mean - of.initial / of.length).powi(2));
        takes + 0.5 * priors.sum::<f64>()
    }

    /// The likeliest variances, from some on.
    pub(super) fn likeliest(&self, start: &DVector<f64>) -> DVector<f64> {
        let drawn: Vec<usize> = self.drawn().collect();
        let mut variances = start.clone();
        let Some(mut here) = self.likely(&variances) else {
            return variances;
        };
        for _ in 0..STEPS {
            let held: Vec<usize> = drawn
                .iter()
                .copied()
                .filter(|at| variances[*at] > 0.0 || here.score[*at] > 0.0)
                .collect();
            let Some(step) = scored(&here, &held) else {
                break;
            };
            let mut taken = None;
            let mut share = 1.0;
            for _ in 0..HALVINGS {
                let mut there = variances.clone();
                for (at, by) in held.iter().zip(step.iter()) {
                    there[*at] = (there[*at] + share * by).max(0.0);
                }
                if let Some(likely) = self.likely(&there).filter(|of| of.log >= here.log) {
                    taken = Some((there, likely));
                    break;
                }
                share *= 0.5;
            }
            let Some((there, likely)) = taken else { break };
            let change = there.map(f64::sqrt) - variances.map(f64::sqrt);
            let size = variances.map(|of| of.sqrt().max(1e-6));
            let is_same = change.component_div(&size).amax() < SAME;
            (variances, here) = (there, likely);
            if is_same {
                break;
            }
        }
        variances
    }

    /// Ends of the interval of a standard deviation, by the likelihood with the others as they are.
    pub(super) fn ends(&self, variances: &DVector<f64>, at: usize) -> [f64; 2] {
        let log = |sd: f64| {
            let mut there = variances.clone();
            there[at] = sd * sd;
            self.likely(&there).map_or(f64::NEG_INFINITY, |of| of.log)
        };
        let best = variances[at].sqrt();
        let least = log(best) - 0.5 * AT_ENDS;
        let between = |mut inside: f64, mut outside: f64| {
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                match log(middle) >= least {
                    true => inside = middle,
                    false => outside = middle,
                }
            }
            inside
        };
        let lower = match log(0.0) >= least {
            true => 0.0,
            false => between(best, 0.0),
        };
        let mut beyond = (2.0 * best).max(1e-6);
        while log(beyond) >= least && beyond < 1e6 {
            beyond *= 2.0;
        }
        [lower, between(best, beyond)]
    }

    fn drawn(&self) -> impl Iterator<Item = usize> + '_ {
        let all = self.parameters.iter().enumerate();
        all.filter(|(_, of)| of.is_drawn).map(|(at, _)| at)
    }

    fn likely(&self, variances: &DVector<f64>) -> Option<Likely> {
        let parts: Vec<MeanPart> = self.parts.iter().map(|of| of.of_means(variances)).collect();
        let total = Total::of(self.parameters, self.mean, parts.iter());
        let count = variances.len();
        // What the takes do not determine tells nothing of spreads.
        let ridge = 1e-9 * total.information.diagonal().amax().max(1e-9);
        let information = &total.information + DMatrix::identity(count, count) * ridge;
        let factor = information.cholesky()?;
        let covariance = factor.inverse();
        let step = -(&covariance * &total.gradient);
        let mut log = -factor.l().diagonal().map(f64::ln).sum() - 0.5 * step.dot(&total.gradient);
        let mut score = DVector::zeros(count);
        let mut fisher = DMatrix::zeros(count, count);
        for (part, plain) in parts.iter().zip(self.parts) {
            log += 0.5 * plain.gradient.dot(&(&part.own * &plain.gradient));
            log -= 0.5 * part.log_determinant;
            let left = &part.gradient + &part.information * &step;
            let shrunk = &part.information * &covariance * &part.information;
            for at in 0..count {
                let told = part.information[(at, at)] - shrunk[(at, at)];
                score[at] += 0.5 * (left[at] * left[at] - told);
            }
            fisher += part.information.component_mul(&part.information) * 0.5;
        }
        log.is_finite().then_some(Likely { log, score, fisher })
    }
}

/// The step by Fisher's information of these variances.
fn scored(here: &Likely, held: &[usize]) -> Option<DVector<f64>> {
    if held.is_empty() {
        return None;
    }
    let fisher = here.fisher.select_rows(held).select_columns(held);
    let fisher = &fisher + DMatrix::from_diagonal(&fisher.diagonal()) * 1e-9;
    let score = DVector::from_iterator(held.len(), held.iter().map(|at| here.score[*at]));
    Some(fisher.cholesky()?.solve(&score))
}
