//! Order of the events about a flight that few samples hold apart, `τ_{k+1} − τ_k ≥ 0` (paper eq. 7).

use super::kind::{At, Constraint, Filled};
use crate::estimate::problem::{Ordered, Problem, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::optimise::block::{Block, BlockPattern};

impl Constraint for Ordered {
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let columns = self.events.iter().filter_map(|event| layout.events[*event]);
        let pattern = BlockPattern::dense(1, columns.collect());
        [pattern, BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        let [from_s, to_s] = self.events.map(|event| at.point.event_times_s[event]);
        block.reset(pattern);
        block.values[0] = (to_s - from_s) / unit::TIME_S;
        block.bounds[0] = (0.0, f64::INFINITY);
        let by = [-1.0, 1.0].map(|sign| sign / unit::TIME_S);
        block.derivatives_mut(pattern, 0).copy_from_slice(&by);
    }

    fn places(&self, _: &Block) -> Vec<std::ops::Range<usize>> {
        Vec::new()
    }
}
