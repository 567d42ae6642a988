//! On which guess an event's time leans, where times are unknown.
//!
//! A restitution says how long the flights beside a bounce last, and with that when it was. Where the scene keeps it
//! fixed, deviations of times suppose that it is right: with `d`, the direction in which the motion follows a change of
//! it ([`direction`](super::direction)), `dt/dθ` is the component of `d` at the event's time.

use super::direction;
use super::wider::{Wider, unbounded};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::motion::{Leaning, Performance, Quantity};
use crate::optimise::Program;
use crate::optimise::kkt::Kkt;

/// By how much restitutions are usually guessed wrong: as much as those of one material differ.
const GUESS: f64 = 0.05;

/// The guess on which each event's time leans most; none where times are known or nothing is guessed.
pub fn leanings(
    context: &SolveContext,
    solution: &Solution,
    performance: Performance,
) -> Vec<Option<Leaning>> {
    if !context.problem.times_are_unknown() {
        return Vec::new();
    }
    let scene = performance.scene;
    let is_guess = |quantity: &Quantity| {
        let is_restitution = matches!(quantity, Quantity::Restitution { .. });
        is_restitution && !scene.frees(*quantity) && scene.untold(*quantity).is_none()
    };
    let guesses: Vec<Quantity> = scene.quantities().into_iter().filter(is_guess).collect();
    if guesses.is_empty() {
        return Vec::new();
    }
    let Some(kkt) = Kkt::new(context, &solution.system, &solution.multipliers) else {
        return Vec::new();
    };
    let free = guesses.iter().map(|quantity| unbounded(scene, *quantity));
    let wider = Wider::new(context, performance, free.collect());
    let point = wider.point(&solution.point);
    let extended = SolveContext::new(
        &wider.problem,
        &wider.layout,
        context.epochs_s.clone(),
        &point,
    );
    let system = extended.evaluated(&Guidance::none(), &point);
    let directions = direction::directions(&extended, &system, context, &kkt, wider.first);
    let of_event = |at: &Option<usize>| {
        let of_each = guesses
            .iter()
            .zip(&directions)
            .filter_map(|(quantity, direction)| {
                Some(Leaning {
                    quantity: *quantity,
                    value: scene.value_of(*quantity),
                    change: GUESS,
                    later_s: GUESS * direction[(*at)?],
                })
            });
        of_each.max_by(|a, b| a.later_s.abs().total_cmp(&b.later_s.abs()))
    };
    context.layout.events.iter().map(of_event).collect()
}
