//! From a guess to the right optimum: all constraints come in together as a quadratic penalty
//! over all unknowns, then multipliers at a moderate weight, then the finish.
//!
//! Hard constraints at once would be imposed on gaps of a hundred units, and that is where
//! general solvers lose the performer's motion for a nearby one. One weight before the
//! multipliers is enough: with states held at the middle of their arcs, slower sweeps (weights
//! 0.1, 1, 10, 100) reached the same optima, in twice the iterations, on pencils at up to eight
//! times the distortion and on up to twenty bounces.

use super::collision;
use super::descend::{Descent, Patience};
use super::events;
use super::finish::{Finish, Finished, Tolerances};
use super::layout::Layout;
use super::merit::AugmentedLagrangian;
use super::point::Point;
use super::problem::Problem;
use super::system::{Guidance, SolveContext, System};
use crate::motion::{Counters, Guess, Observer, Phase};

/// A violation that the greatest weight leaves only where there is nothing better, in units.
const HOPELESS: f64 = 1.0;

/// Multipliers that leave this much of a violation do not lower it, in so many rounds on end.
const STALLED: f64 = 0.8;
const STALLED_ROUNDS: usize = 2;
/// Ratio of successive weights of a sweep from the least to the greatest information.
const SWEEP_RATIO: f64 = 30.0;

/// Settings of the recipe; the defaults are what the studies in `tools/` measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Weights of the sweep, per squared unit.
    pub sweep_weights: Vec<f64>,
    /// Steps at most at each.
    pub sweep_steps: usize,
    /// A sweep or a multiplier round ends when a step gains less than this.
    pub gain: f64,
    /// Standard deviation of the events' pull to their marks while the weight is at most one \[s\].
    pub event_sd_s: f64,
    /// First weight of the multiplier rounds.
    pub multiplier_weight: f64,
    /// Rounds at most, steps of each at most.
    pub multiplier_rounds: (usize, usize),
    /// Orientations of an arc that sweep and multiplier rounds read.
    pub orientations_per_arc: usize,
    /// Violation at which the finish takes over, in units.
    pub finish_below: f64,
    /// Times that a finish which does not converge is followed by a patient descent and another.
    pub retries: usize,
    /// When the finish is done.
    pub tolerances: Tolerances,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            sweep_weights: vec![10.0],
            sweep_steps: 10,
            gain: 1.0,
            event_sd_s: 0.002,
            multiplier_weight: 1000.0,
            multiplier_rounds: (12, 15),
            orientations_per_arc: 16,
            finish_below: 0.3,
            retries: 2,
            tolerances: Tolerances::default(),
        }
    }
}

impl Recipe {
    /// Greatest weight of the multiplier rounds.
    fn weight_max(&self) -> f64 {
        100.0 * self.multiplier_weight
    }

    /// The recipe for a start that is near: multipliers at once, patiently, and no second try.
    pub fn without_sweep(&self) -> Self {
        Self {
            sweep_weights: Vec::new(),
            gain: 1e-4 * self.gain,
            retries: 0,
            ..self.clone()
        }
    }

    /// The recipe for a start that solved the problem but for a few samples: the finish at once.
    pub fn from_the_last(&self) -> Self {
        Self {
            sweep_weights: Vec::new(),
            multiplier_rounds: (0, 0),
            retries: 0,
            ..self.clone()
        }
    }

    /// The recipe for a problem with as much [`Problem::information`]. Where positions and
    /// orientations are weighed in very different units, the sweep goes from the one to the
    /// other: what presses hard on the one would be no more than a hint for the other.
    pub(super) fn scaled(&self, problem: &Problem) -> Self {
        let (least, most) = (problem.least_information(), problem.information());
        let between = ((most / least).log(SWEEP_RATIO).ceil() as i32).max(0);
        let levels = (0..=between).map(|level| (least * SWEEP_RATIO.powi(level)).min(most));
        Self {
            sweep_weights: levels
                .flat_map(|level| self.sweep_weights.iter().map(move |weight| weight * level))
                .collect(),
            gain: self.gain * least,
            event_sd_s: self.event_sd_s / most.sqrt(),
            multiplier_weight: self.multiplier_weight * most,
            ..self.clone()
        }
    }
}

/// Where a solve ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// All unknowns.
    pub point: Point,
    /// Objective and constraints there.
    pub system: System,
    /// Multipliers of the constraints, row by row.
    pub multipliers: Vec<f64>,
    /// How the finish ended.
    pub finished: Finished,
    /// Whether it was ended from outside.
    pub stopped: bool,
    /// Work done.
    pub counters: Counters,
}

impl Solution {
    /// Whether conditions contradicted each other so much that there was no finish.
    fn gave_up(&self) -> bool {
        self.finished.decrease.is_infinite()
    }
}

/// Epochs of the guess, in the order of the arcs \[s\].
pub fn epochs_s(guess: &Guess) -> Vec<f64> {
    guess.arcs.iter().map(|arc| arc.epoch_s).collect()
}

