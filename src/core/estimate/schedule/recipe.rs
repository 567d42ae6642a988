//! The solution of an estimation: the optimiser's schedule, and the guidance of its stages.

use super::events;
use super::hand_on::hand_on;
use super::work::Watched;
use crate::estimate::constraint::collision;
use crate::estimate::posing::waypoint;
use crate::estimate::problem::Problem;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::{Guess, Observer};
use crate::optimise::{self, Program, Schedule, Stage};

/// Settings; the defaults are what the studies in `tools/` measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Sweep, multiplier rounds and finish.
    pub schedule: Schedule,
    /// Standard deviation of the prior that holds events at their initial times, while the sweep's
    /// weight is at most one \[s\].
    pub event_sd_s: f64,
    /// Number of orientations of an arc that sweep and multiplier rounds use.
    pub orientations_per_arc: usize,
    /// Whether waypoints begin where flights by themselves come nearest to their goals, and not at their
    /// marks.
    pub moves_waypoints: bool,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            schedule: Schedule::default(),
            event_sd_s: 0.002,
            orientations_per_arc: 16,
            moves_waypoints: true,
        }
    }
}

impl Recipe {
    /// The defaults with another schedule.
    pub fn of(schedule: Schedule) -> Self {
        Self::default().with(schedule)
    }

    fn with(&self, schedule: Schedule) -> Self {
        Self {
            schedule,
            ..self.clone()
        }
    }

    /// The recipe for a start near the optimum: multiplier rounds at once, with a smaller gain, and
    /// no retries.
    pub fn without_sweep(&self) -> Self {
        self.with(self.schedule.without_sweep())
    }

    /// The recipe for a start that solved the problem without a few samples: the finish at once.
    pub fn from_the_last(&self) -> Self {
        self.with(self.schedule.from_the_last())
    }
}

/// The result of a solve.
pub type Solution = optimise::Solution<Point>;

/// Epochs of the guess, in the order of the arcs \[s\].
pub fn epochs_s(guess: &Guess) -> Vec<f64> {
    guess.arcs.iter().map(|arc| arc.epoch_s).collect()
}

/// Solves a problem from a guess. Where it does not converge with waypoints moved to where flights by
/// themselves come nearest to their goals, it may with waypoints at their marks: a flight that must change
/// much need not pass there when it does now.
pub fn solve(
    problem: &Problem,
    layout: &Layout,
    guess: &Guess,
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Solution {
    let start = || Point::new(problem, guess);
    let solution = solve_from(problem, layout, start(), epochs_s(guess), recipe, observer);
    let is_moved = recipe.moves_waypoints
        && !recipe.schedule.sweep_weights.is_empty()
        && !problem.waypoints.is_empty();
    if solution.finished.converged || solution.stopped || !is_moved {
        return solution;
    }
    let recipe = Recipe {
        moves_waypoints: false,
        ..recipe.clone()
    };
    let mut again = solve_from(problem, layout, start(), epochs_s(guess), &recipe, observer);
    again.work.add(&solution.work);
    if again.finished.converged {
        return again;
    }
    Solution {
        work: again.work,
        ..solution
    }
}

/// Solves a problem from a point with those epochs.
pub fn solve_from(
    problem: &Problem,
    layout: &Layout,
    mut start: Point,
    epochs_s: Vec<f64>,
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Solution {
    let context = SolveContext::new(problem, layout, epochs_s, &start);
    // Without a sweep the start is near the optimum, with good event times.
    if !recipe.schedule.sweep_weights.is_empty() {
        events::align(&context, &mut start);
        if recipe.moves_waypoints {
            waypoint::align(&context, &mut start);
        }
        hand_on(problem, &context.epochs_s, &mut start);
    }
    let lead = Lead::new(&context, &start, recipe);
    let guidance = |stage| lead.guidance(stage);
    let watch = &mut Watched(observer);
    optimise::solve(&context, start, &recipe.schedule, &guidance, watch)
}

/// The guidance of each stage.
#[derive(Clone, Debug)]
pub struct Lead {
    approach_limits_m_s: Vec<f64>,
    event_times_s: Vec<f64>,
    /// Standard deviation of the prior of event times at a weight of one information; `None`: no
    /// prior.
    event_sd_s: Option<f64>,
    information: f64,
    orientations_per_arc: usize,
}

impl Lead {
    /// Contacts must approach with at least three tenths of the start's speed, since otherwise an
    /// impulse could vanish while the penalty is loose. Events have a prior at their initial times,
    /// unless sample times are unknown. Goals with a weight weigh no more than what is hard: one that
    /// is all but hard would lead to another optimum than a hard one.
    pub fn new(context: &SolveContext, start: &Point, recipe: &Recipe) -> Self {
        let problem = context.problem;
        let mut approach_limits_m_s = vec![0.0; problem.event_is_free.len()];
        for of in &problem.collisions {
            let fastest_m_s =
                collision::fastest_approach_m_s(problem, of, start, &context.epochs_s);
            approach_limits_m_s[of.event] = (0.3 * fastest_m_s).min(-0.1);
        }
        let (_, information) = context.information();
        let event_sd_s = recipe.event_sd_s / information.sqrt();
        Self {
            approach_limits_m_s,
            event_times_s: start.event_times_s.clone(),
            event_sd_s: (!problem.times_are_unknown()).then_some(event_sd_s),
            information,
            orientations_per_arc: recipe.orientations_per_arc,
        }
    }

    /// The guidance of a stage; the finish has none.
    pub fn guidance(&self, stage: Stage) -> Guidance {
        match stage {
            Stage::Sweep { weight } => {
                let loosened = (weight / self.information).log10().max(0.0);
                let event_sd_s = self.event_sd_s;
                Guidance {
                    approach_limits_m_s: self.approach_limits_m_s.clone(),
                    event_times_s: self.event_times_s.clone(),
                    event_sd_s: event_sd_s.map(|sd_s| sd_s * 10f64.powf(0.5 * loosened)),
                    goal_weight_max: weight,
                    orientations_per_arc: self.orientations_per_arc,
                }
            }
            Stage::Multipliers => Guidance {
                orientations_per_arc: self.orientations_per_arc,
                ..Guidance::none()
            },
            Stage::Finish => Guidance::none(),
        }
    }
}
