//! What the Gauss–Newton Hessian lacks of the Lagrangian's: second derivatives of the flow are nowhere else.
//!
//! They are told by differences of the Lagrangian's gradient, of a coarse reading of the problem, along the directions
//! `Z` alone that acting rows leave free. With `S` what is lacking, and `P = Z Zᵀ`,
//!
//! ```text
//! S P + P S − P S P
//! ```
//!
//! is added, which makes steps along `Z` what they are with all of `S`: what of it is left out only multipliers see. Of
//! several intervals `S` itself is told, but for what little couples two of them: directions that are free move all nodes. What
//! was told at one point serves near by: a step by a Hessian that is nearly right leads to the same optimum, and each
//! direction costs an evaluation.

use nalgebra::DMatrix;

use super::point::TreePoint;
use super::problem::TreeProblem;
use crate::optimise::envelope::{Envelope, Pattern};
use crate::optimise::{Program, System};

/// Step of the differences.
const STEP: f64 = 1e-6;
/// How near a point is where what was told at another serves, in typical changes,
const NEAR: f64 = 0.1;
/// and by which share of them multipliers may differ.
const NEAR_MULTIPLIERS: f64 = 0.2;

/// What the Hessian lacks at a point with its multipliers.
pub(super) struct HessianRemainder {
    point: TreePoint,
    multipliers: Vec<f64>,
    matrix: DMatrix<f64>,
}

impl HessianRemainder {
    /// Tells it of a program along free directions, a column each, orthonormal.
    pub(super) fn along<P: Program<Point = TreePoint>>(
        program: &P,
        guidance: &P::Guidance,
        free: &DMatrix<f64>,
        point: &TreePoint,
        multipliers: &[f64],
    ) -> Self {
        let remainder = changes(program, guidance, free, point, multipliers);
        let across = &remainder * free.transpose();
        let along = free * free.tr_mul(&remainder) * free.transpose();
        Self {
            point: point.clone(),
            multipliers: multipliers.to_vec(),
            matrix: &across + across.transpose() - 0.5 * (&along + along.transpose()),
        }
    }

    /// Tells of it, where there are several intervals, all that couples unknowns of the same one: one difference tells a column
    /// of every other interval.
    pub(super) fn on_intervals<P: Program<Point = TreePoint>>(
        program: &P,
        guidance: &P::Guidance,
        problem: &TreeProblem,
        point: &TreePoint,
        multipliers: &[f64],
    ) -> Self {
        let (size, nodes) = (problem.unknown_count(), problem.nodes_s.len());
        let unknowns = |node: usize| {
            let count = problem.width() + problem.events_of(node).len();
            (0..count).map(move |at| problem.unknown_of(node, at))
        };
        let most = (0..nodes).map(|node| unknowns(node).len()).max();
        let mut matrix = DMatrix::zeros(size, size);
        for parity in 0..2 {
            let moved = || (parity..nodes).step_by(2);
            let mut each = DMatrix::zeros(size, most.unwrap_or(0));
            for (at, unknown) in moved().flat_map(|node| unknowns(node).enumerate()) {
                each[(unknown, at)] = 1.0;
            }
            let remainder = changes(program, guidance, &each, point, multipliers);
            for node in moved() {
                for (at, column) in unknowns(node).enumerate() {
                    for row in unknowns(node) {
                        let half = 0.5 * remainder[(row, at)];
                        matrix[(row, column)] += half;
                        matrix[(column, row)] += half;
                    }
                }
            }
        }
        Self {
            point: point.clone(),
            multipliers: multipliers.to_vec(),
            matrix,
        }
    }

    /// The matrix that is added.
    #[cfg(test)]
    pub(super) fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Whether it serves at another point of the program with other multipliers.
    pub(super) fn serves<P: Program<Point = TreePoint>>(
        &self,
        program: &P,
        problem: &TreeProblem,
        point: &TreePoint,
        multipliers: &[f64],
    ) -> bool {
        let step = point.minus(problem, &self.point);
        let scale = program.damping().map(f64::sqrt);
        // One typical change of one unknown.
        let unit = (10.0 * program.information().0).sqrt();
        let size = |of: &mut dyn Iterator<Item = f64>| of.map(|x| x * x).sum::<f64>().sqrt();
        let pairs = multipliers.iter().zip(&self.multipliers);
        step.component_mul(&scale).norm() < NEAR * unit
            && size(&mut pairs.map(|(a, b)| a - b))
                <= NEAR_MULTIPLIERS * size(&mut multipliers.iter().copied())
    }

    /// Adds it to the Hessian of a problem's program.
    pub(super) fn add(&self, problem: &TreeProblem, pattern: &Pattern, hessian: &mut Envelope) {
        for row in 0..pattern.size() {
            for column in problem.first_coupled(row)..=row {
                hessian.add(pattern, row, column, self.matrix[(row, column)]);
            }
        }
    }
}

/// How the Lagrangian's gradient changes along directions, a column each, beyond what the program's Hessian says.
fn changes<P: Program<Point = TreePoint>>(
    program: &P,
    guidance: &P::Guidance,
    directions: &DMatrix<f64>,
    point: &TreePoint,
    multipliers: &[f64],
) -> DMatrix<f64> {
    let structure = program.structure();
    let slope = |system: &System| {
        let mut gradient = system.gradient.clone();
        system.add_pull(structure, |row| multipliers[row], &mut gradient);
        gradient
    };
    let here = program.evaluated(guidance, point);
    let before = slope(&here);
    let given = dense(&structure.pattern, &here.hessian);
    let mut changes = DMatrix::zeros(directions.nrows(), directions.ncols());
    let mut moved = point.clone();
    let mut there = System::new(structure);
    for (at, direction) in directions.column_iter().enumerate() {
        program.retract(point, &(direction * STEP), &mut moved);
        program.evaluate(guidance, &moved, &mut there);
        let change = (slope(&there) - &before) / STEP;
        changes.set_column(at, &(change - &given * direction));
    }
    changes
}

/// A symmetric matrix with all its entries.
pub(super) fn dense(pattern: &Pattern, matrix: &Envelope) -> DMatrix<f64> {
    DMatrix::from_fn(pattern.size(), pattern.size(), |row, column| {
        matrix.get(pattern, row.max(column), row.min(column))
    })
}
