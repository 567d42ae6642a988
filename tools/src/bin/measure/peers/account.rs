//! What the peers' answers amount to, scene by scene and solver by solver.

use std::ops::Range;

use anyhow::Result;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;

use super::present::present;
use super::scenes::Own;
use super::{Answer, FEASIBLE, Report, Settings};
use crate::Book;
use crate::figure::or_nan;
use crate::statistics::{median, quantile};
use enact_tools::starts::is_best;

/// What this program is called beside its peers.
pub const OWN: &str = "enact";
pub const WHOLE: &str = "enact, whole estimate";
/// Every scene together.
pub const ALL: &str = "all";
/// Name of the numbers.
const NUMBERS: &str = "peers";

/// One solver on one problem.
#[derive(Clone, Debug, Serialize)]
struct Cell {
    seconds: [f64; 2],
    /// Without what is spent in Python callbacks.
    solver_seconds: f64,
    objective: Option<f64>,
    succeeds: bool,
    is_late: bool,
}

/// One solver on all problems of a scene; not a number where nothing is to be said.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Row {
    pub scene: String,
    pub solver: String,
    pub problems: usize,
    pub succeeds: usize,
    pub late: usize,
    /// Median time, of those that succeed \[s\].
    #[serde(deserialize_with = "or_nan")]
    pub seconds: f64,
    /// Median time of ours, of all \[s\].
    #[serde(deserialize_with = "or_nan")]
    pub own_seconds: f64,
    /// Time over ours, where both succeed: quartile, median, quartile.
    #[serde(deserialize_with = "or_nans")]
    pub ratio: [f64; 3],
    /// Median of the same without Python callbacks.
    #[serde(deserialize_with = "or_nan")]
    pub solver_ratio: f64,
    /// Median of greatest over least time of the repeats, of those that succeed.
    #[serde(deserialize_with = "or_nan")]
    pub spread: f64,
    /// Median of the objective over the lowest known, of all motions.
    #[serde(deserialize_with = "or_nan")]
    pub objective: f64,
}

fn or_nans<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    let numbers = <[Option<f64>; 3]>::deserialize(deserializer)?;
    Ok(numbers.map(|number| number.unwrap_or(f64::NAN)))
}

/// What tables and figures are made of.
#[derive(Deserialize)]
pub struct Measured {
    /// Longest time of a solve \[s\].
    pub limit_s: f64,
    /// Solves of each problem.
    pub repeats: usize,
    /// Scene by scene, solver by solver.
    pub rows: Vec<Row>,
}

/// Keeps raw numbers, and what is made of them.
pub fn show(
    scenes: &[(String, Range<usize>)],
    owns: &[Own],
    report: &Report,
    settings: &Settings,
    book: &mut Book,
) -> Result<()> {
    let agreements = &report.agreements;
    let worst = |of: fn(&super::Agreement) -> f64| agreements.iter().map(of).fold(0.0, f64::max);
    println!(
        "peers: on {} problems, at every start and solution, objectives agree to {:.1e} of them, \
         constraints to {:.1e} units, derivatives with difference quotients to {:.1e}; {} refused",
        agreements.len(),
        worst(|a| a.objective),
        worst(|a| a.constraint),
        worst(|a| a.derivative),
        agreements.iter().filter(|a| a.refused.is_some()).count(),
    );
    for agreement in agreements.iter().filter(|a| a.refused.is_some()) {
        println!("  problem {}: {:?}", agreement.problem, agreement.refused);
    }
    let own_names = [OWN, WHOLE].map(str::to_owned);
    let names: Vec<String> = own_names.into_iter().chain(peers(report)).collect();
    let cells: Vec<Vec<Option<Cell>>> = (0..owns.len())
        .map(|problem| cells(problem, &names, &owns[problem], report))
        .collect();
    let all = (ALL.to_owned(), 0..owns.len());
    let rows: Vec<Row> = scenes
        .iter()
        .chain([&all])
        .flat_map(|(scene, range)| {
            let cells = &cells[range.clone()];
            (0..names.len()).map(move |solver| (scene, solver, cells))
        })
        .map(|(scene, solver, cells)| row(scene, &names[solver], solver, cells))
        .collect();
    let raw = json!({
        "versions": report.versions,
        "limit_s": settings.limit_s,
        "repeats": settings.repeats,
        "rows": rows,
        "own": owns,
        "agreements": report.agreements,
        "answers": report.answers,
    });
    book.numbers(NUMBERS, &raw)?;
    redraw(book)
}

