//! A motion that goes into something, led out of it: non-penetration by constraint generation.
//!
//! A motion is solved without regard to what else it passes, since nearly always nothing is in its way. Where the check finds
//! solids in each other, their distance about the deepest moment becomes a constraint, and the motion is solved again
//! from where it is; until nothing overlaps, or the work for it is used up. Then the motion stays as it was, with its doubt.

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
    observer.phase(Phase::Finish);
    for _ in 0..ROUNDS {
        let (solved, performance) = take.parts();
        let scene = performance.scene.as_estimated(&solved.estimate);
        let found = overlaps(&scene, &solved.estimate, observer);
        if observer.should_stop() {
            return None;
        }
        if found.is_empty() {
            return Some(take);
        }
        if spent(solved) > most || !solved.keep_apart(performance, &found, observer) {
            return None;
        }
    }
    None
}
