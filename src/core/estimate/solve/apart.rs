//! A motion whose solids go into each other, solved again with distances that they must keep.

use super::{Posed, Solved, add};
use crate::estimate::constraint::At;
use crate::estimate::posing::clearance::Overlapping;
use crate::estimate::posing::clearance::again::{KeptClearance, just_passed, renewed, with};
use crate::estimate::problem::clearance::Clearance;
use crate::estimate::schedule::recipe::{self, Recipe};
use crate::motion::{Doubt, Observer, Penetration, Performance};

impl Solved {
    /// Goes on to the motion at which the solids that overlap keep out of each other, near where they are deepest, from this
    /// one. Distances that were asked for before are kept, with the features that are nearest now. This one stays, and
    /// the answer is no, where no features tell a distance and where that leads to no optimum.
    ///
    /// `found` are overlaps of this motion, as [`verify`](crate::verify) finds them. Flights with clocks of their own stay.
    pub fn keep_apart(
        &mut self,
        performance: Performance,
        found: &[Penetration],
        observer: &mut dyn Observer,
    ) -> bool {
        let problem = &self.posed.problem;
        if !self.solution.finished.converged || problem.arcs.iter().any(|arc| arc.clock.is_some()) {
            return false;
        }
        let scene = performance.scene.as_estimated(&self.estimate);
        let overlapping = Overlapping {
            scene: &scene,
            estimate: &self.estimate,
            problem,
        };
        let told: Vec<Clearance> = found
            .iter()
            .filter_map(|found| overlapping.clearance(found))
            .collect();
        if told.is_empty() {
            return false;
        }
        let kept = self.kept(&overlapping);
        let clearances = told.into_iter().fold(kept, with);
        let mut problem = problem.clone();
        problem.clearances = clearances;
        let posed = Posed::new(problem);
        let recipes = [
            Recipe::default().from_the_last(),
            Recipe::default().without_sweep(),
        ];
        let mut counters = self.estimate.counters;
        for recipe in recipes {
            let solution = recipe::solve_from(
                &posed.problem,
                &posed.layout,
                self.solution.point.clone(),
                self.epochs_s.clone(),
                &recipe,
                observer,
            );
            add(&mut counters, &solution.work, 0);
            self.estimate.counters = counters;
            if solution.stopped {
                return false;
            }
            if !solution.finished.converged {
                continue;
            }
            let there = self.with_solution(posed.clone(), solution, performance, counters);
            if there.estimate.verdict == self.estimate.verdict {
                *self = there;
                return true;
            }
        }
        false
    }

    /// What is held out of something, and only just passes it: as a doubt that is only to be known.
    pub fn just_passed(&self, tolerance_m: f64) -> Vec<Doubt> {
        let at = At::new(&self.posed.problem, &self.solution.point, &self.epochs_s);
        let held = self.clearances().filter(|(_, is_held)| *is_held);
        let held = held.map(|(of, _)| of);
        just_passed(held, tolerance_m, |of| Some(of.least(&at)?.time_s))
    }

    /// The distances that are kept, each with whether it holds the motion: their rows are the last.
    fn clearances(&self) -> impl Iterator<Item = (&Clearance, bool)> {
        let clearances = &self.posed.problem.clearances;
        let rows = self.solution.multipliers.len() - clearances.len();
        let pulls = &self.solution.multipliers[rows..];
        clearances.iter().zip(pulls.iter().map(|pull| *pull != 0.0))
    }

    /// The distances that are kept already, [`renewed`].
    fn kept(&self, overlapping: &Overlapping) -> Vec<Clearance> {
        let at = At::new(&self.posed.problem, &self.solution.point, &self.epochs_s);
        let all = self.clearances().map(|(of, is_held)| KeptClearance {
            of: of.clone(),
            is_held,
            least_s: of.least(&at).map(|least| least.time_s),
        });
        renewed(all, |nearest| overlapping.clearance(nearest))
    }
}
