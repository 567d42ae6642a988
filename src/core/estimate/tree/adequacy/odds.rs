//! The odds that a quantity of the scene is wrong, over all models of the errors.

use super::errors::Left;

/// Logarithm of a sum of exponentials.
fn log_sum(logs: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    most + logs.map(|log| (log - most).exp()).sum::<f64>().ln()
}

/// Logarithm of the likelihood of a scene as it is.
pub(super) fn evidence(left: &[Left]) -> f64 {
    log_sum(left.iter().map(|of| of.log))
}

/// Logarithm of the odds that there is a wander: all models but the first have one.
pub(super) fn of_wander(left: &[Left]) -> f64 {
    evidence(&left[1..]) - left[0].log
}

/// Logarithm of the likelihood where a column's quantity is wrong by `off` and by what the slope says beyond it, given
/// its typical change.
pub(super) fn evidence_if_wrong(left: &[Left], column: usize, typical: f64, off: f64) -> f64 {
    log_sum(left.iter().map(|of| {
        let last = of.products.ncols() - 1;
        let prior = typical.powi(-2);
        let information = of.products[(column, column)] + prior;
        let slope = of.products[(column, last)] + off * prior;
        let gained = 0.5 * slope * slope / information - 0.5 * (information / prior).ln();
        of.log - 0.5 * off * off * prior + gained
    }))
}

/// The error of a column's quantity that would make odds of so great a logarithm, under the models as they are likely.
pub(super) fn shown(left: &[Left], column: usize, typical: f64, log_odds: f64) -> f64 {
    let all = evidence(left);
    let information: f64 = left
        .iter()
        .map(|of| (of.log - all).exp() * of.products[(column, column)])
        .sum();
    let price = 0.5 * (information * typical * typical + 1.0).ln();
    (2.0 * (log_odds + price) / information).sqrt()
}
