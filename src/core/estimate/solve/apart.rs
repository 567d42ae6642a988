//! A motion whose solids go into each other, solved again with distances that they must keep.

use super::{Posed, Solved, add};
use crate::estimate::constraint::At;
use crate::estimate::posing::clearance::Overlapping;
use crate::estimate::problem::clearance::Clearance;
use crate::estimate::schedule::recipe::{self, Recipe};
use crate::motion::{About, Doubt, Observer, Penetration, Performance, Place};

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
        let mut clearances = self.kept(&overlapping);
        let before = clearances.len();
        let mut is_told = false;
        for found in found {
            let Some(of) = overlapping.clearance(found) else {
                continue;
            };
            is_told = true;
            let is_same = |other: &&mut Clearance| {
                (other.link, other.against) == (of.link, of.against)
                    && (other.around_s - of.around_s).abs() <= other.reach_s.max(of.reach_s)
            };
            match clearances[..before].iter_mut().find(is_same) {
                Some(other) => {
                    *other = Clearance {
                        depth_m: of.depth_m.max(other.depth_m),
                        ..of
                    }
                }
                None => clearances.push(of),
            }
        }
        if !is_told {
            return false;
        }
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
        let doubts = held.map(|(of, _)| Doubt {
            about: About::KeptOut,
            place: Place::Inside {
                link: of.link,
                against: of.against,
                time_s: of.least(&at).map_or(of.around_s, |least| least.time_s),
            },
            value: of.depth_m,
            bound: tolerance_m,
        });
        doubts.collect()
    }

    /// The distances that are kept, each with whether it holds the motion: their rows are the last.
    fn clearances(&self) -> impl Iterator<Item = (&Clearance, bool)> {
        let clearances = &self.posed.problem.clearances;
        let rows = self.solution.multipliers.len() - clearances.len();
        let pulls = &self.solution.multipliers[rows..];
        clearances.iter().zip(pulls.iter().map(|pull| *pull != 0.0))
    }

    /// The distances that are kept already, with the features that are nearest now where they hold the motion.
    fn kept(&self, overlapping: &Overlapping) -> Vec<Clearance> {
        let at = At::new(&self.posed.problem, &self.solution.point, &self.epochs_s);
        let kept = self.clearances().map(|(of, is_held)| {
            let mut of = of.clone();
            if let Some(least) = of.least(&at) {
                of.around_s = least.time_s;
            }
            let nearest = Penetration {
                link: of.link,
                against: of.against,
                time_s: of.around_s,
                depth_m: f64::NAN,
                point_m: nalgebra::Vector3::zeros(),
            };
            let again = is_held.then(|| overlapping.clearance(&nearest));
            let depth_m = of.depth_m;
            Clearance {
                depth_m,
                ..again.flatten().unwrap_or(of)
            }
        });
        kept.collect()
    }
}
