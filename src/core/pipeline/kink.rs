//! Where a motion has a kink, told by what it leaves of the samples.
//!
//! A hand wanders slowly, so that what flies past a place at which it is caught is led there at a wrong moment; the samples
//! between both moments are then compared with the wrong arc. What is left of them changes at once there, and steadily
//! on either side where they are cut at the kink:
//!
//! ```text
//! min over k   Σ |r_{i+1} − r_i|²,   r_i of the arc before for i < k, of the arc after from k on
//! ```
//!
//! without the step from one to the other, as both arcs are where the hand led them.

use nalgebra::Vector3;

use super::warm::Known;
use crate::motion::{ArcEstimate, Scene, Seen, Sketch, TrackIndex};

/// Reach of the search on either side of an event \[s\].
const REACH_S: f64 = 0.08;

/// Least number of samples there.
const LEAST: usize = 6;

/// Share of the sum at the event below which the cut is moved.
const SHARE: f64 = 0.5;

/// The time at which samples show that a body was caught \[s, physical\], where that is not when its event is estimated.
pub(super) fn caught_s(known: &Known, scene: &Scene, sketch: &Sketch, event: usize) -> Option<f64> {
    let link = scene.events[event].kind.change()?;
    let mechanism = scene.mechanism_of(link);
    let phase = scene.phase_beside(mechanism, event, true)?;
    if phase.on_surface().is_some() {
        return None;
    }
    let mut events = known.estimate.events.iter();
    let event_s = events.find(|of| of.event == event)?.time_s;
    let own = |arc: &&ArcEstimate| arc.mechanism == mechanism;
    let mut arcs = known.estimate.arcs.iter().filter(own);
    let before = arcs.clone().find(|arc| arc.end_s == event_s)?;
    let after = arcs.find(|arc| arc.start_s == event_s)?;
    let tracks = scene.tracks_of(mechanism);
    let left = tracks.map(|track| {
        let left = |arc| left_m(known, scene, sketch, track, arc, event_s);
        (left(before), left(after))
    });
    let (before, after) = left.max_by_key(|(before, _)| before.len())?;
    if before.len() < LEAST {
        return None;
    }
    let roughness = |cut: usize| {
        let sides = [&before[..cut], &after[cut..]];
        let steps = sides.iter().flat_map(|side| side.windows(2));
        steps
            .map(|of| (of[1].1 - of[0].1).norm_squared())
            .sum::<f64>()
    };
    let now = before.partition_point(|(time_s, _)| *time_s <= event_s);
    let cuts = 1..before.len();
    let best = cuts.min_by(|a, b| roughness(*a).total_cmp(&roughness(*b)))?;
    let is_better = roughness(best) < SHARE * roughness(now);
    is_better.then(|| 0.5 * (before[best - 1].0 + before[best].0))
}

/// What an arc leaves of a track's places about a time \[s, m\].
fn left_m(
    known: &Known,
    scene: &Scene,
    sketch: &Sketch,
    track: TrackIndex,
    arc: &ArcEstimate,
    about_s: f64,
) -> Vec<(f64, Vector3<f64>)> {
    let samples = &sketch.tracks[track].samples;
    let point_m = scene.tracks[track].point_m();
    let times = known.estimate.sample_times.iter();
    let near = times.filter(|of| of.track == track && (of.time_s - about_s).abs() < REACH_S);
    let mut left: Vec<(f64, Vector3<f64>)> = near
        .filter_map(|of| {
            let at = samples.binary_search_by_key(&of.stamp, |sample| sample.stamp);
            let seen = &samples[at.ok()?].seen;
            let state = scene.flown(arc, &known.estimate.gravity_m_s2, of.time_s);
            let lever_m = match seen {
                Seen::Point(_) => state.orientation * point_m,
                _ => Vector3::zeros(),
            };
            Some((of.time_s, seen.position_m()? - lever_m - state.position_m))
        })
        .collect();
    left.sort_by(|a, b| a.0.total_cmp(&b.0));
    left
}
