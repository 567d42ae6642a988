//! Circles through vectors that turn steadily about a direction `u` fixed in space.
//!
//! A vector of a body that turns so is, with a steady part that may move on evenly,
//!
//! ```text
//! c + v s + b cos ωs + (u × b) sin ωs,   b ⊥ u
//! ```
//!
//! For a given rate `ω` that is linear in `c`, `v`, `b` and `u × b`. Rates are tried over a grid.

use nalgebra::{DMatrix, Vector3};

/// Greatest angle between readings that is tried \[rad\]: more looks like less.
const STEP_RAD: f64 = 2.0;
/// Steps of the grid per turn over the whole flight.
const PER_TURN: f64 = 6.0;
/// Least number of readings.
const READINGS_MIN: usize = 6;
/// Halvings of a step of the grid.
const HALVINGS: usize = 12;

/// A vector, at a time since the epoch \[s\].
pub(super) type Reading = (f64, Vector3<f64>);

/// How the steady part moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Steady {
    /// Not at all: directions do not.
    Still,
    /// At an even velocity, as places do.
    Moving,
}

/// The best fit with one rate.
#[derive(Clone, Debug)]
pub(super) struct FittedCircle {
    pub(super) rate_rad_s: f64,
    /// `c` and `v`.
    pub(super) steady: [Vector3<f64>; 2],
    /// `b`.
    pub(super) cosine: Vector3<f64>,
    /// `u × b`.
    pub(super) sine: Vector3<f64>,
    /// Sum of squared residuals.
    pub(super) square: f64,
}

impl FittedCircle {
    /// Circles whose rates fit better than those beside them, the best first; none through too few
    /// readings.
    pub(super) fn through(readings: &[Reading], steady: Steady) -> Vec<Self> {
        let (Some(first), Some(last)) = (readings.first(), readings.last()) else {
            return Vec::new();
        };
        let span_s = last.0 - first.0;
        if readings.len() < READINGS_MIN || !(span_s > 0.0) {
            return Vec::new();
        }
        let step_rad_s = std::f64::consts::TAU / (PER_TURN * span_s);
        let most_rad_s = STEP_RAD * (readings.len() - 1) as f64 / span_s;
        let count = (most_rad_s / step_rad_s).floor() as usize;
        let rates = (1..=count).map(|step| step as f64 * step_rad_s);
        let tried: Vec<Self> = rates
            .filter_map(|rate| Self::at(readings, steady, rate))
            .collect();
        let mut best: Vec<Self> = Vec::new();
        for (at, circle) in tried.iter().enumerate() {
            let is_least =
                |other: Option<&Self>| other.is_none_or(|other| circle.square <= other.square);
            let before = at.checked_sub(1).and_then(|before| tried.get(before));
            if is_least(before) && is_least(tried.get(at + 1)) {
                best.push(circle.refined(readings, steady, step_rad_s));
            }
        }
        best.sort_by(|a, b| a.square.total_cmp(&b.square));
        best
    }

    fn at(readings: &[Reading], steady: Steady, rate_rad_s: f64) -> Option<Self> {
        let moving = usize::from(steady == Steady::Moving);
        let design = DMatrix::from_fn(readings.len(), 3 + moving, |row, column| {
            let s = readings[row].0;
            match column {
                0 => 1.0,
                1 if moving == 1 => s,
                _ if column == 1 + moving => (rate_rad_s * s).cos(),
                _ => (rate_rad_s * s).sin(),
            }
        });
        let seen = DMatrix::from_fn(readings.len(), 3, |row, axis| readings[row].1[axis]);
        let normal = (design.tr_mul(&design)).cholesky()?;
        let found = normal.solve(&design.tr_mul(&seen));
        let left = &seen - &design * &found;
        let column =
            |row: usize| -> Vector3<f64> { found.row(row).transpose().fixed_rows::<3>(0).into() };
        let velocity = match steady {
            Steady::Still => Vector3::zeros(),
            Steady::Moving => column(1),
        };
        Some(Self {
            rate_rad_s,
            steady: [column(0), velocity],
            cosine: column(1 + moving),
            sine: column(2 + moving),
            square: left.norm_squared(),
        })
    }

    /// The best rate within a step of the grid, by halving.
    fn refined(&self, readings: &[Reading], steady: Steady, step_rad_s: f64) -> Self {
        let mut best = self.clone();
        let mut step_rad_s = 0.5 * step_rad_s;
        for _ in 0..HALVINGS {
            for by in [-step_rad_s, step_rad_s] {
                let rate = best.rate_rad_s + by;
                if let Some(other) = Self::at(readings, steady, rate)
                    && rate > 0.0
                    && other.square < best.square
                {
                    best = other;
                }
            }
            step_rad_s *= 0.5;
        }
        best
    }

    /// Its radius, in units of the readings.
    pub(super) fn radius(&self) -> f64 {
        (0.5 * (self.cosine.norm_squared() + self.sine.norm_squared())).sqrt()
    }

    /// About what it turns: `u`; `None` where it is no circle.
    pub(super) fn about(&self) -> Option<Vector3<f64>> {
        self.cosine.cross(&self.sine).try_normalize(0.0)
    }
}
