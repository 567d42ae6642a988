//! The motions of held bodies in physical time, as estimated.

use typed_index_collections::TiSlice;

use crate::estimate::problem::{HeldState, Problem};
use crate::estimate::unknowns::point::Point;
use crate::math::Pose;
use crate::motion::held::{Curve, GripEstimate, HeldEstimate, Knot, Mounted, Passed};
use crate::motion::{
    ArcEstimate, EventEstimate, HeldMotion, Sample, SampleTime, Scene, Sketch, TimeMap, Timing,
    TrackIndex, TrackSketch,
};
use crate::physics::State;

/// A correction fades within so many times the time over which the smoother averages.
const FADING: f64 = 2.0;
/// Step of the difference by which the tempo at a sample is measured \[s\].
const TEMPO_STEP_S: f64 = 0.01;

/// How acted time passes, for one tracker.
pub(in crate::estimate) enum Pace {
    /// Physical time is `zero + offset + (1 + slow) (acted − zero)`.
    Clock {
        zero_s: f64,
        offset_s: f64,
        slow: f64,
    },
    /// In an unknown tempo.
    Map(TimeMap),
}

impl Pace {
    /// Stamps are physical times.
    pub(in crate::estimate) const STAMPS: Self = Self::Clock {
        zero_s: 0.0,
        offset_s: 0.0,
        slow: 0.0,
    };

    /// Physical time \[s\], and the acted time that passes in a second of it.
    fn at(&self, acted_s: f64) -> (f64, f64) {
        match self {
            Pace::Clock {
                zero_s,
                offset_s,
                slow,
            } => {
                let time_s = zero_s + offset_s + (1.0 + slow) * (acted_s - zero_s);
                (time_s, 1.0 / (1.0 + slow))
            }
            Pace::Map(map) => {
                let [before_s, after_s] =
                    [-TEMPO_STEP_S, TEMPO_STEP_S].map(|by_s| map.physical_s(acted_s + by_s));
                let rate = 2.0 * TEMPO_STEP_S / (after_s - before_s);
                (map.physical_s(acted_s), rate)
            }
        }
    }
}

/// The motions of the scene's held bodies; `flown` are the physical times of the samples of flights.
pub(in crate::estimate) fn estimates(
    scene: &Scene,
    sketch: &Sketch,
    problem: &Problem,
    point: &Point,
    flown: &[SampleTime],
) -> Vec<HeldEstimate> {
    let mut estimates = Vec::new();
    let tracks: &TiSlice<TrackIndex, TrackSketch> = &sketch.tracks;
    for (track, of) in tracks.iter_enumerated() {
        let Some(motion) = &of.held else { continue };
        let link = scene.tracks[track].link;
        let at_hits = problem.held.iter().zip(&point.held);
        let hits = at_hits.filter(|(held, _)| held.track == track && held.link == link);
        let hits: Vec<(&HeldState, &State)> = hits.collect();
        let Some(pace) = pace(
            scene,
            sketch,
            hits.first().map(|(held, _)| *held),
            point,
            flown,
        ) else {
            continue;
        };
        let mount = match hits.first() {
            Some((held, _)) => held.mount_at(&point.parameters),
            None => scene.tracks[track].link_from_tracker,
        };
        let (knots, times) = in_time(track, &of.samples, motion, &mount, &pace);
        let passed = passed(sketch, motion, &hits, point, &pace);
        estimates.push(HeldEstimate::new(link, knots, passed, times));
    }
    estimates
}

/// The states of a held body at its events.
fn passed(
    sketch: &Sketch,
    motion: &HeldMotion,
    hits: &[(&HeldState, &State)],
    point: &Point,
    pace: &Pace,
) -> Vec<Passed> {
    let passed = hits.iter().map(|(held, state)| Passed {
        event: held.event,
        time_s: point.event_times_s[held.event],
        state: **state,
        fading_s: fading_s(motion, held.event) / pace.at(sketch.marks_s[held.event]).1,
        off: [0.0; 2],
    });
    passed.collect()
}

