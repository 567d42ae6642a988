//! Cleans a take: from readings in any order to poses of bodies in order of time, with counts of
//! both.

use std::cell::LazyCell;
use std::cmp::Ordering;
use std::collections::BTreeMap;

use nalgebra::{Quaternion, UnitQuaternion};
use typed_index_collections::{TiSlice, TiVec};

use super::complete::completed;
use super::edited::join;
use super::error::SegmentError;
use super::marks::{
    Extent, annotated_sd_s, check_extents, mark_sd_s, matched, put_at_the_ends, seconds, union,
};
use super::outliers::drop_outliers;
use super::reading::Reading;
use super::refine::reach_s;
use super::seen::{covariances, seen, show};
use super::units::check_units;
use crate::motion::{
    DropReason, EventKind, Holds, Mark, MarkTime, Sample, SampleCounts, Scene, Seen, Sketch, Stamp,
    TakeEvent, Timing, Track, TrackIndex, TrackSketch,
};

/// Greatest deviation of a quaternion's norm from 1 for the reading to be used: programs round, and some average.
const NORM_LIMIT: f64 = 0.1;

/// Greatest deviation that is not counted as repaired.
const NORM_ROUNDING: f64 = 1e-6;

/// An interval is a gap if it is longer than this many median ones.
const GAP_RATIO: f64 = 2.5;

/// Longest take \[s\].
const SPAN_LIMIT_S: f64 = 86_400.0;

/// Readings by track and stream.
type SegmentStreams = TiVec<TrackIndex, Vec<Vec<Reading>>>;

/// The sketch of a take, with counts of its samples: streams sorted by stamp, without unusable
/// readings, as poses of the bodies, from the scene's start event to its end.
///
/// Of readings with the same stamp the least in a fixed order of their numbers is kept, so that
/// the sketch does not depend on the order of arrival; only `reordered` does. `used` counts all
/// samples of the sketch.
pub fn clean(scene: &Scene, events: &[TakeEvent]) -> Result<(Sketch, SampleCounts), SegmentError> {
    if scene.timing == Timing::Edited {
        return clean_edited(scene, events);
    }
    let Usable {
        mut streams,
        marks,
        extents,
        mut counts,
    } = usable(scene, events, false)?;
    let whole = union(&extents).expect("a scene has tracks");
    let mut stamps = match matched(scene, &marks, whole.first) {
        Err(error @ SegmentError::MarkCount { .. }) => {
            let all = sketch(scene, events, &streams, &[], &mut SampleCounts::default());
            let (stamps, changes) = completed(scene, &marks, &all, error)?;
            counts.marks = changes;
            stamps
        }
        stamps => stamps?,
    };
    let slack_ns = streams.iter().map(|s| gap_limit_ns(s)).max().unwrap_or(0);
    let reach_ns = (reach_s(scene) * 1e9) as i64;
    counts.marks.late = put_at_the_ends(scene, &mut stamps, whole, slack_ns, reach_ns);
    check_extents(scene, &stamps, &extents, slack_ns)?;
    for (track, stream) in streams.iter_mut_enumerated() {
        let read = stream.len();
        let mut dropped = SampleCounts::default();
        drop_outside(scene, &stamps, stream, &mut dropped);
        if stream.is_empty() {
            return Err(no_samples_of(scene, track, 0, read, &dropped));
        }
        merge(&mut counts, &dropped);
    }
    let mut sketch = sketch(scene, events, &streams, &stamps, &mut counts);
    let annotated_s = LazyCell::new(|| annotated_sd_s(scene, &sketch.tracks));
    for (event, mark) in sketch.marks.iter_mut().enumerate() {
        let changed = [&counts.marks.proposed, &counts.marks.late];
        let is_own = !changed.iter().any(|events| events.contains(&event));
        let sd_s = mark_sd_s(scene, event, || *annotated_s);
        *mark = (is_own && sd_s > 0.0).then_some(MarkTime {
            acted_s: sketch.marks_s[event],
            sd_s,
            counted: 1.0,
        });
    }
    for (track, seen) in sketch.tracks.iter_enumerated() {
        check_units(scene.link_seen_by(track), &seen.samples)?;
    }
    Ok((sketch, counts))
}

