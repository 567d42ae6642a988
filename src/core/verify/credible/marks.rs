//! Checks estimated events against the performer's marks.

use crate::motion::{About, Doubt, Estimate, EventKind, Place, Scene, Sketch, TimeMap, Timing};

/// Greatest time of an event after its mark, and before its mark, where times are physical \[s\].
const KNOWN_S: [f64; 2] = [0.075, 0.075];
/// Greatest time of an event from its mark, in the mark's standard deviations, where the scene states these, and of a
/// waypoint, which is about there, and goals say where.
const DEVIATIONS: f64 = 4.0;
/// The same in acted time, where the tempo is unknown: reaction time makes marks late.
const UNKNOWN_S: [f64; 2] = [0.12, 0.15];

/// Greatest acted time of an event after its mark, and before its mark, that is believed \[s\].
pub fn from_mark_s(scene: &Scene, sketch: &Sketch, event: usize) -> [f64; 2] {
    let beyond_s = match scene.timing {
        Timing::Edited | Timing::Known => KNOWN_S,
        Timing::Unknown { .. } => UNKNOWN_S,
    };
    match (&scene.events[event].kind, sketch.marks[event]) {
        (EventKind::Change(_) | EventKind::Waypoint(_), Some(mark)) => [DEVIATIONS * mark.sd_s; 2],
        _ => {
            let stated_s = scene.mark_sd_s.map_or(0.0, |sd_s| DEVIATIONS * sd_s);
            beyond_s.map(|least_s| least_s.max(stated_s))
        }
    }
}

pub(in crate::verify) fn doubts(
    scene: &Scene,
    sketch: &Sketch,
    marks_made_s: &[Option<f64>],
    estimate: &Estimate,
) -> Vec<Doubt> {
    if scene.timing == Timing::Edited {
        return Vec::new();
    }
    let Some(map) = TimeMap::new(&estimate.sample_times, sketch.origin) else {
        return Vec::new();
    };
    let mut doubts = Vec::new();
    for event in &estimate.events {
        let Some(made_s) = marks_made_s[event.event] else {
            continue;
        };
        let [later_s, earlier_s] = from_mark_s(scene, sketch, event.event);
        let late_s = map.acted_s(event.time_s) - made_s;
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
