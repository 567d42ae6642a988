//! From a first guess to the optimum: grow the part of the sketch that counts from the start, so that no fit
//! has to find more than a part of a whirl; bring the goals in by a sweep; come near by steps in a trust region;
//! finish.

use super::point::TreePoint;
use super::problem::{RATE_SD_RAD_S, TreeProblem};
use super::program::{Part, TreeProgram};
use super::time_line::TimeLine;
use crate::estimate::recipe::Watched;
use crate::math::random::Random;
use crate::motion::{Observer, Phase};
use crate::optimise::descend::{Descent, Patience};
use crate::optimise::lagrangian::AugmentedLagrangian;
use crate::optimise::trust::{self, Nearness};
use crate::optimise::{self, Program, Schedule, Solution, Stage, Work};
use crate::physics::tree::TreeState;

/// Standard deviation of the rates at the start while the part grows [rad/s],
const GROWING_SD_RAD_S: f64 = 0.5 * RATE_SD_RAD_S;
/// and of the first log-pace of an unknown tempo from its guess.
const GROWING_LOG_PACE_SD: f64 = 0.1;
/// Samples of the first parts,
const FIRST_PARTS: [usize; 3] = [4, 8, 12];
/// and by how much further ones grow: as a rule, and where that leads to no optimum.
const GROWTHS: [f64; 2] = [1.5, 1.25];
/// Longest step of the integrator \[s\], and the greatest turn of any joint in it \[rad\]: on the way, and in the end.
pub const ROUGHLY: [f64; 2] = [1.0 / 15.0, 0.8];
/// See [`ROUGHLY`].
pub const EXACTLY: [f64; 2] = [1.0 / 40.0, 0.2];
/// Weight of goals at the start while the part grows, per information,
const START_WEIGHT: f64 = 100.0;
/// and how long a descent goes on there.
const GROWING: Patience = Patience {
    steps: 12,
    gain: 0.1,
};
/// How much faster each rate is made at random before a part is fitted that ends before any event [rad/s]: a chain that
/// flies without turning moves alike whichever way it is about to turn, and would stay at rest.
const KICK_RAD_S: f64 = 0.1;
/// Weights of the sweep that brings goals in, steps at each, and what must be gained for another.
const SWEEP: ([f64; 4], usize, f64) = ([0.1, 1.0, 10.0, 100.0], 8, 1.0);
/// How near steps in a trust region come to the optimum before the finish.
const NEARNESS: Nearness = Nearness {
    steps: 40,
    decrease: 1e-6,
    violation: 1e-6,
};
/// Costs are the same that differ by no larger share.
const SAME: f64 = 0.01;
/// How many paces are gone on with,
const LIKELIEST: usize = 2;
/// and how far, root mean square in weights, an optimum may be from samples in an unknown tempo before more is tried: as far as
/// motions are not doubted for.
const FAR: f64 = 3.0;
/// How often samples about an event are given anew to the motions before and after it.
const SIDINGS: usize = 4;

/// The optimum that a start leads to, with the problem whose steps are as short as it needs.
pub struct Solved {
    /// The problem.
    pub problem: TreeProblem,
    /// Its solution.
    pub solution: Solution<TreePoint>,
}

/// Solves a problem from first guesses of the pace in which it is acted, each with the state at the start: one where
/// stamps are physical times. The likeliest paces are gone on with. Where growing by half leads to no optimum, or in an unknown
/// tempo to one that is far from the samples, slower growth is tried, and then multiplier rounds from where each led.
pub fn solve(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    observer: &mut dyn Observer,
) -> Solved {
    let mut work = Work::default();
    let mut tried: Vec<(TreeProblem, TreePoint)> = Vec::new();
    let mut far: Option<Solved> = None;
    for growth in GROWTHS {
        for (problem, point) in likeliest((problem, starts), growth, &mut work, observer) {
            let at_once = Schedule::default().from_the_last();
            let solved = finished(&problem, &point, &at_once, &mut work, observer);
            if !solved.has_ended() {
                tried.push((problem, point));
            } else if solved.solution.stopped || !solved.is_far() {
                return solved;
            } else if far.as_ref().is_none_or(|of| solved.cost() < of.cost()) {
                far = Some(solved);
            }
        }
    }
    if let Some(mut far) = far {
        far.solution.work = work;
        return far;
    }
    let rounds = Schedule {
        sweep_weights: Vec::new(),
        ..Schedule::default()
    };
    let mut last = None;
    for (problem, point) in &tried {
        let solved = finished(problem, point, &rounds, &mut work, observer);
        if solved.has_ended() {
            return solved;
        }
        last = Some(solved);
    }
    last.expect("it grew at least once")
}

