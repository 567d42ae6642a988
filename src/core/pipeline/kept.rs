//! A motion that is kept, for further questions: how its numbers vary together, and what it becomes with other goals.

use super::outcome::Outcome;
use super::perform::Performed;
use super::stages::doubts_with_overlap;
use crate::estimate::{Deviations, VariedTogether};
use crate::motion::{Observer, Phase, Scene};

/// The motion of one group of bodies by themselves, from which an estimate was made.
#[derive(Clone)]
pub struct KeptMotion(pub(super) Performed);

impl KeptMotion {
    /// How the numbers of its estimate vary together; `None` where it failed.
    pub fn varied_together(&self) -> Option<VariedTogether> {
        let inferred = &self.0.inferred;
        inferred.solved.varied_together(&inferred.scene)
    }

    /// The same take of a scene with other goals, from this motion on: a few steps where they are near. `None` where the scene
    /// differs from the one `taken`, with so many marks, in anything else, or where no motion is found from here. Checked as
    /// previews are: gaps, credibility, overlaps. How certain numbers are is told if that is asked; it takes longer than all else.
    pub fn with_goals_of(
        &self,
        scene: &Scene,
        taken: &Scene,
        marks: usize,
        is_told: bool,
        observer: &mut dyn Observer,
    ) -> Option<(Self, Outcome)> {
        let marked = |scene: &Scene| scene.with_marks(marks).with_flight_clocks();
        let (mut scene, mut taken) = (marked(scene), marked(taken));
        let goals = std::mem::take(&mut scene.goals);
        taken.goals.clear();
        if taken != scene || !scene.rest_goals.is_empty() {
            return None;
        }
        let mut performed = self.0.clone();
        performed.inferred.scene.goals = goals;
        observer.phase(Phase::Finish);
        let (solved, performance) = performed.parts();
        let found = solved.with_goals_of(performance, observer)?;
        performed.inferred.solved = found;
        let of = performed.clone();
        let which = match is_told {
            true => Deviations::OfNumbers,
            false => Deviations::None,
        };
        let mut outcome = Outcome::unchecked(
            of.inferred,
            of.marks_made_s,
            of.sketch,
            of.counts,
            which,
            observer,
        );
        observer.phase(Phase::Verify);
        let doubts = doubts_with_overlap(&outcome, observer);
        outcome.estimate.doubt(doubts);
        observer.phase(Phase::Done);
        Some((Self(performed), outcome))
    }
}
