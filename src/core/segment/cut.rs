//! Cuts the stream of each track of a flying body into segments at the marks.

use std::ops::Range;

use super::error::SegmentError;
use crate::motion::{
    EventKind, MechanismIndex, Scene, Segment, Sketch, Timing, TrackIndex, TrackSketch, View,
};

/// Samples closer to a collision's mark than this many median intervals are left out, as in the
/// paper: they may belong to either side, and a sample that changed sides would make the objective
/// discontinuous.
const NEAR_COLLISION_INTERVALS: f64 = 1.0;

/// Least number of samples of a segment that no collision begins; two poses already have as many
/// numbers as a state.
pub const SAMPLES_MIN: usize = 3;

/// Least number of samples of a segment. A flight that a collision begins needs none, nor one that begins
/// in a hand: the impact or the hand tells its state. Of keyframes one is enough: those of other flights tell the rest.
pub fn samples_min(scene: &Scene, sketch: &Sketch, start_event: Option<usize>) -> usize {
    let is_told = start_event.is_some_and(|event| {
        let kind = &scene.events[event].kind;
        let lets_go = |link| scene.hand_beside(scene.mechanism_of(link), event, false);
        kind.collision().is_some() || kind.change().is_some_and(lets_go)
    });
    match is_told {
        true => 0,
        false if scene.is_keyframed(sketch) => 1,
        false => SAMPLES_MIN,
    }
}

/// Cuts the samples of every flying mechanism's tracks at the events that it takes part in; all take part in
/// `start` and `end`. Fails where a segment has fewer samples than [`samples_min`].
///
/// Segments come in order of their ends, so that neighbours in time are neighbours in the list.
pub fn cut(scene: &Scene, sketch: &Sketch) -> Result<Vec<Segment>, SegmentError> {
    let mut segments = Vec::new();
    // What is held or apart does not fly here.
    for mechanism in scene.mechanisms.keys().filter(|of| scene.moves(*of)) {
        cut_mechanism(scene, sketch, mechanism, &mut segments)?;
    }
    segments.sort_by_key(|segment| segment.end_event.unwrap_or(usize::MAX));
    Ok(segments)
}

fn cut_mechanism(
    scene: &Scene,
    sketch: &Sketch,
    mechanism: MechanismIndex,
    segments: &mut Vec<Segment>,
) -> Result<(), SegmentError> {
    let tracks = scene.tracks_of(mechanism);
    // In an edited sketch, and of keyframes, no sample may belong to either side of a collision.
    let window_s = |track: TrackIndex| {
        if scene.timing == Timing::Edited || scene.has_keyframes(sketch, track) {
            0.0
        } else {
            NEAR_COLLISION_INTERVALS * median_interval_s(&sketch.tracks[track])
        }
    };
    let tracks: Vec<(TrackIndex, f64)> = tracks.map(|track| (track, window_s(track))).collect();
    let is = |event: Option<usize>, kind: &EventKind| {
        event.is_some_and(|event| scene.events[event].kind == *kind)
    };
    let events = (0..scene.events.len()).filter(|event| scene.concerns(*event, mechanism));
    let mut start_event = None;
    for end_event in events.map(Some).chain([None]) {
        let is_driven = scene.is_in_hand(mechanism, [start_event, end_event]);
        let is_within = !is(end_event, &EventKind::Start) && !is(start_event, &EventKind::End);
        if is_within && !is_driven {
            let views = tracks.iter().map(|(track, window_s)| View {
                track: *track,
                samples: between(scene, sketch, *track, [start_event, end_event], *window_s),
            });
            let segment = Segment {
                mechanism,
                start_event,
                end_event,
                views: views.collect(),
            };
            let expected = samples_min(scene, sketch, start_event);
            if segment.sample_count() < expected {
                let name = |event: Option<usize>, otherwise: &str| {
                    event.map_or(otherwise.into(), |e| format!("`{}`", scene.events[e].name))
                };
                return Err(SegmentError::TooFewSamples {
                    body: scene.name_of_mechanism(mechanism).to_owned(),
                    samples: segment.sample_count(),
                    expected,
                    from: name(start_event, "the beginning"),
                    to: name(end_event, "the end of the data"),
                });
            }
            segments.push(segment);
        }
        start_event = end_event;
    }
    Ok(())
}

/// The samples of a track between two events; those within a window of a collision are left out.
fn between(
    scene: &Scene,
    sketch: &Sketch,
    track: TrackIndex,
    [start, end]: [Option<usize>; 2],
    window_s: f64,
) -> Range<usize> {
    let samples = &sketch.tracks[track].samples;
    let marks_s = &sketch.marks_s;
    let window_s = |event: usize| match scene.events[event].kind {
        EventKind::Change(link) => {
            let mechanism = scene.mechanism_of(link);
            let is_hand = |is_after| scene.hand_beside(mechanism, event, is_after);
            let is_beside = is_hand(false) || is_hand(true) || scene.jolts(event);
            if is_beside { window_s } else { 0.0 }
        }
        EventKind::Start | EventKind::Waypoint(_) | EventKind::End => 0.0,
        EventKind::Collision(_) | EventKind::Collisions { .. } => window_s,
    };
    let ended = |event: usize| {
        let until_s = marks_s[event] - window_s(event);
        samples.partition_point(|sample| sample.acted_s <= until_s)
    };
    let first = start.map_or(0, |event| {
        let from_s = sketch.left_s(event) + window_s(event);
        let begun = samples.partition_point(|sample| sample.acted_s < from_s);
        // A sample at the mark belongs to the flight that ends there, if one does.
        match scene.events[event].kind {
            EventKind::Start => begun,
            _ => begun.max(ended(event)),
        }
    });
    first..end.map_or(samples.len(), ended).max(first)
}

/// Median interval between a track's samples \[s\]; zero for fewer than two.
pub fn median_interval_s(track: &TrackSketch) -> f64 {
    let mut intervals: Vec<f64> = track
        .samples
        .windows(2)
        .map(|pair| pair[1].acted_s - pair[0].acted_s)
        .collect();
    if intervals.is_empty() {
        return 0.0;
    }
    let middle = intervals.len() / 2;
    *intervals.select_nth_unstable_by(middle, f64::total_cmp).1
}
