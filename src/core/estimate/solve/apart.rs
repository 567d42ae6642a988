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
        let mut held: Vec<&Clearance> = Vec::new();
        for (of, _) in self.clearances().filter(|(_, is_held)| *is_held) {
            if !held.iter().any(|other| other.is_beside(of)) {
                held.push(of);
            }
        }
        let doubts = held.into_iter().map(|of| Doubt {
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

    /// The distances that are kept already: where they hold the motion, of the features that are nearest now, unless these
    /// are at the same face and the others stay where they are.
    fn kept(&self, overlapping: &Overlapping) -> Vec<Clearance> {
        let at = At::new(&self.posed.problem, &self.solution.point, &self.epochs_s);
        let mut kept: Vec<Clearance> = Vec::new();
        for (of, is_held) in self.clearances() {
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
            let again = again.flatten().filter(|again| !again.shares_face(&of));
            let of = Clearance {
                depth_m: of.depth_m,
                ..again.unwrap_or(of)
            };
            let is_kept = |other: &Clearance| other.is_beside(&of) && other.touches == of.touches;
            if !kept.iter().any(is_kept) {
                kept.push(of);
            }
        }
        kept
    }
}

/// Clearances with another one. Of those of the same solids at about the same time stay those at the same face: where a box
/// comes down on a plate each of its corners must keep out. Beside another face they would ask for too much.
fn with(clearances: Vec<Clearance>, of: Clearance) -> Vec<Clearance> {
    let (beside, mut all): (Vec<Clearance>, Vec<Clearance>) = clearances
        .into_iter()
        .partition(|other| other.is_beside(&of));
    let depth_m = beside.iter().map(|other| other.depth_m);
    let depth_m = depth_m.fold(of.depth_m, f64::max);
    let stays = |other: &Clearance| other.shares_face(&of) && other.touches != of.touches;
    all.extend(beside.into_iter().filter(stays));
    all.push(Clearance { depth_m, ..of });
    all
}
