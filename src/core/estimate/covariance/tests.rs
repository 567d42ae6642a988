//! Compares the parts with independent computations: differences, and sums one at a time.

use std::cell::Cell;

use nalgebra::DVector;

use super::residuals::Six;
use super::{Covariance, Moment};
use crate::estimate::outcome;
use crate::estimate::terms::context::Guidance;
use crate::estimate::tests::each_case;
use crate::math::random::Random;
use crate::optimise::Program;

/// What samples tell of a step is how much their residuals change with it.
#[test]
fn information_of_samples_is_that_of_their_differences() {
    each_case(0.0, |context, _, point, lengths| {
        let mut random = Random::default();
        let lengths = lengths.iter().map(|length| length * random.signed());
        let step = DVector::from_iterator(context.layout.size(), lengths);
        let residuals = |share: f64| {
            let mut there = point.clone();
            there.retract_from(point, context.problem, context.layout, &(&step * share));
            let errors = outcome::errors(context.problem, context, &there).into_iter();
            errors.flat_map(|of| of.each).collect::<Vec<Six>>()
        };
        const SHARE: f64 = 1e-5;
        let (before, after) = (residuals(-SHARE), residuals(SHARE));
        let pairs = before.iter().flatten().zip(after.iter().flatten());
        let squares = pairs.map(|(before, after)| ((after - before) / (2.0 * SHARE)).powi(2));
        let numeric: f64 = squares.sum();
        let mut product = DVector::zeros(step.len());
        let pattern = &context.structure().pattern;
        let of_samples = context.of_samples(point);
        of_samples.multiply_add(pattern, &step, &mut product);
        let exact = step.dot(&product);
        let error = (numeric - exact).abs();
        // By time, the steps of what a surface carries have their own error.
        let mut arcs = context.problem.arcs.iter();
        let is_carried = arcs.any(|arc| arc.body.support().is_some());
        let most = if is_carried { 1e-4 } else { 1e-5 };
        assert!(error < most * (1.0 + numeric), "{numeric} {exact}");
    });
}

/// One sum at a time goes along all samples; together they go over products of pairs.
#[test]
fn what_is_told_of_unknowns_together_is_what_is_told_of_each_sum() {
    let (told, open) = (Cell::new(0), Cell::new(0));
    each_case(0.0, |context, _, point, lengths| {
        let mut random = Random::default();
        let system = context.evaluated(&Guidance::none(), point);
        let rows: usize = system.blocks.iter().map(|of| of.values.len()).sum();
        let multipliers = vec![0.0; rows];
        let covariance = Covariance::new(context, point, &system, &multipliers, None);
        let Some(covariance) = covariance else { return };
        for arc in 0..context.problem.arcs.len() {
            let parameters = context.layout.parameters.iter().copied();
            let unknowns: Vec<usize> = context.layout.state(arc).chain(parameters).collect();
            let jointly = covariance.jointly(&unknowns);
            for _ in 0..8 {
                let sum = unknowns.iter().map(|at| random.signed() / lengths[*at]);
                let sum = DVector::from_iterator(unknowns.len(), sum);
                let moment: Moment = unknowns.iter().copied().zip(sum.iter().copied()).collect();
                match (jointly.of(&sum).sd(), covariance.sds(&[moment])[0]) {
                    (Some(one), Some(other)) => {
                        told.set(told.get() + 1);
                        assert!((one - other).abs() < 1e-6 * other, "{one} {other}");
                    }
                    (one, other) => {
                        open.set(open.get() + 1);
                        assert_eq!(one, other);
                    }
                }
            }
        }
    });
    assert!(told.get() > 50, "{told:?} told, {open:?} open");
}
