//! Joins the segments of an edited sketch, one after the other on one time line.
//!
//! Every segment comes with physical times of its own, from any zero. The first segment of every
//! track begins at zero of the time line. At a collision the segments of all tracks that take part
//! end half a median interval before the mark, or earlier where another's is longer; their next
//! segments begin half a median interval after it. So with one track the first sample of a segment
//! is one median interval after the last sample of the one before, with the mark in the middle.
//! Marks keep the order of the scene's events.

use typed_index_collections::{TiSlice, TiVec};

use super::error::SegmentError;
use super::marks::seconds;
use super::reading::Reading;
use crate::motion::{EventKind, Scene, Stamp, TrackIndex};

/// Interval of a track whose segments have one sample each \[ns\]; [`cut`](super::cut()) refuses
/// them.
const INTERVAL_NS: i64 = 1_000_000;

/// One track's position on the time line \[ns\].
struct JoinedSegments<'a> {
    segments: std::slice::Iter<'a, Vec<Reading>>,
    /// Beginning of the next segment.
    begin_ns: i64,
    /// Median interval, at least 2.
    interval_ns: i64,
    joined: Vec<Reading>,
}

/// One stream per track.
type Streams = TiVec<TrackIndex, Vec<Reading>>;

/// The streams of all tracks and the stamps of all events on one line, whose zero is the least
/// stamp of any first segment. `segments` are by track, as many as [`Scene::streams`] says, sorted,
/// none empty. Fails where they are longer than `limit_s`, each or together.
pub(super) fn join(
    scene: &Scene,
    segments: &TiSlice<TrackIndex, Vec<Vec<Reading>>>,
    limit_s: f64,
) -> Result<(Streams, Vec<Stamp>), SegmentError> {
    check_spans(segments, limit_s)?;
    let limit_ns = (limit_s * 1e9) as i64;
    let firsts = segments.iter().filter_map(|track| track.first()?.first());
    let zero = firsts.map(|sample| sample.stamp.0).min().unwrap_or(0);
    // The whole time line is within a few limits of its zero, so that sums do not overflow.
    let zero = zero.min(i64::MAX - 4 * limit_ns);
    let joined = segments
        .iter()
        .map(|track| JoinedSegments::new(track, zero));
    let mut tracks: TiVec<TrackIndex, JoinedSegments> = joined.collect();
    let mut stamps = Vec::new();
    let mut last_ns = zero;
    for event in &scene.events {
        match &event.kind {
            EventKind::Start => stamps.push(Stamp(zero)),
            EventKind::Collision(collision) => {
                let mut mark_ns = last_ns;
                for index in scene.tracks_in(collision) {
                    let track = &mut tracks[index];
                    mark_ns = mark_ns.max(last_ns + track.interval_ns);
                    mark_ns = mark_ns.max(track.place() + track.interval_ns / 2);
                }
                for index in scene.tracks_in(collision) {
                    let track = &mut tracks[index];
                    track.begin_ns = mark_ns + (track.interval_ns - track.interval_ns / 2);
                }
                check_span(Stamp(mark_ns), Stamp(zero), limit_s)?;
                stamps.push(Stamp(mark_ns));
                last_ns = mark_ns;
            }
            EventKind::Collisions { .. }
            | EventKind::Change(_)
            | EventKind::Waypoint(_)
            | EventKind::End => {}
        }
    }
    let ends = tracks.iter_mut().map(|track| track.place());
    let end_ns = ends.fold(last_ns + 1, i64::max);
    check_span(Stamp(end_ns), Stamp(zero), limit_s)?;
    if scene.events.len() > stamps.len() {
        stamps.push(Stamp(end_ns));
    }
    let streams = tracks.into_iter().map(|track| track.joined).collect();
    Ok((streams, stamps))
}

fn check_spans(
    segments: &TiSlice<TrackIndex, Vec<Vec<Reading>>>,
    limit_s: f64,
) -> Result<(), SegmentError> {
    for segment in segments.iter().flatten() {
        if let (Some(first), Some(last)) = (segment.first(), segment.last()) {
            check_span(last.stamp, first.stamp, limit_s)?;
        }
    }
    Ok(())
}

fn check_span(last: Stamp, first: Stamp, limit_s: f64) -> Result<(), SegmentError> {
    let span_s = seconds(last, first);
    if span_s > limit_s {
        return Err(SegmentError::Span { span_s, limit_s });
    }
    Ok(())
}

impl<'a> JoinedSegments<'a> {
    fn new(segments: &'a [Vec<Reading>], zero_ns: i64) -> Self {
        let mut intervals: Vec<i64> = segments
            .iter()
            .flat_map(|segment| segment.windows(2))
            .map(|pair| pair[1].stamp.0 - pair[0].stamp.0)
            .collect();
        intervals.sort_unstable();
        let median_ns = intervals.get(intervals.len() / 2);
        Self {
            segments: segments.iter(),
            begin_ns: zero_ns,
            interval_ns: median_ns.copied().unwrap_or(INTERVAL_NS).max(2),
            joined: Vec::new(),
        }
    }

    /// Places the next segment; returns its end.
    fn place(&mut self) -> i64 {
        let Some(segment) = self.segments.next() else {
            return self.begin_ns;
        };
        // Differences within one segment do not overflow; those between two may.
        let since_ns = |reading: &Reading| reading.stamp.0 - segment[0].stamp.0;
        let placed = |reading| Stamp(self.begin_ns + since_ns(reading));
        let readings = segment.iter();
        self.joined
            .extend(readings.map(|reading| reading.at(placed(reading))));
        self.joined
            .last()
            .map_or(self.begin_ns, |last| last.stamp.0)
    }
}
