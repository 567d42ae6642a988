//! From a first guess to the optimum: `grow` the part of the sketch that counts; bring the goals in by a sweep; come
//! near by steps in a trust region; finish.

#[cfg(test)]
mod tests;

use super::continuation::{
    Continuation, Continued, Intervals, KICK_RAD_S, continuation, continued,
};
use super::modes::walked;
use super::optimum::{Solved, approached, finished};
use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::walk::ROUGHLY;
use crate::math::random::Random;
use crate::motion::{Observer, Phase};
use crate::optimise::descend::{Descent, Patience};
use crate::optimise::lagrangian::AugmentedLagrangian;
use crate::optimise::{Program, Schedule, System, Work};
use crate::physics::tree::TreeState;

/// How the part that counts grows: as a rule, and where that leads to no optimum.
pub(super) const CONTINUATIONS: [Continuation; 7] = [
    continuation(1.5, Intervals::One, KICK_RAD_S),
    continuation(1.25, Intervals::One, KICK_RAD_S),
    continuation(1.5, Intervals::One, 2.0),
    continuation(1.5, Intervals::One, 2.0),
    continuation(1.5, Intervals::One, 3.0),
    continuation(1.5, Intervals::One, 3.0),
    continuation(1.5, Intervals::Found, KICK_RAD_S),
];
/// Weights of the sweep that brings goals in, steps at each, and what must be gained for another.
const SWEEP: ([f64; 4], usize, f64) = ([0.1, 1.0, 10.0, 100.0], 8, 1.0);
/// By which share the objective may be greater on one interval than on several.
const IN_ONE: f64 = 1e-6;
/// Costs of two paces are the same that differ by no larger share.
const SAME: f64 = 0.01;
/// How many are gone on with in multiplier rounds of those from which no optimum was found.
const IN_ROUNDS: usize = 2;
/// What each sample costs at most of a motion from which nothing has to grow: half a squared weight.
const NEAR_EACH: f64 = 0.5;
/// How many paces are gone on with.
const LIKELIEST: usize = 2;

/// Solves a problem from first guesses of the pace in which it is acted, each with the state at the start: one where
/// stamps are physical times. What is near all samples from the start is finished at once. The likeliest paces are gone on with. Where growing by half leads to no optimum, or in an unknown
/// tempo to one that is far from the samples, slower continuation is tried, then growing from other rates at random, then with further
/// nodes, and at last multiplier rounds from where the first ones led.
pub fn solve(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    observer: &mut dyn Observer,
) -> Solved {
    found(&problem.given(), starts, observer).let_go(problem, observer)
}

fn found(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    observer: &mut dyn Observer,
) -> Solved {
    let mut work = Work::default();
    let mut tried: Vec<(TreeProblem, TreePoint)> = Vec::new();
    if let Some(near) = begun_near(problem, starts, &mut work) {
        let (problem, point) = swept(near, &mut work, observer);
        let at_once = Schedule::default().from_the_last();
        let solved = finished(&problem, &point, &at_once, &mut work, observer);
        if solved.has_ended() {
            return walked(solved, &mut work, observer);
        }
        tried.push((problem, point));
    }
    let mut far: Option<Solved> = None;
    let mut lost = None;
    // Of a tempo and of parameters, which all intervals share, one interval alone is tried. An unknown tempo has several starts as it is.
    let is_alone = problem.tempo.is_some() || !problem.parameters.is_empty();
    let is_kicked = |of: &Continuation| of.kick_rad_s > KICK_RAD_S;
    let is_tried = |of: &&Continuation| {
        !(is_alone && of.intervals == Intervals::Found || problem.tempo.is_some() && is_kicked(of))
    };
    let mut random = Random::default();
    for continuation in CONTINUATIONS.iter().filter(is_tried) {
        let ways = likeliest(
            problem,
            starts,
            *continuation,
            &mut random,
            &mut lost,
            &mut work,
            observer,
        );
        for (problem, point) in ways {
            let at_once = Schedule::default().from_the_last();
            let solved = finished(&problem, &point, &at_once, &mut work, observer);
            if !solved.has_ended() {
                tried.push((problem, point));
            } else if solved.solution.stopped || !solved.is_far() {
                let solved = in_one(solved, &mut work, observer);
                return walked(solved, &mut work, observer);
            } else if far.as_ref().is_none_or(|of| solved.cost() < of.cost()) {
                far = Some(solved);
            }
        }
    }
    if let Some(mut far) = far {
        far.solution.work = work;
        return far;
    }
    if tried.is_empty() {
        tried.extend(lost.map(|led| swept(led, &mut work, observer)));
    }
    let rounds = Schedule {
        sweep_weights: Vec::new(),
        ..Schedule::default()
    };
    let mut last = None;
    for (problem, point) in tried.iter().take(IN_ROUNDS) {
        let solved = finished(problem, point, &rounds, &mut work, observer);
        if solved.has_ended() {
            return in_one(solved, &mut work, observer);
        }
        last = Some(solved);
    }
    last.expect("it grew at least once")
}

