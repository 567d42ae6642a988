//! Success rate of each method as one trouble grows.
//!
//! [`cases`] makes every problem once, with where to start and the best known answer, so that other
//! solvers may be asked the same. Marks and outliers act before any solve: all methods get what the
//! program's segmentation makes of them, unless a curve says otherwise. General solvers ([`peers`]) are
//! asked where they are installed.

use std::time::Instant;

use anyhow::Result;
use enact::estimate::recipe::{self, Recipe};
use enact::motion::Sketch;
use enact::optimise::finish::Tolerances;
use enact::physics::Body;
use enact::physics::body::Symmetry;
use rayon::prelude::*;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::peers::{self, PEERS};
use crate::tasks::{posing, with_marks_as_they_are};
use crate::troubles::{Trouble, troubles};
use crate::{Book, Options};
use enact_tools::case::{Case, Posed};
use enact_tools::export;
use enact_tools::methods::{Answer, Grid, Method, Task};

/// Performances of each setting.
const SEEDS: u64 = 24;
/// Evaluations of the evolution strategy, and the most performances that it is asked.
const EVALUATIONS: usize = 30_000;
const SAMPLED: u64 = 6;
/// The most performances that peers are asked, and how long they may take \[s\].
const PEERED: u64 = 6;
const LIMIT_S: f64 = 1.0;
/// Where a turn has no closed form an evaluation takes thirty times as long: a tenth of them.
const SHARE: usize = 10;
/// Starts among which the best optimum is.
const STARTS: usize = 6;
/// Two-sided, 95 %.
const NORMAL: f64 = 1.96;

/// One performance of one setting of a trouble.
pub struct Asked {
    /// Index of the trouble.
    pub trouble: usize,
    /// Index of its setting.
    pub setting: usize,
    /// Of the performance.
    pub seed: u64,
    /// Problem, guesses, best known objective; none where segmentation refused it, which fails
    /// every method.
    pub task: Option<Task>,
    /// The same with the performer's marks as they are.
    as_they_are: Option<Posed>,
    /// What peers make of it, those that were asked.
    peers: Vec<peers::Answer>,
}

/// Every problem of this part, trouble by trouble, setting by setting.
pub fn cases(troubles: &[Trouble], quick: bool) -> Vec<Asked> {
    let seeds = if quick { 2 } else { SEEDS };
    let mut all = Vec::new();
    for (trouble, of) in troubles.iter().enumerate() {
        for setting in 0..of.settings.len() {
            all.extend((0..seeds).map(|seed| (trouble, setting, seed)));
        }
    }
    let made = all.into_par_iter().filter_map(|(trouble, setting, seed)| {
        let of = &troubles[trouble];
        // A seed without a motion is no performance.
        let case = (of.make)(of.settings[setting], seed).ok()?;
        let posing = posing(&case, seed, if quick { 3 } else { STARTS }).ok();
        let raw = posing.as_ref().filter(|_| of.acts_before);
        let raw = raw.and_then(|posing| as_they_are(&case, &posing.sketch));
        let task = posing.map(|posing| posing.task);
        // Without any optimum there is nothing to miss.
        let is_task = task.as_ref().is_none_or(|task| task.best.is_some());
        is_task.then_some(Asked {
            trouble,
            setting,
            seed,
            task,
            as_they_are: raw,
            peers: Vec::new(),
        })
    });
    made.collect()
}

fn as_they_are(case: &Case, sketch: &Sketch) -> Option<Posed> {
    let sketch = with_marks_as_they_are(case, sketch)?;
    enact::segment::cut(case.scene(), &sketch).ok()?;
    Some(Posed::without_marks(case.scene(), &sketch))
}

/// Asks the peers for the same, in two processes: here only success counts.
fn ask_peers(asked: &mut [Asked], quick: bool) -> Result<()> {
    let seeds = if quick { 1 } else { PEERED };
    let mut given: Vec<&mut Asked> = asked
        .iter_mut()
        .filter(|asked| asked.seed < seeds && asked.task.is_some())
        .collect();
    let settings = peers::Settings {
        repeats: 1,
        limit_s: LIMIT_S,
        tolerance: 1e-8,
        from: "start",
        peers: PEERS,
    };
    let half = given.len().div_ceil(2).max(1);
    let halves = given.par_chunks_mut(half).map(|asked| -> Result<()> {
        let tasks = asked.iter().filter_map(|asked| asked.task.as_ref());
        let problem =
            |task: &Task| export::problem("", &task.problem, &task.layout, &task.guesses[0], &[]);
        let problems: Vec<export::Problem> = tasks.map(problem).collect();
        let report = peers::solve(&problems, &settings)?;
        for answer in report.into_iter().flat_map(|report| report.answers) {
            asked[answer.problem].peers.push(answer);
        }
        Ok(())
    });
    halves.collect()
}

