//! First guesses of flights with few samples.
//!
//! A flight of a few milliseconds between two impacts has no fit of its own, or none that a hand's
//! wander would not spoil. It begins in the pose in which the flight before it arrives. Its
//! velocities are between those of the fitted flights on both sides, in proportion to its place in
//! time; after the last impact they are those of the flight before. The impacts correct them once
//! it is known what touches.

use crate::motion::{ArcGuess, MechanismIndex, Scene, Segment};
use crate::physics::{State, flow};

/// Least number of samples of a flight that is fitted by itself.
pub const FITTED_MIN: usize = 3;

/// Whether a flight is fitted by itself.
pub fn is_fitted(segment: &Segment) -> bool {
    segment.sample_count() >= FITTED_MIN
}

/// A flight whose state is set by its fit or by [`fill`].
pub(super) fn open(epoch_s: f64, sample_times_s: Vec<f64>) -> ArcGuess {
    ArcGuess {
        epoch_s,
        state: State::at_rest(),
        sample_times_s,
    }
}

/// Sets the states of the flights that are not fitted and that no hand begins, at their epochs. A flight before them is known,
/// since only an impact leads to one with few samples.
pub(super) fn fill(
    scene: &Scene,
    segments: &[Segment],
    event_times_s: &[f64],
    arcs: &mut [ArcGuess],
) {
    for mechanism in scene.mechanisms.keys() {
        let own = flights_of(segments, mechanism);
        for (place, index) in own.iter().enumerate() {
            let Some(start) = segments[*index].start_event else {
                continue;
            };
            let is_let_go = scene.hand_beside(mechanism, start, false);
            if is_fitted(&segments[*index]) || place == 0 || is_let_go {
                continue;
            }
            let start_s = event_times_s[start];
            let arrived = advanced(scene, mechanism, &arcs[own[place - 1]], start_s);
            let mut rest = own[place..].iter();
            let next = rest.find(|index| is_fitted(&segments[**index]));
            let to = next.and_then(|next| {
                let end_s = event_times_s[segments[*next].start_event?];
                Some((advanced(scene, mechanism, &arcs[*next], end_s), end_s))
            });
            let epoch_s = arcs[*index].epoch_s;
            let from = to.map_or(arrived, |(to, end_s)| {
                // Half of the way of what remains in the middle of a single flight.
                let share = ((epoch_s - start_s) / (end_s - start_s)).clamp(0.0, 1.0);
                mixed(&arrived, &to, if share.is_finite() { share } else { 0.5 })
            });
            let body = &scene.body_between(mechanism, segments[*index].ends());
            let gravity = &scene.gravity_m_s2;
            arcs[*index].state = flow::advance(body, gravity, &from, epoch_s - start_s);
        }
    }
}

/// A mechanism's flights in order of time.
fn flights_of(segments: &[Segment], mechanism: MechanismIndex) -> Vec<usize> {
    let own = |index: &usize| segments[*index].mechanism == mechanism;
    (0..segments.len()).filter(own).collect()
}

fn advanced(scene: &Scene, mechanism: MechanismIndex, arc: &ArcGuess, time_s: f64) -> State {
    let body = scene.body_of(mechanism);
    flow::advance(body, &scene.gravity_m_s2, &arc.state, time_s - arc.epoch_s)
}

/// The pose of one state, with a share of the other's velocities.
fn mixed(one: &State, other: &State, share: f64) -> State {
    let spin = one.orientation.inverse() * other.orientation * other.angular_velocity_rad_s;
    State {
        velocity_m_s: one.velocity_m_s.lerp(&other.velocity_m_s, share),
        angular_velocity_rad_s: one.angular_velocity_rad_s.lerp(&spin, share),
        ..*one
    }
}
