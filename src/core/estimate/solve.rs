//! The stage as the pipeline calls it: from guesses to an estimate, with standard deviations on
//! request.

mod again;
mod apart;
pub mod bound;
pub(in crate::estimate) mod deviation;
pub mod last;
mod nearby;
mod rivals;
pub mod sharing;
pub(in crate::estimate) mod simulate;
pub mod together;
mod wandering;

use std::cell::OnceCell;
use std::cmp::Ordering;

use crate::estimate::adequacy;
use crate::estimate::adequacy::asked::FitAsked;
use crate::estimate::covariance::Covariance;
use crate::estimate::covariance::in_time::InTime;
use crate::estimate::covariance::residuals::Residuals;
use crate::estimate::outcome;
use crate::estimate::problem::Problem;
use crate::estimate::schedule::recipe::{self, Recipe, Solution};
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::{
    Counters, Estimate, FitUntold, Fits, Guess, Observer, Performance, Phase, Scene, Segment,
    Sketch, VelocityGaps, Verdict, WorkLimited,
};
use crate::optimise::{Program, Work};

/// Greatest number of looks at a sample in a stage of a solve, and of iterations that it may take all the same: far from any
/// motion it may go on for minutes.
const LOOKS: usize = 1_500_000;
const LEAST_STEPS: usize = 60;

/// An estimate with the solution from which its deviations are computed.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The estimate without deviations.
    pub estimate: Estimate,
    posed: Posed,
    epochs_s: Vec<f64>,
    solution: Solution,
    /// Residuals of every sample, view by view, in units.
    errors: Vec<Residuals>,
    /// Where each sample was weighed by itself, with the errors that residuals make likely, once somebody asks.
    in_time: OnceCell<Option<InTime>>,
}

impl Solved {
    /// Looks whether the motion explains the performance, and what in the scene may be wrong where it
    /// does not. One that failed explains nothing.
    pub fn judge(&mut self, performance: Performance, observer: &mut dyn Observer) {
        if self.estimate.verdict == Verdict::Failed {
            self.estimate.fit = Err(FitUntold::NoMotion);
            return;
        }
        if observer.should_stop() {
            self.estimate.fit = Err(FitUntold::Stopped);
            return;
        }
        observer.phase(Phase::Adequacy);
        let (context, solution) = (self.context(), &self.solution);
        let in_time = self.in_time(&context);
        let of = (&context, solution, in_time);
        let judged = adequacy::judge(
            of,
            &self.errors,
            performance,
            FitAsked::WithSuspects,
            observer,
        );
        let leanings = adequacy::leanings(&context, solution, performance);
        self.estimate.fit = judged.map(|(fit, suspects)| {
            self.estimate.suspects = suspects;
            fit
        });
        for (event, leaning) in self.estimate.events.iter_mut().zip(leanings) {
            event.leaning = leaning;
        }
    }

    /// Whether the motion explains the performance, as [`judge`](Self::judge) tells it: sooner, since what may be wrong in the scene is
    /// looked for only where the answer depends on it.
    pub fn fits(&self, performance: Performance, observer: &mut dyn Observer) -> Fits {
        // What failed, or is doubted as far, does not, whatever the samples tell.
        if self.estimate.fits() == Fits::No {
            return Fits::No;
        }
        observer.phase(Phase::Adequacy);
        let context = self.context();
        let of = (&context, &self.solution, self.in_time(&context));
        let judged = adequacy::judge(of, &self.errors, performance, FitAsked::Alone, observer);
        judged.map_or(Fits::Unknown, |(fit, _)| fit.fits)
    }

    /// The motion from this one on where what flies is as the performance's scene says it is; `None` where there is none.
    pub fn flown_as_said(
        &self,
        performance: Performance,
        observer: &mut dyn Observer,
    ) -> Option<Self> {
        let mut problem = self.posed.problem.clone();
        for arc in &mut problem.arcs {
            let scene = performance.scene;
            arc.body = scene.body_between(arc.mechanism, [arc.start, arc.end]);
        }
        let posed = Posed::new(problem);
        let solution = recipe::solve_from(
            &posed.problem,
            &posed.layout,
            self.solution.point.clone(),
            self.epochs_s.clone(),
            &Recipe::default().from_the_last(),
            &mut bounded(observer),
        );
        let mut counters = self.estimate.counters;
        add(&mut counters, &solution.work, 0);
        let is_found = solution.finished.converged;
        is_found.then(|| self.with_solution(posed, solution, performance, counters))
    }

    /// See [`Solved`].
    fn in_time(&self, context: &SolveContext) -> Option<&InTime> {
        let told = || adequacy::in_time(context, &self.solution);
        self.in_time.get_or_init(told).as_ref()
    }

