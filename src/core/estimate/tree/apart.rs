//! A motion of trees whose solids go into each other, solved again with distances that they must keep.

use super::clearance::TreeClearance;
use super::optimum::{Solved, finished};
use super::overlapping::OverlappingTrees;
use crate::estimate::posing::clearance::again::{KeptClearance, just_passed, renewed, with};
use crate::motion::{Doubt, Estimate, Observer, Penetration, Scene};
use crate::optimise::Schedule;

impl Solved {
    /// Goes on to the motion at which the solids that overlap keep out of each other, near where they are deepest, from this
    /// one. Distances that were asked for before are kept, with the features that are nearest now. This one stays, and
    /// the answer is no, where no features tell a distance and where that leads to no optimum.
    ///
    /// `found` are overlaps of this motion, of which the estimate tells, in the scene as estimated.
    pub fn keep_apart(
        &mut self,
        scene: &Scene,
        estimate: &Estimate,
        found: &[Penetration],
        observer: &mut dyn Observer,
    ) -> bool {
        if !self.solution.finished.converged {
            return false;
        }
        let overlapping = OverlappingTrees::new(scene, estimate, self);
        let told: Vec<TreeClearance> = found
            .iter()
            .filter_map(|found| overlapping.clearance(found))
            .collect();
        if told.is_empty() {
            return false;
        }
        let kept = renewed(self.clearances(), |nearest| overlapping.clearance(nearest));
        let mut problem = self.problem.clone();
        problem.clearances = told.into_iter().fold(kept, with);
        let schedules = [
            Schedule::default().from_the_last(),
            Schedule::default().without_sweep(),
        ];
        let mut work = self.solution.work;
        for schedule in schedules {
            let point = &self.solution.point;
            let there = finished(&problem, point, &schedule, &mut work, observer);
            if there.solution.stopped {
                return false;
            }
            if there.solution.finished.converged {
                *self = there;
                return true;
            }
        }
        false
    }

    /// What is held out of something, and only just passes it: as a doubt that is only to be known.
    pub fn just_passed(&self, tolerance_m: f64) -> Vec<Doubt> {
        let held = self.clearances().filter(|of| of.is_held);
        let held: Vec<TreeClearance> = held.map(|of| of.of).collect();
        let least_s = |of: &TreeClearance| self.problem.least_s(of, &self.solution.point);
        just_passed(held.iter(), tolerance_m, least_s)
    }

    /// Whether samples err in time.
    pub fn errs_in_time(&self) -> bool {
        self.problem.errors.is_some()
    }

    /// The distances that are kept.
    fn clearances(&self) -> impl Iterator<Item = KeptClearance<TreeClearance>> {
        let blocks = &self.solution.system.blocks[..self.problem.clearance_block(0)];
        let first: usize = blocks.iter().map(|block| block.values.len()).sum();
        let pulls = &self.solution.multipliers[first..];
        let clearances = self.problem.clearances.iter().zip(pulls);
        clearances.map(|(of, pull)| KeptClearance {
            of: of.clone(),
            is_held: *pull != 0.0,
            least_s: self.problem.least_s(of, &self.solution.point),
        })
    }
}
