//! A lower bound of the cost of a part of a performance, for the search over collision sequences
//! (paper §5.1, §7).
//!
//! For any multipliers `ν` and weight `w`, weak duality gives
//!
//! ```text
//! min over x   f(x) + Σ (½ w dist²(c(x) + ν/w, [lower, upper]) − ½ ν²/w)
//!     ≤ minimum of f under the constraints
//! ```
//!
//! since the terms of the sum are at most zero where the constraints hold. Multipliers from a round
//! or two make it tight. No finish is needed, so it is cheap and never fails. Leaving out arcs, and
//! the terms and constraints that tie them, lowers it further: omitted costs are never negative.
//!
//! Most bounds of a search only need to exceed another one, and do so long before they are tight.
//! So a bound is raised in legs of a few steps: at any time it is the value reached, less an
//! estimate of the decrease still possible: twice the prediction of an undamped step or twice the
//! decrease over the last steps. Where an unknown is hardly determined, predictions stay large
//! without a decrease; then, late in a round, four times the decrease over the last leg is
//! subtracted instead.
//!
//! The descent finds a local minimum, so this bounds the result of an estimation from the same
//! guess; it is no proof for other minima.

use crate::estimate::problem::{Problem, VELOCITY_GAP_WEIGHT};
use crate::estimate::schedule::recipe::{self, Lead, Recipe};
use crate::estimate::solve;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::{ArcGuess, Counters, Guess, Scene, Segment, Sketch, VelocityGaps};
use crate::optimise::Program;
use crate::optimise::descend::{DAMPING, Descent, Patience};
use crate::optimise::lagrangian::AugmentedLagrangian;
use crate::optimise::schedule::{self, Schedule};

/// Number of multiplier rounds.
const ROUNDS: usize = 2;
/// Greatest number of steps of a round.
const STEPS: usize = 32;
/// Number of steps of a leg.
const LEG: usize = 4;
/// The decrease still possible is so many times the predicted one, or so many times that of the
/// last leg.
const PROMISES: f64 = 2.0;
const LEGS: f64 = 4.0;
/// A round ends when the decrease still possible is less than this share of the value, or when a
/// step gains less than this share of the schedule's gain; a sweep ends earlier.
const SHARE: f64 = 1e-3;
const GAIN: f64 = 1e-3;
const SWEEP_GAIN: f64 = 0.1;

/// A part of a performance: some arcs, with those collisions that tie two of them and whose
/// contacts the scene names.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The performance.
    pub sketch: &'a Sketch,
    /// All of its segments.
    pub segments: &'a [Segment],
    /// The arcs (indices into `segments`).
    pub arcs: &'a [usize],
    /// Where to start; has an arc for each of `segments`.
    pub guess: &'a Guess,
    /// Whether priors of parameters are included; in a sum of bounds they may be only once.
    pub own_priors: bool,
}

/// A lower bound that further work can raise.
#[derive(Clone, Debug)]
pub struct Bound {
    /// Lower bound of half the sum of squared residuals.
    pub cost: f64,
    /// The bound from completed rounds.
    floor: f64,
    stage: BoundStage,
    place: Option<SearchStanding>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BoundStage {
    Sweep { steps: usize },
    Round { number: usize, steps: usize },
    Done,
}

/// The state of a bound between legs.
#[derive(Clone, Debug)]
struct SearchStanding {
    point: Point,
    damping: f64,
    multipliers: Vec<f64>,
}

impl Default for Bound {
    fn default() -> Self {
        Self {
            cost: 0.0,
            floor: 0.0,
            stage: BoundStage::Sweep { steps: 0 },
            place: None,
        }
    }
}

impl Bound {
    /// Whether further work cannot raise it.
    pub fn is_done(&self) -> bool {
        self.stage == BoundStage::Done
    }

