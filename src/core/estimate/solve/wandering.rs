//! A motion whose samples err in time: solved again with the errors of a hand that its residuals make likely, until these
//! stay the same.

use super::{Posed, Solved, add, bounded};
use crate::estimate::adequacy;
use crate::estimate::covariance::in_time::{InTime, Strayed, likely};
use crate::estimate::covariance::linearised::{free_count, is_too_free};
use crate::estimate::covariance::residuals::{Residuals, mean_squares};
use crate::estimate::posing::Nodes;
use crate::estimate::problem::Problem;
use crate::estimate::problem::influence::Influence;
use crate::estimate::problem::weave::Kinks;
use crate::estimate::schedule::recipe::{self, Recipe, Solution};
use crate::estimate::wander::likelihood::{self, LikelyErrors};
use crate::estimate::wander::process;
use crate::motion::{Observer, Performance, Performer, Timing, VelocityGaps};
use crate::optimise::Work;

/// How often errors are told from residuals.
const ROUNDS: usize = 3;
/// How many times as far from its samples, and from a unit, a motion may be.
const FARTHER: f64 = 3.0;
/// Errors are told well where no logarithm of their sizes and times changes by more.
const SAME: f64 = 0.05;
/// How many times as great, or as small, as their errors mean squares of residuals may be.
const AS_EXPECTED: f64 = 1.5;

impl Solved {
    /// Goes on to the motion with the likeliest errors of a hand, from that at which each sample errs by itself, or where there
    /// is none, as when a hand strays so far that velocities jump. This one stays where there is no hand or no time in which it
    /// strayed, where nobody knows how late a clock is, where velocities must jump, and where that leads to none or far away.
    pub fn refine(&mut self, performance: Performance, observer: &mut dyn Observer) {
        let scene = performance.scene;
        let problem = &self.posed.problem;
        // Which error of one tracker goes with which of another depends on how late a clock is.
        let mut roles = problem.roles.iter();
        let is_late = roles.any(|role| matches!(role.influence, Influence::ClockOffset));
        // Distances that are kept end at the nodes of this problem.
        let keeps_nodes = problem.times_are_unknown() && !problem.clearances.is_empty();
        let may_wander = scene.timing != Timing::Edited && !problem.keeps_starts;
        let is_in_time = may_wander && !is_late && !keeps_nodes;
        let may_be_motion =
            scene.velocity_gaps != VelocityGaps::Always && !problem.is_overconstrained();
        if !is_in_time || !may_be_motion || !self.is_of_hand(scene.performer) {
            return;
        }
        let is_motion = self.solution.finished.converged && problem.velocity_gap_weight.is_none();
        let mut start = self.solution.clone();
        // That of a problem where velocities may jump is no motion.
        start.finished.converged = is_motion;
        let of_paces = problem.times_are_unknown().then(|| {
            let Performance {
                sketch, segments, ..
            } = performance;
            let nodes = Nodes::of_paces(sketch, segments);
            let paced = Posed::new(Problem::at_nodes(scene, sketch, segments, nodes));
            start.point.node_times_s = start.point.at_nodes(problem, &paced.problem);
            paced
        });
        let posed = of_paces.as_ref().unwrap_or(&self.posed);
        let refined = refined(posed, start, &self.epochs_s, observer);
        let Some((posed, solution)) = refined else {
            return;
        };
        let mut counters = self.estimate.counters;
        add(&mut counters, &solution.work, 0);
        let there = self.with_solution(posed, solution, performance, counters);
        let farthest = FARTHER * distance(&self.errors).max(1.0);
        // Written so that what is no number is too far.
        if distance(&there.errors) <= farthest {
            *self = there;
        }
    }

    /// Whether errors of a hand were told.
    pub fn errs_in_time(&self) -> bool {
        self.posed.problem.weave.is_some()
    }

