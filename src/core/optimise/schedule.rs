//! The schedule from a start to the optimum, in three stages:
//!
//! 1. sweep: all constraints enter together as a quadratic penalty over all unknowns,
//!    `min f + ½ w Σ violation²` (the augmented Lagrangian with multipliers zero);
//! 2. multiplier rounds at a moderate weight: descend on the augmented Lagrangian, update `ν`;
//! 3. finish by sequential quadratic programming.
//!
//! Hard constraints from the beginning would be imposed on gaps of a hundred units; general solvers
//! then leave the optimum near the start for another one. One sweep weight is enough for the
//! estimation: with states held at the middle of their arcs, slower sweeps (weights 0.1, 1, 10,
//! 100) reached the same optima, in twice the iterations, on pencils at up to eight times the
//! distortion and on up to twenty bounces.

use super::descend::{Descent, Patience};
use super::finish::{Finish, Finished, Tolerances};
use super::lagrangian::AugmentedLagrangian;
use super::program::Program;
use super::system::System;
use super::work::Work;

/// A violation above this at the greatest weight means that the constraints contradict each other,
/// in units.
const HOPELESS: f64 = 1.0;
/// A multiplier round stalls where it leaves more than this share of the violation,
const STALLED: f64 = 0.8;
/// and the rounds are given up after so many stalled ones in succession.
const STALLED_ROUNDS: usize = 2;
/// Ratio of successive weights of a sweep from the least to the greatest information.
const SWEEP_RATIO: f64 = 30.0;
/// Least weight of leading rows in a sweep, per information.
const LEADING_WEIGHT: f64 = 100.0;
/// Least [`Tolerances::decrease`] where the cost leaves directions open ([`Program::is_open`]): what only
/// terms next to nothing hold is not worth more digits.
const OPEN_DECREASE: f64 = 1e-5;
/// How many times as many steps a multiplier round may take where constraints are curved
/// ([`Program::is_curved`]): the multipliers of a descent that is cut off say little.
const CURVED_STEPS: usize = 4;
/// Factor on [`Schedule::gain`] in the descents of a retry,
const PATIENT: f64 = 1e-7;
/// whose multiplier rounds go on until the violation is below this, in units.
const PATIENT_BELOW: f64 = 1e-5;

/// Weights, numbers of rounds and stopping rules. Weights per squared unit and gains are multiples
/// of the program's [`information`](Program::information).
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Weights of the sweep, per squared unit.
    pub sweep_weights: Vec<f64>,
    /// Greatest number of steps at each weight.
    pub sweep_steps: usize,
    /// [`Patience::gain`] of the sweep and of the multiplier rounds.
    pub gain: f64,
    /// First weight of the multiplier rounds.
    pub multiplier_weight: f64,
    /// Greatest number of rounds, and of steps in each.
    pub multiplier_rounds: (usize, usize),
    /// Violation below which multiplier rounds end and the finish begins, in units.
    pub finish_below: f64,
    /// How often a finish that does not converge is followed by more precise multiplier rounds and
    /// another finish.
    pub retries: usize,
    /// When the finish has converged.
    pub tolerances: Tolerances,
}

impl Default for Schedule {
    fn default() -> Self {
        Self {
            sweep_weights: vec![10.0],
            sweep_steps: 10,
            gain: 1.0,
            multiplier_weight: 1000.0,
            multiplier_rounds: (12, 15),
            finish_below: 0.3,
            retries: 2,
            tolerances: Tolerances::default(),
        }
    }
}

impl Schedule {
    /// Greatest weight of the multiplier rounds.
    fn weight_max(&self) -> f64 {
        100.0 * self.multiplier_weight
    }

    /// The schedule for a start near the optimum: multiplier rounds at once, with a smaller gain,
    /// and no retries.
    pub fn without_sweep(&self) -> Self {
        Self {
            sweep_weights: Vec::new(),
            gain: 1e-4 * self.gain,
            retries: 0,
            ..self.clone()
        }
    }

    /// The schedule for a start that is the solution of a slightly different program: the finish at
    /// once.
    pub fn from_the_last(&self) -> Self {
        Self {
            sweep_weights: Vec::new(),
            multiplier_rounds: (0, 0),
            retries: 0,
            ..self.clone()
        }
    }

