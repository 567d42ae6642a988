//! Performances of which trackers see parts: whether there is a motion, whether what is not seen is said,
//! and how near the truth what is seen is.

use std::collections::BTreeMap;

use anyhow::Result;
use enact::motion::{Estimate, Scene, Undetermined, Verdict};
use enact::pipeline::{Outcome, PipelineError};
use enact_tools::apart::{Apart, apart, apart_from_another};
use enact_tools::case::{Case, estimated};
use enact_tools::parts::{LATE_S, Part};
use enact_tools::perform::{Acting, Style, bounces};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};

/// Performances of each row, and of those that take seconds each.
const SEEDS: u64 = 100;
const SLOW_SEEDS: u64 = 20;
const SLOWEST_SEEDS: u64 = 5;

/// What the program makes of a performance.
type Solved = Result<Outcome, PipelineError>;

/// One performance as its trackers see it.
#[derive(Serialize)]
struct Seen {
    seed: u64,
    verdict: String,
    apart: Option<Apart>,
    iterations: usize,
    objective: f64,
    /// Estimated offset of the second clock and its deviation \[s\].
    late: Option<[f64; 2]>,
    /// Distance of the path from that of orientations weighed to nothing \[m\], of a centre alone.
    off_unweighed_m: Option<f64>,
    /// Objective in such ones, of a centre alone.
    objective_ratio: Option<f64>,
    /// Whether something of the motion is said to be open.
    is_open: bool,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let ways = [
        ("physical", "physical stamps", Acting::timing_known()),
        ("tempo", "acted slowly", Acting::default()),
    ];
    type Make = fn(&Acting, u64) -> Option<Case>;
    let scenes: [(&str, &str, Make); 3] = [
        ("tip", "pencil, tip first", |acting, seed| {
            Some(Case::pencil(Style::Tip, acting, seed))
        }),
        ("eraser", "pencil, eraser first", |acting, seed| {
            Some(Case::pencil(Style::Eraser, acting, seed))
        }),
        ("cube", "cube, two bounces", |acting, seed| {
            Some(Case::new(&bounces::bounces(2, seed).ok()?, acting, seed))
        }),
    ];
    let mut centres = [0; 2];
    for (way_id, way, acting) in ways {
        for (id, scene, make) in scenes {
            let title = format!("{scene}, {way}");
            let mut table = Table::new(
                &format!("{id}_{way_id}"),
                &title,
                &[
                    "seen",
                    "performances",
                    "physical",
                    "plausible",
                    "failed or refused",
                    "path off the truth",
                    "turn off the truth",
                    "path off that of turns weighed to nothing",
                    "objective beside it",
                    "iterations",
                    "clock",
                ],
            );
            // Of turns weighed to nothing, which a centre alone is compared with.
            let mut unweighed: BTreeMap<u64, Solved> = BTreeMap::new();
            for part in Part::ALL {
                // In a quick run one slow row of a kind is enough, and two points stand for one.
                let is_tip = (id, way_id) == ("tip", "physical");
                if options.quick && part.is_slow() && !(is_tip && part != Part::Point) {
                    continue;
                }
                let row = format!("{title}: {}", part.as_str());
                if !options.wants(&row) {
                    continue;
                }
                let seeds = options.seeds(match part {
                    Part::Point => SLOWEST_SEEDS,
                    part if part.is_slow() => SLOW_SEEDS,
                    _ => SEEDS,
                });
                if matches!(part, Part::Centre | Part::Unweighed) && unweighed.is_empty() {
                    let solve = |seed| Some((seed, solved(&make(&acting, seed)?, Part::Unweighed)));
                    unweighed = seeds.clone().into_par_iter().filter_map(solve).collect();
                }
                let all: Vec<Seen> = seeds
                    .into_par_iter()
                    .filter_map(|seed| {
                        let (case, other) = (make(&acting, seed)?, unweighed.get(&seed));
                        Some(match (part, other) {
                            (Part::Unweighed, Some(solved)) => seen(&case, solved, None, seed),
                            (Part::Centre, other) => seen(&case, &solved(&case, part), other, seed),
                            _ => seen(&case, &solved(&case, part), None, seed),
                        })
                    })
                    .collect();
                let with = |verdict: Verdict| {
                    all.iter()
                        .filter(|one| one.verdict == verdict.as_str())
                        .count()
                };
                let (physical, plausible) = (with(Verdict::Physical), with(Verdict::Plausible));
                if part == Part::Centre {
                    centres = [centres[0] + physical, centres[1] + all.len()];
                }
                let of = |value: fn(&Apart) -> f64| {
                    let values = all.iter().filter_map(|one| one.apart.as_ref());
                    median(&values.map(value).collect::<Vec<_>>())
                };
                let iterations: Vec<f64> = all.iter().map(|one| one.iterations as f64).collect();
                let off_unweighed_m: Vec<f64> =
                    all.iter().filter_map(|one| one.off_unweighed_m).collect();
                let late: Vec<[f64; 2]> = all.iter().filter_map(|one| one.late).collect();
                let held = late
                    .iter()
                    .filter(|[value_s, sd_s]| (value_s + LATE_S).abs() <= 1.96 * sd_s)
                    .count();
                table.row([
                    part.as_str().to_owned(),
                    all.len().to_string(),
                    percent(physical, all.len()),
                    plausible.to_string(),
                    (all.len() - physical - plausible).to_string(),
                    format!("{} mm", number(1e3 * of(|apart| apart.position_m))),
                    format!(
                        "{}°",
                        number(of(|apart| apart.orientation_rad).to_degrees())
                    ),
                    if off_unweighed_m.is_empty() {
                        String::new()
                    } else {
                        format!(
                            "{} mm, at most {} mm",
                            number(1e3 * median(&off_unweighed_m)),
                            number(1e3 * off_unweighed_m.iter().copied().fold(0.0, f64::max))
                        )
                    },
                    beside(&all),
                    number(median(&iterations)),
                    if late.is_empty() {
                        String::new()
                    } else {
                        format!("{} of {} within", held, late.len())
                    },
                ]);
                record.numbers(&row, &all)?;
            }
            record.table(table);
        }
    }
    record.say(format!(
        "Of {} performances of which the centre of mass alone is seen, {} become a physical motion.",
        centres[1], centres[0]
    ));
    Ok(())
}

