//! Assigns samples to flights again after the estimation has moved the events.
//!
//! Samples are first assigned to flights by the refined marks. The estimation then moves the
//! events, so that a sample may be compared with a flight outside of its time. Samples are then
//! assigned again by the estimated events, and the estimation continues from its solution, until
//! every sample is compared with the flight to which it belongs.

use std::ops::Range;

use super::infer::Inferred;
use super::kink;
use super::stages::Cut;
use super::warm::{self, Known};
use crate::estimate::{self, Recipe, Solved};
use crate::motion::{
    Counters, EventKind, Observer, Scene, Segment, Sketch, TimeMap, Timing, Verdict, View,
};
use crate::segment;
use crate::segment::cut::{median_interval_s, samples_min};

/// Greatest number of rounds in which samples are assigned again or left out.
const ROUNDS: usize = 6;
/// Distance of an event from a segment's samples, in median intervals, above which the samples
/// between them are added; samples next to a collision are left out in any case.
const BEHIND_INTERVALS: f64 = 3.0;

/// Assigns samples anew and estimates again, until none is compared with a flight outside of its
/// time; where that fails, samples on the wrong side are left out.
pub(super) fn follow(
    sketch: &mut Sketch,
    cut: &mut Cut,
    inferred: &mut Inferred,
    observer: &mut dyn Observer,
) {
    let scene = &inferred.scene;
    // The events of an edited sketch are fixed at the joints of its segments; where times are not
    // known, the order in which samples were given says in which flight each is.
    let mut tracks = sketch.tracks.iter();
    if scene.timing == Timing::Edited || tracks.any(|track| !track.open_times_s.is_empty()) {
        return;
    }
    let mut leaving_out = false;
    let mut rounds = 0;
    while rounds < ROUNDS
        && inferred.solved.estimate.verdict != Verdict::Failed
        && !observer.should_stop()
    {
        let known = Known {
            segments: &cut.segments,
            estimate: &inferred.solved.estimate,
        };
        let Some(acted) = Acted::new(&known, scene, sketch) else {
            break;
        };
        let next = if leaving_out {
            acted.without_those_outside()
        } else {
            acted.assigned()
        };
        let again = next.and_then(|next| Some((solved(&known, scene, &next, observer)?, next)));
        let Some((mut again, next)) = again else {
            if leaving_out {
                break;
            }
            leaving_out = true;
            continue;
        };
        rounds += 1;
        leaving_out |= 2 * rounds >= ROUNDS;
        let mut work: Counters = inferred.solved.estimate.counters;
        work.add(&again.estimate.counters);
        again.estimate.counters = work;
        inferred.solved = again;
        (*sketch, cut.segments) = (next.sketch, next.segments);
    }
    inferred.solved.estimate.counters.assignment_rounds += rounds;
}

/// A sketch whose samples are assigned anew.
struct Assigned {
    sketch: Sketch,
    segments: Vec<Segment>,
}

/// Acted times of an estimate's events, and the sketch whose samples are checked against them.
struct Acted<'a> {
    scene: &'a Scene,
    sketch: &'a Sketch,
    segments: &'a [Segment],
    events_s: Vec<f64>,
    /// When what touched comes off.
    left_s: Vec<f64>,
}

impl<'a> Acted<'a> {
    /// `None` where every sample belongs to the flight with which it is compared, and none is
    /// missing.
    fn new(known: &Known<'a>, scene: &'a Scene, sketch: &'a Sketch) -> Option<Self> {
        let segments = known.segments;
        let map = TimeMap::new(&known.estimate.sample_times, sketch.origin)?;
        let events = known.estimate.events.iter();
        let events_s = events.map(|of| {
            let shown_s = kink::caught_s(known, scene, sketch, of.event);
            map.acted_s(shown_s.unwrap_or(of.time_s))
        });
        let left = known.estimate.events.iter();
        let left_s = left.map(|of| map.acted_s(of.left_s()));
        let acted = Self {
            left_s: left_s.collect(),
            scene,
            sketch,
            segments,
            events_s: events_s.collect(),
        };
        let mut all = segments.iter();
        let is_wrong = all.any(|segment| {
            let mut views = segment.views.iter();
            views.any(|view| {
                acted.within(segment, view) != view.samples || acted.is_left_behind(segment, view)
            })
        });
        is_wrong.then_some(acted)
    }

    /// When a flight after an event begins \[s\].
    fn begins_s(&self, event: usize) -> f64 {
        self.events_s[event].max(self.left_s[event])
    }

