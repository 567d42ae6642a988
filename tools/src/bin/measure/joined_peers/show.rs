//! What all solvers made of the problems, row by row.

use super::{Cell, OWN, Problem, STARTS, WHOLE};
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent};

/// Tables and sentences.
pub fn show(rows: &[String], problems: &[Problem], limit_s: f64, record: &mut Record) {
    let Some(first) = problems.first() else {
        return;
    };
    let worst = |of: fn(&Problem) -> f64| largest(&problems.iter().map(of).collect::<Vec<f64>>());
    record.say(format!(
        "On {} problems of joined bodies the peers' accelerations agree with ours to {:.1e}, objectives to {:.1e}, rows to {:.1e} \
         units, their derivatives with difference quotients to {:.1e}.",
        problems.len(),
        worst(|of| of.agreement.accelerations),
        worst(|of| of.agreement.objective),
        worst(|of| of.agreement.rows),
        worst(|of| of.agreement.derivative),
    ));
    let solvers: Vec<(&str, &str)> = first
        .cells
        .iter()
        .map(|cell| (cell.solver.as_str(), cell.from.as_str()))
        .collect();
    let all: Vec<&Problem> = problems.iter().collect();
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in &solvers {
        if *name != WHOLE && !names.contains(name) {
            names.push(name);
            record.say(said(&all, name, limit_s));
        }
    }
    let header = [
        "motion",
        "solver",
        "from",
        "problems",
        "converged",
        "motions",
        "best known",
        "over the limit",
        "objective over the lowest",
        "greatest",
        "iterations",
        "evaluations",
        "time, ms",
        "longest, ms",
        "time over enact's",
    ];
    let mut table = Table::new("peers", "", &header);
    let every = ("all".to_owned(), all);
    let of_row = |(index, row): (usize, &String)| {
        let own = problems.iter().filter(|problem| problem.row == index);
        (row.clone(), own.collect::<Vec<&Problem>>())
    };
    let groups = rows.iter().enumerate().map(of_row).chain([every]);
    // What was broken off has not reached all rows.
    let groups = groups.filter(|(_, problems)| !problems.is_empty());
    for (row, problems) in groups {
        for solver in &solvers {
            table.row(line(&row, &problems, *solver));
        }
    }
    record.table(table);
}

/// What a solver made of some problems from a start.
fn cells<'p>(
    problems: &[&'p Problem],
    (solver, from): (&str, &str),
) -> Vec<(&'p Problem, &'p Cell)> {
    let is_of = |cell: &&Cell| cell.solver == solver && cell.from == from;
    let of = |problem: &&'p Problem| Some((*problem, problem.cells.iter().find(is_of)?));
    problems.iter().filter_map(of).collect()
}

/// Times over ours from the sketch, where both are the best known.
fn ratios(problems: &[&Problem], solver: (&str, &str)) -> Vec<f64> {
    let own = |problem: &Problem| {
        let of = |cell: &&Cell| cell.solver == OWN && cell.from == STARTS[0];
        let cell = problem.cells.iter().find(of)?;
        problem.is_best(cell).then_some(cell.seconds)
    };
    let of = |(problem, cell): (&Problem, &Cell)| {
        let both = own(problem).filter(|_| problem.is_best(cell));
        both.map(|own_s| cell.seconds / own_s)
    };
    cells(problems, solver).into_iter().filter_map(of).collect()
}

fn line(row: &str, problems: &[&Problem], solver: (&str, &str)) -> Vec<String> {
    let all = cells(problems, solver);
    let count = |holds: &dyn Fn(&Problem, &Cell) -> bool| {
        let holding = all.iter().filter(|(problem, cell)| holds(problem, cell));
        percent(holding.count(), all.len())
    };
    let values = |of: &dyn Fn(&Cell) -> Option<f64>| -> Vec<f64> {
        all.iter().filter_map(|(_, cell)| of(cell)).collect()
    };
    let over: Vec<f64> = all
        .iter()
        .filter_map(|(problem, cell)| Some(cell.motion()? / problem.lowest()))
        .collect();
    let seconds = values(&|cell| Some(cell.seconds));
    vec![
        row.to_owned(),
        solver.0.to_owned(),
        solver.1.to_owned(),
        all.len().to_string(),
        count(&|_, cell| cell.is_converged),
        count(&|_, cell| cell.motion().is_some()),
        count(&|problem, cell| problem.is_best(cell)),
        count(&|_, cell| cell.is_late),
        number(median(&over)),
        number(over.iter().copied().fold(f64::NAN, f64::max)),
        number(median(&values(&|cell| Some(cell.iterations? as f64)))),
        number(median(&values(&|cell| {
            (!cell.is_late).then_some(cell.evaluations as f64)
        }))),
        number(1e3 * median(&seconds)),
        number(1e3 * largest(&seconds)),
        number(median(&ratios(problems, solver))),
    ]
}

/// A solver from all its starts, in a sentence.
fn said(problems: &[&Problem], solver: &str, limit_s: f64) -> String {
    let all = || STARTS.map(|from| (from, cells(problems, (solver, from))));
    let shares = all().into_iter().filter(|(_, cells)| !cells.is_empty());
    let shares = shares.map(|(from, cells)| {
        let best = cells.iter().filter(|(problem, cell)| problem.is_best(cell));
        format!("{} from the {from}", percent(best.count(), cells.len()))
    });
    let shares: Vec<String> = shares.collect();
    let late = all()
        .iter()
        .flat_map(|(_, cells)| cells)
        .filter(|(_, cell)| cell.is_late)
        .count();
    let late = match late {
        0 => String::new(),
        late => format!("; {late} solves were stopped by the limit of {limit_s} s"),
    };
    format!(
        "Of {} problems of joined bodies {solver} finds the best known motion in {}{late}.",
        problems.len(),
        shares.join(", "),
    )
}