/// Makes one figure for each trouble.
pub fn run(options: &Options, book: &mut Book) -> Result<()> {
    let troubles = troubles();
    let begin = Instant::now();
    let mut asked = cases(&troubles, options.quick);
    let seconds = || begin.elapsed().as_secs_f64();
    eprintln!("  {} problems: {:.1} s", asked.len(), seconds());
    ask_peers(&mut asked, options.quick)?;
    eprintln!("  peers: {:.1} s", seconds());
    for (index, trouble) in troubles.iter().enumerate() {
        let asked: Vec<&Asked> = asked.iter().filter(|a| a.trouble == index).collect();
        let begin = Instant::now();
        book.keep(figure(trouble, &asked, options.quick))?;
        eprintln!("  {}: {:.1} s", trouble.name, begin.elapsed().as_secs_f64());
    }
    Ok(())
}

fn figure(trouble: &Trouble, asked: &[&Asked], quick: bool) -> Figure {
    let mut tasks = asked.iter().filter_map(|a| a.task.as_ref());
    let is_known = tasks.all(|task| !task.problem.times_are_unknown());
    let is_closed = |body: &Body| body.symmetry() != Symmetry::Asymmetric;
    let mut tasks = asked.iter().filter_map(|a| a.task.as_ref());
    let is_closed = tasks.all(|task| task.problem.bodies.iter().all(is_closed));
    let evaluations = if is_closed {
        EVALUATIONS
    } else {
        EVALUATIONS / SHARE
    };
    let evaluations = if quick {
        evaluations / 100
    } else {
        evaluations
    };
    let methods = methods(is_known, evaluations);
    let mut rates = rates(trouble, asked, &methods);
    let of_peers = PEERS.iter().zip(rates.split_off(methods.len()));
    let of_peers = of_peers.filter(|(_, points)| !points.is_empty());
    let of_peers = of_peers.map(|(name, points)| Curve::new(*name, points));
    let curves = methods
        .iter()
        .zip(rates)
        .map(|(method, points)| match method {
            Method::Program => Curve::ours(method.name(), points),
            _ => Curve::new(method.name(), points),
        });
    let mut curves: Vec<Curve> = curves.chain(of_peers).collect();
    if trouble.acts_before {
        let points = trouble.settings.iter().enumerate().map(|(setting, x)| {
            let asked: Vec<&&Asked> = asked.iter().filter(|a| a.setting == setting).collect();
            let count = asked.par_iter().filter(|asked| succeeds_raw(asked)).count();
            rate(*x, count, asked.len())
        });
        let name = "sliding grid, lifted event times, marks as they are";
        curves.push(Curve::new(name, points.collect()));
    }
    Figure {
        name: format!("failure_{}", trouble.name),
        title: format!("How often the best optimum is found: {}", trouble.what),
        note: format!(
            "Up to {} performances of each setting (evolution strategy: {SAMPLED}, {evaluations} \
             evaluations; peers: {PEERED}, at most {LIMIT_S} s each). Success: violation within 1e-6 units, events in order, objective within 2e-5 of \
             the best of all methods and {STARTS} starts, the truth among them. Bars: 95 % intervals (Wilson). All methods \
             get the program's segmentation{}.",
            if quick { 2 } else { SEEDS },
            if trouble.acts_before {
                "; of marks as they are it counts whether the end leads to the best optimum after they \
                 are refined"
            } else {
                ""
            }
        ),
        x: Axis {
            logarithmic: trouble.logarithmic,
            ..Axis::linear(trouble.label)
        },
        y: Axis::linear("share that ends at the best known optimum"),
        curves,
    }
}

fn methods(is_known: bool, evaluations: usize) -> Vec<Method> {
    let mut all = vec![
        Method::Program,
        Method::Over(Grid::Implicit),
        Method::Multiple(1),
        Method::Multiple(3),
        Method::Over(Grid::Shooting { intervals: 1 }),
    ];
    if is_known {
        all.push(Method::Sampling(evaluations));
    }
    all
}