/// The motions of what is in a hand for a while, between the estimated `events`; `flown` are the physical times of the samples
/// of flights.
pub(in crate::estimate) fn grips(
    scene: &Scene,
    sketch: &Sketch,
    problem: &Problem,
    point: &Point,
    events: &[EventEstimate],
    flown: &[SampleTime],
) -> Vec<GripEstimate> {
    let phases = scene.phases.iter().enumerate();
    let gripped = phases.filter_map(|(index, phase)| {
        let hand = phase.in_hand()?;
        let motion = sketch.grip(index)?;
        let at_ends = problem.held.iter().zip(&point.held);
        let hits = at_ends
            .filter(|(held, _)| held.link == phase.link && phase.events.contains(&held.event));
        let hits: Vec<(&HeldState, &State)> = hits.collect();
        let first = hits.first().map(|(held, _)| *held);
        let pace = pace(scene, sketch, first, point, flown)?;
        let mount = first.map_or(hand.link_from_tracker, |held| {
            held.mount_at(&point.parameters)
        });
        let is_own = scene.seen_in_hand(phase).is_some();
        let [from_s, until_s] = phase.events.map(|event| sketch.marks_s[event]);
        // Those of a hand are told with it.
        let is_its = |of: &&Sample| is_own && of.acted_s >= from_s && of.acted_s <= until_s;
        let samples = sketch.tracks[hand.track].samples.iter();
        let samples: Vec<Sample> = samples.filter(is_its).cloned().collect();
        let (knots, times) = in_time(hand.track, &samples, motion, &mount, &pace);
        let span_s = phase.events.map(|event| events[event].time_s);
        let passed = passed(sketch, motion, &hits, point, &pace);
        Some(GripEstimate {
            phase: index,
            span_s,
            motion: HeldEstimate::new(phase.link, over(knots, span_s), passed, times),
        })
    });
    let mut grips: Vec<GripEstimate> = gripped.collect();
    grips.sort_by(|a, b| {
        let order = a.motion.link.cmp(&b.motion.link);
        order.then(a.span_s[0].total_cmp(&b.span_s[0]))
    });
    grips
}

/// In an unknown tempo, sets the times of events at which a hand begins or ends before or after all samples of flights: the
/// hand moves on in the tempo of the nearest of these.
pub(in crate::estimate) fn place(
    problem: &Problem,
    sketch: &Sketch,
    flown: &[SampleTime],
    events: &mut [EventEstimate],
) {
    let nodes_s = &problem.nodes_acted_s;
    let Some((first_s, last_s)) = nodes_s.first().zip(nodes_s.last()) else {
        return;
    };
    let map = TimeMap::new(flown, sketch.origin).filter(|_| problem.times_are_unknown());
    for event in problem.grips.iter().flatten() {
        let acted_s = problem.events_acted_s[*event];
        let is_within = (*first_s..=*last_s).contains(&acted_s);
        if let Some(map) = &map
            && !problem.event_is_free[*event]
            && !is_within
        {
            events[*event].time_s = map.physical_s(acted_s);
            events[*event].is_fixed = false;
        }
    }
}

/// From the first beginning of an arc, or of what a hand does, to the last end \[s\].
pub(in crate::estimate) fn lasting_s(
    problem: &Problem,
    arcs: &[ArcEstimate],
    events: &[EventEstimate],
) -> f64 {
    let grips = problem.grips.iter();
    let grips = grips.map(|ends| ends.map(|event| events[event].time_s));
    let spans = arcs.iter().map(|arc| [arc.start_s, arc.end_s]).chain(grips);
    let whole = spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    whole.map_or(0.0, |[from_s, to_s]| to_s - from_s)
}

/// Knots that reach as far as a span, by the motion at their ends.
pub(in crate::estimate) fn over(mut knots: Vec<Knot>, span_s: [f64; 2]) -> Vec<Knot> {
    let curve = Curve::new(knots.clone());
    let [first_s, last_s] = [0, knots.len() - 1].map(|at| knots[at].time_s);
    let at = |time_s: f64| Knot {
        time_s,
        driven: curve.at(time_s),
    };
    if span_s[0] < first_s {
        knots.insert(0, at(span_s[0]));
    }
    if span_s[1] > last_s {
        knots.push(at(span_s[1]));
    }
    knots
}

/// The smoothed motion of a body whose tracker is mounted so, and its samples, in physical time.
pub(in crate::estimate) fn in_time(
    track: TrackIndex,
    samples: &[Sample],
    motion: &HeldMotion,
    mount: &Pose,
    pace: &Pace,
) -> (Vec<Knot>, Vec<SampleTime>) {
    let knots = motion.curve.knots().iter().map(|knot| {
        let (time_s, rate) = pace.at(knot.time_s);
        Knot {
            time_s,
            driven: Mounted::new(&knot.driven, mount).driven.at_rate(rate),
        }
    });
    let times = samples.iter().map(|sample| SampleTime {
        track,
        stamp: sample.stamp,
        time_s: pace.at(sample.acted_s).0,
        is_open: false,
    });
    (knots.collect(), times.collect())
}

/// `None` where an unknown tempo has no map.
fn pace(
    scene: &Scene,
    sketch: &Sketch,
    hit: Option<&HeldState>,
    point: &Point,
    flown: &[SampleTime],
) -> Option<Pace> {
    if matches!(scene.timing, Timing::Unknown { .. }) {
        return TimeMap::new(flown, sketch.origin).map(Pace::Map);
    }
    let [slow, offset_s] = hit.map_or([0.0; 2], |held| held.clock_at(&point.parameters));
    Some(Pace::Clock {
        zero_s: point.node_times_s.first().copied().unwrap_or(0.0),
        offset_s,
        slow,
    })
}

/// In acted time \[s\].
fn fading_s(motion: &HeldMotion, event: usize) -> f64 {
    let meeting = motion.meeting(event);
    let covariance = meeting.map(|meeting| &meeting.covariance);
    covariance.map_or(0.0, |p| FADING * (p[(0, 0)] / p[(6, 6)]).sqrt())
}
