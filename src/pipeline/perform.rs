//! From the events of a take to a motion without deviations and checks: stages 2 to 4.

use super::follow::follow;
use super::infer::Inferred;
use super::outcome::PipelineError;
use super::stages::{account, cut, solve};
use crate::motion::{Observer, Phase, SampleCounts, Scene, Sketch, TakeEvent};
use crate::segment;

/// A motion, and the performance that it is of.
pub(super) struct Performed {
    pub(super) inferred: Inferred,
    pub(super) sketch: Sketch,
    pub(super) counts: SampleCounts,
    /// See [`Outcome::marks_made_s`](super::Outcome::marks_made_s).
    pub(super) marks_made_s: Vec<Option<f64>>,
}

/// The motion of a take. A repeated collision happens as often as marks say.
pub(super) fn perform(
    scene: &Scene,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Result<Performed, PipelineError> {
    observer.phase(Phase::Clean);
    let scene = scene.with_marks(marks(events));
    let (mut sketch, mut counts) = segment::clean::clean(&scene, events)?;
    let mut cut = cut(&scene, &mut sketch, &mut counts, observer)?;
    let mut inferred = solve(&scene, &mut sketch, &cut, observer)?;
    follow(&mut sketch, &mut cut, &mut inferred, observer);
    account(&sketch, &cut.segments, &mut counts);
    Ok(Performed {
        inferred,
        sketch,
        counts,
        marks_made_s: cut.marks_made_s,
    })
}

/// Number of marks in a take.
pub(super) fn marks(events: &[TakeEvent]) -> usize {
    let is_mark = |event: &&TakeEvent| matches!(event, TakeEvent::Mark(_));
    events.iter().filter(is_mark).count()
}
