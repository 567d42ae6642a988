//! The optimum near a point.

use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::time_line::TimeLine;
use super::walk::EXACTLY;
use crate::estimate::schedule::work::Watched;
use crate::motion::Observer;
use crate::optimise::trust::{self, Nearness};
use crate::optimise::{self, Schedule, Solution, Stage, Work};

/// How near steps in a trust region come to the optimum before the finish.
const NEARNESS: Nearness = Nearness {
    steps: 40,
    decrease: 1e-6,
    violation: 1e-6,
};
/// How often samples about an event are given anew to the motions before and after it.
const SIDINGS: usize = 4;
/// How far, root mean square in weights, an optimum may be from samples in an unknown tempo before more is tried: as far as
/// motions are not doubted for.
const FAR: f64 = 3.0;

/// The optimum that a start leads to, with the problem whose steps are as short as it needs.
#[derive(Clone)]
pub struct Solved {
    /// The problem.
    pub problem: TreeProblem,
    /// Its solution.
    pub solution: Solution<TreePoint>,
}

/// Where steps in a trust region lead from a point.
pub(super) fn approached(
    program: &TreeProgram<'_>,
    point: TreePoint,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> TreePoint {
    let stop = &mut |looks| observer.worked(looks);
    let near = trust::approach(program, point, &Part::whole(), &NEARNESS, stop);
    work.add(&near.work);
    near.point
}

/// The optimum near a point, with all the work so far. Samples that it leaves on the wrong side of an event are given
/// to the other side, and it is found again.
pub(super) fn finished(
    problem: &TreeProblem,
    point: &TreePoint,
    schedule: &Schedule,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> Solved {
    let mut solved = optimum(problem.clone(), point, schedule, work, observer);
    for _ in 0..SIDINGS {
        let mut sided = solved.problem.clone();
        if !solved.solution.finished.converged || !sided.part_at(&solved.solution.point) {
            break;
        }
        let schedule = Schedule::default().from_the_last();
        let point = solved.solution.point;
        solved = optimum(sided, &point, &schedule, work, observer);
    }
    solved
}

fn optimum(
    problem: TreeProblem,
    point: &TreePoint,
    schedule: &Schedule,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> Solved {
    let program = TreeProgram::new(&problem, point.clone());
    let guidance = |_: Stage| Part::whole();
    let watch = &mut Watched(observer);
    let mut solution = optimise::solve(&program, point.clone(), schedule, &guidance, watch);
    work.add(&solution.work);
    solution.work = *work;
    Solved { problem, solution }
}

impl Solved {
    pub(super) fn has_ended(&self) -> bool {
        self.solution.finished.converged || self.solution.stopped
    }

    /// Half the sum of squared residuals, priors included.
    pub fn cost(&self) -> f64 {
        self.solution.system.cost
    }

    /// Whether an optimum in an unknown tempo is so far from its samples that it is likely a wrong one.
    pub(super) fn is_far(&self) -> bool {
        let samples = self.problem.samples.len() as f64;
        self.problem.tempo.is_some() && self.cost() > 0.5 * FAR * FAR * samples
    }
}

impl TreeProblem {
    /// Makes steps as short as the motion of a point needs, and parts samples where it has the events.
    pub(super) fn fit_to(&mut self, point: &TreePoint) {
        self.step_s = self.exact_step_s(point, EXACTLY);
        self.part_at(point);
    }

    /// Parts samples where a point has the events; whether one then is on another side than before.
    pub(super) fn part_at(&mut self, point: &TreePoint) -> bool {
        let [mut least_s, most_s] = self.span_s;
        let mut is_other = false;
        let line = TimeLine::new(self, &point.log_paces);
        let times_s = point.event_times_s.iter();
        let acted_s: Vec<f64> = times_s.map(|time_s| line.acted_s(*time_s).0).collect();
        for (event, acted_s) in self.events.iter_mut().zip(acted_s) {
            let about_s = acted_s.max(least_s).min(most_s);
            let between_s = event.about_s.min(about_s)..event.about_s.max(about_s);
            let mut samples = self.samples.iter();
            is_other |= samples.any(|sample| between_s.contains(&sample.acted_s));
            event.about_s = about_s;
            least_s = about_s;
        }
        is_other
    }
}
