//! An object at rest: what its tracker makes up.

use nalgebra::{Quaternion, SymmetricEigen, UnitQuaternion, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::error::CalibrateError;
use super::spread::{CONFIDENCE, correlation_time};
use super::stream::Stream;
use crate::math::so3::log;

/// Fewest poses.
const LEAST: usize = 30;

/// Fewest independent samples for an interval that can be trusted.
const LEAST_INDEPENDENT: f64 = 8.0;

/// Parts of the recording that are compared to see whether the object moved.
const PARTS: usize = 5;

/// The noise along or about one axis, in metres or radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseAxis {
    /// Standard deviation.
    pub sd: f64,
    /// Lower end of its interval.
    pub lower: f64,
    /// Upper end of its interval.
    pub upper: f64,
    /// The part that changes from sample to sample: root mean square of successive differences over √2.
    pub fast_sd: f64,
    /// Integrated correlation time in samples; 1 is white noise.
    pub correlation: f64,
}

/// An object at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct RestFit {
    /// Noise of positions along the world's axes \[m\].
    pub position_m: [NoiseAxis; 3],
    /// Noise of orientations about the tracker's axes \[rad\].
    pub orientation_rad: [NoiseAxis; 3],
    /// Mean position \[m\].
    pub place_m: Vector3<f64>,
    /// Mean orientation.
    pub world_from_tracker: UnitQuaternion<f64>,
    /// How far apart the means of a fifth of the time are \[m\].
    pub moved_m: f64,
    /// How far the mean orientations of a fifth of the time are apart \[rad\].
    pub turned_rad: f64,
    /// Whether noise wanders as slowly as the recording is long: intervals are then too narrow.
    pub is_slow: bool,
    /// Share of poses that are the very same as the one before.
    pub frozen: f64,
}

/// Standard deviations per axis with intervals of the χ² law, for as many samples as are independent: `n / (1 + 2 Σ ρ²)`.
/// The law is that of normal noise; a vibration's is narrower. Fails with fewer than 30 poses.
pub fn rest(stream: &Stream) -> Result<RestFit, CalibrateError> {
    let readings = &stream.readings;
    if readings.len() < LEAST {
        return Err(CalibrateError::TooFew {
            usable: readings.len(),
            least: LEAST,
        });
    }
    let count = readings.len();
    let poses = || readings.iter().map(|reading| &reading.world_from_tracker);
    let positions: Vec<Vector3<f64>> = poses().map(|pose| pose.translation.vector).collect();
    let turns: Vec<UnitQuaternion<f64>> = poses().map(|pose| pose.rotation).collect();
    let world_from_tracker = mean_turn(&turns);
    let place_m = mean(&positions);
    let vectors: Vec<Vector3<f64>> = turns
        .iter()
        .map(|turn| log(&(world_from_tracker.inverse() * turn)))
        .collect();
    let noise = |of: &[Vector3<f64>]| {
        [0, 1, 2].map(|axis| noise(&of.iter().map(|v| [v[axis]]).collect::<Vec<_>>()))
    };
    let (position_m, orientation_rad) = (noise(&positions), noise(&vectors));
    let largest = |of: &[Vector3<f64>]| {
        let means: Vec<_> = of.chunks(count.div_ceil(PARTS)).map(mean).collect();
        let pairs = means
            .iter()
            .flat_map(|a| means.iter().map(move |b| (a - b).norm()));
        pairs.fold(0.0, f64::max)
    };
    let axes = || position_m.iter().chain(&orientation_rad);
    let is_slow = axes().any(|of| of.sd > 0.0 && count as f64 / of.correlation < LEAST_INDEPENDENT);
    let same = readings
        .windows(2)
        .filter(|pair| pair[0].world_from_tracker == pair[1].world_from_tracker);
    Ok(RestFit {
        position_m,
        orientation_rad,
        place_m,
        world_from_tracker,
        moved_m: largest(&positions),
        turned_rad: largest(&vectors),
        is_slow,
        frozen: same.count() as f64 / (count - 1) as f64,
    })
}

fn mean(of: &[Vector3<f64>]) -> Vector3<f64> {
    of.iter().sum::<Vector3<f64>>() / of.len() as f64
}

/// The mean of rotations: the principal axis of their quaternions' scatter (Markley and others, 2007).
pub(super) fn mean_turn(turns: &[UnitQuaternion<f64>]) -> UnitQuaternion<f64> {
    let scatter = turns
        .iter()
        .map(|turn| turn.coords * turn.coords.transpose());
    let eigen = SymmetricEigen::new(scatter.sum::<nalgebra::Matrix4<f64>>());
    let column = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    UnitQuaternion::from_quaternion(Quaternion::from(column.into_owned()))
}

fn noise(series: &[[f64; 1]]) -> NoiseAxis {
    let count = series.len() as f64;
    let mean = series.iter().map(|x| x[0]).sum::<f64>() / count;
    let square: f64 = series.iter().map(|x| (x[0] - mean).powi(2)).sum();
    let correlation = correlation_time(series, |rho| rho);
    // The mean takes as much of the variance as one independent sample has.
    let sd = (square / (count - correlation).max(1.0)).sqrt();
    let independent = count / correlation_time(series, |rho| rho * rho) - 1.0;
    let quantile = |p: f64| {
        let law = ChiSquared::new(independent.max(1.0));
        law.map_or(f64::NAN, |law| law.inverse_cdf(p) / independent.max(1.0))
    };
    let tail = 0.5 * (1.0 - CONFIDENCE);
    let differences = series
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]).powi(2));
    NoiseAxis {
        sd,
        lower: sd / quantile(1.0 - tail).sqrt(),
        upper: sd / quantile(tail).sqrt(),
        fast_sd: (0.5 * differences.sum::<f64>() / (count - 1.0)).sqrt(),
        correlation,
    }
}
