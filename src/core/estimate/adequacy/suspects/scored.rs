//! Suspects by their scores alone.

use super::candidates::{Which, groups};
use super::errors::{Errors, LEVEL};
use super::wider::{Wider, unbounded};
use crate::estimate::adequacy::score::{Extended, Scores};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::SolveContext;
use crate::motion::{FreeParameter, Performance, Quantity, Suspect};
use crate::optimise::kkt::Kkt;

/// Least share of the misfit that a suspect would explain by its score, where its probability does not tell it.
const MOST_SHARE: f64 = 0.85;
/// Least share of the misfit that a suspect explains.
pub(super) const LEAST_SHARE: f64 = 0.1;

/// Those that score high, the one with the greatest gain first.
pub(in crate::estimate::adequacy) fn scored(
    context: &SolveContext,
    solution: &Solution,
    performance: Performance,
    noise: &Errors,
    which: Which,
) -> Vec<Suspect> {
    let scene = performance.scene;
    let groups = groups(scene, which);
    let mut free: Vec<FreeParameter> = Vec::new();
    for quantity in groups.iter().flatten() {
        if !free.iter().any(|free| free.quantity == *quantity) {
            free.push(unbounded(scene, *quantity));
        }
    }
    let wider = Wider::new(context, performance, free);
    let point = wider.point(&solution.point);
    let epochs_s = context.epochs_s.clone();
    let extended = SolveContext::new(&wider.problem, &wider.layout, epochs_s, &point);
    let Some(kkt) = Kkt::new(context, &solution.system, &solution.multipliers) else {
        return Vec::new();
    };
    let multipliers = &solution.multipliers;
    let of = Extended {
        context: &extended,
        point: &point,
        multipliers,
    };
    let scores = Scores::new(&of, context, &kkt, noise.bins, wider.first);
    let cost = solution.system.cost;
    let floor = noise.floor(context);
    let misfit = (cost - floor).max(f64::MIN_POSITIVE);
    let mut suspects: Vec<Suspect> = groups
        .iter()
        .filter_map(|group| {
            let at = |quantity: &Quantity| {
                wider
                    .added
                    .iter()
                    .position(|free| free.quantity == *quantity)
            };
            let indices: Vec<usize> = group.iter().map(at).collect::<Option<_>>()?;
            let lengths: Vec<f64> = group.iter().map(|quantity| quantity.typical()).collect();
            let scored = scores.of(&indices, &lengths, noise.white, noise.hands)?;
            let values = group.iter().zip(&scored.changes).map(|(quantity, change)| {
                let [lower, upper] = quantity.limits();
                let given = scene.value_of(*quantity);
                (*quantity, (given + change).clamp(lower, upper))
            });
            let values: Vec<(Quantity, f64)> = values.collect();
            // A quantity that would have to leave what is physical explains nothing.
            let moves = values.iter().any(|(q, value)| *value != scene.value_of(*q));
            let left = (cost - scored.decrease)
                .max(floor.min(cost))
                .max(1e-3 * cost);
            let gain = noise.gain(context, cost / left, group.len());
            let suspect = Suspect {
                values,
                explains: (scored.decrease / misfit).clamp(0.0, 1.0),
                gain,
                probability: (scored.probability * groups.len() as f64).min(1.0),
            };
            let is_likely = suspect.probability < LEVEL || suspect.explains >= MOST_SHARE;
            let is_told = noise.is_beyond || is_likely;
            let is_suspect =
                moves && suspect.gain > 0.0 && is_told && suspect.explains >= LEAST_SHARE;
            is_suspect.then_some(suspect)
        })
        .collect();
    suspects.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    suspects
}
