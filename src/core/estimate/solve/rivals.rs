//! Different motions that are as near to the keyframes.
//!
//! Keyframes are few, so that several motions may pass through all of them: with one more turn
//! between two of them, or where they have no more numbers than the motion has. With `f` the sums of
//! squares, `n` numbers and `m` unknowns that constraints leave, `f/(n − m)` is the variance of a
//! number; a motion is as near as the best if its sum exceeds the least by less than nine of it.

use crate::estimate::problem::Problem;
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::Guess;
use crate::physics::flow;

/// Excess of the sum of squares that is no difference, in variances of a number.
const EXCESS: f64 = 9.0;
/// Excess that is rounding, per number.
const ROUNDING: f64 = 1e-9;
/// Motions of which no state differs by more are the same [m, rad, m/s, rad/s].
const SAME: f64 = 1e-3;

/// Indices of the solutions that are as near to the keyframes as that of `lowest`, each another
/// motion, in order; empty where the samples are no keyframes.
pub(super) fn alike(
    problem: &Problem,
    layout: &Layout,
    found: &[Solution],
    guesses: &[Guess],
    lowest: usize,
) -> Vec<usize> {
    let least = &found[lowest];
    if !problem.keeps_starts || !least.finished.converged {
        return Vec::new();
    }
    let numbers = 6.0 * problem.sample_count() as f64;
    let bounds = least.system.blocks.iter().flat_map(|block| &block.bounds);
    let equalities = bounds.filter(|(lower, upper)| lower == upper).count();
    let more = numbers - layout.size().saturating_sub(equalities) as f64;
    let variance = 2.0 * least.system.cost / more.max(1.0);
    let most = 2.0 * least.system.cost + EXCESS * variance + ROUNDING * numbers;
    let mut alike: Vec<usize> = Vec::new();
    for (index, solution) in found.iter().enumerate() {
        let is_near = solution.finished.converged && 2.0 * solution.system.cost <= most;
        let motion = |index: usize| (&found[index].point, &guesses[index]);
        let differs = |other: &usize| are_different(problem, motion(*other), motion(index));
        if is_near && alike.iter().all(differs) {
            alike.push(index);
        }
    }
    alike
}

/// Whether states differ at the epochs of the first.
fn are_different(problem: &Problem, one: (&Point, &Guess), other: (&Point, &Guess)) -> bool {
    let gravity_m_s2 = problem.gravity(&one.0.parameters);
    (0..problem.arcs.len()).any(|arc| {
        let since_s = one.1.arcs[arc].epoch_s - other.1.arcs[arc].epoch_s;
        let body = problem.body_of(arc);
        let then = flow::advance(body, &gravity_m_s2, &other.0.arcs[arc], since_s);
        one.0.arcs[arc].minus(&then).amax() > SAME
    })
}
