//! Objective and constraints at a point, with derivatives: what one iteration works on.

use nalgebra::DVector;

use super::block::Block;
use super::collision;
use super::constraint;
use super::layout::Layout;
use super::point::Point;
use super::problem::{Arc, Problem};
use super::samples::{self, ArcSums, ArcTerms};
use super::tempo;
use crate::math::envelope::Envelope;
use crate::physics::impact::ImpactDerivative;
use crate::physics::state::part;

/// What stays fixed while one problem is solved.
#[derive(Clone, Debug)]
pub struct SolveContext<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Where its unknowns sit.
    pub layout: &'a Layout,
    /// Physical times at which the arcs' states are held \[s\].
    pub epochs_s: Vec<f64>,
    /// Sums of each arc's samples; empty where times are unknown.
    pub sums: Vec<ArcSums>,
}

impl<'a> SolveContext<'a> {
    /// A context about `point`.
    pub fn new(
        problem: &'a Problem,
        layout: &'a Layout,
        epochs_s: Vec<f64>,
        point: &Point,
    ) -> Self {
        let gravity = problem.gravity(&point.parameters);
        let sums = if problem.times_are_unknown() {
            Vec::new()
        } else {
            let arcs = problem.arcs.iter().zip(&point.arcs).zip(&epochs_s);
            arcs.map(|((arc, state), epoch_s)| {
                ArcSums::new(arc, &point.node_times_s, *epoch_s, state, &gravity)
            })
            .collect()
        };
        Self {
            problem,
            layout,
            epochs_s,
            sums,
        }
    }
}

/// Terms that lead the way and are gone at the end.
#[derive(Clone, Debug)]
pub struct Guidance {
    /// Greatest normal speed on arrival at each collision [m/s].
    pub approach_limits_m_s: Vec<f64>,
    /// Times towards which the events are pulled \[s\].
    pub event_times_s: Vec<f64>,
    /// Standard deviation of that pull \[s\]; `None`: no pull.
    pub event_sd_s: Option<f64>,
    /// About so many orientations of an arc are read, evenly spread, and stand for all of them.
    pub orientations_per_arc: usize,
}

impl Guidance {
    /// None, but that contacts do not recede.
    pub fn none(problem: &Problem) -> Self {
        Self {
            approach_limits_m_s: vec![0.0; problem.collisions.len()],
            event_times_s: Vec::new(),
            event_sd_s: None,
            orientations_per_arc: usize::MAX,
        }
    }

    /// Of the samples of an arc whose times are unknown one in so many is read: no fewer than there
    /// are orientations to read, nor than nodes.
    fn stride(&self, arc: &Arc) -> usize {
        let samples = &arc.samples;
        let nodes = match (samples.first(), samples.last()) {
            (Some(first), Some(last)) => last.node - first.node + 1,
            _ => 1,
        };
        (samples.len() / self.orientations_per_arc.max(nodes)).max(1)
    }
}

/// Objective and constraints at a point.
#[derive(Clone, Debug)]
pub struct System {
    /// Half the sum of squared residuals, priors and guidance included.
    pub cost: f64,
    /// Its gradient.
    pub gradient: DVector<f64>,
    /// Its positive semidefinite Hessian.
    pub hessian: Envelope,
    /// Constraints, in the order of the layout's blocks.
    pub blocks: Vec<Block>,
    /// Velocity gaps of every collision, where they are priced instead of closed.
    pub velocity_gaps: Vec<Block>,
    /// Room for the derivatives of one impact.
    impact: ImpactDerivative,
}

impl System {
    /// All zero.
    pub fn new(context: &SolveContext) -> Self {
        let blocks = context.layout.blocks.iter().map(Block::zeros);
        Self {
            cost: 0.0,
            gradient: DVector::zeros(context.layout.size()),
            hessian: Envelope::zeros(&context.layout.pattern),
            blocks: blocks.collect(),
            velocity_gaps: vec![Block::default(); context.problem.collisions.len()],
            impact: ImpactDerivative::zeros(),
        }
    }

    /// Evaluates everything at `point`.
    pub fn evaluate(&mut self, context: &SolveContext, guidance: &Guidance, point: &Point) {
        self.cost = 0.0;
        self.gradient.fill(0.0);
        self.hessian.clear();
        self.add_samples(context, guidance, point);
        self.add_priors(context, guidance, point);
        self.fill_constraints(context, guidance, point);
        let problem = context.problem;
        if let Some(weight) = problem.velocity_gap_weight {
            self.add_velocity_gaps(context, weight);
        }
    }

