//! Distance to the best optimum against time, as tolerances vary, on every scene.

use std::time::Instant;

use anyhow::{Context, Result};
use enact::optimise::finish::Tolerances;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::statistics::quantile;
use crate::tasks::posing;
use crate::tuned::{Scene, scenes};
use crate::{Book, Options};
use enact_tools::case::Case;
use enact_tools::methods::{Answer, Grid, Method, Task};

/// What varies along a curve.
#[derive(Clone, Copy)]
struct Setting {
    method: Method,
    tolerances: Tolerances,
}

/// One solve.
struct Point {
    error: f64,
    took_s: f64,
    is_in_order: bool,
}

/// Performances of each scene.
const SEEDS: u64 = 10;
/// Of them, those that the evolution strategy is asked.
const SAMPLED: usize = 3;
/// Most evaluations: so many that they take no longer than this \[s\].
const LONGEST_S: f64 = 4.0;
/// Starts among which the best optimum is.
const STARTS: usize = 20;
/// Errors below this are rounding.
const ROUNDING: f64 = 1e-15;
/// Greatest error of an answer that is taken for the best optimum, roughly solved.
const NEAR: f64 = 1e-4;
/// Repeats of a solve, of which the fastest counts, until they take this long together \[s\].
const REPEATS: usize = 5;
const ENOUGH_S: f64 = 0.02;

/// Makes one figure for each scene.
pub fn run(options: &Options, book: &mut Book) -> Result<()> {
    let seeds = if options.quick { 1 } else { SEEDS };
    for scene in scenes() {
        let begin = Instant::now();
        let mut tasks: Vec<Task> = (0..seeds)
            .filter_map(|seed| {
                let case = Case::new(&(scene.truth)(seed), &scene.acting, seed);
                let starts = if options.quick { 3 } else { STARTS };
                Some(posing(&case, seed, starts).ok()?.task)
            })
            .filter(|task| task.best.is_some())
            .collect();
        let figure = figure(&scene, &mut tasks, options.quick);
        book.keep(figure).context(scene.name)?;
        eprintln!("  {}: {:.1} s", scene.name, begin.elapsed().as_secs_f64());
    }
    Ok(())
}

fn figure(scene: &Scene, tasks: &mut [Task], quick: bool) -> Figure {
    let is_known = scene.acting.is_timing_known() || scene.name == "die";
    let methods = methods(is_known);
    let confirmed = confirm(tasks, &methods);
    let mut solved_by = Vec::new();
    let curves = methods.into_iter().map(|method| {
        let settings = settings(method, tasks, quick);
        let is_sampling = matches!(method, Method::Sampling(_));
        let most = if is_sampling { SAMPLED } else { tasks.len() };
        let tasks = &tasks[..most.min(tasks.len())];
        let (points, solved) = marks(tasks, &settings, quick);
        let name = method.name();
        solved_by.push(format!("{name} {solved} of {}", tasks.len()));
        match method {
            Method::Program => Curve::ours(name, points),
            _ => Curve::new(name, points),
        }
    });
    let curves: Vec<Curve> = curves.collect();
    Figure {
        name: format!("estimation_{}", scene.name),
        title: format!("How near the best optimum in what time: {}", scene.title),
        note: format!(
            "{} performances at 1× distortion (evolution strategy: at most {SAMPLED} of them), all methods \
             from the same arc fits. Points: medians over those that end at the best known optimum, one point per tolerance (evolution strategy: \
             per number of evaluations), with the range of the middle half; crosses: those that end \
             elsewhere, at the tightest tolerance. Times on one thread, the fastest of up to {REPEATS} \
             repeats; layout and start included, segmentation and arc fits not. The best of {STARTS} starts \
             and all methods, {confirmed}. At the best end: {}.",
            tasks.len(),
            solved_by.join("; ")
        ),
        x: Axis::logarithmic("relative excess of the objective + largest violation [units]"),
        y: Axis::logarithmic("time of a solve [s]"),
        curves,
    }
}

/// Lowers what is known to be best to what any method finds; says how well methods agree about it.
fn confirm(tasks: &mut [Task], methods: &[Method]) -> String {
    let tight = Tolerances::default();
    let others = methods
        .iter()
        .filter(|m| !matches!(m, Method::Program | Method::Sampling(_)));
    let others: Vec<Method> = others.copied().collect();
    let (mut confirmed, mut apart) = (0, 0.0_f64);
    let count = tasks.len();
    for task in tasks {
        let Some(best) = task.best else { continue };
        let answers: Vec<Answer> = others.iter().map(|m| task.answer(*m, &tight)).collect();
        let own = task.answer(Method::Program, &tight);
        let best = answers
            .iter()
            .chain([&own])
            .fold(best, |best, answer| answer.lowers(best));
        task.best = Some(best);
        // The program over again confirms nothing.
        let is_another = |m: &Method| !matches!(m, Method::FullFlow | Method::Over(Grid::Lifted));
        let second = answers.iter().zip(&others);
        let second = second.filter(|(a, m)| is_another(m) && a.succeeds(best));
        let errors = second.map(|(answer, _)| answer.error(best));
        if let Some(least) = errors.min_by(f64::total_cmp) {
            confirmed += 1;
            apart = apart.max(least);
        }
    }
    format!("{confirmed} of {count} confirmed over another grid, to {apart:.0e}")
}

