//! Time against distance from the optimum, as tolerances vary.

use anyhow::Result;
use enact::estimate::schedule::recipe::{self, Recipe, Solution};
use enact::optimise::Schedule;
use enact::optimise::finish::Tolerances;

use super::scenes::timed;
use super::{Answer, Settings, solve};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use enact_tools::case::{Case, Posed};
use enact_tools::export;
use enact_tools::perform::{Acting, Style, Truth, bounces, hat_box};

/// Performances of a scene.
const SEEDS: u64 = 30;
/// Violations of constraints at which solvers may end \[units\].
const TOLERANCES: &[f64] = &[1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10];
const FEWER_TOLERANCES: &[f64] = &[1e-2, 1e-8];
/// Our tolerance of decrease for one of violation: what goes with it by default.
const DECREASE: f64 = 0.1;
/// The reference's.
const TIGHT: Tolerances = Tolerances {
    violation: 1e-13,
    decrease: 1e-15,
    steps: 200,
};
/// Distances are drawn from here on: what rounding leaves.
const ROUNDING: f64 = 1e-15;
/// Farther off is another optimum, or none.
const ELSEWHERE: f64 = 0.3;

/// A problem and where it is solved to rounding.
struct Subject {
    posed: Posed,
    problem: export::Problem,
    objective: f64,
}

/// Time and distance of a solve; no distance where there is no end.
type Reached = (f64, Option<f64>);

/// What is performed at a seed.
type Performed = Box<dyn Fn(u64) -> Truth>;

/// Keeps a figure for each of some scenes.
pub fn run(settings: &Settings, options: &Options, record: &mut Record) -> Result<()> {
    let tolerances = options.either(FEWER_TOLERANCES, TOLERANCES);
    let truths: [(&str, &str, Performed); 3] = [
        (
            "tip",
            "a pencil, tip first",
            Box::new(|_| Style::Tip.truth()),
        ),
        ("hat_box", "hat and box", Box::new(|_| hat_box::truth())),
        (
            "cube",
            "a cube with four bounces",
            Box::new(|seed| bounces(4, seed).expect("a bouncing cube")),
        ),
    ];
    for (name, title, truth) in truths {
        let subjects: Vec<Subject> = options
            .seeds(SEEDS)
            .filter_map(|seed| subject(&truth(seed), seed))
            .collect();
        let curves = curves(&subjects, tolerances, settings)?;
        record.figure(Figure {
            name: format!("peers_front_{name}"),
            title: format!("Time against distance from the optimum: {title}"),
            note: format!(
                "Medians of {} performances at the default distortion, timing known; least of {} \
                 solves; from right to left tolerances of {tolerances:?} units. Distance: the \
                 largest of the violation in units and the relative difference of the objective \
                 from a solve to rounding.",
                subjects.len(),
                settings.repeats,
            ),
            x: Axis::logarithmic("distance from the optimum"),
            y: Axis::logarithmic("time, s"),
            curves,
        });
    }
    Ok(())
}

fn subject(truth: &Truth, seed: u64) -> Option<Subject> {
    let case = Case::new(truth, &Acting::timing_known(), seed).one_by_one();
    let outcome = case.estimated(&mut ()).ok()?;
    let posed = Posed::without_marks(&outcome.scene, &outcome.sketch);
    let solution = solved(&posed, TIGHT);
    let others = [("solution", &solution.point)];
    let (problem, layout, guess) = (&posed.problem, &posed.layout, &posed.guesses[0]);
    Some(Subject {
        problem: export::problem(&truth.scene.name, problem, layout, guess, &others),
        objective: 2.0 * solution.system.cost,
        posed,
    })
}

fn solved(posed: &Posed, tolerances: Tolerances) -> Solution {
    let recipe = Recipe::of(Schedule {
        tolerances,
        ..Schedule::default()
    });
    let (problem, layout) = (&posed.problem, &posed.layout);
    recipe::solve(problem, layout, &posed.guesses[0], &recipe, &mut ())
}

fn curves(subjects: &[Subject], tolerances: &[f64], settings: &Settings) -> Result<Vec<Curve>> {
    let own = tolerances
        .iter()
        .map(|tolerance| mark(*tolerance, &own(subjects, *tolerance, settings)));
    let mut curves = vec![Curve::ours("enact", own.collect())];
    curves.extend(
        settings
            .peers
            .iter()
            .map(|peer| Curve::new(*peer, Vec::new())),
    );
    let problems: Vec<export::Problem> = subjects.iter().map(|s| s.problem.clone()).collect();
    for tolerance in tolerances {
        let settings = Settings {
            tolerance: *tolerance,
            ..*settings
        };
        let Some(report) = solve(&problems, &settings)? else {
            continue;
        };
        for curve in &mut curves[1..] {
            let answers = report.answers.iter().filter(|a| a.peer == curve.name);
            let reached: Vec<Reached> = answers
                .map(|answer| of_answer(answer, subjects[answer.problem].objective))
                .collect();
            curve.points.push(mark(*tolerance, &reached));
        }
    }
    Ok(curves)
}

fn own(subjects: &[Subject], tolerance: f64, settings: &Settings) -> Vec<Reached> {
    let tolerances = Tolerances {
        violation: tolerance,
        decrease: DECREASE * tolerance,
        ..Tolerances::default()
    };
    let reached = subjects.iter().map(|subject| {
        let (solution, seconds) = timed(settings.repeats, || solved(&subject.posed, tolerances));
        let objective = 2.0 * solution.system.cost;
        let violation = solution.system.violation();
        (
            seconds[0],
            Some(distance(objective, violation, subject.objective)),
        )
    });
    reached.collect()
}

fn of_answer(answer: &Answer, best: f64) -> Reached {
    let reached = answer.objective.zip(answer.violation);
    let distance = reached.map(|(objective, violation)| distance(objective, violation, best));
    (answer.seconds[0], distance)
}

fn distance(objective: f64, violation: f64, best: f64) -> f64 {
    (objective / best - 1.0).abs().max(violation).max(ROUNDING)
}

/// The medians; failed where that is no optimum.
fn mark(tolerance: f64, reached: &[Reached]) -> Mark {
    let seconds: Vec<f64> = reached.iter().map(|(seconds, _)| *seconds).collect();
    let distances: Vec<f64> = reached
        .iter()
        .map(|(_, distance)| distance.unwrap_or(f64::INFINITY))
        .collect();
    let x = median(&distances);
    let failed = !(x < ELSEWHERE);
    Mark {
        x: if failed { ELSEWHERE } else { x },
        y: median(&seconds),
        setting: Some(format!("{tolerance:.0e} units")),
        failed,
        ..Mark::default()
    }
}
