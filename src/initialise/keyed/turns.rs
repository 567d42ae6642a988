//! Free rotations through the few orientations of a flight: how often the body turns between two of
//! them is open.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::initialise::turn::{self, OrientationReading, TurnFit};
use crate::math::so3;
use crate::physics::Body;
use crate::physics::body::Symmetry;

/// Greatest number of whole turns more or less between two neighbours in time that are tried, across
/// and about an axis of symmetry.
const TURNS: i32 = 3;
/// Greatest number of rotations kept.
const MOST: usize = 48;
/// Of rotations whose root mean square angle is farther from the best, none is kept \[rad\].
const WORSE_RAD: f64 = 0.15;

/// Distinct rotations through two readings or more, in order of time: the slowest first.
pub(super) fn turns(body: &Body, readings: &[OrientationReading]) -> Vec<TurnFit> {
    let pairs = readings.windows(2);
    let nearest = pairs.min_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)));
    let Some([from, to]) = nearest else {
        return Vec::new();
    };
    let lasts_s = to.0 - from.0;
    let turn = so3::log(&(from.1.inverse() * to.1));
    let rate = turn / lasts_s;
    let more = TAU / lasts_s;
    let epoch = readings.iter().min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let orientation = epoch.map_or(from.1, |reading| reading.1);
    let mut starts: Vec<Vector3<f64>> = Vec::new();
    let along = |vector: Vector3<f64>| vector.try_normalize(1e-9);
    match body.symmetry() {
        Symmetry::Spherical => {
            let axis = along(turn).unwrap_or_else(Vector3::x);
            starts.extend((-TURNS..=TURNS).map(|n| rate + axis * (more * f64::from(n))));
        }
        Symmetry::Axial { axis } => {
            let axis = Vector3::ith(axis, 1.0);
            let spin = rate.dot(&axis);
            let across = rate - axis * spin;
            // Half a turn across and half a turn about the axis may be one and the same end.
            for n in -2 * TURNS..=2 * TURNS {
                for m in -2..=2 {
                    let direction = along(across).unwrap_or_else(|| {
                        axis.cross(&Vector3::new(0.3, 0.5, 0.8)).normalize()
                    });
                    let about = spin + 0.5 * more * f64::from(n);
                    starts.push(axis * about + across + direction * (0.5 * more * f64::from(m)));
                }
            }
        }
        Symmetry::Asymmetric => {
            let axis = along(turn).unwrap_or_else(Vector3::x);
            starts.extend((-TURNS..=TURNS).map(|n| rate + axis * (more * f64::from(n))));
            for axis in 0..3 {
                for n in [-2, -1, 1, 2] {
                    starts.push(rate + Vector3::ith(axis, 0.5 * more * f64::from(n)));
                }
            }
        }
    }
    let mut found: Vec<TurnFit> = Vec::new();
    for start in starts {
        let from = TurnFit {
            orientation,
            angular_velocity_rad_s: start,
            square_rad2: f64::INFINITY,
            iterations: 0,
        };
        let end = turn::descend(body, readings, from);
        let is_new = found.iter().all(|other| {
            let apart = other.angular_velocity_rad_s - end.angular_velocity_rad_s;
            apart.norm() * lasts_s > 0.3
        });
        if is_new {
            found.push(end);
        }
    }
    let rms_rad = |fit: &TurnFit| (fit.square_rad2 / readings.len() as f64).sqrt();
    let best_rad = found.iter().map(rms_rad).fold(f64::INFINITY, f64::min);
    found.retain(|fit| rms_rad(fit) <= best_rad + WORSE_RAD);
    let speed = |fit: &TurnFit| fit.angular_velocity_rad_s.norm();
    found.sort_by(|a, b| speed(a).total_cmp(&speed(b)));
    found.truncate(MOST);
    found
}
