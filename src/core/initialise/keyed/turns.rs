//! Free rotations through the few orientations of a flight: how often the body turns between two of
//! them is open.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use crate::initialise::turn::{self, OrientationReading, TurnFit};
use crate::math::so3;
use crate::physics::Body;
use crate::physics::body::Symmetry;
use crate::physics::flow;

/// Greatest number of whole turns more or less between two neighbours in time that are tried, across
/// and about an axis of symmetry.
const TURNS: i32 = 3;
/// Greatest number of rotations kept.
const MOST: usize = 64;
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
    let turn = from.1.inverse() * to.1;
    let more = TAU / lasts_s;
    let counts = -TURNS..=TURNS;
    // In the body's axes at the first of the two.
    let mut starts: Vec<Vector3<f64>> = Vec::new();
    match body.symmetry() {
        Symmetry::Axial { axis } => {
            let (swing, twist_rad) = swing_and_twist(&turn, axis);
            let axis = Vector3::ith(axis, 1.0);
            let direction = swing
                .try_normalize(1e-9)
                .unwrap_or_else(|| axis.cross(&Vector3::new(0.3, 0.5, 0.8)).normalize());
            for across in counts.clone() {
                for about in counts.clone() {
                    let about_rad_s = twist_rad / lasts_s + more * f64::from(about);
                    let across_rad_s = swing.norm() / lasts_s + more * f64::from(across);
                    starts.push(axis * about_rad_s + direction * across_rad_s);
                }
            }
        }
        Symmetry::Spherical | Symmetry::Asymmetric => {
            let turn = so3::log(&turn);
            let direction = turn.try_normalize(1e-9).unwrap_or_else(Vector3::x);
            let along = |n: i32| direction * (turn.norm() / lasts_s + more * f64::from(n));
            starts.extend(counts.clone().map(along));
            if body.symmetry() == Symmetry::Asymmetric {
                for axis in 0..3 {
                    let rate = Vector3::ith(axis, 0.5 * more);
                    starts.extend(counts.clone().map(|n| along(0) + rate * f64::from(n)));
                }
            }
        }
    }
    let mut found: Vec<TurnFit> = Vec::new();
    for start in starts {
        let at_epoch = flow::turn(body, &from.1, &start, -from.0);
        let from = TurnFit {
            orientation: at_epoch.orientation,
            angular_velocity_rad_s: at_epoch.angular_velocity_rad_s,
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

/// A turn as one across a body axis, then one about it: `Exp(swing)·Exp(twist·axis)`.
fn swing_and_twist(turn: &UnitQuaternion<f64>, axis: usize) -> (Vector3<f64>, f64) {
    let twist_rad = 2.0 * turn.imag()[axis].atan2(turn.w);
    let twist = so3::exp(&Vector3::ith(axis, twist_rad));
    (so3::log(&(turn * twist.inverse())), twist_rad)
}
