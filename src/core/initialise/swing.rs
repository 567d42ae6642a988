//! First guesses of a flight of which one point beside the centre of mass is seen.
//!
//! The point `p` of a body that turns steadily about a direction `u` fixed in space, as symmetric
//! bodies do, is at
//!
//! ```text
//! x₀ + v s + ½ g s² + a u + b cos ωs + (u × b) sin ωs,   a² + |b|² = |p|², b ⊥ u
//! ```
//!
//! which less `½ g s²` is a [`FittedCircle`]. Of `a` both signs fit, of the rotation about `p` nothing is
//! seen.

use nalgebra::{UnitQuaternion, Vector3};

use super::ballistic::Place;
use super::circle::{FittedCircle, Reading, Steady};
use super::fit::ArcFit;
use crate::math::so3;
use crate::physics::State;

/// Least radius of a circle, as a share of the point's distance from the centre: smaller ones are noise.
const LEAST: f64 = 0.05;
/// Number of rates that are kept.
const RATES: usize = 2;

/// Fits of a flight through the places of the point `lever_m` in body axes, at times since the epoch;
/// `straight` is the parabola through them. The best come first.
pub(super) fn fits(
    places: &[Place],
    lever_m: &Vector3<f64>,
    pull_m_s2: &Vector3<f64>,
    straight: &State,
) -> Vec<ArcFit> {
    let unfallen = |(s, place_m): &Place| (*s, place_m - pull_m_s2 * (0.5 * s * s));
    let unfallen: Vec<Reading> = places.iter().map(unfallen).collect();
    let mut best = FittedCircle::through(&unfallen, Steady::Moving);
    best.retain(|circle| circle.radius() > LEAST * lever_m.norm());
    best.truncate(RATES);
    let fits: Vec<ArcFit> = best
        .iter()
        .flat_map(|circle| on_circle(circle, lever_m))
        .collect();
    if !fits.is_empty() {
        return fits;
    }
    let orientation = UnitQuaternion::identity();
    let state = State {
        position_m: straight.position_m - orientation * lever_m,
        ..*straight
    };
    vec![ArcFit::of(state, f64::INFINITY)]
}

/// The states at the epoch, with either sign of `a`.
fn on_circle(circle: &FittedCircle, lever_m: &Vector3<f64>) -> Vec<ArcFit> {
    let [place_m, velocity_m_s] = circle.steady;
    let Some(about) = circle.about() else {
        return Vec::new();
    };
    let radius_m = circle.radius().min(lever_m.norm());
    // Not below zero by rounding.
    let along_m = (lever_m.norm_squared() - radius_m * radius_m)
        .max(0.0)
        .sqrt();
    let across = circle.cosine.normalize() * radius_m;
    let signs: &[f64] = if along_m > 0.0 { &[1.0, -1.0] } else { &[1.0] };
    let states = signs.iter().map(|sign| {
        let lever = across + about * (sign * along_m);
        let orientation = so3::between(lever_m, &lever);
        let state = State {
            position_m: place_m - about * (sign * along_m),
            orientation,
            velocity_m_s,
            angular_velocity_rad_s: orientation.inverse() * (about * circle.rate_rad_s),
        };
        ArcFit::of(state, circle.square / lever_m.norm_squared())
    });
    states.collect()
}
