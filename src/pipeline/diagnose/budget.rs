//! What diagnoses may cost: so many times the work of the estimation, counted and not timed, so that the same take gives
//! the same diagnoses on every machine.

use crate::motion::Observer;

/// Work of all tries over that of the estimation.
const SHARE: usize = 10;
/// Work that is allowed however little the estimation took: a fifth of a second for a usual take.
const LEAST: usize = 1_200;
/// Work of cleaning, cutting and guessing a take again.
const TRY: usize = 6;
/// Work of one try at most.
const OF_ONE: usize = 100;

/// What is left of the work that diagnoses may cost. The unit is an iteration: a look whether the run should stop.
pub(super) struct Budget<'a> {
    observer: &'a mut dyn Observer,
    left: usize,
}

impl<'a> Budget<'a> {
    /// All of it, where the estimation took so much.
    pub(super) fn beside(work: usize, observer: &'a mut dyn Observer) -> Self {
        Self {
            observer,
            left: work.saturating_mul(SHARE).max(LEAST),
        }
    }

    /// Whether nothing is left, or the run is to end.
    pub(super) fn is_over(&mut self) -> bool {
        self.left == 0 || self.observer.should_stop()
    }

    /// Takes what preparing a try costs.
    pub(super) fn prepare(&mut self) {
        self.left = self.left.saturating_sub(TRY);
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
        self.left = self.left.saturating_sub(1);
        self.budget.left = self.budget.left.saturating_sub(1);
        self.left == 0 || self.budget.is_over()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tries_share_what_is_left_and_each_has_its_own_end() {
        let mut observer = ();
        let mut budget = Budget::beside(0, &mut observer);
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
        assert_eq!(tries, LEAST.div_ceil(TRY + OF_ONE));
        let mut observer = ();
        assert_eq!(Budget::beside(700, &mut observer).left, 7_000);
    }
}
