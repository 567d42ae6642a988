//! A motion that goes into something, led out of it: non-penetration by constraint generation.
//!
//! A motion is solved without regard to what else it passes, since nearly always nothing is in its way. Where the check finds
//! solids in each other, their distance about the deepest moment becomes a constraint, and the motion is solved again
//! from where it is; until nothing overlaps, or the work for it is used up. Where it is, or where the motion had to be led
//! farther from its performance than chance explains, as where an impact is missing, it stays as it was, with its doubt.

use super::perform::Performed;
use crate::motion::{
    About, Doubt, Estimate, Fits, Observer, Penetration, Performer, Phase, Scene, Verdict,
    Verification,
};
use crate::verify::overlaps;

/// Greatest number of rounds.
const ROUNDS: usize = 10;
/// Work that may be done, in that of the solve,
const WORK: usize = 4;
/// and at least, in iterations.
const LEAST_WORK: usize = 100;

/// Greatest ratio of the objectives of a motion that is kept out and of the one that is not.
const FARTHER: f64 = 1.2;
/// Ratio of these beyond which no further distance can lead it back.
const HOPELESS: f64 = 10.0;
/// Where errors of a hand are told, greatest difference of the two where one distance holds the motion, and how much greater
/// it may be for each more, in the variance of a residual: the truth keeps out too, so that it is greater once in a thousand
/// times by chance (χ² of as many numbers as there are distances; those of corners at one place count once).
const DIFFERENCE: [f64; 2] = [10.8, 3.0];

/// A motion that may be led out of what it goes into.
pub(super) trait Leadable {
    /// The scene that it is of.
    fn scene(&self) -> &Scene;

    /// What is told of it.
    fn estimate(&self) -> &Estimate;

    /// Goes on to the motion near by at which solids that overlap keep out of each other; whether there is one.
    fn keep_apart(&mut self, found: &[Penetration], observer: &mut dyn Observer) -> bool;

    /// What it is held out of and only just passes.
    fn just_passed(&self) -> Vec<Doubt>;

    /// Whether its samples err in time.
    fn errs_in_time(&self) -> bool;
}

impl Leadable for Performed {
    fn scene(&self) -> &Scene {
        &self.inferred.scene
    }

    fn estimate(&self) -> &Estimate {
        &self.inferred.solved.estimate
    }

    fn keep_apart(&mut self, found: &[Penetration], observer: &mut dyn Observer) -> bool {
        let (solved, performance) = self.parts();
        solved.keep_apart(performance, found, observer)
    }

    fn just_passed(&self) -> Vec<Doubt> {
        let tolerance_m = self.scene().tolerance_m;
        self.inferred.solved.just_passed(tolerance_m)
    }

    fn errs_in_time(&self) -> bool {
        self.inferred.solved.errs_in_time()
    }
}

/// Whether nothing speaks against a motion but that solids are in each other, or that another part touches first. What does
/// not agree with its performance is not led farther away from it.
pub(super) fn only_overlaps(estimate: &Estimate) -> bool {
    let is_of_shape = |about| matches!(about, About::Overlap | About::WrongFeature);
    let doubts = estimate.doubts.iter().map(|doubt| doubt.about);
    let grave: Vec<About> = doubts.filter(|of| of.best() != Verdict::Physical).collect();
    let is_known_to_misfit = estimate.fits() == Fits::No || !estimate.suspects.is_empty();
    !grave.is_empty() && !is_known_to_misfit && grave.into_iter().all(is_of_shape)
}

/// Whether a check found solids in each other, or that another part touches first; what was not checked may.
pub(super) fn goes_into_something(checked: Option<&Verification>) -> bool {
    checked.is_none_or(|of| of.deepest.is_some() || of.wrong_features().next().is_some())
}

/// The motion with its solids out of each other; `None` where none was found.
pub(super) fn kept_out<M: Leadable>(mut motion: M, observer: &mut dyn Observer) -> Option<M> {
    let spent = |motion: &M| motion.estimate().counters.iterations;
    if motion.estimate().verdict == Verdict::Failed {
        return None;
    }
    let most = spent(&motion) + (WORK * spent(&motion)).max(LEAST_WORK);
    let objective = motion.estimate().objective;
    observer.phase(Phase::Finish);
    for round in 0..ROUNDS {
        let scene = motion.scene().as_estimated(motion.estimate());
        let found = overlaps(&scene, motion.estimate(), observer);
        if observer.should_stop() {
            return None;
        }
        if found.is_empty() {
            let is_near = is_near(objective, &motion);
            return (is_near && round > 0).then_some(motion);
        }
        let is_hopeless = motion.estimate().objective > HOPELESS * objective.max(DIFFERENCE[0]);
        if is_hopeless || spent(&motion) > most || !motion.keep_apart(&found, observer) {
            return None;
        }
    }
    None
}

/// Whether a motion that is kept out is about as near to its performance as the one that was not: by no more than a share
/// farther, and than chance explains. Where nobody says that there was no hand, samples may err by the scene's weights.
fn is_near(objective: f64, motion: &impl Leadable) -> bool {
    let estimate = motion.estimate();
    let kept = estimate.objective;
    let variance = objective / estimate.residual_count().max(1) as f64;
    let held = motion.just_passed().len();
    let most = DIFFERENCE[0] + DIFFERENCE[1] * held.saturating_sub(1) as f64;
    let farther = kept - objective;
    if motion.errs_in_time() {
        // Residuals are in units of the errors that are told, so that each varies by one, if not more.
        return kept <= FARTHER * objective && farther <= most * variance.max(1.0);
    }
    let may_err = motion.scene().performer != Performer::Nobody;
    kept <= FARTHER * objective || may_err && farther <= most
}
