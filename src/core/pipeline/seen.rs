//! What the streams of a take show besides flights.

use super::outcome::{Outcome, PipelineError};
use crate::motion::{
    EventKind, Fits, Mark, Scene, SeenPhase, Stamp, TakeEvent, TrackIndex, Verdict,
};
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

/// What the streams of a scene as it is marked show besides flights.
pub(super) fn seen(scene: &Scene, events: &[TakeEvent]) -> Result<SeenTake, PipelineError> {
    let sketch = segment::clean::standing(scene, events)?;
    let marks = marks_of(scene, events);
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

/// Whether nothing speaks against a motion.
pub(super) fn is_clean(outcome: &Outcome) -> bool {
    let estimate = &outcome.estimate;
    estimate.verdict == Verdict::Physical
        && estimate.fits() != Fits::No
        && estimate.suspects.is_empty()
        && estimate.doubts.is_empty()
}

/// Puts proposals at what is seen of the scene's phases: where each begins and ends.
pub(super) fn at_phases(scene: &Scene, events: &[TakeEvent], proposals: &mut Vec<MarkProposal>) {
    if scene.phases.is_empty() {
        return;
    }
    let unmarked = events.iter().filter(|of| of.mark().is_none());
    let unmarked: Vec<TakeEvent> = unmarked.cloned().collect();
    let Ok(seen) = seen(scene, &unmarked) else {
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

/// A proposed mark.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkProposal {
    /// The track whose motion has the kink (index into `Scene::tracks`); `None` for start and end.
    pub track: Option<TrackIndex>,
    /// Name of its event, if as many were searched for as the scene has: `bounce 2` of a collision `bounce` that
    /// the scene repeats.
    pub event: Option<String>,
    /// Its time on the clock of the samples.
    pub stamp: Stamp,
    /// Its time [s since the first sample].
    pub time_s: f64,
    /// See [`segment::Proposal::score`]; `None` for start and end.
    pub score: Option<f64>,
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
