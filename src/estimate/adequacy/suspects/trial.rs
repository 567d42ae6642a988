//! Suspects set free for a trial.

use super::candidates::{Which, groups};
use super::errors::Errors;
use super::scored::{LEAST_SHARE, LEVEL};
use super::wider::Wider;
use crate::estimate::adequacy::alone::Alone;
use crate::estimate::context::SolveContext;
use crate::estimate::recipe::{self, Recipe, Solution};
use crate::motion::{Observer, Quantity, Quiet, Scene, Segment, Sketch, Suspect};
use crate::optimise::Schedule;
use crate::optimise::finish::Tolerances;

/// Greatest number of quantities that are set free to see what they explain,
const TRIED: usize = 8;
/// and of suspects.
const MOST: usize = 3;
/// Shares of the misfit that a wander of a hand seldom has in common with one wrong quantity, and how
/// much less the criterion must then be under a wander that the flights may hide: the less of the
/// misfit, the more. The first are odds of [`LEVEL`]; the second are measured.
const ALL: [(f64, f64); 2] = [(0.95, 13.8), (0.9, 60.0)];

/// The best of those that score high, by what they explain when they are set free: where a value is
/// far off, the score's linear prediction no longer ranks them.
pub(in crate::estimate::adequacy) fn tried(
    (context, solution): (&SolveContext, &Solution),
    (scene, sketch, segments): (&Scene, &Sketch, &[Segment]),
    (mut scored, noise, alone): (Vec<Suspect>, &Errors, &Alone),
    observer: &mut dyn Observer,
) -> Vec<Suspect> {
    scored.truncate(TRIED);
    scored.extend(unscored(scene, &scored, noise.is_exceeded));
    let cost = solution.system.cost;
    let tried = scored.into_iter().filter_map(|suspect| {
        let values = suspect.values.iter();
        let free = values.map(|(quantity, value)| scene.freed(*quantity, *value));
        let wider = Wider::new(context, (scene, sketch, segments), free.collect());
        // The flights by themselves are near the motion where the value is far off.
        let trial = Recipe::of(trial());
        let starts = [
            (&alone.point, trial.clone()),
            (&solution.point, trial.from_the_last()),
        ];
        let found = starts.into_iter().find_map(|(start, recipe)| {
            let from = (wider.point(start), context.epochs_s.clone());
            let found = recipe::solve_from(
                &wider.problem,
                &wider.layout,
                from,
                &recipe,
                &mut Quiet(observer),
            );
            found.finished.converged.then_some(found)
        })?;
        let quantities = suspect.values.iter().map(|(quantity, _)| *quantity);
        let values = quantities.zip(found.point.parameters[wider.first..].iter().copied());
        let values: Vec<(Quantity, f64)> = values.collect();
        let left = found.system.cost.max(f64::MIN_POSITIVE);
        let gain = noise.gain(context, cost / left, values.len());
        let misfit = (cost - noise.floor(context)).max(f64::MIN_POSITIVE);
        let explains = ((cost - left) / misfit).clamp(0.0, 1.0);
        let odds = noise.gain_under_wander(cost / left, values.len());
        let is_all = |(share, gain): &(f64, f64)| explains >= *share && odds >= *gain;
        let is_all = ALL.iter().any(is_all);
        let is_told = noise.is_exceeded || suspect.probability < LEVEL || is_all;
        let is_suspect = gain > 0.0 && is_told && explains >= LEAST_SHARE;
        is_suspect.then_some(Suspect {
            values,
            explains,
            gain,
            ..suspect
        })
    });
    let mut tried: Vec<Suspect> = tried.collect();
    tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut suspects: Vec<Suspect> = Vec::new();
    for suspect in tried {
        // Of the components of one thing, those that explain best stand for all.
        if !suspects.iter().any(|better| better.is_same_as(&suspect)) {
            suspects.push(suspect);
        }
    }
    suspects.truncate(MOST);
    suspects
}

/// The schedule of a trial: to compare objectives a few digits are enough, and what needs more steps
/// than this is no explanation.
fn trial() -> Schedule {
    Schedule {
        multiplier_rounds: (4, 10),
        retries: 0,
        tolerances: Tolerances {
            violation: 1e-6,
            decrease: 1e-6,
            steps: 15,
        },
        ..Schedule::default()
    }
}

/// What is tried though it did not score high: coefficients of friction, of which all above some
/// value are alike where a contact sticks, from zero, where it slides, if the misfit is beyond any
/// wander; and the clock's rate where gravity scored or gravity where the rate did, which are the
/// same to a motion.
fn unscored(scene: &Scene, scored: &[Suspect], is_exceeded: bool) -> Vec<Suspect> {
    let has_scored = |is_it: &dyn Fn(Quantity) -> bool| {
        let is_it = |suspect: &&Suspect| suspect.values.iter().any(|(q, _)| is_it(*q));
        scored.iter().find(is_it)
    };
    let is_rate = |quantity| matches!(quantity, Quantity::ClockRate { .. });
    let is_gravity = |quantity| matches!(quantity, Quantity::Gravity { .. });
    let groups = groups(scene, Which::All).into_iter();
    let others = groups.filter_map(|group| match group[..] {
        [quantity] if has_scored(&|scored| scored == quantity).is_some() => None,
        [quantity @ Quantity::Friction { .. }] => is_exceeded.then_some((quantity, 0.0, 1.0)),
        [quantity @ Quantity::ClockRate { .. }] => {
            let twin = has_scored(&is_gravity)?;
            Some((quantity, scene.value_of(quantity), twin.probability))
        }
        [quantity @ Quantity::Gravity { .. }] => {
            let twin = has_scored(&is_rate)?;
            Some((quantity, scene.value_of(quantity), twin.probability))
        }
        _ => None,
    });
    let suspect = |(quantity, value, probability)| Suspect {
        values: vec![(quantity, value)],
        explains: 0.0,
        gain: 0.0,
        probability,
    };
    others.map(suspect).collect()
}
