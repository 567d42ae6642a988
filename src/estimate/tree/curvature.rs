//! What the Gauss–Newton Hessian lacks of the Lagrangian's: second derivatives of the flow are nowhere else.
//!
//! They are told by differences of the Lagrangian's gradient, of a coarse reading of the problem, along the directions
//! `Z` alone that acting rows leave free. With `S` what is lacking, and `P = Z Zᵀ`,
//!
//! ```text
//! S P + P S − P S P
//! ```
//!
//! is added, which makes steps along `Z` what they are with all of `S`: what of it is left out only multipliers see. What
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
const NEAR: f64 = 0.03;
/// and by which share of them multipliers may differ.
const NEAR_MULTIPLIERS: f64 = 0.1;

/// What is lacking at a point with its multipliers.
pub(super) struct Lacking {
    point: TreePoint,
    multipliers: Vec<f64>,
    matrix: DMatrix<f64>,
}

impl Lacking {
    /// Tells it of a program along free directions, a column each, orthonormal.
    pub(super) fn new<P: Program<Point = TreePoint>>(
        (program, guidance): (&P, &P::Guidance),
        free: &DMatrix<f64>,
        point: &TreePoint,
        multipliers: &[f64],
    ) -> Self {
        let structure = program.structure();
        let slope = |system: &System| {
            let mut gradient = system.gradient.clone();
            system.add_pull(structure, |row| multipliers[row], &mut gradient);
            gradient
        };
        let here = program.evaluated(guidance, point);
        let before = slope(&here);
        let given = dense(&structure.pattern, &here.hessian);
        let mut lacking = DMatrix::zeros(free.nrows(), free.ncols());
        let mut moved = point.clone();
        let mut there = System::new(structure);
        for (at, direction) in free.column_iter().enumerate() {
            program.retract(point, &(direction * STEP), &mut moved);
            program.evaluate(guidance, &moved, &mut there);
            let change = (slope(&there) - &before) / STEP;
            lacking.set_column(at, &(change - &given * direction));
        }
        let across = &lacking * free.transpose();
        let along = free * free.tr_mul(&lacking) * free.transpose();
        Self {
            point: point.clone(),
            multipliers: multipliers.to_vec(),
            matrix: &across + across.transpose() - 0.5 * (&along + along.transpose()),
        }
    }

    /// Whether it serves at another point of the program with other multipliers.
    pub(super) fn serves<P: Program<Point = TreePoint>>(
        &self,
        (program, problem): (&P, &TreeProblem),
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

/// A symmetric matrix with all its entries.
pub(super) fn dense(pattern: &Pattern, matrix: &Envelope) -> DMatrix<f64> {
    DMatrix::from_fn(pattern.size(), pattern.size(), |row, column| {
        matrix.get(pattern, row.max(column), row.min(column))
    })
}
