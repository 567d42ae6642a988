//! Where rows are in time whose times are not known.
//!
//! Every row gets a time that agrees with its place among the others: its own where that is known,
//! otherwise one evenly between its neighbours, within its interval. It is the row's log time in the
//! recording: it says in which flight a keyframe is, and where the search for its time begins. Events
//! count as neighbours where they are written between keyframes in order of time.

use anyhow::{anyhow, bail};

use crate::motion::{KeyframeTime, Scene, SketchRow, Stamp, Timing, TrackIndex};

/// Interval where a sketch has none \[ns\].
const INTERVAL_NS: i64 = 50_000_000;

/// A row in the order of one stream.
struct StreamPlace {
    /// Index of the row.
    row: usize,
    /// Number of the keyframe in its stream, from 1.
    number: usize,
    /// What its own time leaves \[ns\].
    own: [Option<i64>; 2],
}

/// The rows in order of their places in time. Fails where rows, in their order, leave a keyframe no
/// time, or where it is open on which side of an event one is.
pub(super) fn placed<'r>(
    rows: &'r [SketchRow],
    scene: &Scene,
) -> anyhow::Result<Vec<(Stamp, &'r SketchRow)>> {
    let known = rows.iter().map(|row| match row {
        SketchRow::Mark(mark) => mark.stamp,
        SketchRow::Keyframe { keyframe, .. } => match keyframe.time {
            KeyframeTime::Known(stamp) => stamp,
            KeyframeTime::Within(..) | KeyframeTime::Unknown => Stamp(0),
        },
    });
    let mut stamps: Vec<Stamp> = known.collect();
    for track in scene.tracks.keys() {
        for flight in 0..scene.streams(track) {
            place_stream(rows, scene, track, flight, &mut stamps)?;
        }
    }
    let mut placed: Vec<(Stamp, &SketchRow)> = stamps.into_iter().zip(rows).collect();
    placed.sort_by_key(|(stamp, _)| *stamp);
    Ok(placed)
}

fn place_stream(
    rows: &[SketchRow],
    scene: &Scene,
    track: TrackIndex,
    flight: usize,
    stamps: &mut [Stamp],
) -> anyhow::Result<()> {
    let (places, aside) = in_order(rows, scene, (track, flight));
    let named = |place: &StreamPlace| {
        let body = &scene.link_seen_by(track).name;
        let flight = match scene.timing {
            Timing::Edited => format!(" in flight {}", flight + 1),
            _ => String::new(),
        };
        format!("keyframe {} of body {body:?}{flight}", place.number)
    };
    // What the rows before and after leave.
    let mut least: Vec<Option<i64>> = Vec::new();
    for place in &places {
        least.push(place.own[0].max(least.last().copied().flatten()));
    }
    let mut most: Vec<Option<i64>> = vec![None; places.len()];
    let mut after = None;
    for (index, place) in places.iter().enumerate().rev() {
        after = [place.own[1], after].into_iter().flatten().min();
        most[index] = after;
    }
    let step_ns = interval_ns(&places);
    let mut last: Option<i64> = None;
    for (index, place) in places.iter().enumerate() {
        if let [Some(from), Some(to)] = place.own
            && from == to
        {
            last = last.max(Some(from));
            continue;
        }
        // As many share what is left.
        let sharing = most[index..].iter().zip(&places[index..]);
        let sharing = sharing.take_while(|(to, of)| **to == most[index] && of.own[0] != of.own[1]);
        let count = sharing.count().max(1) as i64;
        let from = match (least[index], most[index]) {
            (Some(least), _) => least,
            (None, Some(most)) => (most - (count + 1) * step_ns).max(0),
            (None, None) => 0,
        };
        let from = last.map_or(from, |last| last.max(from));
        let to = most[index].unwrap_or(from + (count + 1) * step_ns);
        if to - from <= count {
            bail!(
                "{} has no time left between the rows before and after it, expected rows in order of \
                 time, and times that begin after 0 where a keyframe without one is the first",
                named(place)
            );
        }
        for mark in &aside {
            let SketchRow::Mark(mark) = mark else {
                continue;
            };
            if (from..=to).contains(&mark.stamp.0) {
                let event = mark.event.as_deref().unwrap_or_default();
                return Err(anyhow!(
                    "{} may be before event {event:?} or after it, expected the event's row between \
                     keyframes in order of time, or an interval on one side of it",
                    named(place)
                ));
            }
        }
        let at = from + (to - from) / (count + 1);
        stamps[place.row] = Stamp(at);
        last = Some(at);
    }
    Ok(())
}

/// The keyframes of a stream with the events that are written among them in order of time, and the
/// other events.
fn in_order<'r>(
    rows: &'r [SketchRow],
    scene: &Scene,
    stream: (TrackIndex, usize),
) -> (Vec<StreamPlace>, Vec<&'r SketchRow>) {
    let (mut places, mut aside) = (Vec::new(), Vec::new());
    let mut number = 0;
    let known = |row: &SketchRow| match row {
        SketchRow::Keyframe {
            track,
            flight,
            keyframe,
        } if (*track, *flight) == stream => match keyframe.time {
            KeyframeTime::Known(stamp) => Some(stamp),
            _ => None,
        },
        _ => None,
    };
    for (row, of) in rows.iter().enumerate() {
        let own = match of {
            SketchRow::Keyframe {
                track,
                flight,
                keyframe,
            } => {
                if (*track, *flight) != stream {
                    continue;
                }
                number += 1;
                match keyframe.time {
                    KeyframeTime::Known(at) => [Some(at.0); 2],
                    KeyframeTime::Within(from, to) => [Some(from.0), Some(to.0)],
                    KeyframeTime::Unknown => [None; 2],
                }
            }
            SketchRow::Mark(mark) => {
                let before = rows[..row].iter().filter_map(known).max();
                let after = rows[row..].iter().filter_map(known).min();
                let is_in_place = before.is_none_or(|before| before <= mark.stamp)
                    && after.is_none_or(|after| mark.stamp <= after)
                    && (before.is_some() || after.is_some())
                    && number > 0;
                if scene.timing == Timing::Edited || !is_in_place {
                    aside.push(of);
                    continue;
                }
                [Some(mark.stamp.0); 2]
            }
        };
        places.push(StreamPlace { row, number, own });
    }
    (places, aside)
}

/// Mean interval between the known times of a stream \[ns\].
fn interval_ns(places: &[StreamPlace]) -> i64 {
    let known = places.iter().filter(|place| place.own[0] == place.own[1]);
    let known: Vec<i64> = known.filter_map(|place| place.own[0]).collect();
    match known.as_slice() {
        [first, .., last] => ((last - first) / (known.len() as i64 - 1)).max(1),
        _ => INTERVAL_NS,
    }
}