/// Solves from a guess.
pub fn solve(
    problem: &Problem,
    layout: &Layout,
    guess: &Guess,
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Solution {
    let mut start = Point::new(problem, guess);
    let context = SolveContext::new(problem, layout, epochs_s(guess), &start);
    let information = problem.information();
    let recipe = &recipe.scaled(problem);
    // Without a sweep the start is near.
    if !recipe.sweep_weights.is_empty() {
        events::align(&context, &mut start);
    }
    let mut guidance = leading(&context, &start);
    guidance.orientations_per_arc = recipe.orientations_per_arc;
    let mut descent = Descent::new(&context, start);

    observer.phase(Phase::Sweep);
    for weight in &recipe.sweep_weights {
        if !problem.times_are_unknown() {
            let loosened = (weight / information).log10().max(0.0);
            guidance.event_sd_s = Some(recipe.event_sd_s * 10f64.powf(0.5 * loosened));
        }
        descent.refresh(&guidance);
        let mut lagrangian = AugmentedLagrangian::new(&descent.system, *weight);
        lagrangian.approach_weight = weight.max(100.0 * information);
        let patience = Patience {
            steps: recipe.sweep_steps,
            gain: recipe.gain,
        };
        descent.run(&guidance, &lagrangian, patience);
        if observer.should_stop() {
            break;
        }
    }

    observer.phase(Phase::Multipliers);
    let exact = Guidance::none(problem);
    let coarse = Guidance {
        orientations_per_arc: recipe.orientations_per_arc,
        ..exact.clone()
    };
    let mut lagrangian = AugmentedLagrangian::new(&descent.system, recipe.multiplier_weight);
    if recipe.multiplier_rounds.0 > 0 {
        descent.refresh(&coarse);
        tighten(&mut descent, &coarse, &mut lagrangian, recipe, observer);
    }
    descent.refresh(&exact);
    let mut solution = conclude(descent, &lagrangian, recipe, observer);
    for retry in 0..recipe.retries {
        let is_hopeless = retry > 0 && solution.gave_up();
        if solution.finished.converged || solution.stopped || is_hopeless {
            break;
        }
        // Where full steps lead nowhere, damped ones with all samples come closer.
        observer.phase(Phase::Multipliers);
        let mut descent = Descent::new(&context, solution.point);
        descent.counters = solution.counters;
        descent.refresh(&exact);
        let mut lagrangian = AugmentedLagrangian::new(&descent.system, recipe.multiplier_weight);
        lagrangian.multipliers = solution.multipliers;
        let patient = Recipe {
            gain: 1e-7 * recipe.gain,
            finish_below: 1e-5,
            ..recipe.clone()
        };
        tighten(&mut descent, &exact, &mut lagrangian, &patient, observer);
        solution = conclude(descent, &lagrangian, recipe, observer);
    }
    solution
}

impl Descent<'_> {
    /// Where it ended, without a finish.
    fn given_up(self, multipliers: Vec<f64>) -> Solution {
        Solution {
            finished: Finished {
                converged: false,
                violation: self.system.violation(),
                decrease: f64::INFINITY,
            },
            point: self.point,
            system: self.system,
            multipliers,
            stopped: false,
            counters: self.counters,
        }
    }
}

/// The finish, from where a descent ended.
fn conclude(
    descent: Descent,
    lagrangian: &AugmentedLagrangian,
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Solution {
    let multipliers = lagrangian.multipliers.clone();
    // Conditions that the greatest weight leaves broken by a whole unit contradict each other, and
    // steps that meet them exactly would only lead astray.
    if descent.system.violation() > HOPELESS && lagrangian.weight >= recipe.weight_max() {
        return descent.given_up(multipliers);
    }
    observer.phase(Phase::Finish);
    let Descent {
        context,
        point,
        system,
        counters,
        ..
    } = descent;
    let mut finish = Finish {
        context,
        point,
        system,
        multipliers,
        counters,
    };
    let mut stopped = false;
    let finished = finish.run(&recipe.tolerances, &mut || {
        stopped |= observer.should_stop();
        stopped
    });
    let Finish {
        point,
        system,
        multipliers,
        counters,
        ..
    } = finish;
    Solution {
        point,
        system,
        multipliers,
        finished,
        stopped,
        counters,
    }
}

/// Multiplier rounds until the constraints hold well enough for the finish.
fn tighten(
    descent: &mut Descent,
    guidance: &Guidance,
    lagrangian: &mut AugmentedLagrangian,
    recipe: &Recipe,
    observer: &mut dyn Observer,
) {
    let (rounds, steps) = recipe.multiplier_rounds;
    let patience = Patience {
        steps,
        gain: recipe.gain,
    };
    let mut violation = f64::INFINITY;
    let mut stalled = 0;
    for _ in 0..rounds {
        descent.run(guidance, lagrangian, patience);
        lagrangian.update(&descent.system);
        let now = descent.system.violation();
        let is_stalled = now > STALLED * violation && lagrangian.weight >= recipe.weight_max();
        stalled = if is_stalled { stalled + 1 } else { 0 };
        let is_hopeless = now > HOPELESS && stalled >= STALLED_ROUNDS;
        if now < recipe.finish_below || is_hopeless || observer.should_stop() {
            break;
        }
        // Where multipliers alone are slow, the weight helps.
        if now > 0.25 * violation {
            lagrangian.weight = (lagrangian.weight * 10.0).min(recipe.weight_max());
            lagrangian.approach_weight = lagrangian.weight;
        }
        violation = now;
    }
}

/// What leads the sweep: contacts approach at least at three tenths of the speed that the arc
/// fits say, or an impulse could die while the penalty is loose. Events are pulled to where they begin.
pub(super) fn leading(context: &SolveContext, start: &Point) -> Guidance {
    let problem = context.problem;
    let mut guidance = Guidance::none(problem);
    guidance.event_times_s.clone_from(&start.event_times_s);
    for (index, of) in problem.collisions.iter().enumerate() {
        let fastest_m_s = collision::fastest_approach_m_s(problem, of, start, &context.epochs_s);
        guidance.approach_limits_m_s[index] = (0.3 * fastest_m_s).min(-0.1);
    }
    guidance
}
