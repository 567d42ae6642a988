//! The turning of what a surface carries, by linear least squares: friction changes it steadily, so that the angular
//! velocity is linear in time,
//!
//! ```text
//! min over ω, α   Σ |ω + α s_i − Log(R_{i+1} R_iᵀ)/(s_{i+1} − s_i)|²        s_i in the middle of both, in world axes
//! ```

use nalgebra::{UnitQuaternion, Vector3};

use super::turn::OrientationReading;
use crate::math::so3;
use crate::physics::{Body, OnPlane, Support, Sustained};

/// How a body turns about the epoch.
#[derive(Clone, Copy, Debug)]
pub(super) struct SteadyTurn {
    /// World from body.
    pub(super) orientation: UnitQuaternion<f64>,
    /// Angular velocity [rad/s, body].
    pub(super) angular_velocity_rad_s: Vector3<f64>,
    /// Its rate [rad/s², world].
    pub(super) rate_rad_s2: Vector3<f64>,
}

/// Of readings in order of time; `None` of fewer than three.
pub(super) fn turn(readings: &[OrientationReading]) -> Option<SteadyTurn> {
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
    let rate_rad_s2 = leaning / spread_s2.max(f64::MIN_POSITIVE);
    let omega = mean - rate_rad_s2 * mean_s;
    let nearest = readings
        .iter()
        .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let (since_s, orientation) = *nearest?;
    let orientation = so3::exp(&(omega * -since_s)) * orientation;
    Some(SteadyTurn {
        orientation,
        angular_velocity_rad_s: orientation.inverse() * omega,
        rate_rad_s2,
    })
}

/// The coefficient of friction that changes the turning of what is round so: what rolls moves with its spin, what slides is
/// turned by the friction alone. `None` where nothing round is, or it hardly moves.
///
/// A guess that is off by a third lets what rolls for long turn by other whole turns.
pub(super) fn friction(
    body: &Body,
    pull_m_s2: &Vector3<f64>,
    turn: &SteadyTurn,
    velocity_m_s: &Vector3<f64>,
) -> Option<f64> {
    let Some(Support::Plane(plane)) = body.support() else {
        return None;
    };
    let (n, radius_m) = (plane.normal, plane.touching.radius_m()?);
    let pressed = -pull_m_s2.dot(&n);
    let moments = body.gyration_m2();
    let (about_m2, way) = match plane.touching {
        OnPlane::Side { axis, .. } => {
            let across = n.cross(&(turn.orientation * axis));
            (
                axis.dot(&moments.component_mul(&axis)),
                across.try_normalize(LEAST_M_S),
            )
        }
        _ => (
            moments.mean(),
            (velocity_m_s - n * n.dot(velocity_m_s)).try_normalize(LEAST_M_S),
        ),
    };
    let way = way?;
    let ahead = way * way.dot(velocity_m_s).signum();
    let changed = turn.rate_rad_s2.cross(&n) * radius_m;
    let friction = match plane.sustained {
        Sustained::Roll => {
            let share = 1.0 / (1.0 + about_m2 / (radius_m * radius_m));
            (pull_m_s2 * share - changed).dot(&ahead) / pressed
        }
        Sustained::Slide => changed.norm() * about_m2 / (radius_m * radius_m) / pressed,
        Sustained::Rest => return None,
    };
    (friction > 0.0).then_some(friction)
}

/// Least speed of which a direction is told [m/s].
const LEAST_M_S: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::PlaneSupport;

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
        let found = turn(&readings).expect("enough readings");
        assert!(found.orientation.angle_to(&at_epoch) < 0.02);
        let spin = found.orientation * found.angular_velocity_rad_s;
        assert!((spin - omega(0.0)).norm() < 0.1);
        assert!((found.rate_rad_s2 - Vector3::y() * 100.0).norm() < 1.0);
        assert!(turn(&readings[..2]).is_none());
    }

    /// A cylinder that rolls and a ball that slides, with the rates that their frictions give them.
    #[test]
    fn friction_is_told_by_how_the_spin_changes() {
        let gravity = Vector3::new(0.0, 0.0, -10.0);
        let velocity = Vector3::x();
        let of = |sustained, touching, moments: Vector3<f64>, rate_rad_s2: f64| {
            let plane = PlaneSupport {
                normal: Vector3::z(),
                sustained,
                friction: 0.0,
                touching,
            };
            let body = Body::new(1.0, moments).unwrap();
            let body = body.with_support(Some(Support::Plane(plane)));
            let turn = SteadyTurn {
                orientation: UnitQuaternion::identity(),
                angular_velocity_rad_s: Vector3::zeros(),
                rate_rad_s2: Vector3::y() * rate_rad_s2,
            };
            friction(&body, &gravity, &turn, &velocity)
        };
        let side = OnPlane::Side {
            radius_m: 0.02,
            axis: Vector3::y(),
        };
        let moments = Vector3::new(1e-3, 2e-4, 1e-3);
        // v̇ = −μ g, ω̇ = v̇/r.
        let rolling = of(Sustained::Roll, side, moments, -0.03 * 10.0 / 0.02);
        assert!((rolling.unwrap() - 0.03).abs() < 1e-12);
        // I ω̇ = μ m g r.
        let ball = OnPlane::Ball { radius_m: 0.02 };
        let moments = Vector3::repeat(1.6e-4);
        let sliding = of(Sustained::Slide, ball, moments, 0.2 * 10.0 * 0.02 / 1.6e-4);
        assert!((sliding.unwrap() - 0.2).abs() < 1e-12);
        assert!(of(Sustained::Rest, ball, moments, 1.0).is_none());
    }
}
