//! Assigns marks to the scene's events.

use typed_index_collections::{TiSlice, TiVec};

use super::cut::median_interval_s;
use super::error::SegmentError;
use crate::motion::{
    Collision, EventKind, LinkIndex, Mark, Scene, Stamp, Timing, TrackIndex, TrackSketch,
};

/// First and last stamp of some samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) first: Stamp,
    pub(super) last: Stamp,
}

/// Standard deviation of marks that a performer makes while acting: a button pressed late or early,
/// in acted time \[s\].
const PEOPLE_SD_S: f64 = 0.05;
/// Standard deviation of marks that are annotated afterwards in a stream with physical times, in
/// its intervals, and at least \[s\]: nobody sees better where a hand bounced, however fast the tracker is.
const ANNOTATED_SD_INTERVALS: f64 = 0.5;
const ANNOTATED_SD_S: f64 = 0.5 / 120.0;

/// Standard deviation of marks that were made by looking at the stream \[s\].
pub(super) fn annotated_sd_s(scene: &Scene, tracks: &TiSlice<TrackIndex, TrackSketch>) -> f64 {
    let own = tracks
        .iter_enumerated()
        .filter(|(track, _)| !scene.sees_apart(*track));
    let intervals_s = own.map(|(_, track)| median_interval_s(track));
    let interval_s = intervals_s.fold(0.0, f64::max);
    (ANNOTATED_SD_INTERVALS * interval_s).max(ANNOTATED_SD_S)
}

/// Standard deviation of the mark of an event, in acted time \[s\]. Nothing in a stream shows where a waypoint or an end
/// is, as a kink shows a collision: nobody annotates it better than while acting.
pub(super) fn mark_sd_s(scene: &Scene, event: usize, annotated_s: impl FnOnce() -> f64) -> f64 {
    let of = &scene.events[event];
    let given_s = of.time.mark_sd_s.or(scene.mark_sd_s);
    given_s.unwrap_or_else(|| match scene.timing {
        Timing::Known | Timing::Edited if of.kind.collision().is_some() => annotated_s(),
        Timing::Known | Timing::Edited | Timing::Unknown { .. } => PEOPLE_SD_S,
    })
}

/// One stamp per event of the scene, in order of time.
///
/// Marks with a name are assigned to their event; the others, in order of time, to the remaining
/// events. `origin` is the zero of the times in errors. Fails where numbers, names or order differ.
pub(super) fn matched(
    scene: &Scene,
    marks: &[Mark],
    origin: Stamp,
) -> Result<Vec<Stamp>, SegmentError> {
    let mut marks = marks.to_vec();
    marks.sort_by(|a, b| (a.stamp, &a.event).cmp(&(b.stamp, &b.event)));
    let mut stamps: Vec<Option<Stamp>> = vec![None; scene.events.len()];
    for mark in &marks {
        let Some(name) = &mark.event else { continue };
        let time_s = seconds(mark.stamp, origin);
        let Some(event) = scene.events.iter().position(|e| &e.name == name) else {
            return Err(SegmentError::UnknownMark {
                name: name.clone(),
                time_s,
                events: names(scene, |_| true),
            });
        };
        if let Some(first) = stamps[event].replace(mark.stamp) {
            return Err(SegmentError::DuplicateMark {
                event: name.clone(),
                first_s: seconds(first, origin),
                second_s: time_s,
            });
        }
    }
    if marks.len() != stamps.len() {
        let mut events = String::new();
        if !scene.events.is_empty() {
            events = format!(": {}", names(scene, |_| true));
        }
        let unnamed = names(scene, |event| stamps[event].is_none());
        let some_named = stamps.iter().any(Option::is_some);
        if some_named && !unnamed.is_empty() && marks.len() < stamps.len() {
            events += &format!("; no mark names {unnamed}");
        }
        return Err(SegmentError::MarkCount {
            found: marks.len(),
            expected: stamps.len(),
            events,
        });
    }
    let mut unnamed = marks.iter().filter(|mark| mark.event.is_none());
    let stamps: Vec<Stamp> = stamps
        .into_iter()
        .filter_map(|stamp| stamp.or_else(|| unnamed.next().map(|mark| mark.stamp)))
        .collect();
    assert_eq!(stamps.len(), scene.events.len(), "as many marks as events");
    check_order(scene, &stamps, origin)?;
    Ok(stamps)
}