    /// At the solution.
    fn context(&self) -> SolveContext<'_> {
        self.posed
            .context(self.epochs_s.clone(), &self.solution.point)
    }

    /// The same take with another solution, of a problem with the same flights, after so much work.
    fn with_solution(
        &self,
        posed: Posed,
        solution: Solution,
        performance: Performance,
        counters: Counters,
    ) -> Self {
        let context = posed.context(self.epochs_s.clone(), &solution.point);
        let errors = outcome::errors(&posed.problem, &context, &solution.point);
        let Performance { scene, sketch, .. } = performance;
        let estimate = outcome::estimate(scene, sketch, &context, &solution, &errors, counters);
        Self {
            estimate: Estimate {
                rivals: self.estimate.rivals,
                ..estimate
            },
            epochs_s: self.epochs_s.clone(),
            posed,
            solution,
            errors,
            in_time: OnceCell::new(),
        }
    }

    /// The estimate with its standard deviations and the list of undetermined quantities.
    pub fn with_deviations(
        self,
        scene: &Scene,
        which: Deviations,
        observer: &mut dyn Observer,
    ) -> Estimate {
        observer.phase(Phase::Covariance);
        let Self {
            mut estimate,
            posed,
            epochs_s,
            solution,
            in_time,
            ..
        } = self;
        let context = posed.context(epochs_s, &solution.point);
        // Without time for them nothing is told to be determined.
        let has_time = which != Deviations::None && !observer.should_stop();
        let told = || in_time.get_or_init(|| adequacy::in_time(&context, &solution));
        let in_time = has_time.then(told).and_then(Option::as_ref);
        let covariance = has_time.then(|| covariance(&context, &solution, in_time));
        let covariance = covariance.flatten();
        let known = covariance.as_ref();
        deviation::fill(&mut estimate, scene, &context, &solution, known);
        if let Some(known) = known.filter(|_| which == Deviations::OfMotion) {
            deviation::fill_flights(&mut estimate, &context, &solution.point, known);
        }
        estimate
    }
}

/// Of what standard deviations are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deviations {
    /// None: nothing is told to be determined.
    None,
    /// Of times and parameters.
    OfNumbers,
    /// Of the states along flights, too.
    OfMotion,
}

/// Solves from each guess and keeps the best: the lowest objective of those that converged.
///
/// There is one guess unless the arcs' own fits are ambiguous, so a clear performance costs one
/// solve. Where that finds no motion, and the scene allows it, velocity gaps at collisions are
/// priced instead of closed; from the motion found then, closing them is tried once more. Never
/// fails: an estimate that did not converge has a verdict that says so.
///
/// # Panics
/// Without a guess or without a segment.
pub fn estimate(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    guesses: &[Guess],
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Solved {
    let exact = Posed::new(Problem::new(scene, sketch, segments));
    let may_bend =
        scene.velocity_gaps != VelocityGaps::Never && !exact.problem.collisions.is_empty();
    let is_hopeless =
        scene.velocity_gaps == VelocityGaps::Always || exact.problem.is_overconstrained();
    let mut bent = None;
    let mut work = Counters::default();
    let mut is_unfinished = false;
    let is_bent = may_bend && is_hopeless;
    let mut found = (!is_bent).then(|| {
        let best = exact.best(guesses, recipe, observer);
        add(&mut work, &best.solution.work, best.starts);
        is_unfinished |= best.is_unfinished;
        best
    });
    let is_final = |s: &Solution| s.finished.converged || s.stopped || !may_bend;
    if !found.as_ref().is_some_and(|best| is_final(&best.solution)) {
        let relaxed = Posed::new(exact.problem.with_velocity_gaps());
        let mut best = relaxed.best(guesses, recipe, observer);
        add(&mut work, &best.solution.work, best.starts);
        is_unfinished |= best.is_unfinished;
        let closed = (!is_hopeless && !best.solution.stopped).then(|| {
            let from = &guesses[best.guess];
            let guess = best.solution.point.guess(&exact.problem, from);
            exact.solve(&guess, &recipe.without_sweep(), observer)
        });
        bent = Some(relaxed);
        if let Some(closed) = closed {
            add(&mut work, &closed.work, 0);
            if closed.finished.converged {
                (bent, best.solution) = (None, closed);
            }
        }
        found = Some(best);
    }
    let Best {
        guess: best,
        solution,
        rivals,
        ..
    } = found.expect("solved one way or the other");
    let posed = bent.unwrap_or(exact);
    let context = posed.context(recipe::epochs_s(&guesses[best]), &solution.point);
    let errors = outcome::errors(&posed.problem, &context, &solution.point);
    let mut estimate = outcome::estimate(scene, sketch, &context, &solution, &errors, work);
    estimate.rivals = rivals;
    if is_unfinished {
        estimate.reason.unfinished_after_steps = Some(work.iterations);
    }
    Solved {
        estimate,
        epochs_s: context.epochs_s,
        posed,
        solution,
        errors,
        in_time: OnceCell::new(),
    }
}

fn covariance<'a>(
    context: &'a SolveContext<'a>,
    of: &'a Solution,
    in_time: Option<&'a InTime>,
) -> Option<Covariance<'a>> {
    Covariance::new(context, &of.point, &of.system, &of.multipliers, in_time)
}

