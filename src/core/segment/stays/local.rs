//! How a body moves about each moment: polynomials through the samples near by.
//!
//! Places and rotation vectors about the middle sample are fitted with `c₀ + c₁ t + c₂ t²` over 30 ms to either side, or two
//! samples. What that leaves is the tracker's noise, of which the median over the stream is taken: impacts, which no
//! polynomial follows, are few.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use crate::math::{Pose, so3};
use crate::motion::Sample;

/// Half of a window \[s\], and at least so many samples.
const HALF_S: f64 = 0.03;
const HALF_SAMPLES: usize = 2;
/// Moments are at least so far apart \[s\].
const APART_S: f64 = 0.005;
/// A window that is so many times as long as the usual one has a gap.
const GAP_RATIO: f64 = 1.8;
/// Greatest turn from the middle of a window that is told by both poses alone \[rad\].
const TURN_RAD: f64 = 2.5;
/// Numbers of a polynomial.
const NUMBERS: usize = 3;

/// How a body moves about one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalMotion {
    /// Acted time \[s\].
    pub(super) time_s: f64,
    /// World from body.
    pub(super) pose: Pose,
    /// Of the centre of mass, world axes [m/s].
    pub(super) velocity_m_s: Vector3<f64>,
    /// World axes [rad/s].
    pub(super) spin_rad_s: Vector3<f64>,
}

/// How a body moves along its stream.
#[derive(Clone, Debug)]
pub(super) struct LocalMotions {
    /// In order of time.
    pub(super) each: Vec<LocalMotion>,
    /// All that is seen of poses: times \[s\] and places.
    pub(super) poses: Vec<(f64, Pose)>,
    /// Noise of a sample per axis \[m\].
    pub(super) noise_m: f64,
    /// Noise of a sample's orientation per axis \[rad\].
    pub(super) noise_rad: f64,
    /// Deviation of a velocity per axis [m/s].
    pub(super) velocity_sd_m_s: f64,
    /// Deviation of a spin per axis [rad/s].
    pub(super) spin_sd_rad_s: f64,
}

impl LocalMotions {
    /// `None` of streams that show other things than poses, or too few.
    pub(super) fn of(samples: &[Sample]) -> Option<Self> {
        let poses = samples.iter().map(|sample| {
            let place_m = sample.seen.position_m()?;
            let pose = Pose::from_parts(place_m.into(), sample.seen.orientation()?);
            Some((sample.acted_s, pose))
        });
        let poses: Vec<(f64, Pose)> = poses.collect::<Option<_>>()?;
        let count = poses.len();
        let interval_s = median(poses.windows(2).map(|pair| pair[1].0 - pair[0].0))?;
        let half = ((HALF_S / interval_s.max(1e-9)).round() as usize).max(HALF_SAMPLES);
        let stride = ((APART_S / interval_s.max(1e-9)).round() as usize).max(1);
        if count < 2 * half + 1 {
            return None;
        }
        let usual_s = 2.0 * half as f64 * interval_s;
        let (mut each, mut left_m, mut left_rad, mut spreads_s) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for middle in (half..count - half).step_by(stride) {
            let window = &poses[middle - half..=middle + half];
            if window[2 * half].0 - window[0].0 > GAP_RATIO * usual_s {
                continue;
            }
            let (time_s, about) = window[half];
            let times_s = window.iter().map(|(at_s, _)| at_s - time_s);
            let times_s: Vec<f64> = times_s.collect();
            let origin_m = about.translation.vector;
            let places = window
                .iter()
                .map(|(_, pose)| pose.translation.vector - origin_m);
            let (Some(place), Some(turn)) = (
                Polynomial::through(&times_s, places.collect()),
                Polynomial::through(&times_s, turns(window, half)),
            ) else {
                continue;
            };
            left_m.push(place.variance);
            left_rad.push(turn.variance);
            spreads_s.push(place.slope_sd_per_s);
            let turned = so3::exp(&turn.coefficients[0]) * about.rotation;
            each.push(LocalMotion {
                time_s,
                pose: Pose::from_parts((origin_m + place.coefficients[0]).into(), turned),
                velocity_m_s: place.coefficients[1],
                spin_rad_s: turn.coefficients[1],
            });
        }
        let noise_m = median(left_m.into_iter())?.sqrt();
        let noise_rad = median(left_rad.into_iter())?.sqrt();
        let per_s = median(spreads_s.into_iter())?;
        Some(Self {
            each,
            poses,
            noise_m,
            noise_rad,
            velocity_sd_m_s: noise_m * per_s,
            spin_sd_rad_s: noise_rad * per_s,
        })
    }