/// Where growing leads from each pace, until two lead to the same: the likeliest, in order. None where stamps are physical times
/// and the motion is lost.
pub(super) fn likeliest(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    continuation: Continuation,
    random: &mut Random,
    lost: &mut Option<Continued>,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> Vec<(TreeProblem, TreePoint)> {
    let mut all: Vec<(f64, (TreeProblem, TreePoint))> = Vec::new();
    for (pace, start) in starts {
        let mut paced = problem.clone();
        if let Some(tempo) = &mut paced.tempo {
            tempo.guess = *pace;
        }
        observer.phase(Phase::ArcFits);
        let led = continued(
            &paced,
            start.clone(),
            continuation,
            &mut *random,
            work,
            observer,
        );
        if led.is_lost && problem.tempo.is_none() {
            lost.get_or_insert(led);
            continue;
        }
        if continuation.intervals == Intervals::Found && led.problem.nodes_s.len() == 1 {
            // It has grown as it did without.
            continue;
        }
        let (problem, point) = swept(led, work, observer);
        let cost = match starts.len() {
            1 => 0.0,
            _ => {
                let program = TreeProgram::new(&problem, point.clone());
                program.evaluated(&Part::whole(), &point).cost
            }
        };
        let is_same = |other: f64| (other - cost).abs() < SAME * cost;
        let is_again = all.iter().any(|(other, _)| is_same(*other));
        let is_least = all
            .iter()
            .all(|(other, _)| cost <= *other || is_same(*other));
        all.push((cost, (problem, point)));
        if is_again && is_least || observer.should_stop() {
            break;
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().take(LIKELIEST).map(|(_, of)| of).collect()
}

/// The whole motion from the one start, where that is near all samples as it is, as of what hangs still: nothing has to grow.
/// `None` where it is not, and where several paces are tried.
fn begun_near(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    work: &mut Work,
) -> Option<Continued> {
    let mut problem = problem.clone();
    let [(_, start)] = starts else { return None };
    let point = TreePoint::new(&problem, vec![start.clone()]);
    problem.step_s = problem.step_for(&point, problem.span_s[1], ROUGHLY);
    let program = TreeProgram::new(&problem, point.clone());
    let mut system = System::new(program.structure());
    program.try_out(&Part::whole(), &point, &mut system);
    work.evaluations += 1;
    let is_near = system.cost <= NEAR_EACH * problem.samples.len() as f64;
    is_near.then_some(Continued {
        problem,
        point,
        is_lost: false,
    })
}

/// The same optimum on the state at the start alone, of which the whole motion is one flow; where errors grow too much
/// for that, as it was on several intervals.
pub(super) fn in_one(mut solved: Solved, work: &mut Work, observer: &mut dyn Observer) -> Solved {
    let (problem, solution) = (&solved.problem, &solved.solution);
    if problem.nodes_s.len() == 1 || solution.stopped {
        return solved;
    }
    let alone = TreeProblem {
        nodes_s: vec![problem.nodes_s[0]],
        ..problem.clone()
    };
    let mut point = solution.point.clone();
    point.nodes.truncate(1);
    let at_once = Schedule::default().from_the_last();
    let one = finished(&alone, &point, &at_once, work, observer);
    let is_same = one.solution.system.cost <= solution.system.cost * (1.0 + IN_ONE);
    if one.solution.finished.converged && is_same {
        return one;
    }
    solved.solution.work = *work;
    solved
}

/// Brings the goals in, and comes near the optimum by steps in a trust region: along a weak direction, as the
/// spin of a whole chain, the valley is curved. Steps are exact from there on.
pub(super) fn swept(
    continued: Continued,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> (TreeProblem, TreePoint) {
    let Continued {
        mut problem, point, ..
    } = continued;
    observer.phase(Phase::Sweep);
    let program = &TreeProgram::new(&problem, point.clone());
    let (least, most) = program.information();
    let whole = Part::whole();
    let mut descent = Descent::new(program, point);
    descent.refresh(&whole);
    // Where nothing is asked, no weight is.
    let is_asked = program
        .structure()
        .blocks
        .iter()
        .any(|block| block.row_count() > 0);
    let weights = if is_asked {
        &SWEEP.0[..]
    } else {
        &SWEEP.0[..1]
    };
    for weight in weights {
        let lagrangian = AugmentedLagrangian::new(&descent.system, weight * most);
        let patience = Patience {
            steps: SWEEP.1,
            gain: SWEEP.2 * least,
        };
        descent.run(&whole, &lagrangian, patience, &mut |looks| {
            observer.worked(looks)
        });
        if observer.should_stop() {
            break;
        }
    }
    work.add(&descent.work);
    let point = approached(program, descent.point, work, observer);
    problem.fit_to(&point);
    (problem, point)
}
