//! Problems with more parameters.

use crate::estimate::posing::Nodes;
use crate::estimate::problem::Problem;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::{FreeParameter, Performance, Quantity, Scene};

/// A problem with more parameters than that of a solution.
pub(super) struct Wider {
    pub(super) problem: Problem,
    pub(super) layout: Layout,
    /// The first of them among the parameters.
    pub(super) first: usize,
    added: Vec<FreeParameter>,
}

/// A quantity set free without bounds, whose rows the solution's multipliers do not have.
pub(super) fn unbounded(scene: &Scene, quantity: Quantity) -> FreeParameter {
    FreeParameter {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        ..scene.freed(quantity, scene.value_of(quantity))
    }
}

impl Wider {
    pub(super) fn new(
        context: &SolveContext,
        performance: Performance,
        added: Vec<FreeParameter>,
    ) -> Self {
        let mut wider = performance.scene.clone();
        wider.parameters.extend(added.iter().cloned());
        let nodes = Nodes {
            acted_s: context.problem.nodes_acted_s.clone(),
            samples_each: context.problem.tempo_counts,
        };
        let Performance {
            sketch, segments, ..
        } = performance;
        let mut problem = Problem::at_nodes(&wider, sketch, segments, nodes);
        problem.velocity_gap_weight = context.problem.velocity_gap_weight;
        if let Some(weave) = &context.problem.weave {
            problem = problem.woven_as(weave);
        }
        Self {
            layout: Layout::new(&problem),
            problem,
            first: performance.scene.parameters.len(),
            added,
        }
    }

    /// A point of the narrower problem, with the added parameters as they begin.
    pub(super) fn point(&self, narrow: &Point) -> Point {
        let mut point = narrow.clone();
        let initial = self.added.iter().map(|free| free.initial);
        point.parameters.extend(initial);
        point
    }
}