    fn fill_constraints(&mut self, context: &SolveContext, guidance: &Guidance, point: &Point) {
        let (problem, layout) = (context.problem, context.layout);
        let epochs_s = &context.epochs_s;
        let mut blocks = layout.blocks.iter().zip(&mut self.blocks);
        let gaps = layout.velocity_gaps.iter().zip(&mut self.velocity_gaps);
        let collisions = problem.collisions.iter().zip(&guidance.approach_limits_m_s);
        for (((of, limit_m_s), gaps), block) in collisions.zip(gaps).zip(&mut blocks) {
            let at = (point, epochs_s.as_slice());
            let impact = &mut self.impact;
            collision::fill(problem, of, at, *limit_m_s, impact, [block, gaps]);
        }
        for (goal, block) in problem.goals.iter().zip(&mut blocks) {
            constraint::goal(problem, goal, point, epochs_s, block);
        }
        for (parameter, block) in problem.bounded.iter().zip(&mut blocks) {
            let free = &problem.parameters[*parameter];
            constraint::bound(free, point.parameters[*parameter], block);
        }
        for (cone, block) in problem.cones.iter().zip(&mut blocks) {
            constraint::cone(cone, cone.parameters.map(|p| point.parameters[p]), block);
        }
    }

    /// Half the weighted squares of what velocities jump beyond their impacts.
    fn add_velocity_gaps(&mut self, context: &SolveContext, weight: f64) {
        let layout = context.layout;
        for (block, pattern) in self.velocity_gaps.iter().zip(&layout.velocity_gaps) {
            let values = &block.values;
            self.cost += 0.5 * weight * values.iter().map(|v| v * v).sum::<f64>();
            block.add_pull(pattern, |row| weight * values[row], &mut self.gradient);
            block.add_square(pattern, |_| weight, (&layout.pattern, &mut self.hessian));
        }
    }

    fn add_samples(&mut self, context: &SolveContext, guidance: &Guidance, point: &Point) {
        let (problem, layout) = (context.problem, context.layout);
        let gravity = problem.gravity(&point.parameters);
        for (index, arc) in problem.arcs.iter().enumerate() {
            let flight = (&point.arcs[index], context.epochs_s[index]);
            let times_s = &point.node_times_s;
            let terms = if problem.times_are_unknown() {
                let of = (arc, guidance.stride(arc));
                samples::unknown_times(problem, of, flight, &gravity, times_s, |node, terms| {
                    if let Some(at) = layout.nodes[node] {
                        self.add_time(context, index, at, &terms);
                        if terms.with_next != 0.0
                            && let Some(next) = layout.nodes[node + 1]
                        {
                            let value = terms.with_next;
                            self.hessian.add(&layout.pattern, next, at, value);
                        }
                    }
                })
            } else {
                let sums = &context.sums[index];
                let stride = (arc.samples.len() / guidance.orientations_per_arc).max(1);
                samples::known_times(problem, arc, (sums, stride), flight, &gravity, times_s)
            };
            self.add_arc(context, layout.arcs[index], &terms);
        }
    }

    fn add_time(
        &mut self,
        context: &SolveContext,
        arc: usize,
        at: usize,
        terms: &samples::TimeTerms,
    ) {
        let layout = context.layout;
        self.gradient[at] += terms.gradient;
        self.hessian.add(&layout.pattern, at, at, terms.square);
        let state = layout.arcs[arc];
        for (block, cross) in terms.cross[..4].iter().enumerate() {
            for axis in 0..3 {
                self.hessian
                    .add(&layout.pattern, state + 3 * block + axis, at, cross[axis]);
            }
        }
        for axis in 0..3 {
            if let Some(parameter) = context.problem.gravity_parameters[axis] {
                let row = layout.parameters[parameter];
                self.hessian
                    .add(&layout.pattern, row, at, terms.cross[4][axis]);
            }
        }
    }

