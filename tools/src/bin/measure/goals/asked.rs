//! What becomes of a goal that a motion near the performed one meets.

use enact::motion::{Goal, GoalTarget, Verdict};
use enact::pipeline::{Outcome, PipelineError};
use enact::report::reason_text;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use crate::options::Options;
use enact_tools::apart::apart;
use enact_tools::case::Case;
use enact_tools::goals::{Pair, Quantity, Set, is_closed};
use enact_tools::perform::Acting;

/// Performances of each row.
const SEEDS: u64 = 100;
/// Radius of a body with which a hand wanders as usual; with a smaller one it wanders less \[m\].
const USUAL_M: f64 = 0.05;

/// A performance with one goal.
#[derive(Clone, Serialize)]
pub struct Asked {
    pub seed: u64,
    /// Whether the motion meets it, obeys physics, and is called physical after all checks; and what
    /// that without the goal does of it.
    pub met: bool,
    pub closed: bool,
    pub physical: bool,
    pub met_without: bool,
    pub physical_without: bool,
    /// Root mean square distance from the truth in both \[mm\].
    pub apart_mm: f64,
    pub apart_without_mm: f64,
    /// Distance from the set, in standard deviations of a wish, in both.
    pub off_sds: f64,
    pub off_without_sds: f64,
    pub iterations: usize,
    pub iterations_without: usize,
    /// How the solver ended.
    pub end: String,
}

/// What is asked: a quantity in a set, and the standard deviation of a wish.
pub type What = (Quantity, Set, Option<f64>);

/// What becomes of every goal in every performance where there is such a motion.
pub fn asked(options: &Options, acting: &Acting, whats: &[What]) -> Vec<(What, Vec<Asked>)> {
    let seeds = options.seeds(SEEDS).into_par_iter();
    let each: Vec<Vec<Option<Asked>>> = seeds.map(|seed| asked_once(seed, acting, whats)).collect();
    let of = |index: usize| each.iter().filter_map(move |found| found[index].clone());
    let rows = whats.iter().enumerate();
    rows.map(|(index, what)| (*what, of(index).collect()))
        .collect()
}

/// The same of one performance of one body and one of two.
fn asked_once(seed: u64, acting: &Acting, whats: &[What]) -> Vec<Option<Asked>> {
    let mut found = vec![None; whats.len()];
    for is_of_two in [false, true] {
        let pair = if is_of_two {
            Pair::of_two(seed)
        } else {
            Pair::of_one(seed)
        };
        let Some(mut pair) = pair else { continue };
        let mut without: [Option<(Case, Outcome)>; 2] = [None, None];
        for (found, what) in found.iter_mut().zip(whats) {
            if what.0.is_of_two() == is_of_two {
                *found = asked_of(seed, acting, &mut pair, *what, &mut without);
            }
        }
    }
    found
}

/// The estimate with its checks and no more: what in the scene might be wrong is not asked.
fn checked(case: &Case) -> Result<Outcome, PipelineError> {
    case.pipeline().with_diagnoses(false).finish(&mut ())
}

/// `None` where there is no such goal or no motion without it.
fn asked_of(
    seed: u64,
    acting: &Acting,
    pair: &mut Pair,
    (quantity, set, sd): What,
    without: &mut [Option<(Case, Outcome)>; 2],
) -> Option<Asked> {
    let is_tight = sd.is_some() || seed.is_multiple_of(2) || set == Set::Exact;
    let goal = pair.goal((quantity, set), is_tight, sd)?;
    let mut truth = pair.truth.clone();
    truth.scene.goals.push(goal.clone());
    let radius_m = truth.scene.links[goal.link].radius_m();
    let acting = Acting {
        distortion: acting.distortion * (radius_m / USUAL_M).min(1.0),
        ..*acting
    };
    // Without the goal, but with the same times free.
    let is_end = goal.event + 1 == truth.scene.events.len();
    let free = &mut without[usize::from(is_end)];
    if free.is_none() {
        let mut case = Case::new(&truth, &acting, seed);
        let scene = &mut case.performance.truth.scene;
        let time_is_free = scene.time_is_free(goal.event);
        scene.goals.clear();
        scene.events[goal.event].time.is_free = Some(time_is_free);
        let outcome = checked(&case).ok()?;
        *free = Some((case, outcome));
    }
    let (free, unasked) = free.as_ref()?;
    let of_unasked = measured(free, unasked, &goal);
    let none = Asked {
        seed,
        met: false,
        closed: false,
        physical: false,
        met_without: of_unasked.is_met,
        physical_without: unasked.estimate.verdict == Verdict::Physical,
        apart_mm: f64::NAN,
        apart_without_mm: of_unasked.apart_mm,
        off_sds: f64::NAN,
        off_without_sds: of_unasked.off_sds,
        iterations: 0,
        iterations_without: unasked.estimate.counters.iterations,
        end: String::new(),
    };
    let case = Case::new(&truth, &acting, seed);
    let outcome = match checked(&case) {
        Ok(outcome) => outcome,
        Err(error) => {
            let end = error.to_string();
            return Some(Asked { end, ..none });
        }
    };
    let of_it = measured(&case, &outcome, &goal);
    Some(Asked {
        met: of_it.is_met,
        closed: is_closed(&outcome.estimate),
        physical: outcome.estimate.verdict == Verdict::Physical,
        apart_mm: of_it.apart_mm,
        off_sds: of_it.off_sds,
        iterations: outcome.estimate.counters.iterations,
        end: reason_text(&outcome.scene, &outcome.estimate.reason),
        ..none
    })
}

/// An estimate against a goal and the truth.
struct Measured {
    is_met: bool,
    off_sds: f64,
    apart_mm: f64,
}

fn measured(case: &Case, outcome: &Outcome, goal: &Goal) -> Measured {
    let mut scene = outcome.scene.as_estimated(&outcome.estimate);
    scene.goals = vec![goal.clone()];
    let GoalTarget::Condition(condition) = &goal.target else {
        unreachable!("drawn goals are conditions");
    };
    let attained = scene.goals_attained(&outcome.estimate);
    let of = attained.first();
    let off = of.map_or(f64::NAN, |of| of.distance);
    let truth = &case.performance.truth;
    let found = apart(case, &outcome.scene, &outcome.estimate, truth.duration_s);
    Measured {
        is_met: of.is_some_and(|of| of.is_met()),
        off_sds: off / condition.sd.unwrap_or(f64::NAN),
        apart_mm: found.map_or(f64::NAN, |apart| 1e3 * apart.position_m),
    }
}