/// A problem with its layout.
#[derive(Clone, Debug)]
struct Posed {
    problem: Problem,
    layout: Layout,
}

impl Posed {
    fn new(problem: Problem) -> Self {
        let layout = Layout::new(&problem);
        Self { problem, layout }
    }

    fn context(&self, epochs_s: Vec<f64>, point: &Point) -> SolveContext<'_> {
        SolveContext::new(&self.problem, &self.layout, epochs_s, point)
    }

    /// The best of the solutions from guesses, within the work that a stage may take.
    fn best(&self, guesses: &[Guess], recipe: &Recipe, observer: &mut dyn Observer) -> Best {
        let mut bounded = bounded(observer);
        let mut best = best(&self.problem, &self.layout, guesses, recipe, &mut bounded);
        best.is_unfinished = bounded.is_used_up();
        best.solution.stopped &= !best.is_unfinished;
        best
    }

    fn solve(&self, guess: &Guess, recipe: &Recipe, observer: &mut dyn Observer) -> Solution {
        let mut bounded = bounded(observer);
        let mut found = recipe::solve(&self.problem, &self.layout, guess, recipe, &mut bounded);
        found.stopped &= !bounded.is_used_up();
        found
    }

    /// The optimum from a point that is near it: by the last of the steps, or by all of them but the sweep, with the work of both.
    /// `None` where neither converges.
    fn solved_near(
        &self,
        start: &Point,
        epochs_s: &[f64],
        observer: &mut dyn Observer,
    ) -> Option<Solution> {
        let mut work = Work::default();
        let recipes = [
            Recipe::default().from_the_last(),
            Recipe::default().without_sweep(),
        ];
        let mut found = recipes.iter().filter_map(|recipe| {
            let found = recipe::solve_from(
                &self.problem,
                &self.layout,
                start.clone(),
                epochs_s.to_vec(),
                recipe,
                &mut bounded(observer),
            );
            work.add(&found.work);
            found.finished.converged.then_some(found)
        });
        let found = found.next()?;
        Some(Solution { work, ..found })
    }
}

/// The observer of a stage, whose work is limited.
fn bounded(observer: &mut dyn Observer) -> WorkLimited<'_> {
    WorkLimited {
        observer,
        looks: LOOKS,
        steps: LEAST_STEPS,
    }
}

/// Adds the work of a number of starts to the counters.
pub(super) fn add(counters: &mut Counters, work: &Work, starts: usize) {
    counters.iterations += work.iterations;
    counters.evaluations += work.evaluations;
    counters.factorisations += work.factorisations;
    counters.starts += starts;
}

/// The best of the solutions from several guesses.
#[derive(Clone, Debug)]
pub struct Best {
    /// Index of the guess that led to it.
    pub guess: usize,
    /// The solution, with the work of all guesses.
    pub solution: Solution,
    /// Number of guesses tried.
    pub starts: usize,
    /// Number of other motions that are as near to keyframes.
    pub rivals: usize,
    /// Whether work ended before all guesses were tried to their ends.
    pub is_unfinished: bool,
}

/// Solves from each guess. Of motions that are as near to keyframes as one another the first is the
/// best.
pub fn best(
    problem: &Problem,
    layout: &Layout,
    guesses: &[Guess],
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Best {
    let mut found: Vec<Solution> = Vec::new();
    let mut work = Work::default();
    for guess in guesses {
        let solution = recipe::solve(problem, layout, guess, recipe, observer);
        work.add(&solution.work);
        let stopped = solution.stopped;
        found.push(solution);
        if stopped {
            break;
        }
    }
    let starts = found.len();
    let rank = |solution: &Solution| (!solution.finished.converged, solution.system.cost);
    let order = |a: &usize, b: &usize| rank(&found[*a]).partial_cmp(&rank(&found[*b]));
    let lowest = (0..starts).min_by(|a, b| order(a, b).unwrap_or(Ordering::Equal));
    let lowest = lowest.expect("at least one guess");
    let alike = rivals::alike(problem, layout, &found, guesses, lowest);
    let guess = alike.first().copied().unwrap_or(lowest);
    let mut solution = found.swap_remove(guess);
    solution.work = work;
    Best {
        guess,
        solution,
        starts,
        rivals: alike.len().saturating_sub(1),
        is_unfinished: false,
    }
}

/// Half the sum of squared residuals of a guess, priors included, without regard to constraints.
pub fn cost(scene: &Scene, sketch: &Sketch, segments: &[Segment], guess: &Guess) -> f64 {
    let problem = Problem::new(scene, sketch, segments);
    let layout = Layout::new(&problem);
    let start = Point::new(&problem, guess);
    let context = SolveContext::new(&problem, &layout, recipe::epochs_s(guess), &start);
    let system = context.evaluated(&Guidance::none(), &start);
    system.cost
}
