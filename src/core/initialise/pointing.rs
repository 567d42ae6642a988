//! A free rotation through the directions in which one axis `a` of a body is seen to point:
//!
//! ```text
//! min over R, ω   Σ |d_i − R(s_i) a|²,   R(s) the free rotation from R, ω
//! ```
//!
//! The axis of a body with three equal moments goes round a [`FittedCircle`], which is the start; other
//! bodies' begin there too, rolled about the axis in several ways, for they are not alike about it.
//! A perturbation of the initial state turns `R(s)` by `δ = δθ + s K δω` in the frame of `R(0)`
//! ([`Spin::turn_and_derivative`]), where the residual `e` changes by `δ × c`, `c = R(0)ᵀ R(s) a`.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::circle::{FittedCircle, Reading, Steady};
use super::turn::{Quadratic, READINGS_MAX, TurnFit, descend_on};
use crate::math::so3;
use crate::physics::Body;
use crate::physics::body::Symmetry;
use crate::physics::flow::Spin;

/// Root mean square residual above which the fit may be ambiguous.
const AMBIGUOUS_RMS: f64 = 0.35;
/// Number of rates that are kept.
const RATES: usize = 2;
/// Fits of a body that is not alike about the axis are kept up to so many times the least sum of squares: a
/// hand's wander may hide which one is right.
const ALIKE: f64 = 2.0;
/// Greatest number of such fits.
const FITS: usize = 4;
/// Least angle between two of them \[rad\].
const APART_RAD: f64 = 0.3;
/// Rolls about the axis from which a body begins that is not alike about it.
const ROLLS: [f64; 4] = [0.0, FRAC_PI_2, 2.0 * FRAC_PI_2, 3.0 * FRAC_PI_2];

/// Fits through unit vectors, in order of time, in which `axis` of the body points, the best first,
/// and the number of iterations. `least` is one without rotation about the axis.
pub(super) fn fits(
    body: &Body,
    axis: &Vector3<f64>,
    directions: &[Reading],
    least: TurnFit,
) -> (Vec<TurnFit>, usize) {
    let stride = (directions.len() / READINGS_MAX).max(1);
    let some: Vec<Reading> = directions.iter().copied().step_by(stride).collect();
    let circles = FittedCircle::through(&some, Steady::Still).into_iter();
    let rolls: &[f64] = match body.symmetry() {
        Symmetry::Spherical => &ROLLS[..1],
        _ => &ROLLS,
    };
    let started = circles.take(RATES).filter_map(|c| start(&c, axis));
    let rolled =
        started.flat_map(|start| rolls.iter().map(move |roll| rolled(&start, axis, *roll)));
    let mut iterations = 0;
    let mut found: Vec<TurnFit> = Vec::new();
    for start in rolled.chain([least]) {
        let fit = descend_on(|fit| terms(body, axis, &some, fit), start);
        iterations += fit.iterations;
        found.push(fit);
    }
    found.sort_by(|a, b| a.square_rad2.total_cmp(&b.square_rad2));
    let clear = some.len() as f64 * AMBIGUOUS_RMS * AMBIGUOUS_RMS;
    if body.symmetry() == Symmetry::Spherical {
        let is_clear = found[0].square_rad2 < clear;
        found.truncate(if is_clear { 1 } else { RATES });
    } else {
        let most = found[0].square_rad2 * ALIKE + f64::EPSILON;
        found.retain(|fit| fit.square_rad2 <= most);
        found = distinct(found);
    }
    for fit in &mut found {
        fit.square_rad2 *= stride as f64;
    }
    (found, iterations)
}

/// The first of fits that are one.
fn distinct(fits: Vec<TurnFit>) -> Vec<TurnFit> {
    let mut distinct: Vec<TurnFit> = Vec::new();
    for fit in fits {
        let is_new = distinct
            .iter()
            .all(|other| other.orientation.angle_to(&fit.orientation) > APART_RAD);
        if is_new && distinct.len() < FITS {
            distinct.push(fit);
        }
    }
    distinct
}

/// The same fit, turned about an axis of the body.
fn rolled(fit: &TurnFit, axis: &Vector3<f64>, roll_rad: f64) -> TurnFit {
    let roll = so3::exp(&(axis.normalize() * roll_rad));
    TurnFit {
        orientation: fit.orientation * roll,
        angular_velocity_rad_s: roll.inverse() * fit.angular_velocity_rad_s,
        ..*fit
    }
}

