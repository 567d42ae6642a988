//! A motion that goes into something just before its end: its end is marked late, and it ends where it touches.
//!
//! People mark an end as late or early as a collision. What comes down on a table at metres a second is inside of it a few
//! milliseconds later, though its motion is right until then.

use super::outcome::Outcome;
use crate::motion::{About, Doubt, EventKind, Place, Stamp, TakeEvent, TimeMap, Timing, Verdict};
use crate::verify::credible::from_mark_s;
use crate::verify::overlaps_begin_s;

/// An end that is earlier than its mark.
pub(super) struct EarlyEnd {
    event: usize,
    /// Acted times at which it is marked, and at which the motion ends \[s\].
    made_s: f64,
    touches_s: f64,
    /// When the motion ends, on the clock of the samples.
    stamp: Stamp,
}

impl EarlyEnd {
    /// That of a motion which touches something no longer before the mark of its end than a mark may be late; `None` where
    /// goals, keyframes or no mark say when it ends.
    pub(super) fn of(outcome: &Outcome) -> Option<Self> {
        let Outcome {
            scene,
            sketch,
            estimate,
            ..
        } = outcome;
        let event = scene.events.len().checked_sub(1)?;
        let is_told = scene.time_is_free(event)
            || scene.timing == Timing::Edited
            || scene.is_keyframed(sketch)
            || scene.goals.iter().any(|goal| goal.event == event);
        let is_end = matches!(scene.events[event].kind, EventKind::End);
        if !is_end || is_told || estimate.verdict == Verdict::Failed {
            return None;
        }
        let made_s = outcome.marks_made_s[event]?;
        let map = TimeMap::new(&estimate.sample_times, sketch.origin)?;
        let [_, earlier_s] = from_mark_s(scene, sketch, event);
        let begin_s = overlaps_begin_s(scene, estimate).into_iter();
        let mut touch_s = begin_s.map(|begins_s| map.acted_s(begins_s));
        let touches_s = touch_s.find(|at_s| (0.0..=earlier_s).contains(&(made_s - at_s)))?;
        Some(Self {
            event,
            made_s,
            touches_s,
            stamp: sketch.origin.after(touches_s),
        })
    }

    /// The take with its end marked where it touches; `None` where the mark is not found.
    pub(super) fn marked(&self, outcome: &Outcome, events: &[TakeEvent]) -> Option<Vec<TakeEvent>> {
        let name = &outcome.scene.events[self.event].name;
        let is_mark = |event: &TakeEvent| {
            event.mark().is_some_and(|mark| {
                let is_named = mark.event.as_ref().is_none_or(|of| of == name);
                let acted_s = mark.stamp.seconds_since(outcome.sketch.origin);
                is_named && (acted_s - self.made_s).abs() < 1e-6
            })
        };
        let at = events.iter().position(is_mark)?;
        let mut events = events.to_vec();
        if let TakeEvent::Mark(mark) = &mut events[at] {
            mark.stamp = self.stamp;
        }
        Some(events)
    }

    /// Says it of the motion that ends there.
    pub(super) fn tell(&self, outcome: &mut Outcome) {
        outcome.marks_made_s[self.event] = Some(self.made_s);
        let early = Doubt {
            about: About::EndTouches,
            place: Place::Event(self.event),
            value: self.made_s - self.touches_s,
            bound: 0.0,
        };
        let doubts = outcome.estimate.doubts.iter().cloned();
        outcome.estimate.doubt(doubts.chain([early]).collect());
    }
}
