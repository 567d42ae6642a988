//! A cube that falls nearly flat on an edge or a face, so that two or three of its corners hit the
//! table within milliseconds: for flights of a few samples, or none.
//!
//! Found by trial: a pose a little off flat, a fall, and restitutions, until the corners come at the
//! interval asked for and a long flight follows.

use enact::physics::State;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::bounces::{Bouncer, Hop, Polyhedron, Throw};
use super::truth::{Truth, TruthError, crossing_s};

/// Side of the cube \[m\].
const SIDE_M: f64 = 0.1;
/// Least and greatest duration of the flight before, and of the flight after \[s\].
const BEFORE_S: (f64, f64) = (0.2, 0.3);
const AFTER_S: (f64, f64) = (0.15, 0.3);
/// Least and greatest speed of the fall [m/s].
const FALL_M_S: (f64, f64) = (1.0, 2.5);
/// Standard deviations of the other velocities, per axis [m/s], [rad/s].
const DRIFT_M_S: f64 = 0.3;
const SPIN_RAD_S: f64 = 3.0;
/// Least and greatest restitution.
const RESTITUTION: (f64, f64) = (0.4, 0.95);
/// Least speed with which a corner comes [m/s].
const APPROACH_M_S: f64 = 0.15;
/// Least height of every other corner when one hits \[m\].
const CLEAR_M: f64 = 2e-4;
/// Intervals are as asked for to within this share.
const NEAR: f64 = 0.15;
/// Contacts are looked for at this spacing \[s\].
const SCAN_S: f64 = 1e-4;
const TRIES: usize = 2_000_000;

/// A motion in which so many corners hit, each about `interval_s` after the one before.
pub fn clatter(corners: usize, interval_s: f64, seed: u64) -> Result<Truth, TruthError> {
    let throw = Throw {
        half_m: 0.5 * SIDE_M,
        last_share: 1.0,
        ..Throw::BOX
    };
    let cube = Bouncer::new(Polyhedron::Cube, throw);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let found = (0..TRIES).find_map(|_| tried(&cube, corners, interval_s, &mut rng));
    found
        .map(|path| cube.truth(&path))
        .ok_or(TruthError::NotFound {
            count: corners,
            tries: TRIES,
        })
}

fn tried(
    cube: &Bouncer,
    corners: usize,
    interval_s: f64,
    rng: &mut ChaCha8Rng,
) -> Option<Vec<Hop>> {
    let struck = falling(cube, corners, interval_s, rng);
    let flight = cube.flight();
    let lowest_m = |state: &State| cube.heights_m(state)[0].0;
    // From the first impact on, since few falls have a second one in time.
    let mut path = Vec::new();
    let mut duration_s = rng.random_range(BEFORE_S.0..BEFORE_S.1);
    let mut state = flight.advance(&struck, -duration_s);
    for corner in 0..corners {
        let before = flight.advance(&state, duration_s);
        let heights_m = cube.heights_m(&before);
        let hit = heights_m[0].1;
        let speed_m_s = cube
            .encounter(hit, 1.0)
            .speed_m_s(&before, &super::encounter::still());
        if heights_m[1].0 < CLEAR_M || speed_m_s > -APPROACH_M_S {
            return None;
        }
        let hop = Hop {
            state,
            duration_s,
            corner: hit,
            restitution: rng.random_range(RESTITUTION.0..RESTITUTION.1),
            choice: 0,
        };
        state = cube.bounced(&hop);
        path.push(hop);
        let height_m = |time_s: f64| lowest_m(&flight.advance(&state, time_s));
        if height_m(SCAN_S) <= 0.0 {
            return None;
        }
        if corner + 1 < corners {
            let most_s = (1.0 + NEAR) * interval_s;
            duration_s = crossing_s(SCAN_S, most_s, height_m)?;
            if duration_s < (1.0 - NEAR) * interval_s {
                return None;
            }
        } else {
            let next_s = crossing_s(SCAN_S, AFTER_S.1, height_m);
            duration_s = 0.95 * next_s.unwrap_or(AFTER_S.1);
            if duration_s < AFTER_S.0 {
                return None;
            }
        }
    }
    let first = path[0];
    let above = |time_s: &f64| lowest_m(&flight.advance(&first.state, *time_s)) > 0.0;
    let steps = (first.duration_s / SCAN_S) as usize;
    let mut times_s = (0..steps).map(|step| step as f64 * SCAN_S);
    if !times_s.all(|time_s| above(&time_s)) {
        return None;
    }
    path.push(Hop {
        state,
        duration_s,
        corner: 0,
        restitution: 1.0,
        choice: 0,
    });
    Some(path)
}

/// The state in which the lowest corner touches.
fn falling(cube: &Bouncer, corners: usize, interval_s: f64, rng: &mut ChaCha8Rng) -> State {
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let [drift, spin] =
        [DRIFT_M_S, SPIN_RAD_S].map(|sd| Vector3::new(normal(), normal(), normal()) * sd);
    let fall_m_s = rng.random_range(FALL_M_S.0..FALL_M_S.1);
    // The next corner comes with about the speed of the fall.
    let most_rad = (3.0 * fall_m_s * interval_s / SIDE_M).min(0.7);
    let tilt = |rng: &mut ChaCha8Rng| rng.random_range(-most_rad..most_rad);
    // About the edge below, or anywhere about a face.
    let on_edge = if corners == 2 {
        rng.random_range(0.2..std::f64::consts::FRAC_PI_2 - 0.2)
    } else {
        tilt(rng)
    };
    let about_x = Rotation3::from_axis_angle(&Vector3::x_axis(), on_edge);
    let about_y = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt(rng));
    let heading = rng.random_range(0.0..std::f64::consts::TAU);
    let about_z = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
    let mut state = State {
        position_m: Vector3::zeros(),
        orientation: UnitQuaternion::from_rotation_matrix(&(about_z * about_y * about_x)),
        velocity_m_s: Vector3::new(drift.x, drift.y, -fall_m_s),
        angular_velocity_rad_s: spin,
    };
    state.position_m.z = -cube.heights_m(&state)[0].0;
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_come_at_the_interval_asked_for() {
        for (corners, interval_s) in [(2, 0.002), (2, 0.016), (3, 0.004)] {
            let truth = clatter(corners, interval_s, 1).expect("found");
            let times_s = &truth.event_times_s;
            assert_eq!(times_s.len(), corners + 1);
            for pair in times_s[..corners].windows(2) {
                let share = (pair[1] - pair[0]) / interval_s;
                assert!((share - 1.0).abs() <= NEAR, "{share}");
            }
            assert!(times_s[corners] - times_s[corners - 1] >= 0.95 * AFTER_S.0);
        }
    }
}