/// [`clean`] for an edited sketch: every segment by itself, then joined. Marks are ignored.
fn clean_edited(
    scene: &Scene,
    events: &[TakeEvent],
) -> Result<(Sketch, SampleCounts), SegmentError> {
    let mut counts = SampleCounts::default();
    let (mut streams, _) = delivered(scene, events, &mut counts)?;
    for (track, segments) in streams.iter_mut_enumerated() {
        for (number, stream) in segments.iter_mut().enumerate() {
            let read = stream.len();
            let mut dropped = SampleCounts::default();
            drop_unusable(stream, &scene.tracks[track], false, &mut dropped);
            if stream.is_empty() {
                return Err(no_samples_of(scene, track, number, read, &dropped));
            }
            merge(&mut counts, &dropped);
        }
    }
    let (streams, stamps) = join(scene, &streams, SPAN_LIMIT_S)?;
    let sketch = sketch(scene, events, &streams, &stamps, &mut counts);
    for (track, seen) in sketch.tracks.iter_enumerated() {
        check_units(scene.link_seen_by(track), &seen.samples)?;
    }
    Ok((sketch, counts))
}

/// The sketch of a whole take without marks; those of the take are ignored.
pub fn unmarked(scene: &Scene, events: &[TakeEvent]) -> Result<Sketch, SegmentError> {
    let Usable {
        streams,
        mut counts,
        ..
    } = usable(scene, events, false)?;
    Ok(sketch(scene, events, &streams, &[], &mut counts))
}

/// [`unmarked`], where everything may rest: poses that repeat count.
pub fn standing(scene: &Scene, events: &[TakeEvent]) -> Result<Sketch, SegmentError> {
    let Usable {
        streams,
        mut counts,
        ..
    } = usable(scene, events, true)?;
    Ok(sketch(scene, events, &streams, &[], &mut counts))
}

/// The usable part of a take.
struct Usable {
    /// Readings by track, in order of time; none is empty.
    streams: TiVec<TrackIndex, Vec<Reading>>,
    marks: Vec<Mark>,
    extents: TiVec<TrackIndex, Extent>,
    counts: SampleCounts,
}

fn usable(
    scene: &Scene,
    events: &[TakeEvent],
    all_may_stand: bool,
) -> Result<Usable, SegmentError> {
    let mut counts = SampleCounts::default();
    let (streams, marks) = delivered(scene, events, &mut counts)?;
    let streams = streams.into_iter().map(|streams| streams.concat());
    let mut streams: TiVec<TrackIndex, _> = streams.collect();
    let mut extents = TiVec::new();
    for (track, stream) in streams.iter_mut_enumerated() {
        let read = stream.len();
        let mut dropped = SampleCounts::default();
        let extent = extent(&scene.tracks[track], stream);
        // What is in a hand, or rests, may be seen where it was.
        let link = scene.tracks[track].link;
        let has_phase = scene.phases.iter().any(|phase| phase.link == link);
        let may_stand = all_may_stand || scene.sees_held(track) || has_phase;
        drop_unusable(stream, &scene.tracks[track], may_stand, &mut dropped);
        extents.push(extent.ok_or_else(|| no_samples_of(scene, track, 0, read, &dropped))?);
        merge(&mut counts, &dropped);
    }
    let whole = union(&extents).expect("a scene has tracks");
    let span_s = seconds(whole.last, whole.first);
    if span_s > SPAN_LIMIT_S {
        return Err(SegmentError::Span {
            span_s,
            limit_s: SPAN_LIMIT_S,
        });
    }
    for stream in &mut streams {
        // Where times are not known, or readings show different parts, a path says nothing of jumps.
        let is_path = stream
            .iter()
            .all(|reading| !reading.is_open && reading.holds == stream[0].holds);
        if is_path {
            drop_outliers(stream, &mut counts);
        }
    }
    Ok(Usable {
        streams,
        marks,
        extents,
        counts,
    })
}

/// Readings by track and stream, and the marks; there is at least one reading.
fn delivered(
    scene: &Scene,
    events: &[TakeEvent],
    counts: &mut SampleCounts,
) -> Result<(SegmentStreams, Vec<Mark>), SegmentError> {
    let delivered = sorted(scene, events, counts)?;
    if counts.read > 0 {
        return Ok(delivered);
    }
    let topics = scene
        .tracks
        .iter()
        .map(|track| format!("{:?}", track.topic));
    Err(SegmentError::NoSamples {
        topics: topics.collect::<Vec<String>>().join(", "),
    })
}

