//! Sketches of a few poses.

use super::index::TrackIndex;
use super::scene::{Event, Quantity, Scene, Sees, Timing};
use super::sketch::{Sample, Seen, Sketch};

/// Greatest number of samples of a flight, in the mean of a track, that are keyframes. Streams of
/// 30 samples a second have more in a flight of a fifth of a second.
const PER_FLIGHT_MAX: usize = 6;
/// Greatest median interval of a tracker's samples \[s\], of which nearly all others
const STREAM_S: f64 = 0.045;
/// differ by no more than a share: with a few of them a flight may be short before it.
const STREAM_SHARE: f64 = 0.2;
const NEARLY_ALL: f64 = 0.8;
/// Least number of samples of a flight of which a stream tells anything.
const PER_FLIGHT_MIN: usize = 3;

impl Scene {
    /// Whether a track's samples are keyframes: poses, or poses and parts of them, with physical times
    /// of which each flight has a few, chosen one by one by somebody who knows on which side of a
    /// collision each is.
    ///
    /// In a stream a sample beside a collision may belong to either side of it, since its mark is
    /// right to about a sampling interval. Intervals of keyframes are as long as flights; marks that
    /// were off by as much would say nothing.
    pub fn has_keyframes(&self, sketch: &Sketch, track: TrackIndex) -> bool {
        let mechanism = self.mechanism_seen_by(track);
        let parts = |event: &&Event| {
            let collision = event.kind.collision();
            collision.is_some_and(|collision| self.takes_part(mechanism, collision))
        };
        let flights = 1 + self.events.iter().filter(parts).count();
        let is_physical = matches!(self.timing, Timing::Known | Timing::Edited);
        let of_track = &sketch.tracks[track];
        let samples = &of_track.samples;
        let is_stream = self.timing == Timing::Known
            && !of_track.are_written
            && samples.len() >= PER_FLIGHT_MIN * flights
            && are_regular(samples);
        let is_few = samples.len() <= PER_FLIGHT_MAX * flights && !is_stream;
        let is_whole = |sample: &Sample| matches!(sample.seen, Seen::Pose { .. });
        is_physical
            // No stream has samples without a time.
            && (is_few || !of_track.open_times_s.is_empty())
            && self.tracks_of(mechanism).count() == 1
            && self.tracks[track].sees == Sees::Pose
            && samples.iter().any(is_whole)
    }

    /// Whether a whole sketch is of keyframes: every track's samples are, and all that is seen
    /// flies.
    pub fn is_keyframed(&self, sketch: &Sketch) -> bool {
        let mut tracks = self.tracks.keys().filter(|track| !self.sees_apart(*track));
        tracks.all(|track| self.has_keyframes(sketch, track) && !self.sees_held(track))
    }

    /// The scene of an edited sketch with the clock of every flight but the first of each track
    /// free; any other as it is.
    pub fn with_flight_clocks(self) -> Scene {
        if self.timing != Timing::Edited {
            return self;
        }
        let clocks = self.tracks.keys().flat_map(|track| {
            let flights = 1..self.streams(track);
            flights.map(move |flight| (Quantity::FlightClock { track, flight }, 0.0))
        });
        let clocks: Vec<(Quantity, f64)> = clocks.collect();
        if clocks.iter().any(|(clock, _)| self.frees(*clock)) {
            return self;
        }
        self.with_free(&clocks)
    }
}

/// Whether samples follow each other as fast and as regularly as those of a tracker.
fn are_regular(samples: &[Sample]) -> bool {
    let intervals = samples.windows(2);
    let mut intervals_s: Vec<f64> = intervals
        .map(|pair| pair[1].acted_s - pair[0].acted_s)
        .collect();
    intervals_s.sort_by(f64::total_cmp);
    let Some(&median_s) = intervals_s.get(intervals_s.len() / 2) else {
        return false;
    };
    let is_alike = |of: &&f64| (*of - median_s).abs() <= STREAM_SHARE * median_s;
    let alike = intervals_s.iter().filter(is_alike).count() as f64;
    median_s <= STREAM_S && alike >= NEARLY_ALL * intervals_s.len() as f64
}