/// In how many the objective is as low, within a hundredth, lower or higher.
fn beside(all: &[Seen]) -> String {
    const ALIKE: f64 = 0.01;
    let ratios: Vec<f64> = all.iter().filter_map(|one| one.objective_ratio).collect();
    if ratios.is_empty() {
        return String::new();
    }
    let lower = ratios.iter().filter(|ratio| **ratio < 1.0 - ALIKE).count();
    let higher = ratios.iter().filter(|ratio| **ratio > 1.0 + ALIKE);
    let higher: Vec<f64> = higher.copied().collect();
    let alike = ratios.len() - lower - higher.len();
    let most = ratios.iter().copied().fold(0.0, f64::max);
    let higher = higher.len();
    format!("{alike} as low, {lower} lower, {higher} higher, at most {most:.2} times")
}

fn solved(case: &Case, part: Part) -> Solved {
    let (scene, events) = part.seen(case);
    estimated(&scene, &events, &mut ())
}

/// What became of a performance, and how far it is from what became of another sketch of it.
fn seen(case: &Case, solved: &Solved, other: Option<&Solved>, seed: u64) -> Seen {
    match solved {
        Ok(outcome) => {
            let estimate = &outcome.estimate;
            let until_s = case.performance.truth.duration_s;
            let is_of_motion = |of: &Undetermined| !matches!(of, Undetermined::Parameter(_));
            Seen {
                seed,
                verdict: estimate.verdict.as_str().to_owned(),
                apart: apart(case, &outcome.scene, estimate, until_s),
                iterations: estimate.counters.iterations,
                objective: estimate.objective,
                late: estimate
                    .parameters
                    .iter()
                    .find(|parameter| parameter.name == "late")
                    .and_then(|parameter| Some([parameter.value, parameter.sd?])),
                off_unweighed_m: other
                    .and_then(|other| off_m(case, (&outcome.scene, estimate), other)),
                objective_ratio: other
                    .and_then(|other| Some(other.as_ref().ok()?.estimate.objective))
                    .map(|other| estimate.objective / other),
                is_open: estimate.undetermined.iter().any(is_of_motion),
            }
        }
        Err(error) => Seen {
            seed,
            verdict: error.to_string(),
            apart: None,
            iterations: 0,
            objective: f64::NAN,
            late: None,
            off_unweighed_m: None,
            objective_ratio: None,
            is_open: true,
        },
    }
}

fn off_m(case: &Case, found: (&Scene, &Estimate), other: &Solved) -> Option<f64> {
    let other = other.as_ref().ok()?;
    let other = (&other.scene, &other.estimate);
    apart_from_another(case, found, other).map(|apart| apart.position_m)
}
