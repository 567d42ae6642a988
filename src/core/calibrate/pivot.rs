//! The tip that stays in one place while the object swings about it.

use nalgebra::{Matrix3, Matrix3xX, Vector3};

use super::error::CalibrateError;
use super::regression::{Equation, regress};
use super::spread::{Measured, Spread};
use super::stream::Stream;
use crate::math::so3::matrix;

/// Fewest poses.
pub(super) const LEAST: usize = 30;

/// Least turn about each axis, root mean square \[rad\]: with less, a millimetre of noise is
/// centimetres of the tip.
const LEAST_SWING_RAD: f64 = 0.05;

/// Where the tip is.
#[derive(Clone, Debug, PartialEq)]
pub struct PivotFit {
    /// The tip in the tracker's axes, from its origin \[m\].
    pub tip_m: Measured,
    /// Where it was held \[m, world\].
    pub place_m: Measured,
    /// Root mean square distance of the tip from that place \[m\].
    pub residual_m: f64,
    /// Samples that are too far off to count.
    pub outliers: usize,
    /// Turn about the axis about which it was turned least, root mean square \[rad\].
    pub swing_rad: f64,
    /// How the residuals are correlated.
    pub spread: Spread,
}

/// Finds tip `p` and place `c` by `x_i + R_i p = c`, six unknowns in three linear equations per sample.
///
/// The orientations' noise makes `R_i` shorter by `σ²` on average, so that the tip comes out too near by
/// that share: 0.03 % at 1°.
///
/// Fails where there are fewer than 30 poses, or the object hardly turns about some axis.
pub fn pivot(stream: &Stream) -> Result<PivotFit, CalibrateError> {
    let readings = &stream.readings;
    if readings.len() < LEAST {
        return Err(CalibrateError::TooFew {
            usable: readings.len(),
            least: LEAST,
        });
    }
    let turns: Vec<Matrix3<f64>> = readings
        .iter()
        .map(|reading| matrix(&reading.world_from_tracker.rotation))
        .collect();
    let swing_rad = least_swing_rad(&turns);
    let too_little = CalibrateError::NoSwing {
        least_deg: swing_rad.to_degrees(),
        needed_deg: (LEAST_SWING_RAD.to_degrees() * 10.0).round() / 10.0,
    };
    if !(swing_rad >= LEAST_SWING_RAD) {
        return Err(too_little);
    }
    // Relative to the mean, so that numbers are small wherever the world's origin is.
    let count = readings.len() as f64;
    let positions = readings.iter();
    let positions = positions.map(|reading| reading.world_from_tracker.translation.vector);
    let middle_m = positions.clone().sum::<Vector3<f64>>() / count;
    let equations: Vec<Equation> = turns
        .iter()
        .zip(positions)
        .map(|(turn, position_m)| {
            let mut coefficients = Matrix3xX::zeros(6);
            coefficients.fixed_columns_mut::<3>(0).copy_from(turn);
            coefficients
                .fixed_columns_mut::<3>(3)
                .copy_from(&-Matrix3::identity());
            Equation {
                coefficients,
                observed: middle_m - position_m,
            }
        })
        .collect();
    let fit = regress(&equations).ok_or(too_little)?;
    let sd = |of: usize| fit.covariance[(of, of)].max(0.0).sqrt();
    let freedom = (fit.spread.blocks - 1) as f64;
    let x = &fit.unknowns;
    Ok(PivotFit {
        tip_m: Measured::new(vec![x[0], x[1], x[2]], (0..3).map(sd).collect(), freedom),
        place_m: Measured::new(
            (0..3).map(|axis| x[3 + axis] + middle_m[axis]).collect(),
            (3..6).map(sd).collect(),
            freedom,
        ),
        residual_m: fit.rms(),
        outliers: fit.outliers(),
        swing_rad,
        spread: fit.spread,
    })
}

/// What the tip's least determined direction is determined by: the root of the least eigenvalue of
/// the mean of `(R_i − R̄)ᵀ(R_i − R̄)`, about the root mean square turn across that direction.
fn least_swing_rad(turns: &[Matrix3<f64>]) -> f64 {
    let count = turns.len() as f64;
    let mean = turns.iter().sum::<Matrix3<f64>>() / count;
    let spread = turns
        .iter()
        .map(|turn| (turn - mean).tr_mul(&(turn - mean)));
    let spread = spread.sum::<Matrix3<f64>>() / count;
    spread.symmetric_eigenvalues().min().max(0.0).sqrt()
}
