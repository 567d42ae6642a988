//! Events against the marks that the performer made.

use super::flights::Flight;
use crate::motion::{About, Doubt, Estimate, Place, Scene, Timing};

/// How much later than its mark, and how much earlier, an event may be where times are physical
/// \[s\].
const KNOWN_S: [f64; 2] = [0.075, 0.075];
/// The same in acted time, where the tempo is unknown: a reaction makes marks late.
const UNKNOWN_S: [f64; 2] = [0.12, 0.15];

pub(super) fn doubts(
    scene: &Scene,
    marks_made_s: &[Option<f64>],
    estimate: &Estimate,
    flights: &[Flight],
) -> Vec<Doubt> {
    let [later_s, earlier_s] = match scene.timing {
        Timing::Edited => return Vec::new(),
        Timing::Known => KNOWN_S,
        Timing::Unknown { .. } => UNKNOWN_S,
    };
    let map = TimeMap::new(flights);
    let mut doubts = Vec::new();
    for event in &estimate.events {
        let (Some(made_s), Some(acted_s)) = (marks_made_s[event.event], map.acted_s(event.time_s))
        else {
            continue;
        };
        let late_s = acted_s - made_s;
        let place = Place::Event(event.event);
        doubts.extend(Doubt::beyond(
            About::AfterMark,
            place.clone(),
            late_s,
            later_s,
        ));
        doubts.extend(Doubt::beyond(About::BeforeMark, place, -late_s, earlier_s));
    }
    doubts
}

/// Physical to acted time, linear between samples and beyond them.
struct TimeMap {
    /// Physical and acted times, in order \[s\].
    nodes_s: Vec<[f64; 2]>,
}

impl TimeMap {
    fn new(flights: &[Flight]) -> Self {
        let readings = flights.iter().flat_map(|flight| &flight.readings);
        let mut nodes_s: Vec<[f64; 2]> = readings.map(|r| [r.time_s, r.acted_s]).collect();
        nodes_s.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        nodes_s.dedup_by_key(|node| node[0]);
        Self { nodes_s }
    }

    /// `None` with fewer than two samples. Beyond the first and the last sample time goes on at the
    /// mean tempo.
    fn acted_s(&self, time_s: f64) -> Option<f64> {
        let (first, last) = (self.nodes_s.first()?, self.nodes_s.last()?);
        let line = |from: &[f64; 2], through: [&[f64; 2]; 2]| {
            let rate = (through[1][1] - through[0][1]) / (through[1][0] - through[0][0]);
            from[1] + (time_s - from[0]) * rate
        };
        if self.nodes_s.len() < 2 {
            return None;
        }
        let after = self.nodes_s.partition_point(|node| node[0] <= time_s);
        Some(match (after.checked_sub(1), self.nodes_s.get(after)) {
            (Some(before), Some(next)) => {
                let before = &self.nodes_s[before];
                line(before, [before, next])
            }
            (Some(_), None) => line(last, [first, last]),
            (None, _) => line(first, [first, last]),
        })
    }
}
