//! Moves marks that are too far off to be refined to the collisions that the stream suggests.
//!
//! A cheap test first: does any refined mark reduce the cost less than a cut elsewhere would? Only
//! then are proposals computed, and accepted if they explain the stream clearly better.

use super::propose::{CLEAR_SCORE, ProposedStream};
use super::refine::{unlikely_mark, unlikely_residuals};
use crate::motion::{Collision, Partner, Scene, Sketch, Timing};

/// Marks are doubtful if the score of one of them is less than this,
const DOUBT_SCORE: f64 = 4.0;
/// or if the cost with one of them elsewhere between its neighbours is less than this share.
const DOUBT_SHARE: f64 = 0.8;
/// Superfluous cuts are tried at every so many places.
const DOUBT_STRIDE: usize = 3;
/// Proposals are accepted only if their cost is at most this share of that of the marks.
const SHARE_MAX: f64 = 0.7;

/// Moves refined marks of collisions that are far from any kink; returns the events that moved.
///
/// Either all marks of a mechanism move or none, since proposals are for all of them. Where mechanisms hit
/// each other, none moves.
pub fn relocate_marks(scene: &Scene, sketch: &mut Sketch) -> Vec<usize> {
    let collisions = || {
        let events = scene.events.iter().enumerate();
        events.filter_map(|(index, event)| Some((index, event.kind.collision()?)))
    };
    let is_between_links = collisions().any(|(_, collision)| match collision.partner {
        Partner::World => false,
        Partner::Link(other) => !scene.is_held(other),
    });
    // A mark that fixes or bounds a time is trusted, and proposals are for all marks or none.
    let is_trusted = |(event, _): (usize, &Collision)| {
        !scene.time_is_free(event) || scene.events[event].time.is_bounded()
    };
    if scene.timing == Timing::Edited || is_between_links || collisions().any(is_trusted) {
        return Vec::new();
    }
    let mut moved = Vec::new();
    let tracks = sketch.tracks.iter_enumerated();
    for (index, track) in tracks.filter(|(index, _)| scene.sees_moving(*index)) {
        let mechanism = scene.mechanism_seen_by(index);
        let mut phases = scene.phases.iter();
        // Cuts are sought between flights.
        let is_carried = phases.any(|phase| scene.mechanism_of(phase.link) == mechanism);
        if is_carried || scene.has_keyframes(sketch, index) {
            continue;
        }
        let events: Vec<usize> = collisions()
            .filter_map(|(event, collision)| {
                scene.takes_part(mechanism, collision).then_some(event)
            })
            .collect();
        let quick = ProposedStream::of_positions(scene, index, track);
        let marked: Vec<usize> = events
            .iter()
            .map(|event| quick.cut_at(sketch.marks_s[*event]))
            .collect();
        if !quick.is_doubtful(&marked) {
            continue;
        }
        let stream = ProposedStream::new(scene, index, track);
        let events: Vec<Option<usize>> = events.into_iter().map(Some).collect();
        let Some(cuts) = stream.best_cuts(&events) else {
            continue;
        };
        let is_clear = stream
            .scores(&cuts, 1)
            .iter()
            .all(|score| *score >= CLEAR_SCORE);
        let share = stream.total(&events, &cuts) / stream.total(&events, &marked);
        if !is_clear || share > SHARE_MAX {
            continue;
        }
        // The gain in the stream's likelihood must exceed the loss in that of the marks.
        let off = |event: usize, acted_s: f64| {
            sketch.marks[event].map_or(0.0, |mark| unlikely_mark(&mark, acted_s))
        };
        let further = events.iter().flatten().zip(&cuts);
        let further = further.map(|(event, cut)| {
            off(*event, stream.time_s(*cut)) - off(*event, sketch.marks_s[*event])
        });
        if unlikely_residuals(track, share) + further.sum::<f64>() > 0.0 {
            continue;
        }
        for (event, (cut, marked)) in events
            .into_iter()
            .flatten()
            .zip(cuts.into_iter().zip(marked))
        {
            if cut != marked {
                sketch.marks_s[event] = stream.time_s(cut);
                sketch.marks[event] = None;
                moved.push(event);
            }
        }
    }
    moved
}

impl ProposedStream<'_> {
    /// Whether cuts are too close, or one of them gains little, or less than elsewhere.
    fn is_doubtful(&self, cuts: &[usize]) -> bool {
        !self.has_room(cuts)
            || (0..cuts.len()).any(|index| {
                let (here, best) = self.elsewhere(cuts, index, DOUBT_STRIDE);
                best < DOUBT_SHARE * here
            })
            || self
                .scores(cuts, DOUBT_STRIDE)
                .iter()
                .any(|score| *score < DOUBT_SCORE)
    }
}
