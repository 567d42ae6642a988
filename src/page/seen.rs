//! What was seen of points alone, at physical times.

use nalgebra::Vector3;

use super::input::Page;
use crate::motion::{Stamp, TrackIndex};
use crate::report::TimeMapMessage;
use crate::sampling::stamp;

/// How far apart a stamp and what is said of it may be \[ns\].
const SAME_NS: i64 = 1000;

/// What a tracker read of a point, in order of time: the time map says which readings were used, and when they are.
pub(super) fn seen_points(
    page: &Page,
    time_map: &TimeMapMessage,
    track: TrackIndex,
) -> Vec<(Stamp, Vector3<f64>)> {
    let name = &page.scene.tracks[track].name;
    let Some(map) = time_map.bodies.iter().find(|of| of.body == *name) else {
        return Vec::new();
    };
    let origin = Stamp::from(time_map.origin);
    let times = map.acted_s.iter().zip(&map.physical_s);
    let mut times: Vec<(Stamp, f64)> = times
        .map(|(acted_s, physical_s)| (stamp(origin, *acted_s), *physical_s))
        .collect();
    times.sort_by_key(|(at, _)| *at);
    let readings = page.readings.iter().filter(|(of, _)| *of == track);
    let seen = readings.filter_map(|(_, reading)| {
        let from = Stamp(reading.stamp.0.saturating_sub(SAME_NS));
        let after = times.partition_point(|(at, _)| *at < from);
        let (at, physical_s) = times.get(after)?;
        let is_it = at.0.abs_diff(reading.stamp.0) <= SAME_NS as u64;
        is_it.then(|| (stamp(page.motion.zero, *physical_s), reading.position_m))
    });
    let mut seen: Vec<(Stamp, Vector3<f64>)> = seen.collect();
    seen.sort_by_key(|(at, _)| *at);
    seen
}
