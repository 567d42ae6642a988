//! Distance to the best optimum, and to the truth, against time, as tolerances vary, by several
//! methods on every scene.

mod scenes;
mod solves;

use std::time::Instant;

use anyhow::Result;
use enact::optimise::finish::Tolerances;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::posing::{Posing, posing};
use crate::record::Record;
use crate::statistics::quantile;
use enact_tools::case::Case;
use enact_tools::methods::{Answer, Grid, Method, Part};
use scenes::{Scene, scenes};
use solves::{Point, REPEATS, Setting, Solves};

/// Performances of each scene.
const SEEDS: u64 = 10;
/// Of them, those that the evolution strategy is asked.
const SAMPLED: usize = 3;
/// Most evaluations: so many that they take no longer than this \[s\].
const LONGEST_S: f64 = 4.0;
/// Starts among which the best optimum is.
const STARTS: usize = 20;
/// Makes two figures for each scene.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut ours = [0, 0];
    for scene in scenes() {
        let begin = Instant::now();
        let starts = options.either(3, STARTS);
        let posings = options.seeds(SEEDS).filter_map(|seed| {
            let case = Case::new(&(scene.truth)(seed), &scene.acting, seed).one_by_one();
            posing(&case, seed, starts).ok()
        });
        let mut posings: Vec<Posing> = posings
            .filter(|posing| posing.task.best.is_some())
            .collect();
        let solved = figures(&scene, &mut posings, options.quick, record);
        ours = [ours[0] + solved, ours[1] + posings.len()];
        eprintln!("  {}: {:.1} s", scene.name, begin.elapsed().as_secs_f64());
    }
    record.say(format!(
        "From the same fits of the arcs, enact ends at the best optimum of all methods in {} of {} performances of the \
         eleven scenes.",
        ours[0], ours[1]
    ));
    Ok(())
}

/// Both figures of a scene; how many performances the program solves.
fn figures(scene: &Scene, posings: &mut [Posing], quick: bool, record: &mut Record) -> usize {
    let is_known = scene.acting.is_timing_known() || scene.name == "die";
    let methods = methods(is_known);
    let confirmed = confirm(posings, &methods);
    let mut solved_by = Vec::new();
    let (mut near_best, mut near_truth) = (Vec::new(), Vec::new());
    let mut ours = 0;
    for method in methods {
        let settings = settings(method, posings, quick);
        let is_sampling = matches!(method, Method::Sampling(_));
        let most = if is_sampling { SAMPLED } else { posings.len() };
        let posings = &posings[..most.min(posings.len())];
        let solves = Solves::of(posings, &settings, quick);
        let name = method.name();
        let solved = solves.well.len();
        solved_by.push(format!("{name} {solved} of {}", posings.len()));
        let curve = |points| match method {
            Method::Program => Curve::ours(name.clone(), points),
            _ => Curve::new(name.clone(), points),
        };
        near_best.push(curve(solves.marks(&settings, |point| point.error)));
        let from_truth = |point: &Point| point.off_mm.unwrap_or(f64::NAN);
        // Tolerances do not show there.
        let marks = solves.marks(&settings, from_truth).split_off(solves.last());
        let unnamed = marks.into_iter().map(|mark| Mark {
            setting: None,
            ..mark
        });
        near_truth.push(curve(unnamed.collect()));
        if method == Method::Program {
            ours = solved;
        }
    }
    near_truth.push(Curve::new("enact, whole estimate", whole(posings)));
    let note = format!(
        "{} performances at 1× distortion (evolution strategy: at most {SAMPLED} of them), all methods \
         from the same arc fits. Points: medians over those that end at the best known optimum, one point per tolerance (evolution strategy: \
         per number of evaluations), with the range of the middle half; crosses: those that end \
         elsewhere, at the tightest tolerance. Times on one thread, the fastest of up to {REPEATS} \
         repeats; layout and start included, segmentation and arc fits not. The best of {STARTS} starts \
         and all methods, {confirmed}. At the best end: {}.",
        posings.len(),
        solved_by.join("; ")
    );
    record.figure(Figure {
        name: format!("methods_{}", scene.name),
        title: format!("How near the best optimum in what time: {}", scene.title),
        note,
        x: Axis::logarithmic("relative excess of the objective + largest violation [units]"),
        y: Axis::logarithmic("time of a solve [s]"),
        curves: near_best,
    });
    if posings.iter().any(|posing| !posing.is_bent) {
        record.figure(Figure {
            name: format!("methods_{}_truth", scene.name),
            title: format!("How near the truth in what time: {}", scene.title),
            note: "The same solves at the tightest tolerance. Across: the largest distance from the true motion at the middle of a flight; what the \
                   hand did is farther from it than any solver from its optimum. The whole estimate goes from poses and \
                   marks to intervals, segmentation and arc fits included."
                .to_owned(),
            x: Axis::logarithmic("distance from the true motion [mm]"),
            y: Axis::logarithmic("time of a solve [s]"),
            curves: near_truth,
        });
    }
    ours
}

/// The program from poses and marks to intervals: one point.
fn whole(posings: &[Posing]) -> Vec<Mark> {
    let offs: Vec<f64> = posings
        .iter()
        .filter_map(|posing| posing.whole_off_mm)
        .collect();
    let times_s: Vec<f64> = posings.iter().map(|posing| posing.whole_s).collect();
    let mark = Mark {
        spread: Some([quantile(&times_s, 0.25), quantile(&times_s, 0.75)]),
        ..Mark::at(quantile(&offs, 0.5), quantile(&times_s, 0.5))
    };
    vec![mark]
}

/// Lowers what is known to be best to what any method finds; says how well methods agree about it.
fn confirm(posings: &mut [Posing], methods: &[Method]) -> String {
    let tight = Tolerances::default();
    let others = methods.iter().filter(|m| {
        !matches!(
            m,
            Method::Program | Method::Sampling(_) | Method::Without(_)
        )
    });
    let others: Vec<Method> = others.copied().collect();
    let (mut confirmed, mut apart) = (0, 0.0_f64);
    let count = posings.len();
    for Posing { task, .. } in posings {
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
        // What general code costs that the program's does not.
        Method::Over(Grid::Lifted),
        Method::Over(Grid::Implicit),
        Method::Multiple(1),
        Method::Multiple(3),
        Method::Over(Grid::Shooting { intervals: 1 }),
        Method::Without(Part::Sweep),
        Method::Without(Part::Multipliers),
        Method::Without(Part::Hinge),
        Method::Without(Part::Pull),
    ];
    if is_known {
        // With unknown timing hundreds of sample times are unknowns too: no case for sampling.
        all.push(Method::Sampling(0));
    }
    all
}

/// From rough to tight.
fn settings(method: Method, posings: &[Posing], quick: bool) -> Vec<Setting> {
    let tight = Tolerances::default();
    if let Method::Sampling(_) = method {
        let first = if quick { 100 } else { 1000 };
        let trial = Method::Sampling(first);
        let took_s = posings
            .first()
            .map_or(0.0, |posing| posing.task.answer(trial, &tight).took_s);
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
