//! What the peers' answers amount to, scene by scene and solver by solver.

use std::ops::Range;

use anyhow::Result;
use serde::Serialize;
use serde_json::json;

use super::scenes::{Given, Own, Scene};
use super::{Agreement, Answer, FEASIBLE, Report, Settings, figures};
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::percent;
use enact_tools::starts::is_best;

/// What this program is called beside its peers.
pub const OWN: &str = "enact";
pub const WHOLE: &str = "enact, whole estimate";

/// One solver on one problem.
struct Cell {
    seconds: [f64; 2],
    /// Without what is spent in Python callbacks.
    solver_seconds: f64,
    /// Over the lowest known, of a motion.
    objective: Option<f64>,
    succeeds: bool,
    is_late: bool,
}

/// A scene and its problems.
pub struct Block {
    pub name: String,
    pub what: String,
    /// How much the hand wanders; none of all scenes together.
    pub distortion: Option<f64>,
    pub bounces: Option<usize>,
    problems: Range<usize>,
}

/// One solver on all problems of a scene; not a number where nothing is to be said.
#[derive(Serialize)]
pub struct Row {
    /// Index of the scene.
    pub block: usize,
    pub scene: String,
    pub solver: String,
    pub problems: usize,
    pub succeeds: usize,
    /// Stopped by the limit of time.
    pub late: usize,
    /// Median time, of those that succeed \[s\].
    pub seconds: f64,
    /// Median time of ours, of all \[s\].
    pub own_seconds: f64,
    /// Time over ours, where both succeed: quartile, median, quartile.
    pub ratio: [f64; 3],
    /// Median of the same without Python callbacks.
    solver_ratio: f64,
    /// Median of greatest over least time of the repeats, of those that succeed.
    spread: f64,
    /// Median of the objective over the lowest known, of all motions.
    objective: f64,
}

/// All problems, scene by scene.
#[derive(Default)]
pub struct Account {
    pub given: Vec<Given>,
    pub blocks: Vec<Block>,
}

impl Account {
    /// Adds a scene's problems.
    pub fn add(&mut self, scene: &Scene, given: Vec<Given>) {
        let first = self.given.len();
        self.given.extend(given);
        self.blocks.push(Block {
            name: scene.name.clone(),
            what: scene.what.clone(),
            distortion: Some(scene.acting.distortion),
            bounces: scene.bounces,
            problems: first..self.given.len(),
        });
    }

    /// Keeps raw numbers, and what is made of them.
    pub fn show(
        &mut self,
        report: &Report,
        settings: &Settings,
        record: &mut Record,
    ) -> Result<()> {
        self.blocks.push(Block {
            name: "all".to_owned(),
            what: "all".to_owned(),
            distortion: None,
            bounces: None,
            problems: 0..self.given.len(),
        });
        let solvers: Vec<&str> = [OWN, WHOLE]
            .into_iter()
            .chain(settings.peers.iter().copied())
            .collect();
        let owns = self.given.iter().map(|given| &given.own);
        let cells = owns
            .enumerate()
            .map(|(problem, own)| cells(problem, &solvers, own, report));
        let cells: Vec<Vec<Option<Cell>>> = cells.collect();
        let mut rows = Vec::new();
        for (index, block) in self.blocks.iter().enumerate() {
            for (at, solver) in solvers.iter().enumerate() {
                rows.push(row(
                    (index, &block.name),
                    (at, solver),
                    &cells[block.problems.clone()],
                ));
            }
        }
        record.say(agreement(&report.agreements));
        for row in &rows[rows.len() - solvers.len()..] {
            record.say(said(row, settings.limit_s));
        }
        record.table(figures::table(&rows, &self.blocks, &solvers));
        for figure in figures::all(&rows, &self.blocks, &solvers, settings) {
            record.figure(figure);
        }
        let owns: Vec<&Own> = self.given.iter().map(|given| &given.own).collect();
        record.numbers(
            "peers",
            &json!({
                "limit_s": settings.limit_s,
                "repeats": settings.repeats,
                "rows": rows,
                "own": owns,
                "report": report,
            }),
        )
    }
}

/// How well the peers' formulas agree with ours.
fn agreement(all: &[Agreement]) -> String {
    let worst = |of: fn(&Agreement) -> f64| all.iter().map(of).fold(0.0, f64::max);
    format!(
        "On {} problems, at every start and solution, the peers' objectives agree with ours to {:.1e} of them, constraints to \
         {:.1e} units, derivatives with difference quotients to {:.1e}; {} problems are refused.",
        all.len(),
        worst(|a| a.objective),
        worst(|a| a.constraint),
        worst(|a| a.derivative),
        all.iter().filter(|a| a.refused.is_some()).count(),
    )
}

/// One solver on all problems, in a sentence.
fn said(row: &Row, limit_s: f64) -> String {
    let share = percent(row.succeeds, row.problems);
    let late = if row.late > 0 {
        format!(", {} stopped by the limit of {limit_s} s", row.late)
    } else {
        String::new()
    };
    let ends = match row.solver.as_str() {
        WHOLE => "has the verdict that the scene allows",
        _ => "ends at the best known optimum",
    };
    format!(
        "{} {ends} in {share} of {} problems, in {:.1} times enact's time{late}.",
        row.solver, row.problems, row.ratio[1]
    )
}

/// What every solver made of a problem; `None` of those that were not given it.
fn cells(problem: usize, names: &[&str], own: &Own, report: &Report) -> Vec<Option<Cell>> {
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
        is_late: answer.is_late(),
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
        .map(|name| match *name {
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

fn row(
    (block, scene): (usize, &str),
    (solver, name): (usize, &str),
    cells: &[Vec<Option<Cell>>],
) -> Row {
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
        block,
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
