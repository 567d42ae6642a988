//! What each kind of sketch costs beside full poses of the same motion with as many residuals: one
//! evaluation, one iteration, one whole solve, in turn.

mod sketches;

use std::hint::black_box;
use std::time::Instant;

use anyhow::{Context, Result};
use enact::estimate::schedule::recipe::{self, Recipe, epochs_s};
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::point::Point;
use enact::optimise::Program;
use enact::optimise::kkt::Kkt;
use serde::Serialize;

use self::sketches::{Sketched, residuals, sketches};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number};
use enact_tools::case::Posed;

/// Pairs of runs of a quick check, and of a measurement.
const PAIRS: [usize; 2] = [3, 61];
/// Evaluations, and iterations, timed at once.
const AT_ONCE: usize = 20;
/// No further solves are timed once those of a kind have taken so long \[s\].
const LONG_S: f64 = 3.0;

/// A kind of sketch beside full poses.
#[derive(Serialize)]
struct Beside {
    kind: &'static str,
    timing: &'static str,
    /// Numbers of residuals.
    residuals: [usize; 2],
    /// Medians of the kind's own \[µs\].
    own_us: [f64; 3],
    /// Medians of the ratios, pair by pair: evaluation, iteration, solve.
    ratios: [f64; 3],
    /// Of both solves.
    iterations: [usize; 2],
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let pairs = options.either(PAIRS[0], PAIRS[1]);
    let mut table = Table::new(
        "kinds",
        "",
        &[
            "sketch",
            "timing",
            "residuals",
            "of full poses",
            "evaluation",
            "ratio",
            "iteration",
            "ratio",
            "solve",
            "ratio",
            "iterations",
            "of full poses",
            "ratio per iteration",
        ],
    );
    let mut all = Vec::new();
    for sketched in sketches(options)? {
        let beside = beside(&sketched, pairs)?;
        let [own, full] = beside.iterations;
        let per_iteration = beside.ratios[2] * full as f64 / own as f64;
        let pair = |at: usize| {
            let own = format!("{} µs", number(beside.own_us[at]));
            [own, format!("{:.2}", beside.ratios[at])]
        };
        let head = [
            beside.kind.to_owned(),
            beside.timing.to_owned(),
            beside.residuals[0].to_string(),
            beside.residuals[1].to_string(),
        ];
        let tail = [
            own.to_string(),
            full.to_string(),
            format!("{per_iteration:.2}"),
        ];
        table.row(head.into_iter().chain((0..3).flat_map(pair)).chain(tail));
        all.push(beside);
    }
    record.table(table);
    let slowest = |at: usize| {
        let most = all
            .iter()
            .max_by(|a, b| a.ratios[at].total_cmp(&b.ratios[at]));
        most.map_or((f64::NAN, String::new()), |of| {
            (of.ratios[at], format!("{}, {}", of.kind, of.timing))
        })
    };
    let [(evaluation, of), (solve, of_solve)] = [slowest(0), slowest(2)];
    record.say(format!(
        "Beside full poses with as many residuals an evaluation takes at most {evaluation:.1} times as long ({of}), and a solve {solve:.1} times ({of_solve})."
    ));
    record.numbers("kinds", &all)
}

fn beside(sketched: &Sketched, pairs: usize) -> Result<Beside> {
    let own = Timed::new(&sketched.own).context(sketched.kind)?;
    let full = Timed::new(&sketched.full).context(sketched.kind)?;
    let mut own_us: [Vec<f64>; 3] = Default::default();
    let mut ratios: [Vec<f64>; 3] = Default::default();
    let runs = [Timed::evaluation_s, Timed::iteration_s, Timed::solve_s];
    for _ in 0..pairs {
        for (at, run) in runs.into_iter().enumerate() {
            if own_us[at].iter().sum::<f64>() > 1e6 * LONG_S {
                continue;
            }
            let (a_s, b_s) = (run(&own), run(&full));
            own_us[at].push(1e6 * a_s);
            ratios[at].push(a_s / b_s);
        }
    }
    let medians = |all: [Vec<f64>; 3]| all.map(|each| median(&each));
    Ok(Beside {
        kind: sketched.kind,
        timing: sketched.timing,
        residuals: [&own, &full].map(|of| residuals(&of.posed.problem)),
        own_us: medians(own_us),
        ratios: medians(ratios),
        iterations: [&own, &full].map(Timed::iterations),
    })
}

/// A problem to be timed.
struct Timed<'a> {
    posed: &'a Posed,
    point: Point,
}

impl<'a> Timed<'a> {
    fn new(posed: &'a Posed) -> Result<Self> {
        let guess = posed.guesses.first().context("no guess")?;
        Ok(Self {
            point: Point::new(&posed.problem, guess),
            posed,
        })
    }

    fn context(&self) -> SolveContext<'_> {
        let epochs_s = epochs_s(&self.posed.guesses[0]);
        SolveContext::new(
            &self.posed.problem,
            &self.posed.layout,
            epochs_s,
            &self.point,
        )
    }

    fn evaluation_s(&self) -> f64 {
        let (context, guidance) = (self.context(), Guidance::none());
        let mut system = context.evaluated(&guidance, &self.point);
        each_s(|| context.evaluate(&guidance, black_box(&self.point), &mut system))
    }

    fn iteration_s(&self) -> f64 {
        let (context, guidance) = (self.context(), Guidance::none());
        let mut system = context.evaluated(&guidance, &self.point);
        let multipliers = vec![0.0; system.row_count()];
        each_s(|| {
            context.evaluate(&guidance, black_box(&self.point), &mut system);
            let kkt = Kkt::new(&context, &system, &multipliers);
            black_box(kkt.map(|kkt| kkt.step(context.structure(), &system, None)));
        })
    }

    fn solution(&self) -> recipe::Solution {
        let (posed, recipe) = (self.posed, Recipe::default());
        recipe::solve(
            &posed.problem,
            &posed.layout,
            &posed.guesses[0],
            &recipe,
            &mut (),
        )
    }

    fn solve_s(&self) -> f64 {
        let begin = Instant::now();
        black_box(self.solution());
        begin.elapsed().as_secs_f64()
    }

    fn iterations(&self) -> usize {
        self.solution().work.iterations
    }
}

/// Time of one of several runs \[s\].
fn each_s(mut run: impl FnMut()) -> f64 {
    let begin = Instant::now();
    for _ in 0..AT_ONCE {
        run();
    }
    begin.elapsed().as_secs_f64() / AT_ONCE as f64
}
