//! What a mark weighs beside samples.
//!
//! In the objective samples count one by one, in the scene's units. But a hand that wanders does so
//! about as slowly as flights last: the samples of a flight are worth one, which is off by as much
//! as the hand. By how much the hand is off is seen where flights meet, before they are made to:
//! between two that are fitted alone, and between one and a goal. Marks are weighed by as much as
//! samples count too often; of a performance that needs no bending they weigh little.

use crate::motion::{GoalTarget, Guess, Scene, Segment, Sketch};
use crate::physics::flow;

/// Lets marks count as often as the samples of the flights in `guess` do.
pub fn weigh(scene: &Scene, sketch: &mut Sketch, segments: &[Segment], guess: &Guess) {
    let samples: usize = segments.iter().map(|segment| segment.samples.len()).sum();
    let per_flight = samples as f64 / segments.len().max(1) as f64;
    let unit_m = scene.weights.position_m;
    let square = square_off_m2(scene, segments, guess) / (unit_m * unit_m);
    let counted = (per_flight * square).max(f64::MIN_POSITIVE);
    for mark in sketch.marks.iter_mut().flatten() {
        mark.counted = counted;
    }
}

/// Mean square by which positions of flights are off per axis, from how they meet at events \[m²\].
fn square_off_m2(scene: &Scene, segments: &[Segment], guess: &Guess) -> f64 {
    let position_m = |index: usize, event: usize| {
        let arc = &guess.arcs[index];
        let after_s = guess.event_times_s[event] - arc.epoch_s;
        flow::position(&scene.gravity_m_s2, &arc.state, after_s)
    };
    let ending = |body: usize, event: usize| {
        segments
            .iter()
            .position(|s| s.body == body && s.end_event == Some(event))
    };
    let mut squares_m2 = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        let Some(event) = segment.start_event else {
            continue;
        };
        if let Some(before) = ending(segment.body, event) {
            let apart_m = position_m(index, event) - position_m(before, event);
            // Both are off.
            squares_m2.push(apart_m.norm_squared() / 6.0);
        }
    }
    for goal in &scene.goals {
        if let Some(index) = ending(goal.body, goal.event)
            && let GoalTarget::Pose { world_from_body } = &goal.target
        {
            let apart_m = position_m(index, goal.event) - world_from_body.translation.vector;
            squares_m2.push(apart_m.norm_squared() / 3.0);
        }
    }
    squares_m2.iter().sum::<f64>() / squares_m2.len().max(1) as f64
}
