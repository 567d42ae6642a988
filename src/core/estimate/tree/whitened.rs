//! The objective where samples err in time: sums over residuals whose errors are made independent, from interval to interval.

use nalgebra::{DMatrix, DVector};

use super::problem::TreeProblem;
use super::sample::Residual;
use crate::estimate::wander::{Filter, Means, Process};
use crate::optimise::System;
use crate::optimise::envelope::Pattern;

/// The samples of one link of one kind, with what their errors are known to be.
struct Strand {
    place: usize,
    kind: usize,
    filter: Filter,
    means: Means,
}

/// What whitened residuals add up to.
pub(super) struct WhitenedSums<'p> {
    problem: &'p TreeProblem,
    errors: [Process; 2],
    strands: Vec<Strand>,
    /// Number of unknowns by which residuals are differentiated: all or none.
    size: usize,
    cost: f64,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

impl<'p> WhitenedSums<'p> {
    /// Before the first sample.
    pub(super) fn new(
        problem: &'p TreeProblem,
        errors: [Process; 2],
        has_derivatives: bool,
    ) -> Self {
        let size = match has_derivatives {
            true => problem.unknown_count(),
            false => 0,
        };
        Self {
            problem,
            errors,
            strands: Vec::new(),
            size,
            cost: 0.0,
            gradient: DVector::zeros(size),
            hessian: DMatrix::zeros(size, size),
        }
    }

    /// Adds the next sample, of the interval of a node.
    pub(super) fn add(&mut self, node: usize, residual: &Residual) {
        let (place, kind) = (residual.sample.place, residual.sample.kind());
        let numbers = 3 * (1 + self.size);
        let is_of = |of: &Strand| (of.place, of.kind) == (place, kind);
        let at = self.strands.iter().position(is_of).unwrap_or_else(|| {
            self.strands.push(Strand {
                place,
                kind,
                filter: Filter::new(&self.errors[kind]),
                means: Means::new(numbers),
            });
            self.strands.len() - 1
        });
        // Axis by axis of the residual, then of its derivative by each unknown.
        let mut white = vec![0.0; numbers];
        white[..3].copy_from_slice(residual.value.as_slice());
        if self.size > 0 {
            for (column, by) in residual.by.column_iter().enumerate() {
                let first = 3 * (1 + self.problem.unknown_of(node, column));
                white[first..first + 3].copy_from_slice(by.as_slice());
            }
        }
        let Strand { filter, means, .. } = &mut self.strands[at];
        means.whiten(&filter.next(&residual.sample.instant()), &mut white);
        let white = DMatrix::from_vec(3, 1 + self.size, white);
        let value = white.column(0);
        self.cost += 0.5 * value.norm_squared();
        if self.size > 0 {
            let by = white.columns(1, self.size);
            self.gradient.gemv_tr(1.0, &by, &value, 1.0);
            self.hessian.gemm_tr(1.0, &by, &by, 1.0);
        }
    }

    /// Adds all to a system.
    pub(super) fn add_to(self, pattern: &Pattern, system: &mut System) {
        system.cost += self.cost;
        for row in 0..self.size {
            system.gradient[row] += self.gradient[row];
            for column in 0..=row {
                let entry = self.hessian[(row, column)];
                system.hessian.add(pattern, row, column, entry);
            }
        }
    }
}
