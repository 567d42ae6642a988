//! Cuts the stream of each track of a flying body into segments at the marks.

use super::error::SegmentError;
use crate::motion::{EventKind, Scene, Segment, Sketch, Timing, TrackIndex, TrackSketch};

/// Samples closer to a collision's mark than this many median intervals are left out, as in the
/// paper: they may belong to either side, and a sample that changed sides would make the objective
/// discontinuous.
const NEAR_COLLISION_INTERVALS: f64 = 1.0;

/// Least number of samples of a segment that no collision begins; two poses already have as many
/// numbers as a state.
pub const SAMPLES_MIN: usize = 3;

/// Least number of samples of a segment. A flight that a collision begins needs none: the impact
/// hands its state on.
pub fn samples_min(scene: &Scene, start_event: Option<usize>) -> usize {
    let begins = start_event.and_then(|event| scene.events[event].kind.collision());
    if begins.is_some() { 0 } else { SAMPLES_MIN }
}

/// Cuts the samples of every track of a flying body at the events it takes part in; all tracks take
/// part in `start` and `end`. Fails where a segment has fewer samples than [`samples_min`].
///
/// Segments come in order of their ends, so that neighbours in time are neighbours in the list.
pub fn cut(scene: &Scene, sketch: &Sketch) -> Result<Vec<Segment>, SegmentError> {
    let mut segments = Vec::new();
    // What is held does not fly.
    for track in scene.tracks.keys().filter(|track| !scene.sees_held(*track)) {
        cut_track(scene, sketch, track, &mut segments)?;
    }
    segments.sort_by_key(|segment| segment.end_event.unwrap_or(usize::MAX));
    Ok(segments)
}

fn cut_track(
    scene: &Scene,
    sketch: &Sketch,
    track: TrackIndex,
    segments: &mut Vec<Segment>,
) -> Result<(), SegmentError> {
    let samples = &sketch.tracks[track].samples;
    // In an edited sketch no sample belongs to either side.
    let window_s = match scene.timing {
        Timing::Edited => 0.0,
        Timing::Known | Timing::Unknown { .. } => {
            NEAR_COLLISION_INTERVALS * median_interval_s(&sketch.tracks[track])
        }
    };
    let mut start_event = None;
    let mut first = 0;
    let mechanism = scene.mechanism_seen_by(track);
    let cuts = (0..scene.events.len()).filter(|event| scene.concerns(*event, mechanism));
    for end_event in cuts.map(Some).chain([None]) {
        let is_collision = |event: Option<usize>| {
            event.is_some_and(|e| scene.events[e].kind.collision().is_some())
        };
        let (until_s, next_s) = match end_event {
            Some(event) if is_collision(end_event) => (
                sketch.marks_s[event] - window_s,
                sketch.marks_s[event] + window_s,
            ),
            Some(event) => (sketch.marks_s[event], sketch.marks_s[event]),
            None => (f64::INFINITY, f64::INFINITY),
        };
        let end = samples
            .partition_point(|sample| sample.acted_s <= until_s)
            .max(first);
        let is_start = end_event.is_some_and(|e| scene.events[e].kind == EventKind::Start);
        let past_end = start_event.is_some_and(|e: usize| scene.events[e].kind == EventKind::End);
        if !is_start && !past_end {
            let expected = samples_min(scene, start_event);
            if end - first < expected {
                let name = |event: Option<usize>, otherwise: &str| {
                    event.map_or(otherwise.into(), |e| format!("`{}`", scene.events[e].name))
                };
                return Err(SegmentError::TooFewSamples {
                    body: scene.link_seen_by(track).name.clone(),
                    samples: end - first,
                    expected,
                    from: name(start_event, "the beginning"),
                    to: name(end_event, "the end of the data"),
                });
            }
            segments.push(Segment {
                mechanism,
                start_event,
                end_event,
                track,
                samples: first..end,
            });
        }
        first = if is_start {
            samples.partition_point(|sample| sample.acted_s < next_s)
        } else {
            samples
                .partition_point(|sample| sample.acted_s < next_s)
                .max(end)
        };
        start_event = end_event;
    }
    Ok(())
}

/// Median interval between a track's samples \[s\]; zero for fewer than two.
pub fn median_interval_s(track: &TrackSketch) -> f64 {
    let mut intervals: Vec<f64> = track
        .samples
        .windows(2)
        .map(|pair| pair[1].acted_s - pair[0].acted_s)
        .collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}
