//! A bound of an event's time `τ`, given as an acted time `a`:
//!
//! ```text
//! τ − t(a) ≥ 0,  ≤ 0  or  = 0
//! ```
//!
//! Where stamps are physical times `t(a) = a`. Where they are not, the time map `t` is linear
//! between two nodes, and nodes are unknowns: the row is linear in all of them.

use super::kind::{At, Constraint, Filled};
use crate::estimate::problem::{Problem, TimeBound, TimeSide, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::optimise::block::{Block, BlockPattern};

impl Constraint for TimeBound {
    /// The event's time, then those of the nodes that are unknowns.
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let nodes = self.nodes.into_iter().flatten();
        let columns = layout.events[self.event].into_iter();
        let columns = columns.chain(nodes.filter_map(|node| layout.nodes[node]));
        let pattern = BlockPattern::dense(1, columns.collect());
        [pattern, BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        let (time_s, shares) = self.mapped(at.problem, at.point);
        block.reset(pattern);
        block.values[0] = (at.point.event_times_s[self.event] - time_s) / unit::TIME_S;
        block.bounds[0] = match self.side {
            TimeSide::Earliest => (0.0, f64::INFINITY),
            TimeSide::Latest => (f64::NEG_INFINITY, 0.0),
            TimeSide::Only => (0.0, 0.0),
        };
        // The first node of all is no unknown: it is the zero of time.
        let nodes = self.nodes.into_iter().flatten().zip(shares);
        let by_nodes = nodes.filter_map(|(node, share)| (node > 0).then_some(-share));
        let by = [1.0].into_iter().chain(by_nodes);
        for (entry, by) in block.derivatives_mut(pattern, 0).iter_mut().zip(by) {
            *entry = by / unit::TIME_S;
        }
    }

    fn event(&self) -> Option<usize> {
        Some(self.event)
    }

    fn time_gap_s(&self, rows: &Block) -> f64 {
        rows.violation(0).abs() * unit::TIME_S
    }

    fn half_width(&self, _: &Block) -> Option<f64> {
        (self.side != TimeSide::Only).then_some(self.half_width_s / unit::TIME_S)
    }
}

impl TimeBound {
    /// The physical time at which it is \[s\].
    pub fn time_s(&self, problem: &Problem, point: &Point) -> f64 {
        self.mapped(problem, point).0
    }

    /// That time, and its derivatives by the times of both nodes.
    fn mapped(&self, problem: &Problem, point: &Point) -> (f64, [f64; 2]) {
        let Some(nodes) = self.nodes else {
            return (self.acted_s, [0.0; 2]);
        };
        let [from_s, to_s] = nodes.map(|node| point.node_times_s[node]);
        let [acted_from_s, acted_to_s] = nodes.map(|node| problem.nodes_acted_s[node]);
        let share = (self.acted_s - acted_from_s) / (acted_to_s - acted_from_s);
        (from_s + share * (to_s - from_s), [1.0 - share, share])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::estimate::schedule::recipe::epochs_s;
    use crate::estimate::terms::context::{Guidance, SolveContext};
    use crate::estimate::tests::{scene, sketch};
    use crate::motion::Timing;
    use crate::optimise::Program;

    #[test]
    fn a_bound_is_a_place_in_acted_time_at_any_tempo() {
        let unknown = Timing::Unknown {
            tempo_sd_per_sqrt_s: 0.5,
        };
        for timing in [Timing::Known, unknown] {
            let mut scene = scene(timing);
            scene.events[0].time.window_s = [-0.011, 0.017];
            let (sketch, segments, guess) = sketch(&scene, 0.0);
            let problem = Problem::new(&scene, &sketch, &segments);
            let layout = Layout::new(&problem);
            let point = Point::new(&problem, &guess);
            let context = SolveContext::new(&problem, &layout, epochs_s(&guess), &point);
            let [earliest, latest] = problem.time_bounds[..] else {
                panic!("two bounds")
            };
            assert_eq!(
                (earliest.side, latest.side),
                (TimeSide::Earliest, TimeSide::Latest)
            );
            assert_eq!(earliest.nodes.is_some(), timing == unknown);
            let between_s = latest.time_s(&problem, &point) - earliest.time_s(&problem, &point);
            assert!((between_s - 0.028).abs() < 1e-12, "{between_s}");

            // The rows against differences along the retraction.
            let first = problem.collisions.len() + problem.goals.len() + problem.conditions.len();
            let value = |delta: &DVector<f64>, side: usize| {
                let mut there = point.clone();
                context.retract(&point, delta, &mut there);
                let system = context.evaluated(&Guidance::none(), &there);
                system.blocks[first + side].values[0]
            };
            let system = context.evaluated(&Guidance::none(), &point);
            for side in 0..2 {
                let pattern = &context.structure().blocks[first + side];
                let exact = system.blocks[first + side].derivatives(pattern, 0);
                for (at, exact) in pattern.unknowns(0).iter().zip(exact) {
                    let mut delta = DVector::zeros(layout.size());
                    delta[*at] = 1e-5;
                    let difference = value(&delta, side) - value(&-&delta, side);
                    let error = (difference / 2e-5 - exact).abs();
                    assert!(error < 1e-3 * exact.abs(), "{at}: {error} of {exact}");
                }
            }
        }
    }
}
