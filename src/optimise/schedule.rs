//! From a start to the right optimum: all constraints come in together as a quadratic penalty
//! over all unknowns, then multipliers at a moderate weight, then the finish.
//!
//! Hard constraints at once would be imposed on gaps of a hundred units, and that is where
//! general solvers lose the optimum near the start for another one. One weight before the
//! multipliers is enough for the estimation: with states held at the middle of their arcs, slower
//! sweeps (weights 0.1, 1, 10, 100) reached the same optima, in twice the iterations, on pencils at up
//! to eight times the distortion and on up to twenty bounces.

use super::descend::{Descent, Patience};
use super::finish::{Finish, Finished, Tolerances};
use super::lagrangian::AugmentedLagrangian;
use super::program::Program;
use super::system::System;
use super::work::Work;

/// A violation that the greatest weight leaves only where there is nothing better, in units.
const HOPELESS: f64 = 1.0;
/// Multipliers that leave this much of a violation do not lower it, in so many rounds on end.
const STALLED: f64 = 0.8;
const STALLED_ROUNDS: usize = 2;
/// Ratio of successive weights of a sweep from the least to the greatest information.
const SWEEP_RATIO: f64 = 30.0;
/// Weight of leading rows in a sweep at the least, per information.
const LEADING_WEIGHT: f64 = 100.0;
/// A retry's descent goes on until less than this share of the gain is left,
const PATIENT: f64 = 1e-7;
/// and until the violation is below this, in units.
const PATIENT_BELOW: f64 = 1e-5;

/// Weights, rounds and ends. Those per squared unit are multiples of the program's information.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Weights of the sweep, per squared unit.
    pub sweep_weights: Vec<f64>,
    /// Steps at most at each.
    pub sweep_steps: usize,
    /// A sweep or a multiplier round ends when a step gains less than this.
    pub gain: f64,
    /// First weight of the multiplier rounds.
    pub multiplier_weight: f64,
    /// Rounds at most, steps of each at most.
    pub multiplier_rounds: (usize, usize),
    /// Violation at which the finish takes over, in units.
    pub finish_below: f64,
    /// Times that a finish which does not converge is followed by a patient descent and another.
    pub retries: usize,
    /// When the finish is done.
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

    /// The schedule for a start that is near: multipliers at once, patiently, and no second try.
    pub fn without_sweep(&self) -> Self {
        Self {
            sweep_weights: Vec::new(),
            gain: 1e-4 * self.gain,
            retries: 0,
            ..self.clone()
        }
    }

    /// The schedule for a start that solved the program but for a little: the finish at once.
    pub fn from_the_last(&self) -> Self {
        Self {
            sweep_weights: Vec::new(),
            multiplier_rounds: (0, 0),
            retries: 0,
            ..self.clone()
        }
    }

    /// The schedule for a program with as much [`Program::information`]. Where parts of the cost are
    /// weighed in very different units, the sweep goes from the one to the other: what presses hard
    /// on the one would be no more than a hint for the other.
    pub fn scaled(&self, (least, most): (f64, f64)) -> Self {
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

/// A part of the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// All constraints as a penalty of a weight.
    Sweep {
        /// Per squared unit.
        weight: f64,
    },
    /// Rounds of multipliers.
    Multipliers,
    /// All is as it is meant.
    Finish,
}

/// Who watches a solve, and may end it.
pub trait Watch {
    /// A stage begins.
    fn begins(&mut self, _stage: Stage) {}

    /// Whether to end with what there is.
    fn should_stop(&mut self) -> bool {
        false
    }
}

/// Nobody.
impl Watch for () {}

/// Where a solve ended.
#[derive(Clone, Debug)]
pub struct Solution<T> {
    /// All unknowns.
    pub point: T,
    /// Cost and constraints there.
    pub system: System,
    /// Multipliers of the constraints, row by row.
    pub multipliers: Vec<f64>,
    /// How the finish ended.
    pub finished: Finished,
    /// Whether it was ended from outside.
    pub stopped: bool,
    /// Work done.
    pub work: Work,
}

impl<T> Solution<T> {
    /// Whether conditions contradicted each other so much that there was no finish.
    fn gave_up(&self) -> bool {
        self.finished.decrease.is_infinite()
    }
}

/// Solves from a start; `guidance` says what leads which stage.
pub fn solve<P: Program>(
    program: &P,
    start: P::Point,
    schedule: &Schedule,
    guidance: &dyn Fn(Stage) -> P::Guidance,
    watch: &mut dyn Watch,
) -> Solution<P::Point> {
    let information = program.information();
    let most = information.1;
    let schedule = &schedule.scaled(information);
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
        descent.run(&leading, &lagrangian, patience);
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
        if solution.finished.converged || solution.stopped || is_hopeless {
            break;
        }
        // Where full steps lead nowhere, damped ones without guidance come closer.
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
    /// Where it ended, without a finish.
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

/// The finish, from where a descent ended.
fn conclude<P: Program>(
    descent: Descent<P>,
    exact: &P::Guidance,
    lagrangian: &AugmentedLagrangian,
    schedule: &Schedule,
    watch: &mut dyn Watch,
) -> Solution<P::Point> {
    let multipliers = lagrangian.multipliers.clone();
    // Conditions that the greatest weight leaves broken by a whole unit contradict each other, and
    // steps that meet them exactly would only lead astray.
    if descent.system.violation() > HOPELESS && lagrangian.weight >= schedule.weight_max() {
        return descent.given_up(multipliers, schedule.tolerances);
    }
    watch.begins(Stage::Finish);
    let mut finish = Finish {
        program: descent.program,
        point: descent.point,
        system: descent.system,
        multipliers,
        work: descent.work,
    };
    let mut stopped = false;
    let finished = finish.run(exact, &schedule.tolerances, &mut || {
        stopped |= watch.should_stop();
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
    let (rounds, steps) = schedule.multiplier_rounds;
    let patience = Patience {
        steps,
        gain: schedule.gain,
    };
    let mut violation = f64::INFINITY;
    let mut stalled = 0;
    for _ in 0..rounds {
        descent.run(guidance, lagrangian, patience);
        lagrangian.update(&descent.system);
        let now = descent.system.violation();
        let is_stalled = now > STALLED * violation && lagrangian.weight >= schedule.weight_max();
        stalled = if is_stalled { stalled + 1 } else { 0 };
        let is_hopeless = now > HOPELESS && stalled >= STALLED_ROUNDS;
        if now < schedule.finish_below || is_hopeless || watch.should_stop() {
            break;
        }
        // Where multipliers alone are slow, the weight helps.
        if now > 0.25 * violation {
            lagrangian.weight = (lagrangian.weight * 10.0).min(schedule.weight_max());
            lagrangian.leading_weight = lagrangian.weight;
        }
        violation = now;
    }
}
