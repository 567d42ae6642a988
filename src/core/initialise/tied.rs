//! First guesses of what is tied to a place: how it turns near the middle of its samples, and what follows from that of
//! its centre of mass.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::ballistic::Place;
use super::carried;
use super::turn::OrientationReading;
use crate::math::so3;
use crate::motion::AtPivot;
use crate::physics::State;
use crate::physics::support::PivotAxes;

/// Greatest angle from the orientation in the middle of what is taken for steady turning \[rad\].
const NEAR_RAD: f64 = 0.6;

/// Least number of readings that are taken.
const NEAR_LEAST: usize = 6;

/// Least distance of a point from what it turns about \[m\].
const LEAST_M: f64 = 1e-6;

/// The state at the epoch; `turns` and `places` are since then, in order of time. `straight` has where the centre of mass is
/// seen. `None` where too little is seen.
pub(super) fn state(at: &AtPivot, turns: &[OrientationReading], straight: &State) -> Option<State> {
    let middle = turns.iter().enumerate();
    let (middle, nearest) = middle.min_by(|a, b| a.1.0.abs().total_cmp(&b.1.0.abs()))?;
    let pivot = &at.pivot;
    if pivot.axes == PivotAxes::None {
        return Some(State {
            orientation: nearest.1,
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
            ..*straight
        });
    }
    let is_near = |index: &usize| turns[*index].1.angle_to(&nearest.1) < NEAR_RAD;
    let first = (0..middle).rev().take_while(is_near).last();
    let last = (middle..turns.len()).take_while(is_near).last();
    let first = first
        .unwrap_or(middle)
        .min(middle.saturating_sub(NEAR_LEAST / 2));
    let last = last
        .unwrap_or(middle)
        .max(middle + NEAR_LEAST / 2)
        .min(turns.len() - 1);
    let turn = carried::turn(&turns[first..=last])?;
    let mut orientation = turn.orientation;
    let angular_velocity_rad_s = pivot.axes.allowed() * turn.angular_velocity_rad_s;
    if let (PivotAxes::One(axis), Some(of_world)) = (pivot.axes, at.axis) {
        orientation = so3::between(&(orientation * axis), &of_world) * orientation;
    }
    let arm_m = orientation * pivot.at_m;
    Some(State {
        position_m: at
            .place_m
            .map_or(straight.position_m, |place_m| place_m - arm_m),
        orientation,
        velocity_m_s: orientation * -angular_velocity_rad_s.cross(&pivot.at_m),
        angular_velocity_rad_s,
    })
}

/// Orientations that bring a point of the body to where it is seen, about a pivot whose place is known; empty where they
/// say nothing of it.
pub(super) fn turns(
    at: &AtPivot,
    point_m: &Vector3<f64>,
    places: &[Place],
) -> Vec<OrientationReading> {
    let arm_m = point_m - at.pivot.at_m;
    let axes = match at.pivot.axes {
        PivotAxes::One(axis) => Some((axis, at.axis.unwrap_or(axis))),
        _ => None,
    };
    // What is on the axis does not move.
    let moving_m = axes.map_or(arm_m, |(axis, _)| axis.cross(&arm_m));
    let Some(pivot_m) = at.place_m.filter(|_| moving_m.norm() > LEAST_M) else {
        return Vec::new();
    };
    let mut before = UnitQuaternion::identity();
    let oriented = places.iter().map(|(since_s, place_m)| {
        let seen_m = place_m - pivot_m;
        let orientation = match axes {
            Some((of_body, of_world)) => {
                let body = Rotation3::face_towards(&of_body, &arm_m);
                let world = Rotation3::face_towards(&of_world, &seen_m);
                UnitQuaternion::from_rotation_matrix(&(world * body.inverse()))
            }
            None => so3::between(&(before * arm_m), &seen_m) * before,
        };
        before = orientation;
        (*since_s, orientation)
    });
    oriented.collect()
}
