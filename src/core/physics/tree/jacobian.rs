//! The derivative of a tree's flow, put together: what is integrated and what is known.
//!
//! Of a free tree with centre of mass `c = x + R r`, `ċ = v + R w` ([`Centre`](super::centre::Centre)),
//!
//! ```text
//! δc(T) = δc(0) + T δċ(0) + ċ δT,   δċ(T) = δċ(0) + g δT,   θ(T) = R(T)ᵀ R(0) θ(0) + …
//! ```

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::flow::Flow;
use super::model::Motor;
use super::tangent::{four, perturbation};

impl Flow<'_> {
    /// Derivative of the state now by the tangent of the start: a row per direction of the tangent, coordinates
    /// before rates.
    pub fn jacobian(&mut self, result: &mut DMatrix<f64>) {
        result.fill(0.0);
        let (tree, shift) = (self.tree, self.tree.shift());
        let (turned, freedoms) = (tree.first_turned(), tree.freedoms());
        let width = 2 * tree.columns - turned;
        let place = |direction: usize| match direction.checked_sub(tree.columns - turned) {
            None => shift + turned + direction,
            Some(rate) => freedoms + shift + rate,
        };
        self.tangents(self.stride, &self.changes, |row, numbers| {
            for (direction, number) in numbers[..width].iter().enumerate() {
                result[(row, place(direction))] = *number;
            }
        });
        if tree.is_free {
            self.place();
            let turn = self.rotation();
            let turned = turn.transpose() * self.start.rotation;
            result.fixed_view_mut::<3, 3>(3, 3).copy_from(&turned);
            for column in 0..2 * freedoms {
                let of_centre = self.centre_by(column);
                let base = self.base(&turn, of_centre, |row| result[(row, column)]);
                result.fixed_view_mut::<3, 1>(0, column).copy_from(&base[0]);
                result
                    .fixed_view_mut::<3, 1>(freedoms, column)
                    .copy_from(&base[1]);
            }
        }
    }

    /// How the state goes on now, as a tangent: what tells it, differentiated by time.
    pub fn rate(&mut self) -> DVector<f64> {
        let slope = self.by_time();
        let freedoms = self.tree.freedoms();
        let mut rate = DVector::zeros(2 * freedoms);
        self.tangents(1, &slope, |row, numbers| rate[row] = numbers[0]);
        if self.tree.is_free {
            self.place();
            let (_, velocity_m_s) = self.flown();
            let of_centre = [velocity_m_s, self.gravity_m_s2];
            let base = self.base(&self.rotation(), of_centre, |row| rate[row]);
            rate.fixed_rows_mut::<3>(0).copy_from(&base[0]);
            rate.fixed_rows_mut::<3>(freedoms).copy_from(&base[1]);
        }
        rate
    }

    /// Changes of angular coordinates and rates as rows of tangents.
    fn tangents(&self, stride: usize, changes: &[f64], mut put: impl FnMut(usize, &[f64])) {
        let (tree, shift) = (self.tree, self.tree.shift());
        let freedoms = tree.freedoms();
        let row = |at: usize| &changes[at * stride..(at + 1) * stride];
        let mut turns = vec![0.0; 3 * stride];
        for node in &tree.nodes {
            match node.motor {
                Motor::Pin | Motor::Slide => put(shift + node.column, row(node.coordinate)),
                Motor::Ball => {
                    let q = four(&self.state[node.coordinate..]);
                    let of_q = &changes[node.coordinate * stride..];
                    perturbation(stride, &q, of_q, &mut turns);
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

    /// How the centre of mass and its velocity change now with a direction of the start's tangent.
    fn centre_by(&self, column: usize) -> [Vector3<f64>; 2] {
        let (start, freedoms) = (&self.start, self.tree.freedoms());
        let (mut centre, mut velocity) = (Vector3::zeros(), Vector3::zeros());
        let axis = column % freedoms;
        match (column / freedoms, axis.checked_sub(3)) {
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
        [centre + velocity * self.elapsed_s, velocity]
    }

    /// The change of a free base's position and velocity, from that of the centre of mass and of the angular tangent.
    fn base(
        &self,
        turn: &Matrix3<f64>,
        [centre, velocity]: [Vector3<f64>; 2],
        by: impl Fn(usize) -> f64,
    ) -> [Vector3<f64>; 2] {
        let (tree, freedoms) = (self.tree, self.tree.freedoms());
        let (mut moved, mut faster) = (Vector3::zeros(), Vector3::zeros());
        for angular in 0..tree.columns {
            let (by_coordinate, by_rate) = (by(3 + angular), by(freedoms + 3 + angular));
            moved += self.centre.by_coordinate[angular] * by_coordinate;
            faster += self.centre.velocity_by_coordinate[angular] * by_coordinate
                + self.centre.by_coordinate[angular] * by_rate;
        }
        [centre - turn * moved, velocity - turn * faster]
    }
}
