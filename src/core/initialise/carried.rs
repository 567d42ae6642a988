//! The turning of what a surface carries, by linear least squares: friction changes it steadily, so that the angular
//! velocity is linear in time,
//!
//! ```text
//! min over ω, α   Σ |ω + α s_i − Log(R_{i+1} R_iᵀ)/(s_{i+1} − s_i)|²        s_i in the middle of both, in world axes
//! ```

use nalgebra::{UnitQuaternion, Vector3};

use super::turn::OrientationReading;
use crate::math::so3;

/// World from body and the angular velocity [rad/s, body] at the epoch, of readings in order of time; `None` of fewer
/// than three.
pub(super) fn turn(readings: &[OrientationReading]) -> Option<(UnitQuaternion<f64>, Vector3<f64>)> {
    let pairs = readings.windows(2).filter(|pair| pair[0].0 < pair[1].0);
    let rates = pairs.map(|pair| {
        let ((from_s, from), (to_s, to)) = (pair[0], pair[1]);
        let turned = so3::log(&(to * from.inverse()));
        (0.5 * (from_s + to_s), turned / (to_s - from_s))
    });
    let rates: Vec<(f64, Vector3<f64>)> = rates.collect();
    let count = rates.len() as f64;
    if rates.len() < 2 {
        return None;
    }
    let mean_s = rates.iter().map(|(s, _)| s).sum::<f64>() / count;
    let mean = rates.iter().map(|(_, rate)| rate).sum::<Vector3<f64>>() / count;
    let spread_s2: f64 = rates.iter().map(|(s, _)| (s - mean_s).powi(2)).sum();
    let leaning: Vector3<f64> = rates.iter().map(|(s, rate)| rate * (s - mean_s)).sum();
    let omega = mean - leaning * (mean_s / spread_s2.max(f64::MIN_POSITIVE));
    let nearest = readings
        .iter()
        .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let (since_s, orientation) = *nearest?;
    let orientation = so3::exp(&(omega * -since_s)) * orientation;
    Some((orientation, orientation.inverse() * omega))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball that spins up from nothing to 40 rad/s, and turns about its normal, read every 10 ms.
    #[test]
    fn what_spins_up_is_found() {
        let omega = |s: f64| Vector3::new(0.0, 20.0 + 100.0 * s, 3.0);
        let mut orientation = UnitQuaternion::from_euler_angles(0.3, -0.8, 2.0);
        let (mut readings, mut at_epoch) = (Vec::new(), orientation);
        for step in -2000..=2000 {
            let s = f64::from(step) * 1e-4;
            if step == 0 {
                at_epoch = orientation;
            }
            if step % 100 == 30 {
                readings.push((s, orientation));
            }
            orientation = so3::exp(&(omega(s + 5e-5) * 1e-4)) * orientation;
        }
        let (found, spin) = turn(&readings).expect("enough readings");
        assert!(found.angle_to(&at_epoch) < 0.02);
        assert!((found * spin - omega(0.0)).norm() < 0.1);
        assert!(turn(&readings[..2]).is_none());
    }
}
