//! Problems with more parameters.

use crate::estimate::context::SolveContext;
use crate::estimate::layout::Layout;
use crate::estimate::point::Point;
use crate::estimate::problem::Problem;
use crate::motion::{FreeParameter, Scene, Segment, Sketch};

/// A problem with more parameters than that of a solution.
pub(super) struct Wider {
    pub(super) problem: Problem,
    pub(super) layout: Layout,
    /// The first of them among the parameters,
    pub(super) first: usize,
    /// and all.
    pub(super) added: Vec<FreeParameter>,
}

impl Wider {
    pub(super) fn new(
        context: &SolveContext,
        (scene, sketch, segments): (&Scene, &Sketch, &[Segment]),
        added: Vec<FreeParameter>,
    ) -> Self {
        let mut wider = scene.clone();
        wider.parameters.extend(added.iter().cloned());
        let mut problem = Problem::new(&wider, sketch, segments);
        problem.velocity_gap_weight = context.problem.velocity_gap_weight;
        Self {
            layout: Layout::new(&problem),
            problem,
            first: scene.parameters.len(),
            added,
        }
    }

    /// A point without the added parameters.
    pub(super) fn narrowed(&self, wide: &Point) -> Point {
        let mut point = wide.clone();
        point.parameters.truncate(self.first);
        point
    }

    /// A point of the narrower problem, with the added parameters as they begin.
    pub(super) fn point(&self, narrow: &Point) -> Point {
        let mut point = narrow.clone();
        let initial = self.added.iter().map(|free| free.initial);
        point.parameters.extend(initial);
        point
    }
}
