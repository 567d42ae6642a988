//! Whether a motion that does not agree with its performance is only led away from it by its goals.
//!
//! A goal may ask for another motion than was acted: that is what goals are for. Then flights, marks and impacts
//! disagree with the samples though nothing in the scene is wrong. It is told apart by the same motion without goals: where
//! that agrees, the goals are what the disagreement is about, and nothing else is suspected.

use super::diagnose::motion::{distance, misfit};
use super::outcome::PipelineError;
use super::perform::{Performed, Prepared};
use crate::motion::{About, Doubt, Estimate, Fits, Observer, Place, Suspect, TakeEvent, Verdict};

/// Ratio of the distances from the samples with goals and without, beyond which goals plainly ask for another motion. It is
/// told, and decides nothing.
const FARTHER: f64 = 1.5;

/// By how much goals lead a motion away from its performance.
pub(super) struct LedByGoals {
    doubt: Doubt,
    /// What is suspected of the motion without goals.
    suspects: Vec<Suspect>,
}

impl LedByGoals {
    /// What goals cost, if a motion may differ from its performance and the same without its goals is much nearer and
    /// not known to.
    pub(super) fn of(
        performed: &Performed,
        events: &[TakeEvent],
        observer: &mut dyn Observer,
    ) -> Result<Option<Self>, PipelineError> {
        let scene = &performed.inferred.scene;
        let estimate = &performed.inferred.solved.estimate;
        let is_well = estimate.fit.as_ref().is_ok_and(|fit| fit.fits == Fits::Yes)
            && !is_known_to_differ(performed);
        if scene.goals.is_empty() || estimate.verdict == Verdict::Failed || is_well {
            return Ok(None);
        }
        let mut free = scene.clone();
        free.goals.clear();
        let mut without = Prepared::new(&free, events, observer)?.one_by_one(observer)?;
        // As the motion with goals was found: of a hand's errors one is farther from its samples than of each by itself.
        let errs_in_time = performed.inferred.solved.errs_in_time();
        if errs_in_time {
            without.refine(observer);
        }
        without.judge(observer);
        if observer.should_stop() || is_known_to_differ(&without) {
            return Ok(None);
        }
        let without = without.inferred.solved.estimate;
        let first = scene.goals[0].event;
        let is_one = scene.goals.iter().all(|goal| goal.event == first);
        let place = match is_one {
            true => Place::Event(first),
            false => Place::Motion,
        };
        let cost = |of: &Estimate| match errs_in_time {
            // Errors of a hand are told of each by itself: objectives are not alike.
            true => misfit(scene, &distance(of)),
            false => of.objective.sqrt(),
        };
        let ratio = cost(estimate) / cost(&without).max(f64::MIN_POSITIVE);
        let doubt = Doubt {
            about: About::Led,
            place,
            value: ratio,
            bound: FARTHER,
        };
        Ok(Some(Self {
            suspects: without.suspects,
            doubt,
        }))
    }

    /// Takes suspicions back of which the goals are the reason.
    pub(super) fn clear(&self, performed: &mut Performed) {
        let estimate = &mut performed.inferred.solved.estimate;
        if !estimate.suspects.is_empty() {
            estimate.suspects.clone_from(&self.suspects);
        }
        if let Ok(fit) = &mut estimate.fit {
            fit.fits = fit.fits.min(Fits::Unknown);
        }
    }

    /// The doubts without those of which the goals are the reason, and with what they cost. What is so far from its
    /// samples that other motions may fit as well stays doubted for all.
    pub(super) fn instead_of(self, doubts: Vec<Doubt>) -> Vec<Doubt> {
        let is_far = doubts.iter().any(|doubt| doubt.about == About::Ambiguity);
        let others = doubts.into_iter();
        let others = others.filter(|doubt| is_far || !is_of_agreement(doubt));
        others.chain([self.doubt]).collect()
    }
}

/// Whether a motion is known to differ from its performance: it does not fit, or a doubt says so.
fn is_known_to_differ(performed: &Performed) -> bool {
    let estimate = &performed.inferred.solved.estimate;
    let is_doubted = |doubt: &Doubt| doubt.about == About::Ambiguity || is_of_agreement(doubt);
    estimate.verdict == Verdict::Failed
        || estimate.fit.as_ref().is_ok_and(|fit| fit.fits == Fits::No)
        || performed.doubts().iter().any(is_doubted)
}

/// Whether a doubt is about how a motion agrees with its samples and marks, where a goal may be the reason. How far it is from
/// them stays to be said.
fn is_of_agreement(doubt: &Doubt) -> bool {
    matches!(
        doubt.about,
        About::Alone
            | About::Misfit
            | About::Fall
            | About::FallDirection
            | About::AfterMark
            | About::BeforeMark
    )
}