/// Makes table and figures from the numbers that were kept, if there are any.
pub fn redraw(book: &mut Book) -> Result<()> {
    match book.read::<Measured>(NUMBERS) {
        Some(measured) => present(&measured, book),
        None => Ok(()),
    }
}

/// Prints how many motions the peers find from the truth.
pub fn show_control(problems: usize, report: &Report) {
    println!(
        "From the truth, of {problems} problems, one of each scene that has one, a motion is found by"
    );
    for name in peers(report) {
        let answers = report.answers.iter().filter(|answer| answer.peer == name);
        let motions = answers.filter(|answer| answer.is_motion()).count();
        println!("  {name}: {motions}");
    }
}

/// Names of the peers in the order in which they answered.
fn peers(report: &Report) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for answer in &report.answers {
        if !names.contains(&answer.peer) {
            names.push(answer.peer.clone());
        }
    }
    names
}

/// What every solver made of a problem; `None` of those that were not given it.
fn cells(problem: usize, names: &[String], own: &Own, report: &Report) -> Vec<Option<Cell>> {
    let answers = || report.answers.iter().filter(|a| a.problem == problem);
    let motions = answers().filter(|answer| answer.is_motion());
    let own_is_motion = own.violation < FEASIBLE && own.is_in_order;
    let lowest = motions
        .filter_map(|answer| answer.objective)
        .chain(own.lowest)
        .chain(own_is_motion.then_some(own.objective))
        .fold(f64::INFINITY, f64::min);
    let of_peer = |answer: &Answer| Cell {
        seconds: answer.seconds,
        solver_seconds: answer.seconds[0] - answer.callback_seconds.unwrap_or(0.0),
        objective: answer
            .objective
            .filter(|_| answer.is_motion())
            .map(|o| o / lowest),
        succeeds: answer.is_success(lowest),
        is_late: answer.status == "over the limit",
    };
    let of_own = |seconds: [f64; 2], objective: f64, is_motion: bool| Cell {
        seconds,
        solver_seconds: seconds[0],
        objective: is_motion.then_some(objective / lowest),
        succeeds: is_motion && is_best(objective, lowest),
        is_late: false,
    };
    names
        .iter()
        .map(|name| match name.as_str() {
            OWN => Some(of_own(own.seconds, own.objective, own_is_motion)),
            WHOLE => Some(whole(own)),
            name => answers().find(|answer| answer.peer == name).map(of_peer),
        })
        .collect()
}

/// The whole estimate is of a larger problem, marks and reassigned samples included: its objective is not
/// comparable, and its success is the verdict that the scene allows.
fn whole(own: &Own) -> Cell {
    Cell {
        seconds: own.whole_seconds,
        solver_seconds: own.whole_seconds[0],
        objective: None,
        succeeds: own.whole_is_motion,
        is_late: false,
    }
}

fn row(scene: &str, name: &str, solver: usize, cells: &[Vec<Option<Cell>>]) -> Row {
    let all = || cells.iter().filter_map(|cells| cells[solver].as_ref());
    let good = || all().filter(|cell| cell.succeeds);
    let both = || {
        cells.iter().filter_map(|cells| {
            let (own, other) = (cells[0].as_ref()?, cells[solver].as_ref()?);
            (own.succeeds && other.succeeds).then_some((own, other))
        })
    };
    let ratios: Vec<f64> = both()
        .map(|(own, o)| o.seconds[0] / own.seconds[0])
        .collect();
    let solver_ratios: Vec<f64> = both()
        .map(|(own, o)| o.solver_seconds / own.seconds[0])
        .collect();
    let own_seconds: Vec<f64> = cells
        .iter()
        .filter_map(|cells| Some(cells[0].as_ref()?.seconds[0]))
        .collect();
    let of_good = |value: fn(&Cell) -> f64| median(&good().map(value).collect::<Vec<f64>>());
    Row {
        scene: scene.to_owned(),
        solver: name.to_owned(),
        problems: all().count(),
        succeeds: good().count(),
        late: all().filter(|cell| cell.is_late).count(),
        seconds: of_good(|cell| cell.seconds[0]),
        own_seconds: median(&own_seconds),
        ratio: [0.25, 0.5, 0.75].map(|share| quantile(&ratios, share)),
        solver_ratio: median(&solver_ratios),
        spread: of_good(|cell| cell.seconds[1] / cell.seconds[0]),
        objective: median(
            &all()
                .filter_map(|cell| cell.objective)
                .collect::<Vec<f64>>(),
        ),
    }
}
