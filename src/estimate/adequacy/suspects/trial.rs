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
/// A wander that the flights may hide seldom leaves this share of the misfit to one wrong quantity,
const ALL: f64 = 0.95;
/// or less with a gain that is greater by so much per share.
const GAIN_PER_SHARE: f64 = 900.0;

/// The best of those that score high, by what they explain when they are set free: where a value is
/// far off, the score's linear prediction no longer ranks them.
pub(in crate::estimate::adequacy) fn tried(
    (context, solution): (&SolveContext, &Solution),
    (scene, sketch, segments): (&Scene, &Sketch, &[Segment]),
    (mut scored, noise, alone): (Vec<Suspect>, &Errors, &Alone),
    observer: &mut dyn Observer,
) -> Vec<Suspect> {
    scored.truncate(TRIED);
    scored.extend(unscored(scene, &scored, noise.is_unlikely));
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
        let is_told = noise.is_beyond
            || suspect.probability < LEVEL
            || is_alone(explains, noise.gain_under_wander(cost / left, values.len()));
        let is_suspect = gain > 0.0 && explains >= LEAST_SHARE;
        let suspect = Suspect {
            values,
            explains,
            gain,
            ..suspect
        };
        is_suspect.then_some((suspect, is_told))
    });
    let mut tried: Vec<(Suspect, bool)> = tried.collect();
    tried.sort_by(|(a, _), (b, _)| b.gain.total_cmp(&a.gain));
    let mut suspects: Vec<Suspect> = Vec::new();
    for (suspect, is_told) in &tried {
        // What explains as well as another is suspected with it.
        let mut told = tried.iter().filter(|(_, is_told)| *is_told);
        let is_suspect = *is_told || told.any(|(other, _)| other.is_rivalled_by(suspect));
        // Of the components of one thing, those that explain best stand for all.
        if is_suspect && !suspects.iter().any(|better| better.is_same_as(suspect)) {
            suspects.push(suspect.clone());
        }
    }
    suspects.truncate(MOST);
    suspects
}

/// Whether so great a share of the misfit goes with one thing, at such a gain under a wander, that no
/// wander is likely to look like it.
fn is_alone(explains: f64, gain: f64) -> bool {
    gain >= -2.0 * LEVEL.ln() + GAIN_PER_SHARE * (ALL - explains).max(0.0)
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
/// value are alike where a contact sticks, from zero, where it slides, if the misfit is unlikely under any
/// wander; and the clock's rate where gravity scored or gravity where the rate did, which are the
/// same to a motion.
fn unscored(scene: &Scene, scored: &[Suspect], is_unlikely: bool) -> Vec<Suspect> {
    let has_scored = |is_it: &dyn Fn(Quantity) -> bool| {
        let is_it = |suspect: &&Suspect| suspect.values.iter().any(|(q, _)| is_it(*q));
        scored.iter().find(is_it)
    };
    let is_rate = |quantity| matches!(quantity, Quantity::ClockRate { .. });
    let is_gravity = |quantity| matches!(quantity, Quantity::Gravity { .. });
    let groups = groups(scene, Which::All).into_iter();
    let others = groups.filter_map(|group| match group[..] {
        [quantity] if has_scored(&|scored| scored == quantity).is_some() => None,
        [quantity @ Quantity::Friction { .. }] => is_unlikely.then_some((quantity, 0.0, 1.0)),
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
