//! Suspects set free for a trial.

use super::candidates::{Which, groups};
use super::errors::{Errors, LEVEL};
use super::scored::LEAST_SHARE;
use super::wider::Wider;
use crate::estimate::adequacy::alone::Alone;
use crate::estimate::schedule::recipe::{self, Recipe, Solution};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::motion::{Observer, Performance, Quantity, Quiet, Scene, Suspect};
use crate::optimise::Schedule;
use crate::optimise::finish::Tolerances;

/// Greatest number of quantities that are set free to see what they explain,
const TRIED: usize = 8;
/// and of suspects.
const MOST: usize = 3;
/// Share of a typical change by which a quantity has not moved.
const UNMOVED: f64 = 1e-6;
/// Where a trial leaves less than this share of the objective, the motion itself may have a better optimum near by.
const LOWER: f64 = 0.5;

/// What trials found.
/// A motion that may not fit, with what its flights are by themselves.
pub(in crate::estimate::adequacy) struct SolvedMotion<'a> {
    pub(in crate::estimate::adequacy) context: &'a SolveContext<'a>,
    pub(in crate::estimate::adequacy) solution: &'a Solution,
    pub(in crate::estimate::adequacy) alone: &'a Alone,
}

pub(in crate::estimate::adequacy) struct TriedSuspects {
    /// The best of what was set free.
    pub(in crate::estimate::adequacy) suspects: Vec<Suspect>,
    /// From where the motion itself may have a better optimum: the best trial's motion, if that is much better.
    pub(in crate::estimate::adequacy) start: Option<Point>,
}

/// The best of those that score high, by what they explain when they are set free: where a value is
/// far off, the score's linear prediction no longer ranks them.
pub(in crate::estimate::adequacy) fn tried(
    solved: &SolvedMotion,
    performance: Performance,
    mut scored: Vec<Suspect>,
    noise: &Errors,
    observer: &mut dyn Observer,
) -> TriedSuspects {
    let SolvedMotion {
        context,
        solution,
        alone,
    } = *solved;
    let scene = performance.scene;
    scored.truncate(TRIED);
    let of_unknown_times = context.problem.times_are_unknown();
    scored.extend(unscored(
        scene,
        &scored,
        noise.is_unlikely,
        of_unknown_times,
    ));
    let cost = solution.system.cost;
    let mut lowest: Option<(f64, Point)> = None;
    let tried = scored.into_iter().filter_map(|suspect| {
        if observer.should_stop() {
            return None;
        }
        let values = suspect.values.iter();
        let free = values.map(|(quantity, value)| scene.freed(*quantity, *value));
        let wider = Wider::new(context, performance, free.collect());
        // The flights by themselves are near the motion where the value is far off.
        let trial = Recipe::of(trial());
        let starts = [
            (&alone.point, trial.clone()),
            (&solution.point, trial.from_the_last()),
        ];
        let found = starts.into_iter().find_map(|(start, recipe)| {
            let found = recipe::solve_from(
                &wider.problem,
                &wider.layout,
                wider.point(start),
                context.epochs_s.clone(),
                &recipe,
                &mut Quiet(observer),
            );
            found.finished.converged.then_some(found)
        })?;
        let quantities = suspect.values.iter().map(|(quantity, _)| *quantity);
        let values = quantities.zip(found.point.parameters[wider.first..].iter().copied());
        let values: Vec<(Quantity, f64)> = values.collect();
        let left = found.system.cost.max(f64::MIN_POSITIVE);
        if lowest.as_ref().is_none_or(|(lowest, _)| left < *lowest) {
            lowest = Some((left, wider.narrowed(&found.point)));
        }
        let gain = noise.gain(context, cost / left, values.len());
        let misfit = (cost - noise.floor(context)).max(f64::MIN_POSITIVE);
        let explains = ((cost - left) / misfit).clamp(0.0, 1.0);
        let is_told = noise.is_beyond
            || suspect.probability < LEVEL
            || noise.is_alone(explains, cost / left, values.len())
            || of_unknown_times && is_restitution(&values) && noise.is_less(context, cost / left);
        let moves = values.iter().any(|(quantity, value)| {
            let moved = (value - scene.value_of(*quantity)).abs();
            moved > UNMOVED * quantity.typical()
        });
        let is_suspect = gain > 0.0 && explains >= LEAST_SHARE && moves;
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
    TriedSuspects {
        suspects,
        start: lowest
            .filter(|(lowest, _)| *lowest < LOWER * cost)
            .map(|(_, point)| point),
    }
}

fn is_restitution(values: &[(Quantity, f64)]) -> bool {
    matches!(values, [(Quantity::Restitution { .. }, _)])
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
/// wander; how long contacts last where the height of what is hit scored; restitutions where times are unknown, for with a wrong one these are far off, where a slope tells nothing; and the
/// clock's rate where gravity scored or gravity where the rate did, which are the same to a motion.
fn unscored(
    scene: &Scene,
    scored: &[Suspect],
    is_unlikely: bool,
    of_unknown_times: bool,
) -> Vec<Suspect> {
    let has_scored = |is_it: &dyn Fn(Quantity) -> bool| {
        let is_it = |suspect: &&Suspect| suspect.values.iter().any(|(q, _)| is_it(*q));
        scored.iter().find(is_it)
    };
    let is_rate = |quantity| matches!(quantity, Quantity::ClockRate { .. });
    let is_height = |quantity| matches!(quantity, Quantity::SurfaceHeight { .. });
    let is_gravity = |quantity| matches!(quantity, Quantity::Gravity { .. });
    let durations = scene.quantities().into_iter().filter(|quantity| {
        let lasts = matches!(quantity, Quantity::ContactDuration { .. });
        lasts && !scene.frees(*quantity) && scene.untold(*quantity).is_none()
    });
    let durations = durations.map(|quantity| vec![quantity]);
    let groups = groups(scene, Which::All).into_iter().chain(durations);
    let others = groups.filter_map(|group| match group[..] {
        [quantity] if has_scored(&|scored| scored == quantity).is_some() => None,
        [quantity @ Quantity::Friction { .. }] => is_unlikely.then_some((quantity, 0.0, 1.0)),
        [quantity @ Quantity::Restitution { .. }] => {
            of_unknown_times.then_some((quantity, scene.value_of(quantity), 1.0))
        }
        [quantity @ Quantity::ContactDuration { .. }] => {
            let height = has_scored(&is_height)?;
            Some((quantity, scene.value_of(quantity), height.probability))
        }
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
    others.map(suspect).take(TRIED).collect()
}
