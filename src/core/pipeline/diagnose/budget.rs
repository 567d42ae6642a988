//! What diagnoses may cost: so many times the work of the estimation, counted and not timed, so that the same take gives
//! the same diagnoses on every machine.

use crate::motion::{EventKind, Observer, Scene, TakeEvent};

/// Work of all tries over that of the estimation.
const SHARE: usize = 10;
/// Work that is allowed however little the estimation took, of a take of so many samples and fewer: about a fifth of a
/// second. An iteration of one with more samples takes as much longer.
const LEAST: usize = 1_000;
const SAMPLES: usize = 500;
/// Work of cleaning, cutting and guessing a take, and the same where marks are missing and are looked for.
const PREPARING: usize = 10;
const PROPOSING: usize = 50;
/// Work of one try at most.
const OF_ONE: usize = 100;

/// What is left of the work that diagnoses may cost. The unit is an iteration: a look whether the run should stop.
pub(super) struct Budget<'a> {
    observer: &'a mut dyn Observer,
    left: usize,
    of_preparing: usize,
}

impl<'a> Budget<'a> {
    /// All of it, where the estimation of the take took so many iterations.
    pub(super) fn beside(
        work: usize,
        scene: &Scene,
        events: &[TakeEvent],
        observer: &'a mut dyn Observer,
    ) -> Self {
        let marks = events.iter().filter(|event| event.mark().is_some()).count();
        let wanted = scene.events.iter().map(|event| match &event.kind {
            EventKind::Collisions { least, .. } => *least,
            _ => 1,
        });
        let of_preparing = match marks < wanted.sum() {
            true => PROPOSING,
            false => PREPARING,
        };
        let samples = (events.len() - marks).max(SAMPLES);
        let least = LEAST * SAMPLES / samples;
        Self {
            observer,
            left: work
                .saturating_add(of_preparing)
                .saturating_mul(SHARE)
                .max(least),
            of_preparing,
        }
    }

    /// Whether nothing is left, or the run is to end.
    pub(super) fn is_over(&mut self) -> bool {
        self.left == 0 || self.observer.should_stop()
    }

    /// Takes what preparing a try costs.
    pub(super) fn prepare(&mut self) {
        self.left = self.left.saturating_sub(self.of_preparing);
    }

    /// An observer of one try, which it ends where it takes many more iterations than a motion that fits.
    pub(super) fn of_one(&mut self) -> OfOne<'_, 'a> {
        OfOne {
            budget: self,
            left: OF_ONE,
        }
    }
}

/// What is left for one try.
pub(super) struct OfOne<'b, 'a> {
    budget: &'b mut Budget<'a>,
    left: usize,
}

impl Observer for OfOne<'_, '_> {
    fn should_stop(&mut self) -> bool {
        self.worked(0)
    }

    fn worked(&mut self, looks: usize) -> bool {
        self.left = self.left.saturating_sub(1);
        self.budget.left = self.budget.left.saturating_sub(1);
        self.budget.observer.worked(looks) || self.left == 0 || self.budget.left == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::scene_from_toml;

    #[test]
    fn tries_share_what_is_left_and_each_has_its_own_end() {
        let scene = include_str!("../../../../config/pencil_tip.toml");
        let scene = scene_from_toml(scene).expect("a scene");
        let mut observer = ();
        let mut budget = Budget::beside(0, &scene, &[], &mut observer);
        let (all, of_preparing) = (budget.left, budget.of_preparing);
        let mut tries = 0;
        while !budget.is_over() {
            budget.prepare();
            let mut one = budget.of_one();
            let mut steps = 0;
            while !one.should_stop() {
                steps += 1;
            }
            assert!(steps < OF_ONE);
            tries += 1;
        }
        assert_eq!(tries, all.div_ceil(of_preparing + OF_ONE));
        let mut observer = ();
        let long = Budget::beside(700, &scene, &[], &mut observer).left;
        assert_eq!(long, SHARE * (700 + of_preparing));
    }
}
