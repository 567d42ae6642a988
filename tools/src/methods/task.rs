//! What a method is asked, and what it answers.

use std::time::Instant;

use enact::estimate::problem::Problem;
use enact::estimate::schedule::recipe;
use enact::estimate::unknowns::layout::Layout;
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::optimise::finish::Tolerances;

use super::model::Model;
use super::program::{Part, ending_at, own, with_three_moments, without, without_hinge};
use super::setting::Setting;
use super::split::Grid;
use super::{Judged, evolution, judged, stages};

/// Violation of a success, in units.
const HOLDS: f64 = 1e-6;
/// Violation of an answer that may be the best one.
const EXACT: f64 = 1e-8;

/// A method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The program: sliding grid, lifted event times.
    Program,
    /// The program, modelling the turn of every body as that of one with three different moments.
    FullFlow,
    /// The program's stages over another grid.
    Over(Grid),
    /// Multiple shooting with so many intervals per flight.
    Multiple(usize),
    /// An evolution strategy with so many evaluations.
    Sampling(usize),
    /// The program with a part of its recipe left out.
    Without(Part),
}

impl Method {
    /// Its name.
    pub fn name(self) -> String {
        match self {
            Method::Program => "sliding grid, lifted event times (enact)".into(),
            Method::FullFlow => "enact with the general flow for every body".into(),
            Method::Over(Grid::Lifted) => "sliding grid, lifted event times (general code)".into(),
            Method::Over(Grid::Implicit) => "sliding grid, implicit event times".into(),
            Method::Over(Grid::Shooting { .. }) => "single shooting".into(),
            Method::Multiple(1) => "multiple shooting, an interval per flight".into(),
            Method::Multiple(per_flight) => {
                format!("multiple shooting, {per_flight} intervals per flight")
            }
            Method::Sampling(_) => "evolution strategy (CMA-ES)".into(),
            Method::Without(Part::Sweep) => "enact without its sweep".into(),
            Method::Without(Part::Multipliers) => "enact without multiplier rounds".into(),
            Method::Without(Part::Pull) => "enact without the events' pull".into(),
            Method::Without(Part::Hinge) => "enact without the contacts' hinge".into(),
        }
    }
}

/// A problem, from where it is solved, and the best known answer.
#[derive(Clone, Debug)]
pub struct Task {
    /// The problem.
    pub problem: Problem,
    /// Where its unknowns sit.
    pub layout: Layout,
    /// The arcs' own fits, best first; more than one where they are ambiguous.
    pub guesses: Vec<Guess>,
    /// Lowest objective that any start found; none where none converged.
    pub best: Option<f64>,
    /// Of the performance.
    pub seed: u64,
}

/// What a method ended with.
#[derive(Clone, Debug)]
pub struct Answer {
    /// By the program's own objective and constraints.
    pub judged: Judged,
    /// Whether the method says that it is within its tolerances.
    pub converged: bool,
    /// Whether events are in order.
    pub is_in_order: bool,
    /// From guess to answer \[s\].
    pub took_s: f64,
    /// All unknowns, and the times at which flights have their states \[s\].
    pub point: Point,
    /// The times at which flights have their states \[s\].
    pub epochs_s: Vec<f64>,
}

impl Answer {
    /// Whether everything holds at no more than the best known objective.
    pub fn succeeds(&self, best: f64) -> bool {
        self.judged.violation <= HOLDS
            && self.is_in_order
            && crate::starts::is_best(self.judged.objective, best)
    }

    /// The lower of a best known objective and this one, if it is one.
    pub fn lowers(&self, best: f64) -> f64 {
        let is_one = self.judged.violation <= EXACT && self.is_in_order && self.converged;
        if is_one {
            best.min(self.judged.objective)
        } else {
            best
        }
    }

    /// Relative distance of the objective from the best, plus violation.
    pub fn error(&self, best: f64) -> f64 {
        let excess = (self.judged.objective - best).abs() / best.max(crate::starts::NO_COST);
        excess + self.judged.violation
    }
}

impl Task {
    /// The answer of a method; of several guesses the best, as the program does.
    pub fn answer(&self, method: Method, tolerances: &Tolerances) -> Answer {
        let mut best: Option<(Point, bool, Judged, &Guess)> = None;
        let mut took_s = 0.0;
        for guess in &self.guesses {
            let begin = Instant::now();
            let (point, converged) = self.solved(method, guess, tolerances);
            // Judging is not the method's work.
            took_s += begin.elapsed().as_secs_f64();
            let judged = judged(&self.problem, &self.layout, guess, &point);
            let rank = |converged: bool, judged: &Judged| (!converged, judged.objective);
            let is_better = best
                .as_ref()
                .is_none_or(|(_, c, j, _)| rank(converged, &judged) < rank(*c, j));
            if is_better {
                best = Some((point, converged, judged, guess));
            }
        }
        let (point, converged, judged, guess) = best.expect("a guess at least");
        Answer {
            is_in_order: point.event_times_s.is_sorted(),
            judged,
            converged,
            took_s,
            epochs_s: recipe::epochs_s(guess),
            point,
        }
    }

    fn solved(&self, method: Method, guess: &Guess, tolerances: &Tolerances) -> (Point, bool) {
        match method {
            Method::Program => {
                let layout = Layout::new(&self.problem);
                own(&self.problem, &layout, guess, &ending_at(tolerances))
            }
            Method::Without(part) => {
                let layout = Layout::new(&self.problem);
                let recipe = ending_at(tolerances);
                match part {
                    Part::Hinge => without_hinge(&self.problem, &layout, guess, &recipe),
                    _ => own(&self.problem, &layout, guess, &without(part, recipe)),
                }
            }
            Method::FullFlow => {
                let mut problem = self.problem.clone();
                for body in &mut problem.bodies {
                    *body = with_three_moments(body);
                }
                let layout = Layout::new(&problem);
                own(&problem, &layout, guess, &ending_at(tolerances))
            }
            Method::Over(grid) => {
                let setting = Setting::new(&self.problem, guess, grid);
                let model = Model::new(&setting);
                let start = model.start();
                let end = stages::solve(&model, start, &ending_at(tolerances));
                (setting.whole(&end.place), end.converged)
            }
            Method::Multiple(per_flight) => {
                let mechanisms = self.problem.bodies.len();
                let intervals = per_flight * self.problem.arcs.len().div_ceil(mechanisms);
                self.solved(
                    Method::Over(Grid::Shooting { intervals }),
                    guess,
                    tolerances,
                )
            }
            Method::Sampling(evaluations) => {
                let single = Grid::Shooting { intervals: 1 };
                let setting = Setting::new(&self.problem, guess, single);
                let model = Model::new(&setting);
                let start = model.start();
                let place = evolution::search(&model, &start, evaluations, self.seed);
                (setting.whole(&place), place.exists)
            }
        }
    }
}
