//! Bounds of parts of a sequence.

use crate::estimate::Bound;

/// A bound of some arcs with some open collisions known: the least of those from every guess.
#[derive(Clone, Debug)]
pub(super) struct LowerBound {
    pub(super) is_begun: bool,
    /// Open collisions (places in the field's list) and their candidates.
    pub(super) known: Vec<(usize, usize)>,
    pub(super) arcs: Vec<usize>,
    pub(super) own_priors: bool,
    /// One bound for each guess.
    pub(super) starts: Vec<(usize, Bound)>,
}

impl LowerBound {
    pub(super) fn cost(&self) -> f64 {
        let costs = self.starts.iter().map(|(_, bound)| bound.cost);
        costs.fold(f64::INFINITY, f64::min)
    }

    pub(super) fn is_done(&self) -> bool {
        self.lowest().is_done()
    }

    fn lowest(&self) -> &Bound {
        let (lowest, _) = lowest(&self.starts, |(_, bound)| bound.cost);
        &self.starts[lowest].1
    }
}

/// Index of the lowest of a list that is not empty, and the cost of the second lowest.
pub(super) fn lowest<T>(all: &[T], cost: impl Fn(&T) -> f64) -> (usize, f64) {
    let mut order: Vec<(f64, usize)> = all.iter().map(cost).zip(0..).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    (
        order[0].1,
        order.get(1).map_or(f64::INFINITY, |(cost, _)| *cost),
    )
}
