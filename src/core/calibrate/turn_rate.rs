//! How fast a tracker turns.

use nalgebra::Vector3;

use super::stream::Reading;
use crate::math::so3::log;

/// Share of the window that readings cover on both sides: of a part of it the slope is that of another time.
const COVERED: f64 = 0.5;

/// Angular velocity in tracker axes at a time \[rad/s\]: the slope of a line through the rotation vectors of
/// readings within `half_s`, weighted by `(1 − (u/half)²)²`, so that it is smooth in time. `None` where there
/// are fewer than three, or none for half of one side of the window.
pub(super) fn turn_rate(readings: &[Reading], time_s: f64, half_s: f64) -> Option<Vector3<f64>> {
    let from = readings.partition_point(|of| of.time_s <= time_s - half_s);
    let to = readings.partition_point(|of| of.time_s < time_s + half_s);
    let near = readings.get(from..to)?;
    let [first, last] = [near.first()?, near.last()?];
    let [begin_s, end_s] = [time_s - COVERED * half_s, time_s + COVERED * half_s];
    if near.len() < 3 || first.time_s > begin_s || last.time_s < end_s {
        return None;
    }
    let reference = near[near.len() / 2].world_from_tracker.rotation.inverse();
    let (mut weights, mut mean_s, mut mean) = (0.0, 0.0, Vector3::zeros());
    let points: Vec<(f64, f64, Vector3<f64>)> = near
        .iter()
        .map(|of| {
            let u = (of.time_s - time_s) / half_s;
            let turn = log(&(reference * of.world_from_tracker.rotation));
            ((1.0 - u * u).powi(2), of.time_s - time_s, turn)
        })
        .collect();
    for (weight, at_s, turn) in &points {
        weights += weight;
        mean_s += weight * at_s;
        mean += turn * *weight;
    }
    (mean_s, mean) = (mean_s / weights, mean / weights);
    let (mut square, mut product) = (0.0, Vector3::zeros());
    for (weight, at_s, turn) in &points {
        square += weight * (at_s - mean_s).powi(2);
        product += (turn - mean) * (weight * (at_s - mean_s));
    }
    (square > 0.0).then(|| product / square)
}