    /// Whether a hand acted the motion: as is said, or as it shows. Who acts slowly has one.
    fn is_of_hand(&self, performer: Performer) -> bool {
        match performer {
            Performer::Hand => true,
            Performer::Nobody => false,
            Performer::Unsaid => {
                self.posed.problem.times_are_unknown()
                    || adequacy::show_hand(&self.context(), &self.solution)
            }
        }
    }
}

/// Root mean square residual, in units.
fn distance(errors: &[Residuals]) -> f64 {
    mean_squares(errors).iter().sum::<f64>().sqrt()
}

/// The solution with the likeliest errors, and its problem, from one at which every sample erred by itself or from none, where
/// errors are as expected at first; `None` where there is no optimum.
fn refined(
    posed: &Posed,
    start: Solution,
    epochs_s: &[f64],
    observer: &mut dyn Observer,
) -> Option<(Posed, Solution)> {
    let expected = LikelyErrors::EXPECTED;
    let is_motion = start.finished.converged;
    let mut errors = match is_motion {
        true => likely_at_start(posed, &start, epochs_s).unwrap_or(expected),
        false => expected,
    };
    let mut may_be_expected = is_motion;
    let mut best: Option<(Posed, Solution)> = None;
    let mut work = Work::default();
    let observer = &mut bounded(observer);
    for _ in 0..=ROUNDS {
        if observer.should_stop() {
            break;
        }
        let from = best
            .as_ref()
            .map_or(&start.point, |(_, solution)| &solution.point);
        let exact = posed.problem.without_velocity_gaps();
        let woven = Posed::new(exact.woven(&errors, Kinks::Rounded, from, epochs_s));
        let recipe = match is_motion || best.is_some() {
            true => Recipe::default().from_the_last(),
            false => Recipe::default().without_sweep(),
        };
        let found = recipe::solve_from(
            &woven.problem,
            &woven.layout,
            from.clone(),
            epochs_s.to_vec(),
            &recipe,
            observer,
        );
        work.add(&found.work);
        if !found.finished.converged {
            if best.is_some() || !may_be_expected {
                break;
            }
            // Where the motion of white noise is far off, its residuals tell little of a hand.
            may_be_expected = false;
            errors = expected;
            continue;
        }
        let apart_s = match is_as_expected(&woven, &found) {
            true => likelihood::APART_S,
            false => 0.0,
        };
        let context = woven.context(epochs_s.to_vec(), &found.point);
        let likely = likely(&context, &found, &errors, apart_s);
        best = Some((woven, found));
        let Some(likely) = likely else { break };
        let is_same = process::change(&errors.processes, &likely.processes) < SAME;
        errors = likely;
        if is_same {
            break;
        }
    }
    best.map(|(posed, solution)| (posed, Solution { work, ..solution }))
}

/// The errors that a motion's residuals make likeliest where it was found without them; `None` where it may go along too many
/// directions to tell.
fn likely_at_start(posed: &Posed, start: &Solution, epochs_s: &[f64]) -> Option<LikelyErrors> {
    let context = posed.context(epochs_s.to_vec(), &start.point);
    let in_time = InTime::expected(&context, start, Strayed::Hand);
    let (context, start) = in_time.at(&context, start);
    if is_too_free(&context, &start.system) {
        return None;
    }
    let expected = LikelyErrors::EXPECTED;
    likely(&context, &start, &expected, likelihood::APART_S)
}

/// Whether residuals are about as great as their errors: told by few samples, these can be far off.
fn is_as_expected(posed: &Posed, solution: &Solution) -> bool {
    let hands = posed.problem.weave.iter().flat_map(|weave| &weave.hands);
    let samples = hands.flat_map(|of| &of.arcs).flat_map(|of| &of.samples);
    let kinds = samples.map(|of| of.gains.iter().flatten().count());
    let context = posed.context(Vec::new(), &solution.point);
    let left = (3 * kinds.sum::<usize>()) as f64 - free_count(&context, &solution.system) as f64;
    let ratio = 2.0 * solution.system.cost / left.max(1.0);
    (AS_EXPECTED.recip()..=AS_EXPECTED).contains(&ratio)
}