/// Readings by track and stream, and the marks, in an order that arrival does not change.
fn sorted(
    scene: &Scene,
    events: &[TakeEvent],
    counts: &mut SampleCounts,
) -> Result<(SegmentStreams, Vec<Mark>), SegmentError> {
    let tracks = scene.tracks.keys();
    let count: usize = tracks.clone().map(|track| scene.streams(track)).sum();
    // As many as there are if every stream has as many.
    let readings = || Vec::with_capacity(events.len().div_ceil(count.max(1)));
    let mut streams: SegmentStreams = tracks
        .map(|track| (0..scene.streams(track)).map(|_| readings()).collect())
        .collect();
    let mut latest: BTreeMap<(TrackIndex, usize), Stamp> = BTreeMap::new();
    let mut marks = Vec::new();
    for (index, event) in events.iter().enumerate() {
        match event {
            TakeEvent::Mark(mark) => marks.push(mark.clone()),
            TakeEvent::Pose {
                track,
                stream,
                sample,
            } => {
                let Some(of_track) = streams.get_mut(*track) else {
                    return Err(SegmentError::NoSuchTrack {
                        track: usize::from(*track),
                        tracks: scene.tracks.len(),
                    });
                };
                let count = of_track.len();
                let samples =
                    of_track
                        .get_mut(*stream)
                        .ok_or_else(|| SegmentError::NoSuchStream {
                            body: scene.link_seen_by(*track).name.clone(),
                            stream: stream.saturating_add(1),
                            streams: count,
                        })?;
                counts.read += 1;
                let latest = latest.entry((*track, *stream)).or_insert(sample.stamp);
                counts.reordered += usize::from(*latest > sample.stamp);
                *latest = sample.stamp.max(*latest);
                samples.push(Reading::new(index, sample));
            }
        }
    }
    for stream in streams.iter_mut().flatten() {
        stream.sort_by(by_stamp_then_numbers);
    }
    Ok((streams, marks))
}

fn by_stamp_then_numbers(a: &Reading, b: &Reading) -> Ordering {
    let numbers = |s: &Reading| {
        let [x, y, z, w] = s.quaternion_xyzw;
        [s.position_m.x, s.position_m.y, s.position_m.z, x, y, z, w]
    };
    a.stamp.cmp(&b.stamp).then_with(|| {
        numbers(a)
            .iter()
            .zip(&numbers(b))
            .map(|(a, b)| a.total_cmp(b))
            .find(|order| order.is_ne())
            .unwrap_or(Ordering::Equal)
    })
}

/// Drops readings that are no pose, repeat a stamp, or repeat the pose before them bit for bit, unless
/// what they show may stand still.
fn drop_unusable(
    stream: &mut Vec<Reading>,
    track: &Track,
    may_stand: bool,
    counts: &mut SampleCounts,
) {
    let mut kept: usize = 0;
    for index in 0..stream.len() {
        let reason = unusable(track, &mut stream[index]).or_else(|| {
            let (sample, previous) = (&stream[index], &stream[kept.checked_sub(1)?]);
            if previous.stamp == sample.stamp {
                Some(DropReason::Duplicate)
            } else if !may_stand && same_bits(previous, sample) {
                Some(DropReason::Frozen)
            } else {
                None
            }
        });
        match reason {
            Some(reason) => counts.drop(reason, 1),
            None => {
                stream.swap(kept, index);
                kept += 1;
            }
        }
    }
    stream.truncate(kept);
}

/// Why a reading is not used; one that is used keeps only what its track sees.
fn unusable(track: &Track, sample: &mut Reading) -> Option<DropReason> {
    if !show(track, sample) {
        return Some(DropReason::NotSeen);
    }
    let finite = sample
        .position_m
        .iter()
        .chain(&sample.quaternion_xyzw)
        .all(|x| x.is_finite());
    if !finite {
        return Some(DropReason::NotFinite);
    }
    // Not `> NORM_LIMIT`: a norm that overflowed is no unit either.
    let near_unit = (norm(sample) - 1.0).abs() <= NORM_LIMIT;
    (!near_unit).then_some(DropReason::NotUnit)
}

fn same_bits(a: &Reading, b: &Reading) -> bool {
    let bits = |s: &Reading| {
        (
            [s.position_m.x, s.position_m.y, s.position_m.z].map(f64::to_bits),
            s.quaternion_xyzw.map(f64::to_bits),
        )
    };
    bits(a) == bits(b)
}

fn norm(sample: &Reading) -> f64 {
    let [x, y, z, w] = sample.quaternion_xyzw;
    Quaternion::new(w, x, y, z).norm()
}

/// Drops readings before the start and after the end, if the scene has these events.
fn drop_outside(
    scene: &Scene,
    stamps: &[Stamp],
    stream: &mut Vec<Reading>,
    counts: &mut SampleCounts,
) {
    let of = |kind: EventKind| {
        let event = scene.events.iter().position(|event| event.kind == kind);
        event.map(|event| stamps[event])
    };
    let (start, end) = (of(EventKind::Start), of(EventKind::End));
    stream.retain(|sample| {
        let reason = if start.is_some_and(|start| sample.stamp < start) {
            DropReason::BeforeStart
        } else if end.is_some_and(|end| sample.stamp > end) {
            DropReason::AfterEnd
        } else {
            return true;
        };
        counts.drop(reason, 1);
        false
    });
}