/// Whether each method and then each peer ends at the best known answer, that of the starts or of any
/// of them; `None` of those that were not asked.
fn judge(asked: &Asked, methods: &[Method]) -> Vec<Option<bool>> {
    let is_asked = |method: &Method| match method {
        Method::Sampling(_) => asked.seed < SAMPLED,
        _ => true,
    };
    let asked_methods = methods.iter().map(is_asked);
    let Some(task) = &asked.task else {
        let asked_peers = PEERS.iter().map(|_| asked.seed < PEERED);
        let all = asked_methods.chain(asked_peers);
        return all.map(|is_asked| is_asked.then_some(false)).collect();
    };
    let answers = methods.iter().zip(asked_methods);
    let answers: Vec<Option<Answer>> = answers
        .map(|(method, is_asked)| is_asked.then(|| task.answer(*method, &Tolerances::default())))
        .collect();
    let motions = asked.peers.iter().filter(|answer| answer.is_motion());
    let best = motions
        .filter_map(|answer| answer.objective)
        .fold(task.best.unwrap_or(f64::INFINITY), f64::min);
    let best = answers
        .iter()
        .flatten()
        .fold(best, |best, answer| answer.lowers(best));
    let of_methods = answers
        .iter()
        .map(|answer| Some(answer.as_ref()?.succeeds(best)));
    let of_peers = PEERS.iter().map(|name| {
        let answer = asked.peers.iter().find(|answer| answer.peer == *name)?;
        Some(answer.is_success(best))
    });
    of_methods.chain(of_peers).collect()
}

/// Success rates at every setting, of methods and then of peers; nothing of those that were given no
/// problem.
fn rates(trouble: &Trouble, asked: &[&Asked], methods: &[Method]) -> Vec<Vec<Mark>> {
    let judged = asked.par_iter().map(|asked| judge(asked, methods));
    let judged: Vec<Vec<Option<bool>>> = judged.collect();
    let column = |index: usize| {
        let rows = || asked.iter().zip(&judged);
        if !rows().any(|(asked, good)| asked.task.is_some() && good[index].is_some()) {
            return Vec::new();
        }
        let settings = trouble.settings.iter().enumerate();
        let points = settings.map(|(setting, x)| {
            let here = rows().filter(|(asked, _)| asked.setting == setting);
            let good: Vec<bool> = here.filter_map(|(_, good)| good[index]).collect();
            rate(*x, good.iter().filter(|good| **good).count(), good.len())
        });
        points.collect()
    };
    (0..methods.len() + PEERS.len()).map(column).collect()
}

/// Whether the answer with marks as they are, gone on from after they are refined, is the best.
fn succeeds_raw(asked: &Asked) -> bool {
    let (Some(task), Some(raw)) = (&asked.task, &asked.as_they_are) else {
        return false;
    };
    let recipe = Recipe::default();
    let guess = &raw.guesses[0];
    let rough = recipe::solve(&raw.problem, &raw.layout, guess, &recipe, &mut ());
    if !rough.finished.converged {
        return false;
    }
    let mut from = task.guesses[0].clone();
    from.event_times_s.clone_from(&rough.point.event_times_s);
    for (index, arc) in from.arcs.iter_mut().enumerate() {
        let of = &task.problem.arcs[index];
        let body = &task.problem.bodies[of.body];
        let gravity = task.problem.gravity(&rough.point.parameters);
        let past_s = arc.epoch_s - guess.arcs[index].epoch_s;
        let state = &rough.point.arcs[index];
        arc.state = enact::physics::flow::advance(body, &gravity, state, past_s);
    }
    let one = Task {
        guesses: vec![from],
        ..task.clone()
    };
    let near = recipe.without_sweep();
    let end = recipe::solve(&one.problem, &one.layout, &one.guesses[0], &near, &mut ());
    let best = one.best.unwrap_or(f64::NAN);
    end.finished.converged && enact_tools::starts::is_best(2.0 * end.system.cost, best)
}

/// A share with Wilson's interval.
fn rate(x: f64, count: usize, of: usize) -> Mark {
    if of == 0 {
        return Mark {
            failed: true,
            ..Mark::at(x, 0.0)
        };
    }
    let (n, share) = (of as f64, count as f64 / of as f64);
    let square = NORMAL * NORMAL / n;
    let middle = (share + 0.5 * square) / (1.0 + square);
    let half = NORMAL * (share * (1.0 - share) / n + 0.25 * square / n).sqrt() / (1.0 + square);
    Mark {
        spread: Some([(middle - half).max(0.0), (middle + half).min(1.0)]),
        ..Mark::at(x, share)
    }
}
