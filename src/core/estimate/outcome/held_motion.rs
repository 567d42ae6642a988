//! The motions of held bodies in physical time, as estimated.

use typed_index_collections::TiSlice;

use crate::estimate::problem::{HeldState, Problem};
use crate::estimate::unknowns::point::Point;
use crate::math::Pose;
use crate::motion::held::{HeldEstimate, Knot, Mounted, Passed};
use crate::motion::{
    HeldMotion, SampleTime, Scene, Sketch, TimeMap, Timing, TrackIndex, TrackSketch,
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
        let hits = at_hits.filter(|(held, _)| held.track == track);
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
        let (knots, times) = in_time(track, of, motion, &mount, &pace);
        let passed = hits.iter().map(|(held, state)| Passed {
            event: held.event,
            time_s: point.event_times_s[held.event],
            state: **state,
            fading_s: fading_s(motion, held.event) / pace.at(sketch.marks_s[held.event]).1,
            off: [0.0; 2],
        });
        estimates.push(HeldEstimate::new(link, knots, passed.collect(), times));
    }
    estimates
}

/// The smoothed motion of a body whose tracker is mounted so, and its samples, in physical time.
pub(in crate::estimate) fn in_time(
    track: TrackIndex,
    of: &TrackSketch,
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
    let times = of.samples.iter().map(|sample| SampleTime {
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
