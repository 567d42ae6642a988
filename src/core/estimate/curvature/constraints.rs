//! The curvature of the constraints, `Σ_k ν_k ∇²c_k`.
//!
//! It is the derivative of `Jᵀν`, computed block by block as central differences of the exact `J`.
//! With right perturbations, the symmetric part of that derivative is the second derivative along
//! the retraction. Coordinates of goals have theirs in closed form
//! ([`Block::second`]), which the optimiser adds by itself.

use super::nudged::Nudged;
use crate::estimate::constraint::At;
use crate::estimate::unknowns::point::Point;
use crate::optimise::System;
use crate::optimise::block::{Block, BlockPattern};
use crate::optimise::envelope::Envelope;

/// Adds the curvature of constraints with `multipliers`, row by row, and that of velocity gaps
/// where these are priced.
pub fn add(nudged: &mut Nudged, system: &System, multipliers: &[f64], matrix: &mut Envelope) {
    let context = nudged.context;
    let (problem, structure) = (context.problem, &context.layout.structure);
    let mut multipliers = multipliers;
    let patterns = structure.blocks.iter().zip(&structure.priced);
    let blocks = system.blocks.iter().zip(&system.priced);
    for ((constraint, patterns), blocks) in problem.constraints().zip(patterns).zip(blocks) {
        let (pulls, rest) = multipliers.split_at(blocks.0.values.len());
        multipliers = rest;
        if !constraint.is_curved() {
            continue;
        }
        let weight = constraint.price(problem, f64::INFINITY);
        let priced_rows = 0..blocks.1.values.len();
        let priced_pulls = priced_rows.map(|row| weight * blocks.1.violation(row));
        let priced_pulls: Vec<f64> = priced_pulls.collect();
        let mut filled = [Block::default(), Block::default()];
        let pull = |point: &Point, sum: &mut [f64]| {
            let [rows, priced] = &mut filled;
            let mut at = At::new(problem, point, &context.epochs_s);
            constraint.fill(
                &mut at,
                [(patterns.0, &mut *rows), (patterns.1, &mut *priced)],
            );
            add_pull(patterns.0, rows, pulls, sum);
            add_pull(patterns.1, priced, &priced_pulls, sum);
        };
        nudged.add_curvature(&[patterns.0, patterns.1], pull, matrix);
        // Second derivatives that are given are added by whoever minimises; what is convex of those of
        // priced rows is in the Hessian.
        let given = blocks
            .0
            .second
            .iter()
            .map(|of| of.pulled(patterns.0, pulls[of.row]));
        let known = blocks.1.convex(patterns.1, |row| priced_pulls[row]);
        for of in given.chain(known) {
            matrix.add(&structure.pattern, of.row, of.column, -of.value);
        }
    }
}