    /// Raises it, always with the same part and recipe, until it is above `ceiling` or cannot be
    /// raised; returns the work done.
    ///
    /// # Panics
    /// Where two of the arcs meet at a collision that is open, or without an arc; with a recipe that has no sweep.
    pub fn tighten(&mut self, part: &Part, ceiling: f64, recipe: &Recipe) -> Counters {
        if self.is_done() {
            return Counters::default();
        }
        let (problem, guess) = part.problem();
        if problem.sample_count() == 0 {
            // Flights without samples cost nothing.
            self.stage = BoundStage::Done;
            return Counters::default();
        }
        let layout = Layout::new(&problem);
        let start = Point::new(&problem, &guess);
        let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &start);
        let (least, most) = context.information();
        let schedule = recipe.schedule.scaled(least, most);
        let lead = Lead::new(&context, &start, recipe);
        let weight = *schedule.sweep_weights.last().expect("a sweep");
        let leading = lead.guidance(schedule::Stage::Sweep { weight });
        let exact = Guidance::none();
        let mut run = match self.place.take() {
            Some(place) => {
                Tightening::resumed(&context, self.stage, &leading, &exact, &schedule, place)
            }
            None => Tightening::new(&context, &leading, &schedule, start),
        };
        let is_tied = !run.lagrangian.multipliers.is_empty();
        if !is_tied && self.stage == (BoundStage::Sweep { steps: 0 }) {
            self.begin_round(&mut run, 0, &exact, &schedule);
        }
        while self.stage != BoundStage::Done && self.cost <= ceiling {
            match self.stage {
                BoundStage::Sweep { steps } => {
                    self.sweep(&mut run, steps, &leading, &exact, &schedule)
                }
                BoundStage::Round { number, steps } => {
                    let is_last = number + 1 == ROUNDS || !is_tied;
                    self.round(&mut run, number, steps, is_last, &exact, &schedule);
                }
                BoundStage::Done => {}
            }
        }
        let mut counters = Counters::default();
        solve::add(&mut counters, &run.descent.work, 0);
        if self.stage != BoundStage::Done {
            self.place = Some(run.place());
        }
        counters
    }

    fn sweep(
        &mut self,
        run: &mut Tightening,
        steps: usize,
        leading: &Guidance,
        exact: &Guidance,
        schedule: &Schedule,
    ) {
        let (taken, gained) = run.leg(leading, SWEEP_GAIN * schedule.gain);
        let may_gain = run.may_gain(gained, false);
        let steps = steps + LEG;
        if leading.event_sd_s.is_none() {
            // Apart from the leading approach speeds, this is a relaxed problem, too.
            let mut lagrangian = run.lagrangian.clone();
            lagrangian.leading_weight = f64::MIN_POSITIVE;
            let value = lagrangian.merit(&run.descent.system) - may_gain;
            self.cost = self.floor.max(value);
        }
        self.stage = BoundStage::Sweep { steps };
        if taken < LEG || steps >= schedule.sweep_steps {
            self.begin_round(run, 0, exact, schedule);
        }
    }

    fn begin_round(
        &mut self,
        run: &mut Tightening,
        number: usize,
        exact: &Guidance,
        schedule: &Schedule,
    ) {
        if number == 0 {
            run.descent.refresh(exact);
            run.lagrangian =
                AugmentedLagrangian::new(&run.descent.system, schedule.multiplier_weight);
        } else {
            run.lagrangian.update(&run.descent.system);
        }
        run.descent.damping = run.descent.damping.clamp(DAMPING.0, DAMPING.1);
        self.stage = BoundStage::Round { number, steps: 0 };
    }

    fn round(
        &mut self,
        run: &mut Tightening,
        number: usize,
        steps: usize,
        is_last: bool,
        exact: &Guidance,
        schedule: &Schedule,
    ) {
        let (taken, gained) = run.leg(exact, GAIN * schedule.gain);
        let may_gain = run.may_gain(gained, steps > 0);
        let steps = steps + LEG;
        let value = run.lagrangian.dual(&run.descent.system) - may_gain;
        if value.is_finite() {
            self.cost = self.floor.max(value);
        }
        self.stage = BoundStage::Round { number, steps };
        if taken < LEG || may_gain < SHARE * value || steps >= STEPS {
            self.floor = self.cost;
            if is_last {
                self.stage = BoundStage::Done;
            } else {
                self.begin_round(run, number + 1, exact, schedule);
            }
        }
    }
}

/// A descent in progress.
struct Tightening<'a> {
    descent: Descent<'a, SolveContext<'a>>,
    lagrangian: AugmentedLagrangian,
}

impl<'a> Tightening<'a> {
    fn new(
        context: &'a SolveContext<'a>,
        leading: &Guidance,
        schedule: &Schedule,
        start: Point,
    ) -> Self {
        let mut descent = Descent::new(context, start);
        descent.refresh(leading);
        descent.damping = descent.damping.clamp(DAMPING.0, DAMPING.1);
        let lagrangian = leading_price(&descent, schedule);
        Self {
            descent,
            lagrangian,
        }
    }

