//! Goals of every kind that a motion near the performed one meets: whether they are met, by a motion that
//! is called physical, and how near the truth that is.

use anyhow::Result;
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

/// A performance with one goal.
#[derive(Serialize)]
struct Asked {
    seed: u64,
    verdict: &'static str,
    /// Whether the motion meets it, and whether that without it does.
    met: bool,
    met_without: bool,
    /// Root mean square distance from the truth in both \[mm\].
    apart_mm: f64,
    apart_without_mm: f64,
    /// Distance from the set, in standard deviations of a wish, in both.
    off_sds: f64,
    off_without_sds: f64,
    iterations: usize,
    iterations_without: usize,
}

impl Asked {
    fn is_physical(&self) -> bool {
        self.verdict == Verdict::Physical.as_str()
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let ways = [
        ("acted slowly", "tempo", Acting::default()),
        ("physical stamps", "physical", Acting::timing_known()),
    ];
    for (way, name, acting) in ways {
        let mut table = Table::new(
            name,
            way,
            &[
                "what",
                "set",
                "not met without it",
                "met and physical",
                "met, not physical",
                "not met",
                "from the truth",
                "without it",
                "iterations",
                "without it",
                "met without it",
                "met and physical",
            ],
        );
        let (mut all, mut good) = (0, 0);
        for quantity in Quantity::ALL {
            for set in quantity.sets() {
                let row = format!("{way}: {}, {}", quantity.as_str(), set.as_str());
                if !options.wants(&row) {
                    continue;
                }
                let asked: Vec<Asked> = options
                    .seeds(SEEDS)
                    .filter_map(|seed| asked(seed, &acting, (quantity, *set), None))
                    .collect();
                let (idle, active): (Vec<&Asked>, Vec<&Asked>) =
                    asked.iter().partition(|one| one.met_without);
                let right = |some: &[&Asked]| {
                    some.iter()
                        .filter(|one| one.met && one.is_physical())
                        .count()
                };
                all += asked.len();
                good += right(&active) + right(&idle);
                let of = |value: fn(&Asked) -> f64| {
                    let values = active
                        .iter()
                        .map(|one| value(one))
                        .filter(|v| v.is_finite());
                    number(median(&values.collect::<Vec<_>>()))
                };
                let met = active.iter().filter(|one| one.met).count();
                table.row([
                    quantity.as_str().to_owned(),
                    set.as_str().to_owned(),
                    active.len().to_string(),
                    percent(right(&active), active.len()),
                    (met - right(&active)).to_string(),
                    (active.len() - met).to_string(),
                    format!("{} mm", of(|one| one.apart_mm)),
                    format!("{} mm", of(|one| one.apart_without_mm)),
                    of(|one| one.iterations as f64),
                    of(|one| one.iterations_without as f64),
                    idle.len().to_string(),
                    percent(right(&idle), idle.len()),
                ]);
                record.numbers(&row, &asked)?;
            }
        }
        record.table(table);
        record.say(format!(
            "{way}: of {all} goals that a motion near the performed one meets, {good} are met by a motion that is called physical."
        ));
    }
    wishes(options, record)
}

/// Goals with a weight.
fn wishes(options: &Options, record: &mut Record) -> Result<()> {
    let mut table = Table::new(
        "wishes",
        "With a weight",
        &[
            "what",
            "performances",
            "physical",
            "off it, sd",
            "without it",
            "from the truth",
            "without it",
        ],
    );
    for quantity in Quantity::ALL {
        let row = format!("wish: {}", quantity.as_str());
        if !options.wants(&row) {
            continue;
        }
        let asked: Vec<Asked> = options
            .seeds(SEEDS)
            .filter_map(|seed| asked(seed, &Acting::default(), (quantity, Set::Exact), Some(SD)))
            .collect();
        let of = |value: fn(&Asked) -> f64| {
            let values = asked.iter().map(value).filter(|v| v.is_finite());
            number(median(&values.collect::<Vec<_>>()))
        };
        let physical = asked.iter().filter(|one| one.is_physical()).count();
        table.row([
            quantity.as_str().to_owned(),
            asked.len().to_string(),
            percent(physical, asked.len()),
            of(|one| one.off_sds),
            of(|one| one.off_without_sds),
            format!("{} mm", of(|one| one.apart_mm)),
            format!("{} mm", of(|one| one.apart_without_mm)),
        ]);
        record.numbers(&row, &asked)?;
    }
    record.table(table);
    Ok(())
}

/// `None` where there is no such motion.
fn asked(seed: u64, acting: &Acting, what: (Quantity, Set), sd: Option<f64>) -> Option<Asked> {
    let mut pair = if what.0.is_of_two() {
        Pair::of_two(seed)?
    } else {
        Pair::of_one(seed)?
    };
    let is_tight = sd.is_some() || seed.is_multiple_of(2) || what.1 == Set::Exact;
    let goal = pair.goal(what, is_tight, sd)?;
    let mut truth = pair.truth;
    truth.scene.goals.push(goal.clone());
    let case = Case::new(&truth, acting, seed);
    let mut free = Case::new(&truth, acting, seed);
    // Without the goal, but with the same times free.
    let scene = &mut free.performance.truth.scene;
    let time_is_free = scene.time_is_free(goal.event);
    scene.goals.clear();
    scene.events[goal.event].time.is_free = Some(time_is_free);
    let without = free.pipeline().finish(&mut ()).ok()?;
    let of_without = measured(&free, &without, &goal);
    let none = Asked {
        seed,
        verdict: "refused",
        met: false,
        met_without: of_without.is_met,
        apart_mm: f64::NAN,
        apart_without_mm: of_without.apart_mm,
        off_sds: f64::NAN,
        off_without_sds: of_without.off_sds,
        iterations: 0,
        iterations_without: without.estimate.counters.iterations,
    };
    let Ok(outcome) = case.pipeline().finish(&mut ()) else {
        return Some(none);
    };
    let of_it = measured(&case, &outcome, &goal);
    Some(Asked {
        verdict: outcome.estimate.verdict.as_str(),
        met: of_it.is_met,
        apart_mm: of_it.apart_mm,
        off_sds: of_it.off_sds,
        iterations: outcome.estimate.counters.iterations,
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
