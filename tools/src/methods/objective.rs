//! Gradient and Hessian of samples, priors and pulls by the grid's unknowns.

use enact::estimate::terms::context::SolveContext;
use enact::optimise::System;
use enact::optimise::envelope::{Envelope, Pattern};
use enact::physics::state::DIMENSION as STATE;
use nalgebra::{DMatrix, DVector};

use super::chain::Chains;
use super::parts::{Part, gravity};

impl Chains<'_> {
    /// Adds gradient and Hessian of samples, priors and pulls.
    pub fn add_objective(&self, context: &SolveContext, lifted: &System, out: &mut System) {
        let problem = context.problem;
        let from = context.layout;
        let pattern = &self.columns.layout.structure.pattern;
        for (piece, arc) in problem.arcs.iter().enumerate() {
            let (at, own) = (from.arcs[piece], &self.columns.pieces[piece]);
            let chain = self.pieces[piece].as_ref();
            let gradient = lifted.gradient.rows(at, STATE).into_owned();
            let square =
                DMatrix::from_fn(STATE, STATE, |i, j| entry(context, lifted, at + i, at + j));
            add_gradient(own, &pulled(chain, gradient), out);
            let square = match chain {
                Some(chain) => chain.tr_mul(&(square * chain)),
                None => square,
            };
            add_square(pattern, own, &square, &mut out.hessian);
            let mut cross = |with: usize, column: usize| {
                let by = DVector::from_fn(STATE, |i, _| entry(context, lifted, at + i, with));
                let by = pulled(chain, by);
                for (entry, row) in by.iter().zip(own) {
                    add_symmetric(pattern, *row, column, *entry, &mut out.hessian);
                }
            };
            for sample in arc.samples() {
                if let (Some(with), Some(column)) =
                    (from.nodes[sample.node], self.columns.nodes[sample.node])
                {
                    cross(with, column);
                }
            }
            for part in gravity(problem) {
                if let Part::Parameter(p) = part {
                    cross(from.parameters[p], self.columns.parameters[p]);
                }
            }
        }
        self.add_others(context, lifted, out);
    }

    /// Times and parameters among themselves.
    fn add_others(&self, context: &SolveContext, lifted: &System, out: &mut System) {
        let (from, to) = (context.layout, self.columns);
        let pattern = &to.layout.structure.pattern;
        let nodes = from.nodes.iter().zip(&to.nodes);
        let nodes = nodes.filter_map(|(from, to)| Some(((*from)?, (*to)?)));
        let nodes: Vec<(usize, usize)> = nodes.collect();
        let parameters = from
            .parameters
            .iter()
            .copied()
            .zip(to.parameters.iter().copied());
        let parameters: Vec<(usize, usize)> = parameters.collect();
        for (index, (with, column)) in nodes.iter().enumerate() {
            out.gradient[*column] += lifted.gradient[*with];
            for (other, other_column) in &nodes[index.saturating_sub(2)..=index] {
                let value = entry(context, lifted, *with, *other);
                add_once(pattern, *column, *other_column, value, &mut out.hessian);
            }
        }
        for (index, (with, column)) in parameters.iter().enumerate() {
            out.gradient[*column] += lifted.gradient[*with];
            for (other, other_column) in &parameters[..=index] {
                let value = entry(context, lifted, *with, *other);
                add_once(pattern, *column, *other_column, value, &mut out.hessian);
            }
            if gravity(context.problem).any(|g| from.parameters[part_index(g)] == *with) {
                for (other, other_column) in &nodes {
                    let value = entry(context, lifted, *with, *other);
                    add_once(pattern, *column, *other_column, value, &mut out.hessian);
                }
            }
        }
        for (event, at) in from.events.iter().enumerate() {
            let Some(at) = at else { continue };
            let own = &to.events[event];
            let chain = self.events[event].as_ref();
            let gradient = DVector::repeat(1, lifted.gradient[*at]);
            let weight = entry(context, lifted, *at, *at);
            add_gradient(own, &pulled(chain, gradient), out);
            if weight != 0.0 {
                let by = pulled(chain, DVector::repeat(1, 1.0));
                add_square(
                    pattern,
                    own,
                    &(&by * by.transpose() * weight),
                    &mut out.hessian,
                );
            }
        }
    }
}

fn part_index(part: Part) -> usize {
    match part {
        Part::Piece(index) | Part::Event(index) | Part::Parameter(index) => index,
    }
}

fn entry(context: &SolveContext, lifted: &System, i: usize, j: usize) -> f64 {
    lifted
        .hessian
        .get(&context.layout.structure.pattern, i.max(j), i.min(j))
}

fn pulled(chain: Option<&DMatrix<f64>>, gradient: DVector<f64>) -> DVector<f64> {
    match chain {
        Some(chain) => chain.tr_mul(&gradient),
        None => gradient,
    }
}

fn add_gradient(own: &[usize], gradient: &DVector<f64>, out: &mut System) {
    for (at, value) in own.iter().zip(gradient.iter()) {
        out.gradient[*at] += value;
    }
}

fn add_square(pattern: &Pattern, own: &[usize], square: &DMatrix<f64>, matrix: &mut Envelope) {
    for (i, row) in own.iter().enumerate() {
        for (j, column) in own[..=i].iter().enumerate() {
            matrix.add(pattern, *row, *column, square[(i, j)]);
        }
    }
}

fn add_once(pattern: &Pattern, i: usize, j: usize, value: f64, matrix: &mut Envelope) {
    if value != 0.0 {
        matrix.add(pattern, i.max(j), i.min(j), value);
    }
}

/// An entry and its mirror: both where they are one place.
fn add_symmetric(pattern: &Pattern, i: usize, j: usize, value: f64, matrix: &mut Envelope) {
    let twice = if i == j { 2.0 } else { 1.0 };
    add_once(pattern, i, j, twice * value, matrix);
}