/// The rotation that a circle shows.
fn start(circle: &FittedCircle, axis: &Vector3<f64>) -> Option<TurnFit> {
    let about = circle.about()?;
    let across = circle.cosine.normalize() * circle.radius();
    let there = about * about.dot(&circle.steady[0]) + across;
    let orientation = so3::between(axis, &there.try_normalize(0.0)?);
    Some(TurnFit {
        orientation,
        angular_velocity_rad_s: orientation.inverse() * about * circle.rate_rad_s,
        square_rad2: circle.square,
        iterations: 0,
    })
}

fn terms(body: &Body, axis: &Vector3<f64>, directions: &[Reading], fit: &TurnFit) -> Quadratic {
    let mut spin = Spin::new(body, &fit.angular_velocity_rad_s);
    let axis = axis.normalize();
    let mut square = Matrix6::zeros();
    let mut gradient = Vector6::zeros();
    let mut cost = 0.0;
    for (s, direction) in directions {
        let (turn, k) = spin.turn_and_derivative(*s);
        let shown = turn * axis;
        let error = shown - fit.orientation.inverse() * direction;
        cost += 0.5 * error.norm_squared();
        let by_turn = -so3::hat(&shown);
        let by_spin: Matrix3<f64> = by_turn * k * *s;
        let blocks = [by_turn, by_spin];
        for (row, of_row) in blocks.iter().enumerate() {
            let mut part = gradient.fixed_rows_mut::<3>(3 * row);
            part += of_row.tr_mul(&error);
            for (column, of_column) in blocks.iter().enumerate() {
                let mut part = square.fixed_view_mut::<3, 3>(3 * row, 3 * column);
                part += of_row.tr_mul(of_column);
            }
        }
    }
    Quadratic {
        cost,
        gradient,
        matrix: square,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    /// An axis of which is seen where it points, of bodies of all kinds.
    #[test]
    fn finds_the_rotation_of_which_one_axis_is_seen() {
        let axis = Vector3::new(0.6, 0.0, -0.8);
        for moments in [[2.0; 3], [2.0, 1.0, 1.5], [2.0, 2.0, 0.4]] {
            let body = Body::new(1.0, Vector3::from(moments)).unwrap();
            let orientation = UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0);
            let omega = Vector3::new(5.0, -3.0, 6.0);
            let mut spin = Spin::new(&body, &omega);
            let mut at = |s: f64| orientation * spin.turn_and_derivative(s).0;
            let times_s = (0..60).map(|i| f64::from(i) / 60.0 - 0.5);
            let directions: Vec<Reading> = times_s.map(|s| (s, at(s) * axis)).collect();
            let least = TurnFit {
                orientation: so3::between(&axis, &directions[30].1),
                angular_velocity_rad_s: Vector3::zeros(),
                square_rad2: f64::INFINITY,
                iterations: 0,
            };
            let (found, _) = fits(&body, &axis, &directions, least);
            let fit = found[0];
            assert!(fit.square_rad2 < 1e-9, "{moments:?} {fit:?}");
            // The angular velocity in the world, however the body is rolled about the axis.
            let apart_rad_s = fit.orientation * fit.angular_velocity_rad_s - orientation * omega;
            assert!(apart_rad_s.norm() < 1e-3, "{moments:?} {fit:?}");
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let body = Body::new(1.0, Vector3::new(2.0, 1.0, 1.5)).unwrap();
        let axis = Vector3::x();
        let directions = [(-0.3, Vector3::y()), (0.2, Vector3::new(0.6, 0.0, 0.8))];
        let fit = TurnFit {
            orientation: UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0),
            angular_velocity_rad_s: Vector3::new(2.0, -3.0, 4.0),
            square_rad2: 0.0,
            iterations: 0,
        };
        let cost = |by: Vector6<f64>| {
            let turn = so3::exp(&by.fixed_rows::<3>(0).into());
            let moved = TurnFit {
                orientation: fit.orientation * turn,
                angular_velocity_rad_s: fit.angular_velocity_rad_s + by.fixed_rows::<3>(3),
                ..fit
            };
            terms(&body, &axis, &directions, &moved).cost
        };
        let gradient = terms(&body, &axis, &directions, &fit).gradient;
        for at in 0..6 {
            let by = Vector6::ith(at, 1e-5);
            let slope = (cost(by) - cost(-by)) / 2e-5;
            assert!(
                (slope - gradient[at]).abs() < 1e-8,
                "{at}: {slope} {gradient}"
            );
        }
    }
}