    /// The schedule with its weights multiplied by a program's [`Program::information`]. Where
    /// least and greatest information differ, the sweep repeats its weights at levels from one to
    /// the other: a weight that is strong against one part of the cost is weak against the other.
    pub fn scaled(&self, least: f64, most: f64) -> Self {
        let between = ((most / least).log(SWEEP_RATIO).ceil() as i32).max(0);
        let levels = (0..=between).map(|level| (least * SWEEP_RATIO.powi(level)).min(most));
        Self {
            sweep_weights: levels
                .flat_map(|level| self.sweep_weights.iter().map(move |weight| weight * level))
                .collect(),
            gain: self.gain * least,
            multiplier_weight: self.multiplier_weight * most,
            ..self.clone()
        }
    }
}

/// A stage of the schedule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// All constraints as a quadratic penalty.
    Sweep {
        /// Its weight, per squared unit.
        weight: f64,
    },
    /// Multiplier rounds on the augmented Lagrangian.
    Multipliers,
    /// Sequential quadratic programming, without temporary terms.
    Finish,
}

/// An observer of a solve, which may end it.
pub trait Watch {
    /// A stage begins.
    fn begins(&mut self, _stage: Stage) {}

    /// Whether to end with the point reached so far.
    fn should_stop(&mut self) -> bool {
        false
    }

    /// The same before an iteration of so much work ([`Program::iteration_work`]).
    fn worked(&mut self, _work: usize) -> bool {
        self.should_stop()
    }
}

/// No observer.
impl Watch for () {}

/// The result of a solve.
#[derive(Clone, Debug)]
pub struct Solution<T> {
    /// Values of all unknowns.
    pub point: T,
    /// Cost and constraints at the point.
    pub system: System,
    /// Multipliers of the constraints, row by row.
    pub multipliers: Vec<f64>,
    /// How the finish ended.
    pub finished: Finished,
    /// Whether [`Watch::should_stop`] ended the finish.
    pub stopped: bool,
    /// Work done in all stages.
    pub work: Work,
}

impl<T> Solution<T> {
    /// Whether the finish was left out because the constraints contradict each other.
    fn gave_up(&self) -> bool {
        self.finished.decrease.is_infinite()
    }
}

/// Minimises the cost of `program` under its constraints from a start; `guidance` gives the
/// temporary terms of each stage.
///
/// Not converging is no failure: [`Solution::finished`] says what is left.
pub fn solve<P: Program>(
    program: &P,
    start: P::Point,
    schedule: &Schedule,
    guidance: &dyn Fn(Stage) -> P::Guidance,
    watch: &mut dyn Watch,
) -> Solution<P::Point> {
    let (least, most) = program.information();
    let schedule = &schedule.scaled(least, most);
    let mut descent = Descent::new(program, start);
    for (index, weight) in schedule.sweep_weights.iter().enumerate() {
        let stage = Stage::Sweep { weight: *weight };
        if index == 0 {
            watch.begins(stage);
        }
        let leading = guidance(stage);
        descent.refresh(&leading);
        let mut lagrangian = AugmentedLagrangian::new(&descent.system, *weight);
        lagrangian.leading_weight = weight.max(LEADING_WEIGHT * most);
        let patience = Patience {
            steps: schedule.sweep_steps,
            gain: schedule.gain,
        };
        descent.run(&leading, &lagrangian, patience, &mut |work| {
            watch.worked(work)
        });
        if watch.should_stop() {
            break;
        }
    }

    let exact = guidance(Stage::Finish);
    let mut lagrangian = AugmentedLagrangian::new(&descent.system, schedule.multiplier_weight);
    if schedule.multiplier_rounds.0 > 0 {
        watch.begins(Stage::Multipliers);
        let coarse = guidance(Stage::Multipliers);
        descent.refresh(&coarse);
        tighten(&mut descent, &coarse, &mut lagrangian, schedule, watch);
    }
    descent.refresh(&exact);
    let mut solution = conclude(descent, &exact, &lagrangian, schedule, watch);
    for retry in 0..schedule.retries {
        let is_hopeless = retry > 0 && solution.gave_up();
        if solution.finished.converged || solution.stopped || is_hopeless || watch.should_stop() {
            break;
        }
        // Where full steps do not converge, damped ones without temporary terms come closer.
        watch.begins(Stage::Multipliers);
        let mut descent = Descent::new(program, solution.point);
        descent.work = solution.work;
        descent.refresh(&exact);
        let mut lagrangian = AugmentedLagrangian::new(&descent.system, schedule.multiplier_weight);
        lagrangian.multipliers = solution.multipliers;
        let patient = Schedule {
            gain: PATIENT * schedule.gain,
            finish_below: PATIENT_BELOW,
            ..schedule.clone()
        };
        tighten(&mut descent, &exact, &mut lagrangian, &patient, watch);
        solution = conclude(descent, &exact, &lagrangian, schedule, watch);
    }
    solution
}

