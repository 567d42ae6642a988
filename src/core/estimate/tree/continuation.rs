//! The part of the sketch that counts grows from the start, so that no fit has to find more than a part of a whirl.

use super::part::Part;
use super::point::TreePoint;
use super::problem::{RATE_SD_RAD_S, TreeProblem};
use super::program::TreeProgram;
use super::walk::ROUGHLY;
use crate::math::random::Random;
use crate::motion::Observer;
use crate::optimise::Work;
use crate::optimise::descend::{Descent, Patience};
use crate::optimise::lagrangian::AugmentedLagrangian;
use crate::physics::tree::TreeState;

/// Standard deviation of the rates at the start while the part grows [rad/s],
const RATES_RAD_S: f64 = 0.5 * RATE_SD_RAD_S;
/// and of the first log-pace of an unknown tempo from its guess.
const LOG_PACE_SD: f64 = 0.1;
/// Samples of the first parts.
const FIRST: [usize; 3] = [4, 8, 12];
/// Weight of goals at the start, per information,
const START_WEIGHT: f64 = 100.0;
/// and how long a descent goes on.
const PATIENCE: Patience = Patience {
    steps: 12,
    gain: 0.1,
};
/// How much faster each rate is made at random, as a rule [rad/s]: a chain that flies without turning moves alike whichever
/// way it is about to turn, and would stay at rest.
pub(super) const KICK_RAD_S: f64 = 0.1;
/// A motion is lost where each of its samples costs so many times what one did of the best part with so many samples,
/// but at least so much.
const LOST: (f64, usize, f64) = (30.0, 24, 0.1);
/// Errors that grow by more along one interval lead to no optimum of it.
const WHIRL: f64 = 1e4;
/// Share of a further part that is tried where the whole leads to a lost motion, and how often.
const LESS: (f64, usize) = (0.5, 3);

/// How the part that counts grows.
#[derive(Clone, Copy)]
pub(super) struct Continuation {
    /// By which factor.
    pub(super) by: f64,
    /// On which intervals.
    pub(super) intervals: Intervals,
    /// How much faster each rate is made at random before a part is fitted that ends before any event [rad/s].
    pub(super) kick_rad_s: f64,
}

/// On which intervals the motion is found that grows.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Intervals {
    /// On one, by all that is added at a time.
    One,
    /// As far as errors let the motion be followed, and with further nodes where they grow too much.
    Found,
    /// As far as that, with the problem's own nodes.
    Given,
}

/// How the part that counts grows: by which factor, on which intervals, with which kicks \[rad/s\].
pub(super) const fn continuation(by: f64, intervals: Intervals, kick_rad_s: f64) -> Continuation {
    Continuation {
        by,
        intervals,
        kick_rad_s,
    }
}

/// Where growing led.
pub(super) struct Continued {
    /// The problem, with the nodes that it needs and steps for a rough flow.
    pub(super) problem: TreeProblem,
    pub(super) point: TreePoint,
    /// Whether the motion is far from the samples, or errors grow too much along its one interval.
    pub(super) is_lost: bool,
}

/// Lets the part that counts grow from a state at the start to the whole.
pub(super) fn continued(
    problem: &TreeProblem,
    start: TreeState,
    continuation: Continuation,
    random: &mut Random,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> Continued {
    let mut problem = problem.clone();
    let given_s = problem.nodes_s.split_off(1);
    let is_followed = continuation.intervals != Intervals::One;
    let mut point = TreePoint::new(&problem, vec![start]);
    let mut parts_s = problem.parts_s(continuation.by).into_iter().peekable();
    let mut reached_s = problem.span_s[0];
    let mut best_each = f64::INFINITY;
    let (mut share, mut is_lost) = (1.0, false);
    while let Some(part_s) = parts_s.peek().copied() {
        let until_s = match is_followed {
            true => problem.followed_s(&point, reached_s, part_s, share),
            false => part_s,
        };
        let (mut further, fitted) = (problem.clone(), point.clone());
        let (fitted, cost) = fit(
            &mut further,
            fitted,
            until_s,
            continuation.kick_rad_s,
            &mut *random,
            work,
            &mut *observer,
        );
        let count = problem.count_until(until_s);
        let each = cost / count as f64;
        is_lost = count >= LOST.1 && !(each <= LOST.0 * best_each.max(LOST.2));
        if is_lost {
            let is_least = share <= LESS.0.powi(LESS.1 as i32);
            if !is_followed || is_least || observer.should_stop() {
                break;
            }
            share *= LESS.0;
            continue;
        }
        share = 1.0;
        if count >= LOST.1 {
            best_each = each.min(best_each);
        }
        (problem, point) = match continuation.intervals {
            Intervals::One => (further, fitted),
            Intervals::Found => further.cut(fitted, until_s),
            Intervals::Given => further.cut_at(&given_s, fitted, until_s),
        };
        if until_s >= part_s {
            parts_s.next();
        }
        reached_s = until_s;
        if observer.should_stop() {
            break;
        }
    }
    problem.step_s = problem.step_for(&point, problem.span_s[1], ROUGHLY);
    let whirls =
        continuation.intervals == Intervals::One && !(problem.errors_grown(&point) <= WHIRL);
    Continued {
        problem,
        point,
        is_lost: is_lost || whirls,
    }
}

/// Fits the part until a time \[s\]: where that leads, and what it costs.
fn fit(
    problem: &mut TreeProblem,
    mut point: TreePoint,
    until_s: f64,
    kick_rad_s: f64,
    random: &mut Random,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> (TreePoint, f64) {
    problem.step_s = problem.step_for(&point, until_s, ROUGHLY);
    let first = problem.events.first();
    if first.is_none_or(|event| event.about_s > until_s) {
        let rates = point.nodes[0].rates.iter_mut().enumerate();
        for (_, rate) in rates.filter(|(at, _)| !problem.forest.is_translation(*at)) {
            *rate += kick_rad_s * random.normal();
        }
    }
    let program = TreeProgram::new(problem, point.clone());
    let part = Part {
        until_s,
        rate_sd_rad_s: RATES_RAD_S,
        log_pace_sd: Some(LOG_PACE_SD),
    };
    let mut descent = Descent::new(&program, point);
    descent.refresh(&part);
    let information = problem.information;
    let lagrangian = AugmentedLagrangian::new(&descent.system, START_WEIGHT * information.1);
    let patience = Patience {
        gain: PATIENCE.gain * information.0,
        ..PATIENCE
    };
    descent.run(&part, &lagrangian, patience, &mut |looks| {
        observer.worked(looks)
    });
    work.add(&descent.work);
    let (point, cost) = (descent.point, descent.system.cost);
    problem.part_at(&point);
    (point, cost)
}

impl TreeProblem {
    /// Number of samples until a time \[s\].
    fn count_until(&self, until_s: f64) -> usize {
        let until = self.samples.iter().filter(|of| of.acted_s <= until_s);
        until.count()
    }

    /// Times at which the growing parts end \[s\]: before the goals at the end.
    fn parts_s(&self, continuation: f64) -> Vec<f64> {
        let times_s = self.sample_stamps_s();
        let mut counts = FIRST.to_vec();
        while let Some(last) = counts.last().copied()
            && last < times_s.len()
        {
            counts.push((last as f64 * continuation) as usize);
        }
        counts.retain(|count| *count < times_s.len());
        counts.push(times_s.len());
        // A goal at the last sample's time does not count yet.
        let end_s = self.span_s[1];
        let last = counts.iter().filter_map(|count| times_s.get(count - 1));
        last.map(|time_s| time_s.min(end_s.next_down())).collect()
    }
}
