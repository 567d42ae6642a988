//! The derivative of a tree's flow, put together: what is integrated and what is known.
//!
//! Of a free tree with centre of mass `c = x + R r`, `ċ = v + R w` ([`Centre`](super::centre::Centre)),
//!
//! ```text
//! δc(T) = δc(0) + T δċ(0) + ċ δT,   δċ(T) = δċ(0) + g δT,   θ(T) = R(T)ᵀ R(0) θ(0) + …
//! ```

use nalgebra::{DMatrix, Vector3};

use super::flow::Flow;
use super::model::Motor;
use super::tangent::{four, perturbation};

impl Flow<'_> {
    /// Derivative of the state now by the tangent of the start, and by time in the last column: a row
    /// per direction of the tangent, coordinates before rates.
    pub fn jacobian(&mut self, result: &mut DMatrix<f64>) {
        result.fill(0.0);
        self.integrated(result);
        if self.tree.is_free {
            let turned = self.rotation().transpose() * self.start.rotation;
            result.fixed_view_mut::<3, 3>(3, 3).copy_from(&turned);
            self.translated(result);
        }
    }

    /// Angular coordinates and rates by all but what turns a free tree as a whole.
    fn integrated(&self, result: &mut DMatrix<f64>) {
        let (tree, stride, shift) = (self.tree, self.stride, self.tree.shift());
        let (turned, freedoms) = (tree.first_turned(), tree.freedoms());
        let width = 2 * tree.columns - turned + 1;
        let place = |direction: usize| match direction.checked_sub(tree.columns - turned) {
            None => shift + turned + direction,
            Some(rate) if rate < tree.columns => freedoms + shift + rate,
            Some(_) => 2 * freedoms,
        };
        let mut put = |row: usize, numbers: &[f64]| {
            for (direction, number) in numbers[..width].iter().enumerate() {
                result[(row, place(direction))] = *number;
            }
        };
        let row = |at: usize| &self.changes[at * stride..(at + 1) * stride];
        let mut turns = vec![0.0; 3 * stride];
        for node in &tree.nodes {
            match node.motor {
                Motor::Pin => put(shift + node.column, row(node.coordinate)),
                Motor::Ball => {
                    let q = four(&self.state[node.coordinate..]);
                    perturbation(
                        stride,
                        &q,
                        &self.changes[node.coordinate * stride..],
                        &mut turns,
                    );
                    for axis in 0..3 {
                        put(
                            shift + node.column + axis,
                            &turns[axis * stride..(axis + 1) * stride],
                        );
                    }
                }
            }
        }
        for column in 0..tree.columns {
            put(freedoms + shift + column, row(tree.coordinates + column));
        }
    }

    /// Position and velocity of a free base.
    fn translated(&mut self, result: &mut DMatrix<f64>) {
        self.place();
        let (tree, freedoms) = (self.tree, self.tree.freedoms());
        let (start, turn) = (&self.start, self.rotation());
        for column in 0..=2 * freedoms {
            let (mut centre, mut velocity) = (Vector3::zeros(), Vector3::zeros());
            let axis = column % freedoms;
            match (column / freedoms, axis.checked_sub(3)) {
                (2, _) => {
                    centre = self.centre_velocity_m_s * start.elapsed_by_time;
                    velocity = self.gravity_m_s2 * start.elapsed_by_time;
                }
                (0, None) => centre[axis] = 1.0,
                (_, None) => velocity[axis] = 1.0,
                (0, Some(angular)) => {
                    centre = start.rotation * start.centre.by_coordinate[angular];
                    velocity = start.rotation * start.centre.velocity_by_coordinate[angular];
                }
                (_, Some(angular)) => {
                    velocity = start.rotation * start.centre.by_coordinate[angular];
                }
            }
            if column < 2 * freedoms {
                centre += velocity * start.elapsed_s;
            }
            let (mut moved, mut faster) = (Vector3::zeros(), Vector3::zeros());
            for angular in 0..tree.columns {
                let by_coordinate = result[(3 + angular, column)];
                let by_rate = result[(freedoms + 3 + angular, column)];
                moved += self.centre.by_coordinate[angular] * by_coordinate;
                faster += self.centre.velocity_by_coordinate[angular] * by_coordinate
                    + self.centre.by_coordinate[angular] * by_rate;
            }
            let (position, velocity) = (centre - turn * moved, velocity - turn * faster);
            result
                .fixed_view_mut::<3, 1>(0, column)
                .copy_from(&position);
            result
                .fixed_view_mut::<3, 1>(freedoms, column)
                .copy_from(&velocity);
        }
    }
}
