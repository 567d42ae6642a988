//! General solvers beside the program on bodies joined in trees, from the same sketches.
//!
//! A problem goes out as JSON ([`problem`]), `tools/peers/joined.py` shows that its equations of motion and its
//! objective agree, solves it by multiple shooting, and answers with states at the start ([`mod@ask`]). What any
//! solver found is judged by the program's own formulas at its state ([`show`] makes tables of it).

mod ask;
mod problem;
mod show;

use std::time::Instant;

use anyhow::Result;
use enact::physics::tree::TreeState;
use enact_tools::trees::{Jointed, Kind, TreeActing, TreePerformance, perform};
use serde::Serialize;
use serde_json::Value;

use crate::joined::{Solved, sketched, solved_from};
use crate::options::Options;
use crate::peers::are_installed;
use crate::record::Record;
use crate::run::Run;
use ask::{Agreement, Answer, ask};
use problem::{Found, Posed};

/// Of the wander of a usual hand.
const DISTORTIONS: [f64; 3] = [1.0, 2.0, 4.0];
/// Performances of a row.
const SEEDS: u64 = 3;
/// Where peers start: from the motion of the program's first guess, from nodes along the sketch, from the true motion.
const STARTS: [&str; 3] = ["start", "sketch", "truth"];
/// Longest time of a peer's solve \[s\]: of a problem twelve times that.
const LIMIT_S: f64 = 10.0;
/// No new problem is begun after so long \[s\].
const SPENT_S: f64 = 1200.0;
/// Violation up to which a motion done again from its start counts: ten micrometres \[units\].
const FEASIBLE: f64 = 1e-3;
/// An objective within this of the lowest one, relative, is as good.
const SAME: f64 = 1e-4;
/// What this program is called, and its whole answer to a recording.
const OWN: &str = "enact";
const WHOLE: &str = "enact, whole answer";

/// What one solver made of a problem from one start.
#[derive(Serialize)]
struct Cell {
    solver: String,
    from: String,
    status: String,
    /// Whether the limit of time stopped it.
    is_late: bool,
    seconds: f64,
    evaluations: usize,
    iterations: Option<usize>,
    /// Whether it says that it has converged.
    is_converged: bool,
    /// By the program's formulas from the state at the start.
    objective: Option<f64>,
    violation: Option<f64>,
    /// What a peer says besides.
    answer: Option<Answer>,
}

impl Cell {
    /// Of its state among the points of a problem: no other is called so.
    fn name(&self) -> String {
        format!("solution of {}, from the {}", self.solver, self.from)
    }

    /// The objective of what is a motion, done again from its start.
    fn motion(&self) -> Option<f64> {
        let holds = self.violation.is_some_and(|off| off < FEASIBLE);
        self.objective.filter(|_| holds)
    }
}

/// All of them on one problem.
#[derive(Serialize)]
struct Problem {
    row: usize,
    seed: u64,
    agreement: Agreement,
    cells: Vec<Cell>,
    truth_objective: f64,
}

impl Problem {
    /// The lowest objective of any motion.
    fn lowest(&self) -> f64 {
        let found = self.cells.iter().filter_map(Cell::motion);
        found.fold(f64::INFINITY, f64::min)
    }

    fn is_best(&self, cell: &Cell) -> bool {
        let lowest = self.lowest();
        cell.motion()
            .is_some_and(|found| found <= lowest * (1.0 + SAME))
    }
}