    fn add_arc(&mut self, context: &SolveContext, at: usize, terms: &ArcTerms) {
        let pattern = &context.layout.pattern;
        let [p0, p1, p2, p3, p4] = terms.powers;
        self.cost += terms.cost + terms.turn.cost;
        let [x, v, r, w] = [
            part::POSITION,
            part::VELOCITY,
            part::ORIENTATION,
            part::ANGULAR_VELOCITY,
        ]
        .map(|part| at + part);
        for axis in 0..3 {
            self.gradient[x + axis] += terms.position_gradient[0][axis];
            self.gradient[v + axis] += terms.position_gradient[1][axis];
            self.gradient[r + axis] += terms.turn.gradient_orientation[axis];
            self.gradient[w + axis] += terms.turn.gradient_spin[axis];
            self.hessian.add(pattern, x + axis, x + axis, p0);
            self.hessian.add(pattern, v + axis, x + axis, p1);
            self.hessian.add(pattern, v + axis, v + axis, p2);
            self.hessian
                .add(pattern, r + axis, r + axis, terms.turn.count);
            for other in 0..3 {
                self.hessian.add(
                    pattern,
                    w + axis,
                    r + other,
                    terms.turn.cross[(other, axis)],
                );
                if other <= axis {
                    let square = terms.turn.square[(axis, other)];
                    self.hessian.add(pattern, w + axis, w + other, square);
                }
            }
            if let Some(parameter) = context.problem.gravity_parameters[axis] {
                let g = context.layout.parameters[parameter];
                self.gradient[g] += terms.position_gradient[2][axis];
                self.hessian.add(pattern, g, x + axis, 0.5 * p2);
                self.hessian.add(pattern, g, v + axis, 0.5 * p3);
                self.hessian.add(pattern, g, g, 0.25 * p4);
            }
        }
    }

    fn add_priors(&mut self, context: &SolveContext, guidance: &Guidance, point: &Point) {
        let (problem, layout) = (context.problem, context.layout);
        if let Some(sd) = problem.tempo_sd_per_sqrt_s {
            for first in 0..problem.nodes_acted_s.len().saturating_sub(2) {
                self.add_tempo(context, point, first, sd);
            }
        }
        for mark in &problem.marks {
            let term = mark.term(problem, point);
            self.add_residual(context, layout.of_mark(mark), term.residual, term.jacobian);
        }
        for (index, free) in problem.parameters.iter().enumerate() {
            if let Some(sd) = free.prior_sd {
                let offset = point.parameters[index] - free.initial;
                self.add_pull(context, layout.parameters[index], offset, sd);
            }
        }
        if let Some(sd_s) = guidance.event_sd_s {
            for (event, at) in layout.events.iter().enumerate() {
                if let Some(at) = *at {
                    let offset = point.event_times_s[event] - guidance.event_times_s[event];
                    self.add_pull(context, at, offset, sd_s);
                }
            }
        }
    }

    /// Half the square of `offset/sd`, for one unknown.
    fn add_pull(&mut self, context: &SolveContext, at: usize, offset: f64, sd: f64) {
        let weight = 1.0 / (sd * sd);
        self.cost += 0.5 * weight * offset * offset;
        self.gradient[at] += weight * offset;
        self.hessian.add(&context.layout.pattern, at, at, weight);
    }

    fn add_tempo(&mut self, context: &SolveContext, point: &Point, first: usize, sd: f64) {
        let three = |values: &[f64]| [values[first], values[first + 1], values[first + 2]];
        let term = tempo::term(
            &three(&point.node_times_s),
            &three(&context.problem.nodes_acted_s),
            sd,
        );
        let unknowns = [0, 1, 2].map(|node| context.layout.nodes[first + node]);
        self.add_residual(context, unknowns, term.residual, term.jacobian);
    }

    /// Half the square of a residual of three unknowns, some of which may be fixed.
    fn add_residual(
        &mut self,
        context: &SolveContext,
        unknowns: [Option<usize>; 3],
        residual: f64,
        jacobian: [f64; 3],
    ) {
        self.cost += 0.5 * residual * residual;
        for (i, row) in unknowns.into_iter().enumerate() {
            let Some(row) = row else { continue };
            self.gradient[row] += residual * jacobian[i];
            for (j, column) in unknowns.into_iter().enumerate() {
                if let Some(column) = column.filter(|column| *column <= row) {
                    let value = jacobian[i] * jacobian[j];
                    self.hessian
                        .add(&context.layout.pattern, row, column, value);
                }
            }
        }
    }

    /// Number of rows of all constraints.
    pub fn row_count(&self) -> usize {
        self.blocks.iter().map(|block| block.values.len()).sum()
    }

    /// Values of all rows, in units.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.blocks
            .iter()
            .flat_map(|block| block.values.iter().copied())
    }

    /// Sum of all violations, in units.
    pub fn total_violation(&self) -> f64 {
        self.violations().sum()
    }

    fn violations(&self) -> impl Iterator<Item = f64> + '_ {
        let blocks = self.blocks.iter();
        blocks.flat_map(|block| (0..block.values.len()).map(|row| block.violation(row).abs()))
    }

    /// Largest violation of any constraint, in units.
    pub fn violation(&self) -> f64 {
        self.violations().fold(0.0, f64::max)
    }
}