    fn resumed(
        context: &'a SolveContext<'a>,
        stage: BoundStage,
        leading: &Guidance,
        exact: &Guidance,
        schedule: &Schedule,
        place: SearchStanding,
    ) -> Self {
        let is_sweep = matches!(stage, BoundStage::Sweep { .. });
        let guidance = if is_sweep { leading } else { exact };
        let mut descent = Descent::new(context, place.point);
        descent.refresh(guidance);
        descent.damping = place.damping;
        let mut lagrangian = if is_sweep {
            leading_price(&descent, schedule)
        } else {
            AugmentedLagrangian::new(&descent.system, schedule.multiplier_weight)
        };
        lagrangian.multipliers = place.multipliers;
        Self {
            descent,
            lagrangian,
        }
    }

    /// Takes a leg; returns the number of steps, and the decrease over each half of them.
    fn leg(&mut self, guidance: &Guidance, gain: f64) -> (usize, [f64; 2]) {
        let steps = LEG / 2;
        let (mut taken, mut gained) = (0, [0.0; 2]);
        for half in &mut gained {
            let before = self.lagrangian.merit(&self.descent.system);
            let patience = Patience { steps, gain };
            let of_half = self
                .descent
                .go_on(guidance, &self.lagrangian, patience, &mut |_| false);
            taken += of_half;
            *half = before - self.lagrangian.merit(&self.descent.system);
            if of_half < steps {
                break;
            }
        }
        (taken, gained)
    }

    /// What may be gained beyond, after a leg whose halves gained that.
    fn may_gain(&mut self, [early, late]: [f64; 2], is_late: bool) -> f64 {
        let promised = PROMISES * self.descent.promise(&self.lagrangian).max(late);
        let gained = early + late;
        // A leg of which no step was accepted says nothing.
        if is_late && gained > 0.0 {
            promised.min(LEGS * gained)
        } else {
            promised
        }
    }

    fn place(self) -> SearchStanding {
        SearchStanding {
            point: self.descent.point,
            damping: self.descent.damping,
            multipliers: self.lagrangian.multipliers,
        }
    }
}

fn leading_price(descent: &Descent<SolveContext>, schedule: &Schedule) -> AugmentedLagrangian {
    let mut lagrangian = AugmentedLagrangian::new(&descent.system, schedule.sweep_weights[0]);
    lagrangian.leading_weight = lagrangian.weight.max(schedule.multiplier_weight / 10.0);
    lagrangian
}

impl Part<'_> {
    /// The relaxed problem, and the guess of its arcs.
    fn problem(&self) -> (Problem, Guess) {
        let (all, scene) = (self.segments, self.scene);
        let part: Vec<Segment> = self.arcs.iter().map(|i| all[*i].clone()).collect();
        let arcs: Vec<ArcGuess> = self
            .arcs
            .iter()
            .map(|i| self.guess.arcs[*i].clone())
            .collect();
        let guess = Guess {
            arcs,
            event_times_s: self.guess.event_times_s.clone(),
            parameters: self.guess.parameters.clone(),
        };
        let mut problem = Problem::new(scene, self.sketch, &part);
        for (event, is_free) in problem.event_is_free.iter_mut().enumerate() {
            let bounds_an_arc = |arc: &crate::estimate::problem::Arc| {
                arc.start == Some(event) || arc.end == Some(event)
            };
            let is_waypoint = problem.waypoints.iter().any(|of| of.event == event);
            *is_free &= is_waypoint || problem.arcs.iter().any(bounds_an_arc);
        }
        // A condition is bounded where all that it depends on is here; the others cost nothing.
        let is_here = |event: usize| {
            let mut arcs = problem.arcs.iter();
            arcs.any(|arc| arc.start == Some(event) || arc.end == Some(event))
                || problem.waypoints.iter().any(|of| of.event == event)
        };
        let own_times = self.own_priors;
        let conditions = std::mem::take(&mut problem.conditions).into_iter();
        let kept = conditions.filter(|of| {
            let is_of_times = of.arcs.is_empty() && of.is_soft();
            of.events().all(is_here) && (own_times || !is_of_times)
        });
        problem.conditions = kept.collect();
        let goals = std::mem::take(&mut problem.goals).into_iter();
        problem.goals = goals.filter(|of| is_here(of.event)).collect();
        if !self.own_priors {
            for free in &mut problem.parameters {
                free.prior_sd = None;
            }
        }
        if scene.velocity_gaps == VelocityGaps::Always {
            // Its Lagrangian is that of the whole performance.
            let samples = |of: &[Segment]| {
                let counts = of.iter().map(Segment::sample_count);
                let seen = counts.clone().filter(|count| *count > 0).count();
                counts.sum::<usize>() as f64 / seen.max(1) as f64
            };
            let information = problem.information() * samples(all) / samples(&part);
            problem.velocity_gap_weight = Some(VELOCITY_GAP_WEIGHT * information);
        }
        (problem, guess)
    }
}
