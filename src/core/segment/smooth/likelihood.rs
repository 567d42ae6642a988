//! Strengths of a tracker's noise and of a hand's jerk, by the likelihood of what was read.
//!
//! Where the noise is not given, the likelihood is largest at a variance in closed form for every
//! ratio of both, so that one number is searched for: the jerk relative to the noise,
//! `q h⁵/r`, with the median interval `h`. Its sixth root is the inverse of the time over which the
//! smoother averages, in intervals.

use super::chain::Chain;
use super::filter::{Noises, Surprise, Timed, surprise};

/// Decimal logarithms of the least and the greatest ratio: averages over a hundred intervals, and over
/// less than one.
const LEAST: f64 = -12.0;
const GREATEST: f64 = 4.0;
/// Where the search begins: averages over some five intervals.
const FIRST: f64 = -4.0;
/// The greatest ratio is taken whose likelihood is not lower than the greatest by more than this, in
/// twice its logarithm: too stiff a motion is wrong, too loose a one only less certain.
const CREDIBLE: f64 = 2.7;
/// Number of bisections of a decade.
const BISECTIONS: usize = 4;

/// The noises of some stretches of readings. `given` is the reading's standard deviation, where it is
/// known; it is never less than `least`.
pub(super) fn credible<C: Chain>(
    stretches: &[Vec<Timed<C::Reading>>],
    interval_s: f64,
    given: Option<f64>,
    least: f64,
) -> Noises {
    let jerk = |decade: f64| 10_f64.powf(decade) * interval_s.powi(-5);
    let surprised = |decade: f64| {
        let noises = Noises {
            reading: 1.0,
            jerk: jerk(decade),
        };
        let mut sum = Surprise::default();
        for stretch in stretches {
            sum.add(&surprise::<C>(stretch, &noises));
        }
        sum
    };
    // The variance of a reading for which the innovations are likeliest.
    let variance = |sum: &Surprise| {
        let likeliest = sum.square / sum.count();
        given.map_or(likeliest, |sd| sd * sd).max(least * least)
    };
    // Minus twice the logarithm of the likelihood.
    let cost = |decade: f64| {
        let sum = surprised(decade);
        let variance = variance(&sum);
        sum.log_determinant + sum.count() * variance.ln() + sum.square / variance
    };
    // By decades to the least cost, first down, then up.
    let (mut best, mut least_cost) = (FIRST, cost(FIRST));
    for step in [-1.0, 1.0] {
        while (LEAST..=GREATEST).contains(&(best + step)) {
            let there = cost(best + step);
            if there >= least_cost {
                break;
            }
            (best, least_cost) = (best + step, there);
        }
    }
    // Up to where it is no longer credible.
    let is_credible = |decade: f64| cost(decade) < least_cost + CREDIBLE;
    while best + 1.0 <= GREATEST && is_credible(best + 1.0) {
        best += 1.0;
    }
    let mut beyond = (best + 1.0).min(GREATEST);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (best + beyond);
        if is_credible(middle) {
            best = middle;
        } else {
            beyond = middle;
        }
    }
    let reading = variance(&surprised(best));
    Noises {
        reading,
        jerk: jerk(best) * reading,
    }
}