/// From the first pose to the last, including repeated poses: marks made while the tracker was at
/// rest are within the data.
fn extent(track: &Track, stream: &[Reading]) -> Option<Extent> {
    let usable = |sample: &&Reading| {
        let mut sample = **sample;
        unusable(track, &mut sample).is_none()
    };
    Some(Extent {
        first: stream.iter().find(usable)?.stamp,
        last: stream.iter().rfind(usable)?.stamp,
    })
}

fn no_samples_of(
    scene: &Scene,
    track: TrackIndex,
    stream: usize,
    read: usize,
    dropped: &SampleCounts,
) -> SegmentError {
    let reasons: Vec<String> = dropped
        .dropped
        .iter()
        .map(|(reason, count)| format!(", {count} {}", reason.said()))
        .collect();
    SegmentError::NoSamplesOfBody {
        body: scene.link_seen_by(track).name.clone(),
        topic: scene.stream_topic(track, stream),
        read,
        dropped: reasons.concat(),
    }
}

fn merge(counts: &mut SampleCounts, more: &SampleCounts) {
    for (reason, count) in &more.dropped {
        counts.drop(*reason, *count);
    }
}

/// Interval above which there is a gap in the stream \[ns\].
fn gap_limit_ns(stream: &[Reading]) -> i64 {
    let mut intervals: Vec<i64> = stream
        .windows(2)
        .map(|pair| pair[1].stamp.0 - pair[0].stamp.0)
        .collect();
    intervals.sort_unstable();
    let median = intervals.get(intervals.len() / 2).copied().unwrap_or(0);
    (median as f64 * GAP_RATIO) as i64
}

/// Poses of links since the first kept sample, unit quaternions of continuous sign.
fn sketch(
    scene: &Scene,
    events: &[TakeEvent],
    streams: &TiSlice<TrackIndex, Vec<Reading>>,
    stamps: &[Stamp],
    counts: &mut SampleCounts,
) -> Sketch {
    let origin = streams
        .iter()
        .filter_map(|stream| Some(stream.first()?.stamp))
        .min()
        .expect("every track has samples");
    let mut tracks = TiVec::new();
    for (stream, track) in streams.iter().zip(&scene.tracks) {
        let limit_ns = gap_limit_ns(stream);
        counts.gaps += stream
            .windows(2)
            .filter(|pair| pair[1].stamp.0 - pair[0].stamp.0 > limit_ns)
            .count();
        counts.used += stream.len();
        let tracker_from_link = track.link_from_tracker.inverse();
        let mut samples: Vec<Sample> = Vec::with_capacity(stream.len());
        let mut open_times_s = BTreeMap::new();
        let mut last: Option<UnitQuaternion<f64>> = None;
        for reading in stream {
            let holds_orientation = matches!(reading.holds, Holds::Pose | Holds::Orientation);
            let is_off = holds_orientation && (norm(reading) - 1.0).abs() > NORM_ROUNDING;
            counts.normalised += usize::from(is_off);
            let mut seen = seen(&tracker_from_link, reading);
            if let Seen::Pose { orientation, .. } | Seen::Orientation(orientation) = &mut seen {
                if last.is_some_and(|last| last.coords.dot(&orientation.coords) < 0.0) {
                    *orientation = UnitQuaternion::new_unchecked(-orientation.into_inner());
                    counts.flipped += 1;
                }
                last = Some(*orientation);
            }
            if let Some(open) = reading.open(events) {
                open_times_s.insert(samples.len(), open.range_s());
            }
            samples.push(Sample {
                stamp: reading.stamp,
                acted_s: reading.stamp.seconds_since(origin),
                seen,
            });
        }
        let covariances = covariances(track, stream, events);
        tracks.push(TrackSketch {
            samples,
            covariances,
            open_times_s,
            are_written: stream.iter().any(|reading| reading.is_written(events)),
            held: None,
            grips: Vec::new(),
        });
    }
    Sketch {
        origin,
        tracks,
        marks_s: stamps.iter().map(|stamp| seconds(*stamp, origin)).collect(),
        marks: vec![None; stamps.len()],
        contacts_s: BTreeMap::new(),
        cuts_sd_s: BTreeMap::new(),
    }
}

#[cfg(test)]
mod tests;
