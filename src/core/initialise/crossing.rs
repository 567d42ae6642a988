//! First times of collisions: where the guessed flights before and after them come nearest.
//!
//! A collision is marked by a hand that reacts, or expects. Flights that fall alike move apart evenly, by `Δp + Δv t` with `t` since
//! the mark, each known within `σ`. With the mark's own deviation `s` the likeliest time of the collision is
//!
//! ```text
//! t = −Σ Δp·Δv / (Σ |Δv|² + σ²/s²)
//! ```
//!
//! over all that collide. The turn after a bounce depends on the moment of it far more than the flight does: from the mark a
//! search may end with another side of the body touching.

use nalgebra::Vector3;

use super::between::is_fitted;
use crate::motion::{ArcGuess, Guess, Scene, Segment, Sketch};

/// A collision stays at least so far from the middles of the flights beside it, as a share of the way there.
const LEAST_LEFT: f64 = 0.5;

/// Moves the times of collisions that are unknown, in a known tempo.
pub(super) fn place(scene: &Scene, sketch: &Sketch, segments: &[Segment], guess: &mut Guess) {
    for event in 0..scene.events.len() {
        let is_collision = scene.events[event].kind.collision().is_some();
        if is_collision && scene.time_is_free(event) {
            guess.event_times_s[event] = crossing_s(scene, sketch, segments, guess, event);
        }
    }
}

fn crossing_s(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    guess: &Guess,
    event: usize,
) -> f64 {
    let mark_s = guess.event_times_s[event];
    let [mut earliest_s, mut latest_s] = [f64::NEG_INFINITY, f64::INFINITY];
    let sd_s = sketch.marks[event].map(|mark| mark.sd_s);
    let (mut towards, mut apart) = (0.0, 0.0);
    if let Some(sd_s) = sd_s {
        apart += (scene.weights.position_m / sd_s).powi(2);
    }
    let flights = || segments.iter().zip(&guess.arcs);
    for (before, from) in flights().filter(|(of, _)| of.end_event == Some(event)) {
        let is_next = |(of, _): &(&Segment, _)| {
            of.start_event == Some(event) && of.mechanism == before.mechanism
        };
        let Some((after, to)) = flights().find(is_next) else {
            continue;
        };
        let middle_s = |middle_s: f64| mark_s + LEAST_LEFT * (middle_s - mark_s);
        earliest_s = earliest_s.max(middle_s(from.epoch_s));
        latest_s = latest_s.min(middle_s(to.epoch_s));
        if !is_fitted(before) || !is_fitted(after) {
            continue;
        }
        let pull_m_s2 = scene
            .body_of(before.mechanism)
            .pull_m_s2(&scene.gravity_m_s2);
        let [from, to] = [from, to].map(|arc| fallen(arc, &pull_m_s2, mark_s));
        let (off_m, off_m_s) = (to.0 - from.0, to.1 - from.1);
        towards -= off_m.dot(&off_m_s);
        apart += off_m_s.norm_squared();
    }
    let later_s = towards / apart;
    match later_s.is_finite() && earliest_s < latest_s {
        true => (mark_s + later_s).clamp(earliest_s, latest_s),
        false => mark_s,
    }
}

/// Place \[m\] and velocity [m/s] of the centre of mass of a guessed flight at a time \[s\].
fn fallen(arc: &ArcGuess, pull_m_s2: &Vector3<f64>, time_s: f64) -> (Vector3<f64>, Vector3<f64>) {
    let since_s = time_s - arc.epoch_s;
    let velocity_m_s = arc.state.velocity_m_s + pull_m_s2 * (0.5 * since_s);
    (
        arc.state.position_m + velocity_m_s * since_s,
        arc.state.velocity_m_s + pull_m_s2 * since_s,
    )
}