fn methods(is_known: bool) -> Vec<Method> {
    let mut all = vec![
        Method::Program,
        Method::FullFlow,
        // What the study's code costs that the program's does not.
        Method::Over(Grid::Lifted),
        Method::Over(Grid::Implicit),
        Method::Multiple(1),
        Method::Multiple(3),
        Method::Over(Grid::Shooting { intervals: 1 }),
    ];
    if is_known {
        // With unknown timing hundreds of sample times are unknowns too: no case for sampling.
        all.push(Method::Sampling(0));
    }
    all
}

/// From rough to tight.
fn settings(method: Method, tasks: &[Task], quick: bool) -> Vec<Setting> {
    let tight = Tolerances::default();
    if let Method::Sampling(_) = method {
        let first = if quick { 100 } else { 1000 };
        let trial = Method::Sampling(first);
        let took_s = tasks
            .first()
            .map_or(0.0, |task| task.answer(trial, &tight).took_s);
        let powers = if quick { 0..2 } else { 0..5 };
        let budgets = powers.map(|power| 3usize.pow(power));
        let budgets = budgets.filter(|times| *times as f64 * took_s < LONGEST_S);
        return budgets
            .map(|times| times * first)
            .map(|evaluations| Setting {
                method: Method::Sampling(evaluations),
                tolerances: tight,
            })
            .collect();
    }
    let without_finish = Tolerances { steps: 0, ..tight };
    let rough = [1e-1, 1e-3, 1e-5, 1e-7].map(|violation| Tolerances {
        violation,
        decrease: 0.1 * violation,
        ..tight
    });
    let all = [without_finish].into_iter().chain(rough);
    let all = all.chain([
        tight,
        Tolerances {
            violation: 1e-11,
            decrease: 1e-13,
            ..tight
        },
    ]);
    all.map(|tolerances| Setting { method, tolerances })
        .collect()
}

/// Points of a curve, and how many tasks it solves.
fn marks(tasks: &[Task], settings: &[Setting], quick: bool) -> (Vec<Mark>, usize) {
    let solves: Vec<Vec<Point>> = tasks
        .iter()
        .map(|task| {
            settings
                .iter()
                .map(|setting| point(task, setting, quick))
                .collect()
        })
        .collect();
    let ends_well = |points: &&Vec<Point>| {
        points
            .last()
            .is_some_and(|last| last.error < NEAR && last.is_in_order)
    };
    let well: Vec<&Vec<Point>> = solves.iter().filter(ends_well).collect();
    let mut marks = Vec::new();
    for (index, setting) in settings.iter().enumerate() {
        if well.is_empty() {
            break;
        }
        let of = |value: fn(&Point) -> f64| -> Vec<f64> {
            well.iter().map(|points| value(&points[index])).collect()
        };
        let (errors, times_s) = (of(|p| p.error), of(|p| p.took_s));
        marks.push(Mark {
            spread: Some([quantile(&times_s, 0.25), quantile(&times_s, 0.75)]),
            setting: Some(match setting.method {
                Method::Sampling(evaluations) => format!("{evaluations} evaluations"),
                _ if setting.tolerances.steps == 0 => "no finish".into(),
                _ => format!("{:.0e}", setting.tolerances.violation),
            }),
            ..Mark::at(quantile(&errors, 0.5), quantile(&times_s, 0.5))
        });
    }
    for points in solves.iter().filter(|points| !ends_well(points)) {
        marks.extend(points.last().map(|last| Mark {
            failed: true,
            ..Mark::at(last.error, last.took_s)
        }));
    }
    (marks, well.len())
}

fn point(task: &Task, setting: &Setting, quick: bool) -> Point {
    let answer = || task.answer(setting.method, &setting.tolerances);
    let first: Answer = answer();
    let mut took_s = first.took_s;
    let mut together_s = took_s;
    for _ in 1..REPEATS {
        if quick || together_s > ENOUGH_S {
            break;
        }
        let again_s = answer().took_s;
        took_s = took_s.min(again_s);
        together_s += again_s;
    }
    let best = task.best.unwrap_or(f64::NAN);
    let error = first.error(best).max(ROUNDING);
    Point {
        // What is not even a motion has no error: far right.
        error: if error.is_finite() {
            error.min(1e6)
        } else {
            1e6
        },
        took_s,
        is_in_order: first.is_in_order,
    }
}
