//! What an evaluation of a motion is of, and what it tells.

use nalgebra::{Matrix3xX, Vector3};

use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::sample::Residual;

/// What is evaluated.
#[derive(Clone, Copy)]
pub(super) struct Evaluation<'e> {
    /// The problem, in which all is as the point says.
    pub(super) problem: &'e TreeProblem,
    pub(super) part: &'e Part,
    pub(super) point: &'e TreePoint,
    pub(super) has_derivatives: bool,
}

/// Who is told of samples and goals before these are added, and may add derivatives.
pub(super) trait Told {
    /// A sample, of the interval of a node.
    fn sample(&mut self, node: usize, residual: &mut Residual);

    /// A goal's quantity, with its derivatives by the unknowns of its interval.
    fn goal(&mut self, goal: usize, value: &Vector3<f64>, by: &mut Matrix3xX<f64>);
}

/// What a motion says of its samples, goals and rows, or how that changes with a parameter.
#[derive(Clone, Debug, Default)]
pub(super) struct MotionValues {
    /// Of every sample, in order.
    pub(super) residuals: Vec<Vector3<f64>>,
    /// Of goals, by their indices, where they were asked.
    pub(super) goals: Vec<Option<Vector3<f64>>>,
    /// Of rows, block by block.
    pub(super) blocks: Vec<Vec<f64>>,
}

impl Told for MotionValues {
    fn sample(&mut self, _node: usize, residual: &mut Residual) {
        self.residuals.push(residual.value);
    }

    fn goal(&mut self, goal: usize, value: &Vector3<f64>, _by: &mut Matrix3xX<f64>) {
        self.goals.resize(self.goals.len().max(goal + 1), None);
        self.goals[goal] = Some(*value);
    }
}

impl MotionValues {
    /// Adds so many times another motion's, of which the same was told.
    pub(super) fn add(&mut self, other: &Self, times: f64) {
        for (sum, of) in self.residuals.iter_mut().zip(&other.residuals) {
            *sum += of * times;
        }
        for (sum, of) in self.goals.iter_mut().zip(&other.goals) {
            *sum = sum.zip(*of).map(|(sum, of)| sum + of * times);
        }
        for (sums, of) in self.blocks.iter_mut().zip(&other.blocks) {
            for (sum, of) in sums.iter_mut().zip(of) {
                *sum += of * times;
            }
        }
    }
}

/// How a motion changes with a parameter.
pub(super) struct Slope {
    /// Index of the parameter.
    pub(super) parameter: usize,
    pub(super) of: MotionValues,
}
