//! Motions near the best one, simulated from first states near its own.

use std::cell::OnceCell;

use nalgebra::DVector;

use super::simulate::simulate;
use super::{Solved, add, covariance};
use crate::estimate::covariance::whitened::Whitened;
use crate::estimate::outcome;
use crate::estimate::problem::pull::Pull;
use crate::estimate::problem::unit;
use crate::estimate::schedule::recipe::{self, Recipe, Solution};
use crate::estimate::terms::context::Guidance;
use crate::estimate::unknowns::point::Point;
use crate::motion::{Counters, End, MechanismIndex, Observer, Performance};
use crate::optimise::Program;

/// Units of a state's parts.
const UNITS: [f64; 4] = [
    unit::POSITION_M,
    unit::ORIENTATION_RAD,
    unit::VELOCITY_M_S,
    unit::ANGULAR_VELOCITY_RAD_S,
];

/// Weight of the pulls that hold states while sample times are solved for, relative to the samples of
/// an arc.
const HELD: f64 = 1e4;
/// Greatest distance of a state from where it is held, in the constraints' units,
const THERE: f64 = 1e-9;
/// and the greatest number of times that pulls are corrected for it.
const CORRECTIONS: usize = 8;

impl Solved {
    /// Whitened coordinates of the states of the first flights of some mechanisms; `None` where the
    /// problem is singular.
    pub fn first_flights(&self, mechanisms: &[MechanismIndex]) -> Option<Vec<Whitened>> {
        let (problem, point) = (&self.posed.problem, &self.solution.point);
        let context = self.posed.context(self.epochs_s.clone(), point);
        let system = &self.solution.system;
        let covariance = covariance(&context, &self.solution, None)?;
        let of = |mechanism: &MechanismIndex| {
            let mut arcs = problem.arcs.iter();
            let arc = arcs.position(|arc| arc.mechanism == *mechanism)?;
            Whitened::new(&context, system, &covariance, arc, &point.arcs[arc])
        };
        mechanisms.iter().map(of).collect()
    }

    /// Whether physical times of samples are unknowns.
    pub fn times_are_unknown(&self) -> bool {
        self.posed.problem.times_are_unknown()
    }

    /// The motion simulated from other first flights: at whitened coordinates `z`, with parameters
    /// and sample times as they are. `None` where a collision would not happen.
    pub fn simulated(
        &self,
        performance: Performance,
        flights: &[(&Whitened, DVector<f64>)],
    ) -> Option<Self> {
        let mut point = self.solution.point.clone();
        for (flight, z) in flights {
            point.arcs[flight.arc] = flight.state(z);
        }
        let point = simulate(&self.posed.problem, &self.epochs_s, point)?;
        Some(self.with(performance, point, self.estimate.counters))
    }

    /// The motion, simulated from this one's first flights, with sample times that fit it best; `None`
    /// where none are found.
    pub fn with_sample_times(
        &self,
        performance: Performance,
        observer: &mut dyn Observer,
    ) -> Option<Self> {
        let mut problem = self.posed.problem.clone();
        let weight = HELD * problem.sample_count() as f64 / problem.arcs.len() as f64;
        let arcs = self.solution.point.arcs.iter().enumerate();
        let pulls = arcs.map(|(arc, state)| Pull::new(arc, *state, weight, UNITS));
        problem.pulls = pulls.collect();
        let mut point = self.solution.point.clone();
        let mut counters = self.estimate.counters;
        for _ in 0..CORRECTIONS {
            let recipes = [
                Recipe::default().from_the_last(),
                Recipe::default().without_sweep(),
            ];
            let found = recipes.iter().find_map(|recipe| {
                let layout = &self.posed.layout;
                let solution = recipe::solve_from(
                    &problem,
                    layout,
                    point.clone(),
                    self.epochs_s.clone(),
                    recipe,
                    observer,
                );
                add(&mut counters, &solution.work, 0);
                solution.finished.converged.then_some(solution)
            });
            point = found?.point;
            let mut most: f64 = 0.0;
            for pull in &mut problem.pulls {
                let miss = pull.miss(&point.arcs[pull.arc]);
                most = most.max(miss.amax());
                pull.left += miss;
            }
            if most <= THERE {
                break;
            }
        }
        // What was held is as it was, to rounding; sample times alone are new.
        for (state, held) in point.arcs.iter_mut().zip(&self.solution.point.arcs) {
            *state = *held;
        }
        let held = &self.solution.point;
        point.event_times_s.clone_from(&held.event_times_s);
        point.parameters.clone_from(&held.parameters);
        Some(self.with(performance, point, counters))
    }

    /// The estimate of another point of the same problem, which need not be an optimum.
    fn with(&self, performance: Performance, point: Point, counters: Counters) -> Self {
        let posed = &self.posed;
        let context = posed.context(self.epochs_s.clone(), &point);
        let system = context.evaluated(&Guidance::none(), &point);
        let mut finished = self.solution.finished;
        finished.violation = system.violation();
        finished.decrease = 0.0;
        finished.converged = finished.violation <= finished.tolerances.violation;
        let solution = Solution {
            point,
            system,
            finished,
            ..self.solution.clone()
        };
        let errors = outcome::errors(&posed.problem, &context, &solution.point);
        let mut estimate = outcome::estimate(
            performance.scene,
            performance.sketch,
            &context,
            &solution,
            &errors,
            counters,
        );
        if let End::Converged(progress) = estimate.reason.end {
            estimate.reason.end = End::Simulated(progress);
        }
        Self {
            estimate,
            posed: posed.clone(),
            epochs_s: self.epochs_s.clone(),
            solution,
            errors,
            in_time: OnceCell::new(),
        }
    }
}
