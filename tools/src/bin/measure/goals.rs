//! Goals of every kind that a motion near the performed one meets: whether they are met, by a motion that
//! is called physical, and how near the truth that is.

use anyhow::Result;
use enact::estimate::outcome::PHYSICAL;
use enact::motion::{Goal, GoalTarget, Verdict};
use enact::pipeline::Outcome;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};
use enact_tools::apart::apart;
use enact_tools::case::Case;
use enact_tools::goals::{Pair, Quantity, Set};
use enact_tools::perform::Acting;

/// Performances of each row.
const SEEDS: u64 = 100;
/// Standard deviation of a wish, as a share of how far the true motion is from what is wished.
const SD: f64 = 0.3;

/// Radius of a body with which a hand wanders as usual; with a smaller one it wanders less \[m\].
const USUAL_M: f64 = 0.05;

/// A performance with one goal.
#[derive(Serialize)]
struct Asked {
    seed: u64,
    /// Whether the motion meets it, obeys physics, and is called physical after all checks; and what
    /// that without the goal does of it.
    met: bool,
    closed: bool,
    physical: bool,
    met_without: bool,
    physical_without: bool,
    /// Root mean square distance from the truth in both \[mm\].
    apart_mm: f64,
    apart_without_mm: f64,
    /// Distance from the set, in standard deviations of a wish, in both.
    off_sds: f64,
    off_without_sds: f64,
    iterations: usize,
    iterations_without: usize,
}

/// What is asked: a quantity in a set, and the standard deviation of a wish.
type What = (Quantity, Set, Option<f64>);

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let ways = [
        ("acted slowly", "tempo", Acting::default()),
        ("physical stamps", "physical", Acting::timing_known()),
    ];
    let sets = |quantity: Quantity| {
        quantity
            .sets()
            .iter()
            .map(move |set| (quantity, *set, None))
    };
    let hard: Vec<What> = Quantity::ALL.into_iter().flat_map(sets).collect();
    for (way, name, acting) in ways {
        let mut table = Table::new(
            name,
            way,
            &[
                "what",
                "set",
                "not met without it",
                "met",
                "obeys physics",
                "physical",
                "physical without it",
                "from the truth",
                "without it",
                "iterations",
                "without it",
                "met without it",
                "met",
                "physical",
                "physical without it",
            ],
        );
        let (mut all, mut good, mut physical, mut usual) = (0, 0, 0, 0);
        for ((quantity, set, _), asked) in asked(options, &acting, &hard) {
            let (idle, active): (Vec<&Asked>, Vec<&Asked>) =
                asked.iter().partition(|one| one.met_without);
            let count =
                |some: &[&Asked], is: fn(&Asked) -> bool| some.iter().filter(|one| is(one)).count();
            let share =
                |some: &[&Asked], is: fn(&Asked) -> bool| percent(count(some, is), some.len());
            let whole: Vec<&Asked> = asked.iter().collect();
            all += whole.len();
            good += count(&whole, |one| one.met && one.closed);
            physical += count(&whole, |one| one.met && one.physical);
            usual += count(&whole, |one| one.physical_without);
            let of = |value: fn(&Asked) -> f64| {
                let values = active
                    .iter()
                    .map(|one| value(one))
                    .filter(|v| v.is_finite());
                number(median(&values.collect::<Vec<_>>()))
            };
            table.row([
                quantity.as_str().to_owned(),
                set.as_str().to_owned(),
                active.len().to_string(),
                share(&active, |one| one.met),
                share(&active, |one| one.met && one.closed),
                share(&active, |one| one.met && one.physical),
                share(&active, |one| one.physical_without),
                format!("{} mm", of(|one| one.apart_mm)),
                format!("{} mm", of(|one| one.apart_without_mm)),
                of(|one| one.iterations as f64),
                of(|one| one.iterations_without as f64),
                idle.len().to_string(),
                share(&idle, |one| one.met),
                share(&idle, |one| one.met && one.physical),
                share(&idle, |one| one.physical_without),
            ]);
            let row = format!("{way}: {}, {}", quantity.as_str(), set.as_str());
            let missed = asked.iter().filter(|one| !(one.met && one.closed));
            record.numbers(&row, &missed.map(|one| one.seed).collect::<Vec<_>>())?;
        }
        record.table(table);
        record.say(format!(
            "{way}: of {all} goals that a motion near the performed one meets, {good} are met by a motion that obeys physics; {physical} of these motions are called physical after all checks, and {usual} of those without the goal."
        ));
    }
    wishes(options, record);
    Ok(())
}

/// Goals with a weight.
fn wishes(options: &Options, record: &mut Record) {
    let mut table = Table::new(
        "wishes",
        "With a weight",
        &[
            "what",
            "performances",
            "obeys physics",
            "off it, sd",
            "without it",
            "from the truth",
            "without it",
        ],
    );
    let soft = Quantity::ALL.map(|quantity| (quantity, Set::Exact, Some(SD)));
    for ((quantity, ..), asked) in asked(options, &Acting::default(), &soft) {
        let of = |value: fn(&Asked) -> f64| {
            let values = asked.iter().map(value).filter(|v| v.is_finite());
            number(median(&values.collect::<Vec<_>>()))
        };
        let closed = asked.iter().filter(|one| one.closed).count();
        table.row([
            quantity.as_str().to_owned(),
            asked.len().to_string(),
            percent(closed, asked.len()),
            of(|one| one.off_sds),
            of(|one| one.off_without_sds),
            format!("{} mm", of(|one| one.apart_mm)),
            format!("{} mm", of(|one| one.apart_without_mm)),
        ]);
    }
    record.table(table);
}

/// What becomes of every goal in every performance where there is such a motion.
fn asked(options: &Options, acting: &Acting, whats: &[What]) -> Vec<(What, Vec<Asked>)> {
    let mut all: Vec<(What, Vec<Asked>)> = whats.iter().map(|what| (*what, Vec::new())).collect();
    for seed in options.seeds(SEEDS) {
        let mut pairs = [Pair::of_one(seed), Pair::of_two(seed)];
        for (is_of_two, pair) in pairs.iter_mut().enumerate() {
            let Some(pair) = pair else { continue };
            let mut without: [Option<(Case, Outcome)>; 2] = [None, None];
            for ((quantity, set, sd), found) in &mut all {
                if quantity.is_of_two() == (is_of_two == 1) {
                    let what = (*quantity, *set, *sd);
                    found.extend(asked_of(seed, acting, pair, what, &mut without));
                }
            }
        }
    }
    all
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
        let outcome = case.pipeline().finish(&mut ()).ok()?;
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
    };
    let case = Case::new(&truth, &acting, seed);
    let Ok(outcome) = case.pipeline().finish(&mut ()) else {
        return Some(none);
    };
    let of_it = measured(&case, &outcome, &goal);
    Some(Asked {
        met: of_it.is_met,
        closed: is_closed(&outcome),
        physical: outcome.estimate.verdict == Verdict::Physical,
        apart_mm: of_it.apart_mm,
        off_sds: of_it.off_sds,
        iterations: outcome.estimate.counters.iterations,
        ..none
    })
}

/// Whether no gap is left, whatever else is doubted.
fn is_closed(outcome: &Outcome) -> bool {
    outcome.estimate.events.iter().all(|event| {
        event.gap.position_m <= PHYSICAL.position_m
            && event.gap.orientation_rad <= PHYSICAL.orientation_rad
            && event.gap.velocity_m_s <= PHYSICAL.velocity_m_s
            && event.gap.angular_velocity_rad_s <= PHYSICAL.angular_velocity_rad_s
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