fn check_order(scene: &Scene, stamps: &[Stamp], origin: Stamp) -> Result<(), SegmentError> {
    for (pair, events) in stamps.windows(2).zip(scene.events.windows(2)) {
        if pair[0] >= pair[1] {
            return Err(SegmentError::MarkOrder {
                earlier: events[0].name.clone(),
                earlier_s: seconds(pair[0], origin),
                later: events[1].name.clone(),
                later_s: seconds(pair[1], origin),
            });
        }
    }
    Ok(())
}

/// Moves marks of starts and ends that lie before or after all samples by more than a sampling gap,
/// but by no more than a performer's reaction time, to the first or the last sample: the recorder
/// stopped first. Returns their events.
pub(super) fn put_at_the_ends(
    scene: &Scene,
    stamps: &mut [Stamp],
    whole: Extent,
    gap_ns: i64,
    reach_ns: i64,
) -> Vec<usize> {
    let mut put = Vec::new();
    for (index, (event, stamp)) in scene.events.iter().zip(stamps).enumerate() {
        let nearest = (*stamp).clamp(whole.first, whole.last);
        let outside_ns = stamp.0.abs_diff(nearest.0);
        let is_late = outside_ns > gap_ns.unsigned_abs() && outside_ns <= reach_ns.unsigned_abs();
        if is_late && matches!(event.kind, EventKind::Start | EventKind::End) {
            *stamp = nearest;
            put.push(index);
        }
    }
    put
}

/// Refuses marks outside the samples: of the bodies that take part, for a collision; of any body,
/// for a start or an end, which may also lie up to `slack_ns` outside.
pub(super) fn check_extents(
    scene: &Scene,
    stamps: &[Stamp],
    extents: &TiSlice<TrackIndex, Extent>,
    slack_ns: i64,
) -> Result<(), SegmentError> {
    let Some(whole) = union(extents) else {
        return Ok(());
    };
    for (event, stamp) in scene.events.iter().zip(stamps) {
        let (extent, slack_ns) = match &event.kind {
            EventKind::Collision(collision) => {
                (shared(scene, extents, collision).unwrap_or(whole), 0)
            }
            EventKind::Change(link) | EventKind::Waypoint(link) => {
                (seen(scene, extents, *link).unwrap_or(whole), 0)
            }
            EventKind::Start | EventKind::Collisions { .. } | EventKind::End => (whole, slack_ns),
        };
        let inside = stamp.0 >= extent.first.0.saturating_sub(slack_ns)
            && stamp.0 <= extent.last.0.saturating_add(slack_ns);
        if !inside {
            return Err(SegmentError::MarkOutsideData {
                event: event.name.clone(),
                time_s: seconds(*stamp, whole.first),
                first_s: seconds(extent.first, whole.first),
                last_s: seconds(extent.last, whole.first),
            });
        }
    }
    Ok(())
}

/// The time in which all tracks of a collision have samples.
fn shared(
    scene: &Scene,
    extents: &TiSlice<TrackIndex, Extent>,
    collision: &Collision,
) -> Option<Extent> {
    let all = scene.tracks_in(collision).map(|track| extents[track]);
    all.reduce(|a, b| Extent {
        first: a.first.max(b.first),
        last: a.last.min(b.last),
    })
}

/// The time in which some track of a link has samples.
fn seen(scene: &Scene, extents: &TiSlice<TrackIndex, Extent>, link: LinkIndex) -> Option<Extent> {
    let tracks = scene.tracks_of(scene.mechanism_of(link));
    let extents: TiVec<TrackIndex, Extent> = tracks.map(|track| extents[track]).collect();
    union(&extents)
}

/// From the first of the firsts to the last of the lasts.
pub(super) fn union(extents: &TiSlice<TrackIndex, Extent>) -> Option<Extent> {
    Some(Extent {
        first: extents.iter().map(|e| e.first).min()?,
        last: extents.iter().map(|e| e.last).max()?,
    })
}

/// Seconds between stamps, without overflow for any integers.
pub(super) fn seconds(stamp: Stamp, origin: Stamp) -> f64 {
    (i128::from(stamp.0) - i128::from(origin.0)) as f64 * 1e-9
}

fn names(scene: &Scene, listed: impl Fn(usize) -> bool) -> String {
    let names: Vec<String> = scene
        .events
        .iter()
        .enumerate()
        .filter(|(index, _)| listed(*index))
        .map(|(_, event)| format!("{:?}", event.name))
        .collect();
    names.join(", ")
}
