//! What can be checked of an answer without the program's own checks: against the raw samples, the
//! table, energy, and the filter that the samples went through.

use enact::math::Pose;
use enact::motion::{ArcEstimate, LinkIndex};
use enact::physics::{State, flow};
use enact::pipeline::Outcome;
use nalgebra::Vector3;
use serde::Serialize;

use super::read::RATE_HZ;
use super::smoothing::Filter;
use super::solid::Solid;
use crate::tosses::Pose as Sample;

/// From one look at the motion to the next \[s\].
const LOOK_S: f64 = 1e-3;

/// What is found of a motion.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Checked {
    /// Root mean square distance of the tracked frame from the raw samples \[mm\], and angle \[°\].
    pub residual: (f64, f64),
    /// The same distance after the motion went through the filter that the samples show; `None`
    /// where there are too few samples for it.
    pub filtered_mm: Option<f64>,
    /// Greatest depth below the table at any time \[mm\]; `None` without a table.
    pub depth_mm: Option<f64>,
    /// Energy just after the impact over that just before, above the table; `None` without an impact.
    pub energy_ratio: Option<f64>,
}

/// State at a time.
fn at(outcome: &Outcome, time_s: f64) -> State {
    let arcs = &outcome.estimate.arcs;
    let is_over = |arc: &&ArcEstimate| arc.end_s < time_s;
    let arc = arcs.iter().take_while(is_over).count().min(arcs.len() - 1);
    in_arc(outcome, arc, time_s)
}

fn in_arc(outcome: &Outcome, arc: usize, time_s: f64) -> State {
    let arc = &outcome.estimate.arcs[arc];
    let body = &outcome.scene.links[LinkIndex(0)].body;
    let gravity_m_s2 = &outcome.estimate.gravity_m_s2;
    flow::advance(body, gravity_m_s2, &arc.state, time_s - arc.epoch_s)
}

/// Pose of the tracked frame at a sample's place, counted from the first.
fn tracked(outcome: &Outcome, solid: &Solid, place: usize) -> Pose {
    let state = at(outcome, place as f64 / RATE_HZ);
    state.world_from_body() * solid.tracked_from_body.inverse()
}

/// Distance of the motion from a sample at that place \[mm\], and angle \[°\].
pub fn miss(outcome: &Outcome, solid: &Solid, (place, sample): (usize, &Sample)) -> (f64, f64) {
    let pose = tracked(outcome, solid, place);
    let apart_m = (pose.translation.vector - sample.0).norm();
    (
        1e3 * apart_m,
        pose.rotation.angle_to(&sample.1).to_degrees(),
    )
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| {
        (sum + value * value, count + 1)
    });
    (sum / f64::from(count)).sqrt()
}

/// Checks the motion of the first `count` of some samples; those after it are what the filter saw
/// beyond.
pub fn checked(
    outcome: &Outcome,
    solid: &Solid,
    (samples, count): (&[Sample], usize),
    filter: Option<Filter>,
) -> Checked {
    let misses: Vec<(f64, f64)> = (0..count)
        .map(|place| miss(outcome, solid, (place, &samples[place])))
        .collect();
    Checked {
        residual: (
            rms(misses.iter().map(|miss| miss.0)),
            rms(misses.iter().map(|miss| miss.1)),
        ),
        filtered_mm: filter
            .and_then(|filter| filtered_mm(outcome, solid, (samples, count), &filter)),
        depth_mm: depth_mm(outcome, solid),
        energy_ratio: energy_ratio(outcome),
    }
}

/// The motion, followed by the samples as they are, through the filter.
fn filtered_mm(
    outcome: &Outcome,
    solid: &Solid,
    (samples, count): (&[Sample], usize),
    filter: &Filter,
) -> Option<f64> {
    let moved = (0..count).map(|place| tracked(outcome, solid, place).translation.vector);
    let after = samples[count..].iter().map(|sample| sample.0);
    let positions_m: Vec<Vector3<f64>> = moved.chain(after).collect();
    let filtered_m = filter.smoothed_positions(&positions_m)?;
    let apart_m = filtered_m.iter().zip(samples).take(count);
    Some(1e3 * rms(apart_m.map(|(filtered, sample)| (filtered - sample.0).norm())))
}

fn table_m(outcome: &Outcome) -> Option<f64> {
    Some(outcome.scene.surfaces.first()?.plane()?.0.z)
}

fn depth_mm(outcome: &Outcome, solid: &Solid) -> Option<f64> {
    let table_m = table_m(outcome)?;
    let [start_s, end_s] = outcome.estimate.extent_s()?;
    let looks = ((end_s - start_s) / LOOK_S).ceil() as usize;
    let height_m = |look: usize| {
        let time_s = (start_s + look as f64 * LOOK_S).min(end_s);
        solid.lowest_m(&at(outcome, time_s).world_from_body()) - table_m
    };
    let least_m = (0..=looks).map(height_m).fold(f64::INFINITY, f64::min);
    Some(1e3 * (-least_m).max(0.0))
}

fn energy_ratio(outcome: &Outcome) -> Option<f64> {
    let table_m = table_m(outcome)?;
    let [_, after] = outcome.estimate.arcs.as_slice() else {
        return None;
    };
    let body = &outcome.scene.links[LinkIndex(0)].body;
    let energy_j = |arc: usize| {
        let state = in_arc(outcome, arc, after.start_s);
        let spin = state.angular_velocity_rad_s;
        let moving_j = 0.5 * body.mass_kg() * state.velocity_m_s.norm_squared();
        let turning_j = 0.5 * spin.dot(&body.moments_kg_m2().component_mul(&spin));
        let weight_n = -outcome.estimate.gravity_m_s2 * body.mass_kg();
        let above_m = state.position_m - Vector3::z() * table_m;
        moving_j + turning_j + weight_n.dot(&above_m)
    };
    Some(energy_j(1) / energy_j(0))
}