fn kinds() -> [(&'static str, Kind); 6] {
    [
        ("pendulum of 2, pins", Kind::pendulum(2, Jointed::Pin)),
        (
            "pendulum of 2, universal",
            Kind::pendulum(2, Jointed::Universal),
        ),
        ("pendulum of 2, balls", Kind::pendulum(2, Jointed::Ball)),
        ("pendulum of 3, pins", Kind::pendulum(3, Jointed::Pin)),
        (
            "pendulum of 3, universal",
            Kind::pendulum(3, Jointed::Universal),
        ),
        ("the chain", Kind::CHAIN),
    ]
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    if !are_installed() {
        println!("joined_peers: none installed, left out (tools/peers/install.sh installs them)");
        return Ok(());
    }
    let limit_s = options.either(10.0, LIMIT_S);
    let rows = rows(options);
    let names: Vec<String> = rows.iter().map(|(name, ..)| name.clone()).collect();
    let (mut problems, mut versions) = (Vec::new(), None);
    let begin = Instant::now();
    let tell = |problems: &[Problem], versions: &Option<Value>, record: &mut Record| {
        show::show(&names, problems, limit_s, record);
        record.numbers("versions", versions)?;
        record.numbers("rows", &names)?;
        record.numbers("problems", &problems)
    };
    // All rows of a seed before the next: what is broken off has a little of each.
    for seed in options.seeds(SEEDS) {
        for (row, (name, kind, distortion)) in rows.iter().enumerate() {
            if begin.elapsed().as_secs_f64() > SPENT_S {
                continue;
            }
            let performance = perform(kind, &TreeActing::of(*distortion), seed);
            let (problem, said) = solved(&performance, (row, seed), limit_s)?;
            problems.push(problem);
            versions = versions.or(Some(said));
            eprintln!("  {name}, {seed}: {:.0} s", begin.elapsed().as_secs_f64());
            if options.rows.is_none() {
                let mut so_far = Record::quiet(Run {
                    seconds: begin.elapsed().as_secs_f64(),
                    ..record.run.clone()
                });
                tell(&problems, &versions, &mut so_far)?;
                so_far.save(&options.folder, "joined_peers")?;
            }
        }
    }
    tell(&problems, &versions, record)
}

/// What is measured: a name, what moves, and how wide a hand wanders.
fn rows(options: &Options) -> Vec<(String, Kind, f64)> {
    let distortions = options.either(&DISTORTIONS[..1], &DISTORTIONS[..]);
    let all = distortions.iter().flat_map(|distortion| {
        kinds().map(|(name, kind)| (format!("{name}, {distortion}×"), kind, *distortion))
    });
    all.filter(|(name, ..)| options.wants(name)).collect()
}

/// One problem by this program and by all peers, one after the other.
fn solved(
    performance: &TreePerformance,
    (row, seed): (usize, u64),
    limit_s: f64,
) -> Result<(Problem, Value)> {
    let posed = Posed::of(performance)?;
    let truth = &performance.truth;
    let mut cells = vec![
        own(&posed, (WHOLE, STARTS[0]), sketched(performance)),
        own(
            &posed,
            (OWN, STARTS[0]),
            solved_from(performance, posed.start.clone()),
        ),
        own(
            &posed,
            (OWN, STARTS[2]),
            solved_from(performance, truth.clone()),
        ),
    ];
    // Where a solve failed its motion may whirl: what integrators make of that says nothing of formulas.
    let motions = cells.iter().filter(|(cell, _)| cell.is_converged);
    let solutions: Vec<(String, &TreeState)> = motions
        .filter_map(|(cell, state)| Some((cell.name(), state.as_ref()?)))
        .collect();
    let mut points = vec![("start", &posed.start), ("truth", truth)];
    points.extend(
        solutions
            .iter()
            .map(|(name, state)| (name.as_str(), *state)),
    );
    let report = ask(&posed.file(&points)?, &STARTS, limit_s)?;
    let mut cells: Vec<Cell> = cells.drain(..).map(|(cell, _)| cell).collect();
    cells.extend(
        report
            .answers
            .into_iter()
            .map(|answer| peer(&posed, answer)),
    );
    let problem = Problem {
        row,
        seed,
        agreement: report.agreement,
        cells,
        truth_objective: posed.found(truth).objective,
    };
    Ok((problem, report.versions))
}

fn own(posed: &Posed, (solver, from): (&str, &str), solved: Solved) -> (Cell, Option<TreeState>) {
    let found = solved.state.as_ref().map(|state| posed.found(state));
    let cell = Cell {
        solver: solver.to_owned(),
        from: from.to_owned(),
        status: solved.verdict,
        is_late: false,
        seconds: solved.seconds,
        evaluations: solved.evaluations,
        iterations: Some(solved.iterations),
        is_converged: solved.is_motion,
        objective: found.as_ref().map(|found| found.objective),
        violation: found.as_ref().map(Found::violation),
        answer: None,
    };
    (cell, solved.state)
}

fn peer(posed: &Posed, answer: Answer) -> Cell {
    let state = answer.state.clone().map(TreeState::from);
    let found = state.map(|state| posed.found(&state));
    Cell {
        solver: answer.peer.clone(),
        from: answer.from.clone(),
        status: answer.status.clone(),
        is_late: answer.is_late(),
        seconds: answer.seconds[0],
        evaluations: answer.evaluations,
        iterations: answer.iterations,
        is_converged: answer.succeeded,
        objective: found.as_ref().map(|found| found.objective),
        violation: found.as_ref().map(Found::violation),
        answer: Some(answer),
    }
}
