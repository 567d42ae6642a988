//! The weight of marks relative to samples.
//!
//! In the objective samples count one by one, in the scene's unit `u`. But a hand wanders about as
//! slowly as flights last: the `n` samples of a flight are together worth one, with the hand's
//! error `e`. They count `n/u²` instead of `1/e²`, too often by `n e²/u²`, and marks are made to
//! count as much too often, and so are the smoothed states of bodies in the hand. The error is estimated where flights meet: from the distance between
//! two that are fitted alone, and between one and a goal. For a performance close to a motion it is
//! small.

use nalgebra::Vector3;

use super::between::is_fitted;
use crate::motion::{
    GoalTarget, Guess, MechanismIndex, Performer, Scene, Segment, Sketch, TrackSketch,
};
use crate::physics::flow;

/// Least square error of flights that is believed, in squared units of positions.
const LEAST_SQUARE: f64 = 1e-6;

/// Sine of an angle below which directions are the same.
const PARALLEL: f64 = 1e-3;

/// Sets how often marks count ([`MarkTime::counted`](crate::motion::MarkTime::counted)) to how
/// often the samples of the flights in `guess` do.
pub fn weigh(scene: &Scene, sketch: &mut Sketch, segments: &[Segment], guess: &Guess) {
    let samples: usize = segments.iter().map(Segment::sample_count).sum();
    let flights = segments.iter().filter(|segment| is_fitted(segment)).count();
    let per_flight = samples as f64 / flights.max(1) as f64;
    let unit_m = scene.weights.position_m;
    let counted = match square_off_m2(scene, segments, guess) {
        Some(square_m2) => per_flight * square_m2 / (unit_m * unit_m),
        None => expected_count(scene, sketch, per_flight),
    };
    let counted = counted.max(f64::MIN_POSITIVE);
    for mark in sketch.marks.iter_mut().flatten() {
        mark.counted = counted;
    }
    // What is known of a held body keeps some weight beside flights without errors.
    let counted = counted.max(per_flight * LEAST_SQUARE);
    let held = sketch.tracks.iter_mut().flat_map(TrackSketch::motions_mut);
    held.for_each(|motion| motion.counted = counted);
}

/// How often samples count where no two flights meet: nobody asks, unless something is in a hand for a while. Where nobody acts
/// a flight, each of them errs by itself as the tracker does; else all of a flight with the hand.
fn expected_count(scene: &Scene, sketch: &Sketch, per_flight: f64) -> f64 {
    let grips = sketch.tracks.iter().flat_map(|track| &track.grips);
    let noises_m = grips.map(|grip| grip.motion.noise_sd[0]);
    let noise_m = noises_m.reduce(f64::max);
    noise_m.map_or(0.0, |noise_m| match scene.performer {
        Performer::Nobody => (noise_m / scene.weights.position_m).powi(2),
        Performer::Hand | Performer::Unsaid => per_flight.max(1.0),
    })
}

/// Mean square error of flights' positions per axis, from their distances at events \[m²\]; `None` where none tells.
fn square_off_m2(scene: &Scene, segments: &[Segment], guess: &Guess) -> Option<f64> {
    let arrival = |index: usize, event: usize| {
        let arc = &guess.arcs[index];
        let after_s = guess.event_times_s[event] - arc.epoch_s;
        let body = scene.body_between(segments[index].mechanism, segments[index].ends());
        let state = flow::advance(&body, &scene.gravity_m_s2, &arc.state, after_s);
        (state.position_m, state.velocity_m_s)
    };
    let ending = |mechanism: MechanismIndex, event: usize| {
        segments
            .iter()
            .position(|s| s.mechanism == mechanism && s.end_event == Some(event))
    };
    let mut squares_m2 = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        // A flight that is not fitted was begun where the one before it ends.
        if !is_fitted(segment) {
            continue;
        }
        let Some(event) = segment.start_event else {
            continue;
        };
        if let Some(before) = ending(segment.mechanism, event) {
            let (from, to) = (arrival(before, event), arrival(index, event));
            // How far what a surface carries comes depends on friction, which may be guessed.
            let carried = [(before, from.1), (index, to.1)].into_iter();
            let carried = carried.filter(|(index, _)| {
                let of = &segments[*index];
                let phase = scene.phase_between(of.mechanism, of.ends());
                phase.is_some()
            });
            let carried: Vec<Vector3<f64>> = carried.map(|(_, velocity)| velocity).collect();
            // The difference has the errors of both flights.
            squares_m2.push(0.5 * across_m2(to.0 - from.0, to.1 - from.1, &carried));
        }
    }
    for goal in &scene.goals {
        if let Some(index) = ending(scene.mechanism_of(goal.link), goal.event)
            && let GoalTarget::Pose { world_from_body } = &goal.target
        {
            let (position_m, velocity_m_s) = arrival(index, goal.event);
            let apart_m = position_m - world_from_body.translation.vector;
            squares_m2.push(across_m2(apart_m, velocity_m_s, &[]));
        }
    }
    (!squares_m2.is_empty()).then(|| squares_m2.iter().sum::<f64>() / squares_m2.len() as f64)
}

/// Mean square per axis perpendicular to the relative velocity: the part along it may be the mark's
/// own error, and without those along `others`.
fn across_m2(apart_m: Vector3<f64>, velocity_m_s: Vector3<f64>, others: &[Vector3<f64>]) -> f64 {
    let direction = velocity_m_s.try_normalize(0.0);
    let along_m = direction.map_or(0.0, |direction| apart_m.dot(&direction));
    let mut left_m2 = apart_m.norm_squared() - along_m * along_m;
    let mut axes = 2.0_f64;
    let mut base: Vec<Vector3<f64>> = direction.into_iter().collect();
    for other in others {
        let left = base
            .iter()
            .fold(*other, |left, axis| left - axis * axis.dot(&left));
        if let Some(axis) = left.try_normalize(PARALLEL * other.norm()) {
            left_m2 -= apart_m.dot(&axis).powi(2);
            axes -= 1.0;
            base.push(axis);
        }
    }
    left_m2.max(0.0) / axes.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_mark_is_off_by_is_not_the_hands() {
        let (apart_m, velocity_m_s) = (Vector3::new(0.02, 0.03, 0.0), Vector3::new(3.0, 0.0, 0.0));
        assert!((across_m2(apart_m, velocity_m_s, &[]) - 0.5 * 0.03 * 0.03).abs() < 1e-15);
        let still = across_m2(apart_m, Vector3::zeros(), &[]);
        assert!((still - 0.5 * apart_m.norm_squared()).abs() < 1e-15);
        // Nor is what friction makes of a way, of which no part is left twice.
        let up = Vector3::new(0.0, 0.01, 0.02);
        let slides = [Vector3::new(1.0, 2.0, 0.0), Vector3::y(), Vector3::zeros()];
        assert!((across_m2(up, velocity_m_s, &slides) - 0.02_f64.powi(2)).abs() < 1e-15);
    }
}
