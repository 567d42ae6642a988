//! What the streams of a take show besides flights.

use super::{MarkProposal, Outcome, Pipeline, PipelineError};
use crate::motion::{EventKind, Fits, Mark, Scene, SeenPhase, Stamp, TakeEvent, Verdict};
use crate::segment;

/// A flight may end so long before what follows it is seen \[ns\].
const FOLLOWS_NS: i64 = 100_000_000;

/// What the streams of a take show besides flights.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenTake {
    /// The first sample.
    pub first: Stamp,
    /// Body by body in order of time.
    pub phases: Vec<SeenPhase>,
    /// For each of them the phase of the scene that says it (index into `Scene::phases`).
    pub said: Vec<Option<usize>>,
    /// The marks that the take has of the scene's events, by their names.
    pub marks: Vec<Mark>,
}

impl SeenTake {
    /// Those that the scene does not say.
    pub fn unsaid(&self) -> impl Iterator<Item = &SeenPhase> {
        let all = self.phases.iter().zip(&self.said);
        all.filter(|(_, said)| said.is_none()).map(|(of, _)| of)
    }

    /// When a phase of the scene is seen to begin and to end.
    fn span(&self, phase: usize) -> Option<[Stamp; 2]> {
        let of = self.said.iter().position(|said| *said == Some(phase))?;
        Some([self.phases[of].from, self.phases[of].until])
    }
}

impl Pipeline {
    /// What the streams show besides flights, between the marks of start and end where the take has them. Of edited stamps
    /// nothing is told.
    pub fn seen(&self) -> Result<SeenTake, PipelineError> {
        let scene = &self.scene.with_marks(self.marks());
        let sketch = segment::clean::standing(scene, &self.events)?;
        let marks = marks_of(scene, &self.events);
        let samples = sketch.tracks.iter().flat_map(|track| &track.samples);
        let stamps = samples.map(|sample| sample.stamp);
        let (first, last) = stamps.fold((Stamp(i64::MAX), Stamp(i64::MIN)), |(first, last), of| {
            (first.min(of), last.max(of))
        });
        let mark = |kind: EventKind| {
            let event = scene.events.iter().position(|of| of.kind == kind)?;
            marks[event]
        };
        let between = [
            mark(EventKind::Start).unwrap_or(first),
            mark(EventKind::End).unwrap_or(last),
        ];
        let phases = segment::seen_phases(scene, &sketch, between);
        let said = segment::said(scene, &phases, &marks);
        let named = marks
            .iter()
            .zip(&scene.events)
            .filter_map(|(stamp, event)| {
                Some(Mark {
                    stamp: (*stamp)?,
                    event: Some(event.name.clone()),
                })
            });
        let marks = named.collect();
        Ok(SeenTake {
            first,
            phases,
            said,
            marks,
        })
    }

    /// What the scene does not say of a motion against which something speaks.
    pub(super) fn unsaid(&self, outcome: &Outcome) -> Vec<SeenPhase> {
        let estimate = &outcome.estimate;
        let is_clean = estimate.verdict == Verdict::Physical
            && estimate.fits() != Fits::No
            && estimate.suspects.is_empty()
            && estimate.doubts.is_empty();
        if is_clean {
            return Vec::new();
        }
        let seen = self.seen();
        seen.map_or_else(|_| Vec::new(), |seen| seen.unsaid().copied().collect())
    }

    /// Puts proposals at what is seen of the scene's phases: where each begins and ends.
    pub(super) fn at_phases(&self, scene: &Scene, proposals: &mut Vec<MarkProposal>) {
        if scene.phases.is_empty() {
            return;
        }
        let unmarked = self.events.iter().filter(|of| of.mark().is_none());
        let take = Self::of(scene.clone(), unmarked.cloned());
        let Ok(seen) = take.seen() else {
            return;
        };
        for (index, phase) in scene.phases.iter().enumerate() {
            let Some(span) = seen.span(index) else {
                continue;
            };
            for (event, stamp) in phase.events.into_iter().zip(span) {
                let of = &scene.events[event];
                let found = proposals
                    .iter_mut()
                    .find(|proposal| proposal.event.as_ref() == Some(&of.name));
                let is_later = |than: Stamp| than.0 < stamp.0 && seen_there(&seen, than);
                let time_s = stamp.seconds_since(seen.first);
                match (found, &of.kind) {
                    (Some(proposal), EventKind::Start) if proposal.stamp <= stamp => {}
                    (Some(proposal), EventKind::End) if !is_later(proposal.stamp) => {}
                    (Some(proposal), _) => (proposal.stamp, proposal.time_s) = (stamp, time_s),
                    (None, _) => proposals.push(MarkProposal {
                        track: scene.tracks_of(scene.mechanism_of(phase.link)).next(),
                        event: Some(of.name.clone()),
                        stamp,
                        time_s,
                        score: None,
                    }),
                }
            }
        }
    }
}

/// Whether something is seen at a time, or soon after it.
fn seen_there(seen: &SeenTake, time: Stamp) -> bool {
    let mut phases = seen.phases.iter();
    phases.any(|of| of.from.0 - FOLLOWS_NS <= time.0 && time.0 <= of.until.0)
}

/// The marks of the scene's events: those that name them, or all in order.
fn marks_of(scene: &Scene, events: &[TakeEvent]) -> Vec<Option<Stamp>> {
    let mut marks: Vec<&Mark> = events.iter().filter_map(TakeEvent::mark).collect();
    marks.sort_by_key(|mark| mark.stamp);
    let is_all = marks.len() == scene.events.len();
    let mark = |event: usize| {
        let name = Some(&scene.events[event].name);
        let named = marks.iter().find(|mark| mark.event.as_ref() == name);
        let in_order = || {
            marks
                .get(event)
                .filter(|mark| is_all && mark.event.is_none())
        };
        Some(named.or_else(in_order)?.stamp)
    };
    (0..scene.events.len()).map(mark).collect()
}
