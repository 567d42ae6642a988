//! Completes absent marks and drops superfluous ones, by proposals from the stream.

use super::error::SegmentError;
use super::marks::seconds;
use super::propose::{CLEAR_SCORE, Proposal, ends_of_motion_s, propose};
use crate::motion::{EventKind, Mark, MarkChanges, Scene, Sketch, Stamp};

/// Greatest distance of a mark without a name from the proposed place of its event \[s\].
const NEAR_S: f64 = 0.25;

/// One stamp per event: its mark, or its proposed place; start and end at the first and the last
/// sample. `sketch` has all samples, and no marks.
///
/// Fails with `error`, and the proposals in it, where proposals are not clear, or where a mark is
/// not near any of them.
pub(super) fn completed(
    scene: &Scene,
    marks: &[Mark],
    sketch: &Sketch,
    error: SegmentError,
) -> Result<(Vec<Stamp>, MarkChanges), SegmentError> {
    let proposals = propose(scene, sketch, None);
    let Some(places) = places(scene, sketch, &proposals, marks) else {
        return Err(error);
    };
    let is_clear = proposals.iter().all(|p| p.score >= CLEAR_SCORE);
    let mut marks = marks.to_vec();
    marks.sort_by(|a, b| (a.stamp, &a.event).cmp(&(b.stamp, &b.event)));
    let matches = aligned(scene, &marks, &places, sketch.origin);
    let used = matches.iter().flatten().count();
    if !is_clear || used < marks.len().min(places.len()) {
        return Err(with_proposals(error, scene, &proposals));
    }
    let mut changes = MarkChanges {
        ignored: marks.len() - used,
        ..MarkChanges::default()
    };
    let mut stamps = Vec::new();
    for (event, (place, mark)) in places.iter().zip(&matches).enumerate() {
        match mark {
            Some(mark) => stamps.push(marks[*mark].stamp),
            None => {
                changes.proposed.push(event);
                stamps.push(*place);
            }
        }
    }
    let is_ordered = stamps.windows(2).all(|pair| pair[0] < pair[1]);
    if is_ordered {
        Ok((stamps, changes))
    } else {
        Err(with_proposals(error, scene, &proposals))
    }
}

/// The proposed places of the events; `None` unless every collision has one, in order. Nothing in a
/// stream is sought that shows where a waypoint or a change of phase is: its own mark alone tells, by name.
fn places(
    scene: &Scene,
    sketch: &Sketch,
    proposals: &[Proposal],
    marks: &[Mark],
) -> Option<Vec<Stamp>> {
    let ends_s = ends_of_motion_s(scene, sketch)?;
    let stamp = |acted_s: f64| sketch.origin.after(acted_s);
    let places: Option<Vec<Stamp>> = (0..scene.events.len())
        .map(|event| match scene.events[event].kind {
            EventKind::Start => Some(stamp(ends_s[0])),
            EventKind::End => Some(stamp(ends_s[1])),
            EventKind::Collision(_) | EventKind::Collisions { .. } => {
                let proposal = proposals.iter().find(|p| p.event == Some(event))?;
                Some(proposal.stamp(sketch))
            }
            EventKind::Change(_) | EventKind::Waypoint(_) => {
                let name = Some(&scene.events[event].name);
                let mark = marks.iter().find(|mark| mark.event.as_ref() == name)?;
                Some(mark.stamp)
            }
        })
        .collect();
    places.filter(|places| places.windows(2).all(|pair| pair[0] < pair[1]))
}

/// For every event its mark, if any: the assignment in order with the most marks and, among those,
/// the least sum of distances.
fn aligned(scene: &Scene, marks: &[Mark], places: &[Stamp], origin: Stamp) -> Vec<Option<usize>> {
    let fits = |mark: usize, event: usize| {
        let distance_s = seconds(marks[mark].stamp, origin) - seconds(places[event], origin);
        match &marks[mark].event {
            // A name decides, whatever the distance.
            Some(name) => (*name == scene.events[event].name).then_some(0.0),
            None => (distance_s.abs() <= NEAR_S).then_some(distance_s.abs()),
        }
    };
    // Dynamic programming over the first marks and the first events: number of matches, and minus
    // the sum of their distances; the greatest is best.
    let (rows, columns) = (marks.len() + 1, places.len() + 1);
    let mut worth = vec![0.0_f64; rows * columns];
    let per_match = NEAR_S * 2.0 * rows.max(columns) as f64;
    let matched = |worth: &[f64], m: usize, e: usize| {
        fits(m - 1, e - 1).map_or(f64::NEG_INFINITY, |distance_s| {
            worth[(m - 1) * columns + e - 1] + per_match - distance_s
        })
    };
    for m in 1..rows {
        for e in 1..columns {
            let skipped = worth[(m - 1) * columns + e].max(worth[m * columns + e - 1]);
            worth[m * columns + e] = skipped.max(matched(&worth, m, e));
        }
    }
    let mut of_event = vec![None; places.len()];
    let (mut m, mut e) = (rows - 1, columns - 1);
    while m > 0 && e > 0 {
        let here = worth[m * columns + e];
        if here == worth[m * columns + e - 1] {
            e -= 1;
        } else if here == worth[(m - 1) * columns + e] {
            m -= 1;
        } else {
            of_event[e - 1] = Some(m - 1);
            (m, e) = (m - 1, e - 1);
        }
    }
    of_event
}

fn with_proposals(error: SegmentError, scene: &Scene, proposals: &[Proposal]) -> SegmentError {
    let SegmentError::MarkCount {
        found,
        expected,
        events,
    } = error
    else {
        return error;
    };
    let suggested: Vec<String> = proposals
        .iter()
        .filter_map(|p| {
            let name = &scene.events[p.event?].name;
            Some(format!(
                "{name:?} at {:.3} s (score {:.1})",
                p.acted_s, p.score
            ))
        })
        .collect();
    SegmentError::MarkCount {
        found,
        expected,
        events: format!("{events}; the stream suggests {}", suggested.join(", ")),
    }
}