/// Adds `Jᵀν` of a block to a sum over all unknowns.
fn add_pull(pattern: &BlockPattern, block: &Block, pulls: &[f64], sum: &mut [f64]) {
    for (row, pull) in pulls.iter().enumerate().filter(|(_, pull)| **pull != 0.0) {
        let derivatives = block.derivatives(pattern, row);
        for (unknown, derivative) in pattern.unknowns(row).iter().zip(derivatives) {
            sum[*unknown] += pull * derivative;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::estimate::terms::context::{Guidance, SolveContext};
    use crate::estimate::tests::conditions::wished_cases;
    use crate::estimate::tests::each_case;
    use crate::optimise::Program;

    /// `νᵀc` and the price of velocity gaps, of which the curvature is asked.
    fn pulled(
        context: &SolveContext,
        point: &Point,
        delta: &DVector<f64>,
        (pulls, gap_pulls): (&[f64], &[f64]),
    ) -> f64 {
        let mut there = point.clone();
        context.retract(point, delta, &mut there);
        let mut system = System::new(context.structure());
        let guidance = Guidance::none();
        context.evaluate(&guidance, &there, &mut system);
        let gaps = system.priced.iter().flat_map(|gaps| &gaps.values);
        let rows = system.values().zip(pulls);
        let rows = rows.chain(gaps.copied().zip(gap_pulls));
        rows.map(|(value, pull)| value * pull).sum()
    }

    /// Against second differences of the values themselves.
    #[test]
    fn it_is_the_second_derivative_of_the_pull() {
        let check = |context: &SolveContext, point: &Point| {
            let problem = context.problem;
            let size = context.layout.size();
            let mut system = System::new(context.structure());
            let guidance = Guidance::none();
            context.evaluate(&guidance, point, &mut system);
            // Bounds and cones of parameters have no curvature here.
            let blocks = problem.constraints().zip(&system.blocks);
            let is_curved = blocks.flat_map(|(constraint, block)| {
                let is_curved = constraint.is_curved() || !block.second.is_empty();
                block.values.iter().map(move |_| is_curved)
            });
            let pulls = is_curved
                .enumerate()
                .map(|(row, is_curved)| f64::from(is_curved) * (1.0 + row as f64).sin());
            let pulls: Vec<f64> = pulls.collect();
            // Priced rows pull by what they cost.
            let priced = problem.constraints().zip(&system.priced);
            let gap_pulls = priced.flat_map(|(constraint, block)| {
                let weight = constraint.price(problem, f64::INFINITY);
                (0..block.values.len()).map(move |row| weight * block.violation(row))
            });
            let gap_pulls: Vec<f64> = gap_pulls.collect();
            let mut matrix = Envelope::zeros(&context.layout.structure.pattern);
            let mut at = Nudged::new(context, point);
            add(&mut at, &system, &pulls, &mut matrix);
            let pattern = &context.layout.structure.pattern;
            for of in system.curvature(context.structure(), |row| pulls[row]) {
                matrix.add(pattern, of.row, of.column, of.value);
            }
            // What the Hessian has already of that of priced rows.
            let mut first = 0;
            for (block, rows) in system.priced.iter().zip(&context.structure().priced) {
                for of in block.convex(rows, |row| gap_pulls[first + row]) {
                    matrix.add(pattern, of.row, of.column, of.value);
                }
                first += block.values.len();
            }
            let terms = system.values().zip(&pulls);
            let priced = system
                .priced
                .iter()
                .flat_map(|gaps| gaps.values.iter().copied());
            let terms = terms.chain(priced.zip(&gap_pulls));
            let size_of_sum: f64 = terms.map(|(value, pull)| (value * pull).abs()).sum();
            // A few pairs of every kind: all would take long.
            for i in (0..size).step_by(3) {
                for j in (0..=i).step_by(2) {
                    let steps = [i, j].map(|k| 30.0 * at.step(k));
                    let value = |signs: [f64; 2]| {
                        let mut delta = DVector::zeros(size);
                        delta[i] += signs[0] * steps[0];
                        delta[j] += signs[1] * steps[1];
                        pulled(context, point, &delta, (&pulls, &gap_pulls))
                    };
                    let second = value([1.0, 1.0]) - value([1.0, -1.0]) - value([-1.0, 1.0])
                        + value([-1.0, -1.0]);
                    let expected = second / (4.0 * steps[0] * steps[1]);
                    let got = matrix.get(pattern, i, j);
                    let rounding = (1e-13 + 1e-15 * size_of_sum) / (steps[0] * steps[1]);
                    assert!(
                        (got - expected).abs() < 1e-3 * (1.0 + expected.abs()) + rounding,
                        "{i} {j}: {got} {expected}"
                    );
                }
            }
        };
        // The general form of a coordinate's rows has its curvature by the time alone.
        let is_plain = |context: &SolveContext| context.problem.arcs.iter().all(|arc| arc.is_plain);
        each_case(1.0, |context, _, point, _| {
            if is_plain(context) {
                check(context, point);
            }
        });
        wished_cases(5, check);
    }
}
