//! Success rate of each method and of each peer as one trouble grows.
//!
//! [`asked::cases`] makes every problem once, with where to start and the best known answer, so that
//! other solvers may be asked the same. Marks and outliers act before any solve: all methods get what
//! the program's segmentation makes of them, unless a curve says otherwise. General solvers ([`peers`])
//! are asked where they are installed.
//!
//! [`peers`]: crate::peers

mod asked;
mod troubles;

use std::time::Instant;

use anyhow::Result;
use enact::estimate::schedule::recipe::{self, Recipe};
use enact::optimise::finish::Tolerances;
use enact::physics::Body;
use enact::physics::body::Symmetry;
use enact::physics::flow;
use rayon::prelude::*;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::peers::PEERS;
use crate::record::Record;
use crate::statistics::wilson;
use asked::{Asked, LIMIT_S, STARTS};
use enact_tools::methods::{Answer, Grid, Method, Part, Task};
use enact_tools::starts::is_best;
use troubles::{Trouble, troubles};

/// Evaluations of the evolution strategy, and the most performances that it is asked.
const EVALUATIONS: usize = 30_000;
const SAMPLED: u64 = 6;
/// Where a turn has no closed form an evaluation takes thirty times as long: a tenth of them.
const SHARE: usize = 10;

/// Makes one figure for each trouble.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let troubles = troubles(options.quick);
    let begin = Instant::now();
    let mut asked = asked::cases(&troubles, options);
    let seconds = || begin.elapsed().as_secs_f64();
    eprintln!("  {} problems: {:.1} s", asked.len(), seconds());
    asked::ask_peers(&mut asked)?;
    eprintln!("  peers: {:.1} s", seconds());
    for (index, trouble) in troubles.iter().enumerate() {
        let asked: Vec<&Asked> = asked.iter().filter(|a| a.trouble == index).collect();
        record.figure(figure(trouble, &asked, options.quick));
        eprintln!("  {}: {:.1} s", trouble.name, seconds());
    }
    Ok(())
}

fn figure(trouble: &Trouble, asked: &[&Asked], quick: bool) -> Figure {
    let mut tasks = asked.iter().filter_map(|a| a.task.as_ref());
    let is_known = tasks.all(|task| !task.problem.times_are_unknown());
    let is_closed = |body: &Body| body.symmetry() != Symmetry::Asymmetric;
    let mut tasks = asked.iter().filter_map(|a| a.task.as_ref());
    let is_closed = tasks.all(|task| task.problem.bodies.iter().all(is_closed));
    let evaluations = EVALUATIONS / if is_closed { 1 } else { SHARE } / if quick { 100 } else { 1 };
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
    let late: Vec<String> = PEERS.iter().filter_map(|name| late(name, asked)).collect();
    let late = if late.is_empty() {
        String::new()
    } else {
        format!(", which stops {}", late.join(", "))
    };
    Figure {
        name: format!("failure_{}", trouble.name),
        title: format!("How often the best optimum is found: {}", trouble.what),
        note: format!(
            "Up to {} performances of each setting (evolution strategy: {SAMPLED}, {evaluations} \
             evaluations; peers: at most {LIMIT_S} s each{late}). Success: violation within 1e-6 units, events in order, objective within 2e-5 of \
             the best of all methods and {STARTS} starts, the truth among them. Bars: 95 % intervals (Wilson). All methods \
             get the program's segmentation{}.",
            asked.iter().map(|a| a.index + 1).max().unwrap_or(0),
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

/// How often the limit of time is what stops a peer, if ever.
fn late(name: &str, asked: &[&Asked]) -> Option<String> {
    let answers = asked.iter().flat_map(|asked| &asked.peers);
    let own: Vec<bool> = answers
        .filter(|a| a.peer == name)
        .map(|a| a.is_late())
        .collect();
    let late = own.iter().filter(|late| **late).count();
    (late > 0).then(|| format!("{name} in {late} of {}", own.len()))
}

fn methods(is_known: bool, evaluations: usize) -> Vec<Method> {
    let mut all = vec![
        Method::Program,
        Method::Over(Grid::Implicit),
        Method::Multiple(1),
        Method::Multiple(3),
        Method::Over(Grid::Shooting { intervals: 1 }),
        Method::Without(Part::Sweep),
        Method::Without(Part::Multipliers),
        Method::Without(Part::Hinge),
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
        Method::Sampling(_) => asked.index < SAMPLED,
        _ => true,
    };
    let asked_methods = methods.iter().map(is_asked);
    let Some(task) = &asked.task else {
        let all = asked_methods.chain(PEERS.iter().map(|_| true));
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
        let body = &task.problem.bodies[of.mechanism];
        let gravity = task.problem.gravity(&rough.point.parameters);
        let past_s = arc.epoch_s - guess.arcs[index].epoch_s;
        let state = &rough.point.arcs[index];
        arc.state = flow::advance(body, &gravity, state, past_s);
    }
    let one = Task {
        guesses: vec![from],
        ..task.clone()
    };
    let near = recipe.without_sweep();
    let end = recipe::solve(&one.problem, &one.layout, &one.guesses[0], &near, &mut ());
    let best = one.best.unwrap_or(f64::NAN);
    end.finished.converged && is_best(2.0 * end.system.cost, best)
}

/// A share with Wilson's interval.
fn rate(x: f64, count: usize, of: usize) -> Mark {
    if of == 0 {
        return Mark {
            failed: true,
            ..Mark::at(x, 0.0)
        };
    }
    Mark {
        spread: Some(wilson(count, of)),
        ..Mark::at(x, count as f64 / of as f64)
    }
}