    /// Samples of a segment's view that lie between its events.
    fn within(&self, segment: &Segment, view: &View) -> Range<usize> {
        let samples = self.sketch.samples_of(view);
        let begin = segment.start_event.map(|event| self.begins_s(event));
        let end = segment.end_event.map(|event| self.events_s[event]);
        let (from_s, to_s) = (
            begin.unwrap_or(f64::NEG_INFINITY),
            end.unwrap_or(f64::INFINITY),
        );
        let first = samples.partition_point(|sample| sample.acted_s < from_s);
        let last = samples.partition_point(|sample| sample.acted_s <= to_s);
        let begin = view.samples.start;
        begin + first..begin + last.max(first)
    }

    /// Whether a collision is so far from a segment that samples between them are missing from a view.
    fn is_left_behind(&self, segment: &Segment, view: &View) -> bool {
        let track = &self.sketch.tracks[view.track];
        let slack_s = BEHIND_INTERVALS * median_interval_s(track);
        let collision = |event: Option<usize>| event.filter(|event| self.scene.jolts(*event));
        let acted_s = |index: usize| track.samples.get(index).map(|sample| sample.acted_s);
        let before = view.samples.start.checked_sub(1).and_then(acted_s);
        let after = acted_s(view.samples.end);
        let end = collision(segment.end_event).map(|event| self.events_s[event]);
        let begin = collision(segment.start_event).map(|event| self.begins_s(event));
        let (ends, begins) = (end.zip(after), begin.zip(before));
        ends.is_some_and(|(event_s, after_s)| after_s < event_s - slack_s)
            || begins.is_some_and(|(event_s, before_s)| before_s > event_s + slack_s)
    }

    /// The cut at these times; `None` where it is the old one, or cannot be made.
    fn assigned(&self) -> Option<Assigned> {
        let mut sketch = self.sketch.clone();
        let cuts = sketch.marks_s.iter_mut().zip(&self.events_s);
        for ((cut_s, event_s), of) in cuts.zip(&self.scene.events) {
            // Samples before a start or after an end are no longer in the sketch.
            *cut_s = match of.kind {
                EventKind::Start => cut_s.max(*event_s),
                EventKind::End => cut_s.min(*event_s),
                EventKind::Collision(_)
                | EventKind::Collisions { .. }
                | EventKind::Change(_)
                | EventKind::Waypoint(_) => *event_s,
            };
        }
        for (event, contact_s) in &mut sketch.contacts_s {
            *contact_s = self.left_s[*event] - self.events_s[*event];
        }
        // What is in a hand is there for another time.
        segment::grip(self.scene, &mut sketch).ok()?;
        let segments = segment::cut(self.scene, &sketch).ok()?;
        (segments != self.segments).then_some(Assigned { sketch, segments })
    }

    /// The old cut without samples that do not belong to their segment; `None` where there are
    /// none, or where too few would remain.
    fn without_those_outside(&self) -> Option<Assigned> {
        let segments: Vec<Segment> = self
            .segments
            .iter()
            .map(|segment| {
                let views = segment.views.iter().map(|view| View {
                    track: view.track,
                    samples: self.within(segment, view),
                });
                Segment {
                    views: views.collect(),
                    ..segment.clone()
                }
            })
            .collect();
        let mut each = segments.iter();
        let is_enough = each.all(|s| {
            let least = samples_min(self.scene, self.sketch, s.start_event);
            s.sample_count() >= least
        });
        (is_enough && segments != self.segments).then(|| Assigned {
            sketch: self.sketch.clone(),
            segments,
        })
    }
}

/// The solution of the new cut, started from the old one; `None` where it does not converge.
fn solved(
    known: &Known,
    scene: &Scene,
    assigned: &Assigned,
    observer: &mut dyn Observer,
) -> Option<Solved> {
    let guess = [warm::guess(
        known,
        scene,
        &assigned.sketch,
        &assigned.segments,
    )?];
    let verdict = known.estimate.verdict;
    let recipes = [
        Recipe::default().from_the_last(),
        Recipe::default().without_sweep(),
        Recipe::default(),
    ];
    let mut solved = recipes.iter().map(|recipe| {
        estimate::estimate(
            scene,
            &assigned.sketch,
            &assigned.segments,
            &guess,
            recipe,
            observer,
        )
    });
    solved.find(|solved| solved.estimate.verdict == verdict)
}
