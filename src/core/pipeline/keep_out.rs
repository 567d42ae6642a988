//! A motion that goes into something, led out of it: non-penetration by constraint generation.
//!
//! A motion is solved without regard to what else it passes, since nearly always nothing is in its way. Where the check finds
//! solids in each other, their distance about the deepest moment becomes a constraint, and the motion is solved again
//! from where it is; until nothing overlaps, or the work for it is used up. Where it is, or where the motion had to be led
//! farther from its performance than chance explains, as where an impact is missing, it stays as it was, with its doubt.

use super::perform::Performed;
use crate::estimate::Solved;
use crate::motion::{Observer, Phase, Verdict, Verification};
use crate::verify::overlaps;

/// Greatest number of rounds.
const ROUNDS: usize = 10;
/// Work that may be done, in that of the solve,
const WORK: usize = 4;
/// and at least, in iterations.
const LEAST_WORK: usize = 100;

/// Greatest ratio of the objectives of a motion that is kept out and of the one that is not,
const FARTHER: f64 = 1.2;
/// and where errors of a hand are told the greatest difference: the truth itself is as far from the best fit by chance
/// once in a thousand times (χ² of the thirteen numbers that a flight and an impact have).
const DIFFERENCE: f64 = 34.5;

/// Whether a check found solids in each other, or that another part touches first.
pub(super) fn goes_into_something(verification: &Verification) -> bool {
    verification.deepest.is_some() || verification.wrong_features().next().is_some()
}

/// The motion with its solids out of each other; `None` where none was found.
pub(super) fn kept_out(mut take: Performed, observer: &mut dyn Observer) -> Option<Performed> {
    let spent = |solved: &Solved| solved.estimate.counters.iterations;
    if take.inferred.solved.estimate.verdict == Verdict::Failed {
        return None;
    }
    let most = spent(&take.inferred.solved) + (WORK * spent(&take.inferred.solved)).max(LEAST_WORK);
    let objective = take.inferred.solved.estimate.objective;
    observer.phase(Phase::Finish);
    for round in 0..ROUNDS {
        let (solved, performance) = take.parts();
        let scene = performance.scene.as_estimated(&solved.estimate);
        let found = overlaps(&scene, &solved.estimate, observer);
        if observer.should_stop() {
            return None;
        }
        if found.is_empty() {
            let is_near = is_near(objective, solved);
            return (is_near && round > 0).then_some(take);
        }
        if spent(solved) > most || !solved.keep_apart(performance, &found, observer) {
            return None;
        }
    }
    None
}

/// Whether a motion that is kept out is about as near to its performance as the one that was not.
fn is_near(objective: f64, solved: &Solved) -> bool {
    let kept = solved.estimate.objective;
    let is_likely = !solved.errs_in_time() || kept - objective <= DIFFERENCE;
    kept <= FARTHER * objective.max(1.0) && is_likely
}