impl<P: Program> Descent<'_, P> {
    /// The descent's point as a solution without a finish.
    fn given_up(self, multipliers: Vec<f64>, tolerances: Tolerances) -> Solution<P::Point> {
        Solution {
            finished: Finished {
                converged: false,
                tolerances,
                violation: self.system.violation(),
                decrease: f64::INFINITY,
            },
            point: self.point,
            system: self.system,
            multipliers,
            stopped: false,
            work: self.work,
        }
    }
}

/// The finish, from the end of a descent.
fn conclude<P: Program>(
    descent: Descent<P>,
    exact: &P::Guidance,
    lagrangian: &AugmentedLagrangian,
    schedule: &Schedule,
    watch: &mut dyn Watch,
) -> Solution<P::Point> {
    let multipliers = lagrangian.multipliers.clone();
    // Constraints that the greatest weight leaves violated by a whole unit contradict each other:
    // steps that satisfy their linearisation would lead far away.
    if descent.system.violation() > HOPELESS && lagrangian.weight >= schedule.weight_max() {
        let mut given_up = descent.given_up(multipliers, schedule.tolerances);
        given_up.stopped = watch.should_stop();
        return given_up;
    }
    watch.begins(Stage::Finish);
    let mut finish = Finish {
        program: descent.program,
        point: descent.point,
        system: descent.system,
        multipliers,
        work: descent.work,
        damping: 0.0,
        exact: None,
    };
    let mut stopped = false;
    let mut tolerances = schedule.tolerances;
    if finish.program.is_open() {
        tolerances.decrease = tolerances.decrease.max(OPEN_DECREASE);
    }
    let finished = finish.run(exact, &tolerances, &mut |work| {
        stopped |= watch.worked(work);
        stopped
    });
    Solution {
        point: finish.point,
        system: finish.system,
        multipliers: finish.multipliers,
        finished,
        stopped,
        work: finish.work,
    }
}

/// Multiplier rounds until the constraints hold well enough for the finish.
fn tighten<P: Program>(
    descent: &mut Descent<P>,
    guidance: &P::Guidance,
    lagrangian: &mut AugmentedLagrangian,
    schedule: &Schedule,
    watch: &mut dyn Watch,
) {
    let (rounds, mut steps) = schedule.multiplier_rounds;
    if descent.program.is_curved() {
        steps *= CURVED_STEPS;
    }
    let patience = Patience {
        steps,
        gain: schedule.gain,
    };
    let mut violation = f64::INFINITY;
    let mut stalled = 0;
    for _ in 0..rounds {
        descent.run(guidance, lagrangian, patience, &mut |work| {
            watch.worked(work)
        });
        lagrangian.update(&descent.system);
        let now = descent.system.violation();
        let is_stalled = now > STALLED * violation && lagrangian.weight >= schedule.weight_max();
        stalled = if is_stalled { stalled + 1 } else { 0 };
        let is_hopeless = now > HOPELESS && stalled >= STALLED_ROUNDS;
        if now < schedule.finish_below || is_hopeless || watch.should_stop() {
            break;
        }
        // Where multiplier updates alone reduce the violation slowly, increase the weight.
        if now > 0.25 * violation {
            lagrangian.weight = (lagrangian.weight * 10.0).min(schedule.weight_max());
            lagrangian.leading_weight = lagrangian.weight;
        }
        violation = now;
    }
}
