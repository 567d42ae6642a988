//! Whole tosses: an object that is held, thrown, bounces and rests in one stream.
//!
//! The cuts of least cost (`propose.rs`) suppose that all of a stream is flights. A hand before them and a
//! body that rests after them fit no flight at all, and take the cuts to where they explain most of that. So
//! where times are physical and the stream begins or ends at rest, what flies is looked for first
//! ([`falls`]): stretches that fall as the scene's gravity lets its body, as exactly as the tracker sees. A
//! flight ends by an impact where the velocity jumps there.

use nalgebra::Vector3;

use crate::motion::{Fall, Scene, Sketch, Timing, TrackIndex, TrackSketch, falls};

/// Accelerations of flights are the scene's up to this share: trackers' lengths and floors are off.
const PULL_SHARE: f64 = 0.15;
/// A stream rests where it stays so long \[s\]
const REST_S: [f64; 3] = [0.1, 0.2, 0.4];
/// within this share of what a fall would bend it by.
const REST_SHARE: f64 = 0.05;
/// Least number of samples of a rest.
const REST_SAMPLES: usize = 5;
/// An impact changes the velocity by this share of it, or of what gravity changes it by in the flight.
const KINK_SHARE: f64 = 0.2;
/// Samples after a flight that tell the velocity there.
const AFTER_SAMPLES: usize = 4;
/// The next flight begins so many samples after an impact, or others are between.
const BETWEEN_SAMPLES: usize = 4;

/// The flights of a toss.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Toss {
    /// Flights that end by an impact, one after the other, as ranges of samples; at least one. The first is
    /// the first of the stream, and after a gap there are none.
    pub(super) flights: Vec<std::ops::Range<usize>>,
    /// Where a rest at the end begins, or the end of the stream.
    pub(super) rest: usize,
}

/// The toss in a stream; `None` where it is none, or where all that is seen may be flights.
pub(super) fn toss(scene: &Scene, index: TrackIndex, track: &TrackSketch) -> Option<Toss> {
    let is_joined = scene.joint_trees().next().is_some();
    if scene.timing != Timing::Known || is_joined || scene.sees_held(index) {
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
    let rest = rest_at_end(&times_s, &points, size);
    let is_still = rest.is_some() || rests_at_begin(&times_s, &points, size);
    if !(size > 0.0) || !is_still {
        return None;
    }
    let is_flight =
        |of: &Vector3<f64>, sd: f64| (of - pull).norm() <= PULL_SHARE * size + 3.0 * sd;
    let found = falls(&times_s, &points, is_flight);
    let hits = |fall: &&Fall| kinks(fall, &times_s, &points);
    let first = found.iter().position(|fall| hits(&fall))?;
    let mut flights: Vec<&Fall> = vec![&found[first]];
    for next in &found[first + 1..] {
        let last = flights.last().map_or(0, |fall| fall.samples.end);
        if next.samples.start > last + BETWEEN_SAMPLES {
            break;
        }
        flights.push(next);
        if !kinks(next, &times_s, &points) {
            break;
        }
    }
    let place = |index: usize| places.get(index).copied().unwrap_or(track.samples.len());
    Some(Toss {
        flights: flights
            .iter()
            .map(|fall| place(fall.samples.start)..places[fall.samples.end - 1] + 1)
            .collect(),
        rest: place(rest.unwrap_or(times_s.len())),
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
        if scene.sees_held(index) {
            continue;
        }
        let toss = toss(scene, index, track)?;
        let time_s = |place: usize| track.samples[place].acted_s;
        let begin_s = time_s(toss.flights[0].start);
        let end_s = match toss.flights.get(collisions) {
            Some(flight) => time_s(flight.end - 1),
            None => time_s(toss.rest.min(track.samples.len() - 1)),
        };
        let [first_s, last_s] = ends.unwrap_or([begin_s, end_s]);
        ends = Some([first_s.min(begin_s), last_s.max(end_s)]);
    }
    ends
}

/// Where the stream begins to stay, if it does until its end.
fn rest_at_end(times_s: &[f64], points: &[Vector3<f64>], pull_m_s2: f64) -> Option<usize> {
    let last_s = *times_s.last()?;
    let begin = REST_S.iter().find_map(|rest_s| {
        let begin = times_s.partition_point(|time_s| *time_s < last_s - rest_s);
        (begin > 0 && stays(&points[begin..], *rest_s, pull_m_s2)).then_some((begin, *rest_s))
    });
    let (mut begin, rest_s) = begin?;
    // It rests as long before as it is where it ends.
    let at = mean(&points[begin..]);
    let limit_m = limit_m(rest_s, pull_m_s2);
    while begin > 0 && (points[begin - 1] - at).norm() <= limit_m {
        begin -= 1;
    }
    Some(begin)
}

fn rests_at_begin(times_s: &[f64], points: &[Vector3<f64>], pull_m_s2: f64) -> bool {
    let Some(first_s) = times_s.first() else {
        return false;
    };
    REST_S.iter().any(|rest_s| {
        let end = times_s.partition_point(|time_s| *time_s <= first_s + rest_s);
        end < points.len() && stays(&points[..end], *rest_s, pull_m_s2)
    })
}

/// What a fall is away from a straight line by, in its middle, and a share of that.
fn limit_m(rest_s: f64, pull_m_s2: f64) -> f64 {
    REST_SHARE * pull_m_s2 * rest_s.powi(2) / 8.0
}

fn stays(points: &[Vector3<f64>], rest_s: f64, pull_m_s2: f64) -> bool {
    let at = mean(points);
    let limit_m = limit_m(rest_s, pull_m_s2);
    points.len() >= REST_SAMPLES && points.iter().all(|point| (point - at).norm() <= limit_m)
}

fn mean(points: &[Vector3<f64>]) -> Vector3<f64> {
    points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64
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
