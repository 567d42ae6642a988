//! Whole tosses: an object that is held, thrown, bounces and rests in one stream.
//!
//! The cuts of least cost (`propose.rs`) suppose that all of a stream is flights. A hand before them and a
//! body that tumbles and rests after them fit no flight at all, and take the cuts to where they explain most
//! of that. So where times are physical and the stream does not fall where it begins or where it ends, what
//! flies is looked for first ([`falls`]): stretches that fall as the scene's gravity lets its body, as exactly
//! as the tracker sees. A flight ends by an impact where the velocity jumps there.

use std::ops::Range;

use nalgebra::Vector3;

use crate::motion::{Fall, Scene, Sketch, Timing, TrackIndex, TrackSketch, acceleration, falls};

/// Accelerations of flights are the scene's up to this share: trackers' lengths and floors are off.
const PULL_SHARE: f64 = 0.15;
/// What is off by this share is no fall.
const NO_FALL_SHARE: f64 = 0.5;
/// At an end of a stream it is told by two windows of so long \[s\], which one impact cannot both spoil,
const WINDOW_S: f64 = 0.1;
/// and of so many samples at least.
const WINDOW_SAMPLES: usize = 5;
/// An impact changes the velocity by this share of it, or of what gravity changes it by in the flight.
const KINK_SHARE: f64 = 0.2;
/// Samples after a flight that tell the velocity there.
const AFTER_SAMPLES: usize = 4;
/// The next flight begins so many samples after an impact, or others are between.
pub(super) const BETWEEN_SAMPLES: usize = 4;
/// A flight of fewer samples is not seen.
const UNSEEN_SAMPLES: usize = 6;

/// The flights of a toss.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Toss {
    /// The first flight that ends by an impact, and those that follow each other from there on; the last may
    /// have no impact. Ranges of samples.
    pub(super) flights: Vec<Range<usize>>,
}

