//! First guesses of a flight of which one point beside the centre of mass is seen.
//!
//! The point `p` of a body that turns steadily about a direction `u` fixed in space, as symmetric
//! bodies do, is at
//!
//! ```text
//! x₀ + v s + ½ g s² + a u + b cos ωs + (u × b) sin ωs,   a² + |b|² = |p|², b ⊥ u
//! ```
//!
//! For a given rate `ω` that is linear in `x₀ + a u`, `v`, `b` and `u × b`. Rates are tried over a
//! grid; of `a` both signs fit, of the rotation about `p` nothing is seen.

use nalgebra::{DMatrix, UnitQuaternion, Vector3};

use super::ballistic::Place;
use super::fit::Fit;
use crate::math::so3;
use crate::physics::State;

/// Greatest angle between samples that is tried \[rad\]: more looks like less.
const STEP_RAD: f64 = 2.0;
/// Steps of the grid per turn over the whole flight.
const PER_TURN: f64 = 6.0;
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
) -> Vec<Fit> {
    let arm_m = lever_m.norm();
    let unturned = || {
        let orientation = UnitQuaternion::identity();
        let state = State {
            position_m: straight.position_m - orientation * lever_m,
            ..*straight
        };
        vec![Fit::of(state, f64::INFINITY)]
    };
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return unturned();
    };
    let span_s = last.0 - first.0;
    if places.len() < 6 || !(span_s > 0.0) {
        return unturned();
    }
    let step_rad_s = std::f64::consts::TAU / (PER_TURN * span_s);
    let most_rad_s = STEP_RAD * (places.len() - 1) as f64 / span_s;
    let count = (most_rad_s / step_rad_s).floor() as usize;
    let rates = (1..=count).map(|step| step as f64 * step_rad_s);
    let tried: Vec<Circle> = rates
        .filter_map(|rate| Circle::at(places, pull_m_s2, rate))
        .collect();
    let mut best: Vec<Circle> = Vec::new();
    for (at, circle) in tried.iter().enumerate() {
        let is_least =
            |other: Option<&Circle>| other.is_none_or(|other| circle.square_m2 <= other.square_m2);
        let before = at.checked_sub(1).and_then(|before| tried.get(before));
        if is_least(before) && is_least(tried.get(at + 1)) {
            best.push(circle.refined(places, pull_m_s2, step_rad_s));
        }
    }
    best.retain(|circle| circle.radius_m() > LEAST * arm_m);
    best.sort_by(|a, b| a.square_m2.total_cmp(&b.square_m2));
    best.truncate(RATES);
    let fits = best.iter().flat_map(|circle| circle.fits(lever_m));
    let fits: Vec<Fit> = fits.collect();
    if fits.is_empty() { unturned() } else { fits }
}

/// The best flight with one rate.
#[derive(Clone, Debug)]
struct Circle {
    rate_rad_s: f64,
    /// `x₀ + a u`, `v`, `b`, `u × b`.
    columns: [Vector3<f64>; 4],
    square_m2: f64,
}

impl Circle {
    fn at(places: &[Place], pull_m_s2: &Vector3<f64>, rate_rad_s: f64) -> Option<Self> {
        let design = DMatrix::from_fn(places.len(), 4, |row, column| {
            let s = places[row].0;
            match column {
                0 => 1.0,
                1 => s,
                2 => (rate_rad_s * s).cos(),
                _ => (rate_rad_s * s).sin(),
            }
        });
        let seen = DMatrix::from_fn(places.len(), 3, |row, axis| {
            let (s, place_m) = places[row];
            (place_m - pull_m_s2 * (0.5 * s * s))[axis]
        });
        let normal = (design.tr_mul(&design)).cholesky()?;
        let found = normal.solve(&design.tr_mul(&seen));
        let left = &seen - &design * &found;
        Some(Self {
            rate_rad_s,
            columns: std::array::from_fn(|row| {
                found.row(row).transpose().fixed_rows::<3>(0).into()
            }),
            square_m2: left.norm_squared(),
        })
    }

    /// The best rate within a step of the grid, by halving.
    fn refined(&self, places: &[Place], pull_m_s2: &Vector3<f64>, step_rad_s: f64) -> Self {
        let mut best = self.clone();
        let mut step_rad_s = 0.5 * step_rad_s;
        for _ in 0..12 {
            for by in [-step_rad_s, step_rad_s] {
                let rate = best.rate_rad_s + by;
                if let Some(other) = Self::at(places, pull_m_s2, rate)
                    && rate > 0.0
                    && other.square_m2 < best.square_m2
                {
                    best = other;
                }
            }
            step_rad_s *= 0.5;
        }
        best
    }

    fn radius_m(&self) -> f64 {
        let [_, _, cosine, sine] = &self.columns;
        (0.5 * (cosine.norm_squared() + sine.norm_squared())).sqrt()
    }

    /// The states at the epoch, with either sign of `a`.
    fn fits(&self, lever_m: &Vector3<f64>) -> Vec<Fit> {
        let [place_m, velocity_m_s, cosine, sine] = self.columns;
        let Some(about) = cosine.cross(&sine).try_normalize(0.0) else {
            return Vec::new();
        };
        let radius_m = self.radius_m().min(lever_m.norm());
        // Not below zero by rounding.
        let along_m = (lever_m.norm_squared() - radius_m * radius_m)
            .max(0.0)
            .sqrt();
        let across = cosine.normalize() * radius_m;
        let signs: &[f64] = if along_m > 0.0 { &[1.0, -1.0] } else { &[1.0] };
        let states = signs.iter().map(|sign| {
            let lever = across + about * (sign * along_m);
            let orientation = so3::between(lever_m, &lever);
            let state = State {
                position_m: place_m - about * (sign * along_m),
                orientation,
                velocity_m_s,
                angular_velocity_rad_s: orientation.inverse() * (about * self.rate_rad_s),
            };
            Fit::of(state, self.square_m2 / lever_m.norm_squared())
        });
        states.collect()
    }
}