/// Where growing leads from each pace, until two lead to the same: the likeliest, in order.
fn likeliest(
    (problem, starts): (&TreeProblem, &[(f64, TreeState)]),
    growth: f64,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> Vec<(TreeProblem, TreePoint)> {
    let mut all: Vec<(f64, (TreeProblem, TreePoint))> = Vec::new();
    for (pace, start) in starts {
        let mut paced = problem.clone();
        if let Some(tempo) = &mut paced.tempo {
            tempo.guess = *pace;
        }
        let (problem, point) = grown((&paced, start.clone()), growth, work, observer);
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

/// The optimum near a point, with all the work so far. Samples that it leaves on the wrong side of an event are given
/// to the other side, and it is found again.
fn finished(
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
    fn has_ended(&self) -> bool {
        self.solution.finished.converged || self.solution.stopped
    }

    fn cost(&self) -> f64 {
        self.solution.system.cost
    }

    /// Whether an optimum in an unknown tempo is so far from its samples that it is likely a wrong one.
    fn is_far(&self) -> bool {
        let samples = self.problem.samples.len() as f64;
        self.problem.tempo.is_some() && self.cost() > 0.5 * FAR * FAR * samples
    }
}

/// Lets the part that counts grow, each time by this share: where that leads, with the problem whose steps are as short as it needs.
fn grown(
    (problem, start): (&TreeProblem, TreeState),
    growth: f64,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> (TreeProblem, TreePoint) {
    let mut problem = problem.clone();
    let mut point = TreePoint::new(&problem, vec![start]);
    observer.phase(Phase::ArcFits);
    let mut random = Random::default();
    for until_s in problem.parts_s(growth) {
        problem.step_s = problem.step_for(&point, until_s, ROUGHLY);
        if problem
            .events
            .first()
            .is_none_or(|event| event.about_s > until_s)
        {
            let rates = point.nodes[0].rates.iter_mut().enumerate();
            for (_, rate) in rates.filter(|(at, _)| !problem.forest.is_translation(*at)) {
                *rate += KICK_RAD_S * random.normal();
            }
        }
        let program = TreeProgram::new(&problem, point.clone());
        let part = Part {
            until_s,
            rate_sd_rad_s: GROWING_SD_RAD_S,
            log_pace_sd: Some(GROWING_LOG_PACE_SD),
        };
        let mut descent = Descent::new(&program, point);
        descent.refresh(&part);
        let information = problem.information.1;
        let lagrangian = AugmentedLagrangian::new(&descent.system, START_WEIGHT * information);
        let patience = Patience {
            gain: GROWING.gain * problem.information.0,
            ..GROWING
        };
        descent.run(&part, &lagrangian, patience);
        work.add(&descent.work);
        point = descent.point;
        problem.part_at(&point);
        if observer.should_stop() {
            break;
        }
    }
    problem.step_s = problem.step_for(&point, problem.span_s[1], ROUGHLY);
    let program = TreeProgram::new(&problem, point.clone());
    let point = swept(&program, point, work, observer);
    problem.step_s = problem.step_for(&point, problem.span_s[1], EXACTLY);
    problem.part_at(&point);
    (problem, point)
}

/// Brings the goals in, and comes near the optimum by steps in a trust region: along a weak direction, as the
/// spin of a whole chain, the valley is curved.
fn swept(
    program: &TreeProgram,
    point: TreePoint,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> TreePoint {
    observer.phase(Phase::Sweep);
    let (least, most) = program.information();
    let whole = Part::whole();
    let mut descent = Descent::new(program, point);
    descent.refresh(&whole);
    for weight in SWEEP.0 {
        let lagrangian = AugmentedLagrangian::new(&descent.system, weight * most);
        let patience = Patience {
            steps: SWEEP.1,
            gain: SWEEP.2 * least,
        };
        descent.run(&whole, &lagrangian, patience);
        if observer.should_stop() {
            break;
        }
    }
    work.add(&descent.work);
    let stop = &mut || observer.should_stop();
    let near = trust::approach(program, descent.point, &whole, &NEARNESS, stop);
    work.add(&near.work);
    near.point
}

impl TreeProblem {
    /// Parts samples where a point has the events; whether one then is on another side than before.
    fn part_at(&mut self, point: &TreePoint) -> bool {
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

    /// Times at which the growing parts end \[s\]: before the goals at the end.
    fn parts_s(&self, growth: f64) -> Vec<f64> {
        let mut times_s: Vec<f64> = self.samples.iter().map(|sample| sample.acted_s).collect();
        times_s.dedup();
        let mut counts = FIRST_PARTS.to_vec();
        while let Some(last) = counts.last().copied()
            && last < times_s.len()
        {
            counts.push((last as f64 * growth) as usize);
        }
        counts.retain(|count| *count < times_s.len());
        counts.push(times_s.len());
        // A goal at the last sample's time does not count yet.
        let end_s = self.span_s[1];
        let last = counts.iter().filter_map(|count| times_s.get(count - 1));
        last.map(|time_s| time_s.min(end_s.next_down())).collect()
    }
}