/// The toss in a stream; `None` where it is none, or where all that is seen may be flights.
pub(super) fn toss(scene: &Scene, index: TrackIndex, track: &TrackSketch) -> Option<Toss> {
    let is_joined = scene.joint_trees().next().is_some();
    if scene.timing != Timing::Known || is_joined || !scene.sees_moving(index) {
        return None;
    }
    let pull = scene
        .link_seen_by(index)
        .body
        .pull_m_s2(&scene.gravity_m_s2);
    let size = pull.norm();
    let seen = track.samples.iter().enumerate();
    let seen = seen.filter_map(|(place, of)| Some((place, of.acted_s, of.seen.position_m()?)));
    let (mut places, mut times_s, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for (place, time_s, point) in seen {
        places.push(place);
        times_s.push(time_s);
        points.push(point);
    }
    if !(size > 0.0) || !does_not_fall_at_an_end(&times_s, &points, &pull) {
        return None;
    }
    let found = flights(&times_s, &points, &pull);
    // Stretches that follow each other without an impact are one flight.
    let mut flights: Vec<Range<usize>> = Vec::new();
    let mut open: Option<Range<usize>> = None;
    let mut last_end = 0;
    for fall in &found {
        let follows = fall.samples.start <= last_end + BETWEEN_SAMPLES;
        if !follows && !flights.is_empty() {
            break;
        }
        let begin = open.take().filter(|_| follows);
        let begin = begin.map_or(fall.samples.start, |open| open.start);
        let whole = begin..fall.samples.end;
        if kinks(fall, &times_s, &points) {
            flights.push(whole);
        } else {
            open = Some(whole);
        }
        last_end = fall.samples.end;
    }
    if flights.is_empty() {
        return None;
    }
    flights.extend(open);
    let end = |index: usize| places[index - 1] + 1;
    let flights = flights.into_iter();
    Some(Toss {
        flights: flights.map(|of| places[of.start]..end(of.end)).collect(),
    })
}

/// The stretches of a path that fall as a pull lets a body fall.
pub(super) fn flights(times_s: &[f64], points: &[Vector3<f64>], pull: &Vector3<f64>) -> Vec<Fall> {
    let most = PULL_SHARE * pull.norm();
    falls(times_s, points, |of, sd| {
        (of - pull).norm() <= most + 3.0 * sd
    })
}

/// Times of release and of the end of the flight after so many collisions, for a toss [s since the origin].
pub(super) fn ends_s(scene: &Scene, sketch: &Sketch) -> Option<[f64; 2]> {
    let collisions = scene
        .events
        .iter()
        .filter(|event| event.kind.collision().is_some())
        .count();
    let mut ends: Option<[f64; 2]> = None;
    for (index, track) in sketch.tracks.iter_enumerated() {
        if !scene.sees_moving(index) {
            continue;
        }
        let toss = toss(scene, index, track)?;
        let time_s = |place: usize| track.samples[place].acted_s;
        let begin_s = time_s(toss.flights[0].start);
        let end_s = match toss.flights.get(collisions) {
            Some(flight) => time_s(flight.end - 1),
            // What follows an impact without a flight is contact: as little of it as might be one.
            None if toss.flights.len() >= collisions.max(1) => {
                let impact = toss.flights[collisions.max(1) - 1].end;
                time_s((impact + UNSEEN_SAMPLES).min(track.samples.len() - 1))
            }
            None => time_s(track.samples.len() - 1),
        };
        let [first_s, last_s] = ends.unwrap_or([begin_s, end_s]);
        ends = Some([first_s.min(begin_s), last_s.max(end_s)]);
    }
    ends
}

/// Whether a stream begins or ends with what is no fall.
fn does_not_fall_at_an_end(times_s: &[f64], points: &[Vector3<f64>], pull: &Vector3<f64>) -> bool {
    let count = times_s.len();
    let is_no_fall = |window: Range<usize>| {
        let told = acceleration(&times_s[window.clone()], &points[window]);
        told.is_some_and(|(of, sd)| (of - pull).norm() > NO_FALL_SHARE * pull.norm() + 3.0 * sd)
    };
    let end_of = |begin: usize| {
        let after = times_s.partition_point(|time_s| *time_s <= times_s[begin] + WINDOW_S);
        after.max(begin + WINDOW_SAMPLES)
    };
    let begin_of = |end: usize| {
        let before = times_s.partition_point(|time_s| *time_s < times_s[end - 1] - WINDOW_S);
        before.min(end.saturating_sub(WINDOW_SAMPLES))
    };
    if count < 2 * WINDOW_SAMPLES {
        return false;
    }
    let (first, last) = (end_of(0), begin_of(count));
    let is_begin = first < count && {
        let second = end_of(first);
        second <= count && is_no_fall(0..first) && is_no_fall(first..second)
    };
    let is_end = last > WINDOW_SAMPLES && {
        let second = begin_of(last);
        is_no_fall(last..count) && is_no_fall(second..last)
    };
    is_begin || is_end
}

/// Whether the velocity jumps at the end of a flight.
fn kinks(fall: &Fall, times_s: &[f64], points: &[Vector3<f64>]) -> bool {
    let (begin, end) = (fall.samples.start, fall.samples.end);
    let after = end..(end + AFTER_SAMPLES).min(points.len());
    if after.len() < 2 {
        return false;
    }
    // Mean velocity over the flight, and by its acceleration at its end and in the middle of what follows.
    let flight_s = times_s[end - 1] - times_s[begin];
    let mean_m_s = (points[end - 1] - points[begin]) / flight_s;
    let at_end_m_s = mean_m_s + fall.acceleration * (0.5 * flight_s);
    let (first, last) = (after.start, after.end - 1);
    let after_m_s = (points[last] - points[first]) / (times_s[last] - times_s[first]);
    let middle_s = 0.5 * (times_s[last] + times_s[first]) - times_s[end - 1];
    let jump_m_s = after_m_s - at_end_m_s - fall.acceleration * middle_s;
    let gained_m_s = fall.acceleration.norm() * flight_s;
    jump_m_s.norm() >= KINK_SHARE * at_end_m_s.norm().max(gained_m_s)
}
