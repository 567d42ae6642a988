//! Sets free the fewest quantities that explain a misfit.
//!
//! One thing after the other: that which explains most of what is left when it is set free, by
//! Schwarz's criterion ([`Suspect::gain`]), until the motion fits, or until a wander of the hand may
//! explain the rest. Nothing is set free where another thing explains the performance as well: the
//! data do not tell which it is.

use super::outcome::PipelineError;
use super::perform::{Performed, Prepared};
use crate::motion::{Estimate, Fits, Observer, Suspect, TakeEvent, Verdict};

/// Greatest number of things that are set free.
const MOST: usize = 4;

/// The motion with what explains the misfit of `performed` set free, and what that is, in order.
pub(super) fn free(
    mut performed: Performed,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Result<(Performed, Vec<Suspect>), PipelineError> {
    let mut freed = Vec::new();
    while freed.len() < MOST {
        let estimate = &performed.inferred.solved.estimate;
        let fits = estimate.fit.as_ref().map(|fit| fit.fits);
        let is_needed = fits == Ok(Fits::No) || fits == Ok(Fits::Unknown) && freed.is_empty();
        let Some(culprit) = culprit(estimate).filter(|_| is_needed).cloned() else {
            break;
        };
        let wider = performed.inferred.scene.with_free(&culprit.values);
        let mut next = Prepared::new(&wider, events, observer)?.performed(observer)?;
        if next.inferred.solved.estimate.verdict == Verdict::Failed {
            break;
        }
        next.judge(observer);
        performed = next;
        freed.push(culprit);
    }
    Ok((performed, freed))
}

/// What explains the misfit better than anything else.
fn culprit(estimate: &Estimate) -> Option<&Suspect> {
    let (first, others) = estimate.suspects.split_first()?;
    let mut others = others.iter();
    let is_alone = !others.any(|other| first.is_rivalled_by(other));
    is_alone.then_some(first)
}
