//! The motion of the same performance with other goals, from the one that was found on: what an editor asks for again and again.

use super::{Posed, Solved, add};
use crate::estimate::posing::Nodes;
use crate::estimate::problem::Problem;
use crate::motion::{Observer, Performance, Verdict};

impl Solved {
    /// The motion with the goals of the performance's scene, which differs from this one's in nothing else; `None` where this is
    /// none, or that is not found from here. Samples weigh as they do in this one.
    pub fn with_goals_of(
        &self,
        performance: Performance,
        observer: &mut dyn Observer,
    ) -> Option<Self> {
        if self.estimate.verdict == Verdict::Failed {
            return None;
        }
        let posed = Posed::new(self.problem_of(performance));
        let solution = posed.solved_near(&self.solution.point, &self.epochs_s, observer)?;
        let mut counters = Default::default();
        add(&mut counters, &solution.work, 1);
        Some(self.with_solution(posed, solution, performance, counters))
    }

    /// This problem with those goals.
    fn problem_of(&self, performance: Performance) -> Problem {
        let Performance {
            scene,
            sketch,
            segments,
        } = performance;
        let own = &self.posed.problem;
        let is_paced = own.weave.is_some() && own.times_are_unknown();
        let other = match is_paced {
            true => Problem::at_nodes(scene, sketch, segments, Nodes::of_paces(sketch, segments)),
            false => Problem::new(scene, sketch, segments),
        };
        let other = match &own.weave {
            Some(weave) => other.woven_as(weave),
            None => other,
        };
        Problem {
            clearances: own.clearances.clone(),
            velocity_gap_weight: own.velocity_gap_weight,
            ..other
        }
    }
}