    /// The samples between two times \[s\].
    pub(super) fn within(&self, span_s: [f64; 2]) -> Range<usize> {
        let first = self.poses.partition_point(|of| of.0 < span_s[0]);
        let last = self.poses.partition_point(|of| of.0 <= span_s[1]);
        first..last.max(first)
    }

    /// How many there are.
    pub(super) fn count(&self, span_s: [f64; 2]) -> usize {
        self.within(span_s).len()
    }

    /// The motion at a time \[s\], between the two moments about it; `None` beyond them.
    pub(super) fn at(&self, time_s: f64, within_s: f64) -> Option<LocalMotion> {
        let after = self.each.partition_point(|of| of.time_s < time_s);
        let later = self.each.get(after)?;
        let Some(before) = after.checked_sub(1).map(|at| &self.each[at]) else {
            return (later.time_s - time_s <= 1e-9).then_some(*later);
        };
        let apart_s = later.time_s - before.time_s;
        if apart_s > within_s {
            return None;
        }
        let share = ((time_s - before.time_s) / apart_s).clamp(0.0, 1.0);
        let turned = so3::log(&(before.pose.rotation.inverse() * later.pose.rotation));
        let between = |a: Vector3<f64>, b: Vector3<f64>| a.lerp(&b, share);
        let place_m = between(
            before.pose.translation.vector,
            later.pose.translation.vector,
        );
        let turn = before.pose.rotation * so3::exp(&(share * turned));
        Some(LocalMotion {
            time_s,
            pose: Pose::from_parts(place_m.into(), turn),
            velocity_m_s: between(before.velocity_m_s, later.velocity_m_s),
            spin_rad_s: between(before.spin_rad_s, later.spin_rad_s),
        })
    }
}

/// How far the poses of a window are turned from the middle one: rotation vectors, world axes. What turns by more than is told apart
/// there is followed step by step.
fn turns(window: &[(f64, Pose)], half: usize) -> Vec<Vector3<f64>> {
    let turn = |from: usize, to: usize| {
        so3::log(&(window[to].1.rotation * window[from].1.rotation.inverse()))
    };
    let steps = (1..window.len()).map(|to| turn(to - 1, to));
    let steps: Vec<Vector3<f64>> = steps.collect();
    let most_rad = steps.iter().map(|step| step.norm()).fold(0.0, f64::max);
    if most_rad * (half as f64) < TURN_RAD {
        return (0..window.len()).map(|to| turn(half, to)).collect();
    }
    let along = |to: usize| {
        let sum = |steps: &[Vector3<f64>]| steps.iter().sum::<Vector3<f64>>();
        match to < half {
            true => -sum(&steps[to..half]),
            false => sum(&steps[half..to]),
        }
    };
    (0..window.len()).map(along).collect()
}

/// A polynomial of second degree, of least squares.
struct Polynomial {
    coefficients: [Vector3<f64>; NUMBERS],
    /// Of what is left, per axis.
    variance: f64,
    /// Deviation of the slope over that of a sample [1/s].
    slope_sd_per_s: f64,
}

impl Polynomial {
    fn through(times_s: &[f64], values: Vec<Vector3<f64>>) -> Option<Self> {
        let reach_s = times_s.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
        let powers = |time_s: f64| {
            let u = time_s / reach_s;
            Vector3::new(1.0, u, u * u)
        };
        let (mut gram, mut moments) = (Matrix3::zeros(), Matrix3::zeros());
        for (time_s, value) in times_s.iter().zip(&values) {
            let powers = powers(*time_s);
            gram += powers * powers.transpose();
            moments += powers * value.transpose();
        }
        let covariance = gram.try_inverse()?;
        let solution = covariance * moments;
        let left = times_s
            .iter()
            .zip(&values)
            .map(|(time_s, value)| (value - solution.transpose() * powers(*time_s)).norm_squared());
        let freedom = (3 * values.len().saturating_sub(NUMBERS)).max(1);
        let variance = left.sum::<f64>() / freedom as f64;
        let scaled = |power: i32| solution.row(power as usize).transpose() / reach_s.powi(power);
        let of = Self {
            coefficients: [scaled(0), scaled(1), scaled(2)],
            variance,
            slope_sd_per_s: covariance[(1, 1)].sqrt() / reach_s,
        };
        of.variance.is_finite().then_some(of)
    }
}

/// The middle of some numbers.
pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
