//! Derivatives of a tree's `u̇` by coordinates and rates: `du̇ = −M⁻¹ d[ID(q, u, u̇) − τ]`, with `u̇` held.
//!
//! The derivatives of inverse dynamics are analytic (Carpentier and Mansard, "Analytical derivatives of
//! rigid body dynamics algorithms", 2018; in this form Singh, Russo and Wensing, "Efficient analytical
//! derivatives of rigid-body dynamics using spatial vector algebra", 2022). With `λ` what the column's
//! node hangs from, sums over all that hangs on it marked `C`, `G` of
//! [`Gyration`](super::spatial::Gyration), and
//!
//! ```text
//! Ψ̇ = v_λ × S,   Ψ̈ = a_λ × S + v_λ × Ψ̇,   Σ̇ = Ψ̇ + v × S
//! ```
//!
//! a column `j` and a row `i` at or beyond it have
//!
//! ```text
//! ∂ID_i/∂q_j = S_i·(I_iᶜ Ψ̈_j + G_iᶜ Ψ̇_j),               ∂ID_i/∂u_j = S_i·(I_iᶜ Σ̇_j + G_iᶜ S_j),
//! ∂ID_j/∂q_i = S_j·(I_iᶜ Ψ̈_i + G_iᶜ Ψ̇_i + S_i ×* F_iᶜ),   ∂ID_j/∂u_i = S_j·(I_iᶜ Σ̇_i + G_iᶜ S_i)
//! ```
//!
//! the second line for `j` truly before `i`. Changes of orientation are right perturbations.

use nalgebra::Vector3;

use super::articulated::LANES;
use super::field::{Field, twist};
use super::kinematics::Root;
use super::model::{Motor, Tree, TreeNode};
use super::spatial::{Force, Gyration, Inertia, Motion};
use crate::math::so3;

/// Derivatives of `u̇`, stored by rows.
#[derive(Clone, Debug)]
pub struct Change {
    /// Numbers per row; the last few are padding.
    pub stride: usize,
    /// A row per column of the tree, then three for a free base's translation, in its axes. A number
    /// per coordinate that counts ([`Tree::first_turned`]), then one per rate.
    pub rows: Vec<f64>,
    /// Per node: sums over all that hangs on it.
    inertias: Vec<Inertia>,
    gyrations: Vec<Gyration>,
    forces: Vec<Force>,
    /// Per column.
    sides: Vec<ChangeSide>,
}

/// What a column contributes.
#[derive(Clone, Copy, Debug)]
struct ChangeSide {
    /// `S`, `Ψ̇`, `Ψ̈`, `Σ̇`.
    axis: Motion,
    first: Motion,
    second: Motion,
    whirl: Motion,
    /// `Iᶜ S`.
    momentum: Force,
}

impl Change {
    /// Room for a tree.
    pub fn new(tree: &Tree) -> Self {
        let nodes = tree.nodes.len();
        let width = 2 * tree.columns - tree.first_turned();
        let stride = width.next_multiple_of(LANES);
        let side = ChangeSide {
            axis: Motion::ZERO,
            first: Motion::ZERO,
            second: Motion::ZERO,
            whirl: Motion::ZERO,
            momentum: Force::ZERO,
        };
        Self {
            stride,
            rows: vec![0.0; stride * (tree.columns + tree.shift())],
            inertias: vec![Inertia::ZERO; nodes],
            gyrations: vec![Gyration::ZERO; nodes],
            forces: vec![Force::ZERO; nodes],
            sides: vec![side; tree.columns],
        }
    }

    /// Where the evaluation of a field stands.
    pub fn evaluate(&mut self, tree: &Tree, field: &mut Field, coordinates: &[f64], root: &Root) {
        self.sum(tree, field);
        self.inverse_dynamics(tree, field, root);
        for node in &tree.nodes {
            self.passive(tree, node, coordinates);
        }
        for link in &tree.pushed {
            link.take_change(tree, &field.kinematics, root, &mut self.rows, self.stride);
        }
        for number in &mut self.rows {
            *number = -*number;
        }
        field
            .articulated
            .solve_many(tree, &mut self.rows, self.stride);
    }

    fn sum(&mut self, tree: &Tree, field: &Field) {
        for index in 0..tree.nodes.len() {
            let inertia = &field.inertias[index];
            self.inertias[index] = *inertia;
            self.gyrations[index] = Gyration::new(
                inertia,
                &field.kinematics.velocities[index],
                &field.momenta[index],
            );
            self.forces[index] =
                field.forces[index] + inertia.of(&field.articulated.accelerations()[index]);
        }
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            if let Some(parent) = node.parent {
                let (inertia, gyration) = (self.inertias[index], self.gyrations[index]);
                self.inertias[parent] += inertia;
                self.gyrations[parent] += gyration;
                let force = self.forces[index];
                self.forces[parent] += force;
            }
        }
    }

    fn inverse_dynamics(&mut self, tree: &Tree, field: &Field, root: &Root) {
        let (stride, turned) = (self.stride, tree.first_turned());
        let by_rate = tree.columns - turned;
        self.rows.fill(0.0);
        for (index, node) in tree.nodes.iter().enumerate() {
            let (velocity, acceleration) = field.above(node, root);
            let (inertia, gyration) = (&self.inertias[index], &self.gyrations[index]);
            for column in node.columns() {
                let axis = field.kinematics.axes[column];
                let first = velocity.cross(&axis);
                self.sides[column] = ChangeSide {
                    axis,
                    first,
                    second: acceleration.cross(&axis) + velocity.cross(&first),
                    whirl: first + field.kinematics.velocities[index].cross(&axis),
                    momentum: inertia.of(&axis),
                };
            }
            for row in node.columns() {
                let side = self.sides[row];
                let transposed = gyration.transposed_of(&side.axis);
                let by_coordinate = inertia.of(&side.second)
                    + gyration.of(&side.first.angular)
                    + side.axis.cross_force(&self.forces[index]);
                let by_its_rate = inertia.of(&side.whirl) + gyration.of(&side.axis.angular);
                for column in node.columns() {
                    let (q, u) = beyond(&side.momentum, &transposed, &self.sides[column]);
                    if column >= turned {
                        self.rows[row * stride + column - turned] = q;
                    }
                    self.rows[row * stride + by_rate + column] = u;
                }
                let mut above = node.parent;
                while let Some(index) = above {
                    for column in tree.nodes[index].columns() {
                        let other = &self.sides[column];
                        let (q, u) = beyond(&side.momentum, &transposed, other);
                        if column >= turned {
                            self.rows[row * stride + column - turned] = q;
                        }
                        self.rows[row * stride + by_rate + column] = u;
                        if row >= turned {
                            self.rows[column * stride + row - turned] =
                                other.axis.dot(&by_coordinate);
                        }
                        self.rows[column * stride + by_rate + row] = other.axis.dot(&by_its_rate);
                    }
                    above = tree.nodes[index].parent;
                }
                for axis in 0..tree.shift() {
                    let from = (tree.columns + axis) * stride;
                    if row >= turned {
                        self.rows[from + row - turned] = by_coordinate.force[axis];
                    }
                    self.rows[from + by_rate + row] = by_its_rate.force[axis];
                }
            }
        }
    }

    /// Less the change of the moments of dampers and springs.
    fn passive(&mut self, tree: &Tree, node: &TreeNode, coordinates: &[f64]) {
        let (stride, turned) = (self.stride, tree.first_turned());
        for column in node.columns() {
            self.rows[column * stride + tree.columns - turned + column] += node.damping_n_m_s;
        }
        if node.stiffness_n_m == 0.0 {
            return;
        }
        let at = |row: usize, column: usize| {
            (node.column + row) * stride + node.column + column - turned
        };
        match node.motor {
            Motor::Pin | Motor::Slide => self.rows[at(0, 0)] += node.stiffness_n_m,
            Motor::Ball => {
                let by_turn = so3::right_jacobian_inverse(&twist(&coordinates[node.coordinates()]));
                for row in 0..3 {
                    for column in 0..3 {
                        self.rows[at(row, column)] += node.stiffness_n_m * by_turn[(row, column)];
                    }
                }
            }
        }
    }
}

/// The first line of the derivatives: by a column's coordinate and by its rate.
#[inline(always)]
fn beyond(momentum: &Force, transposed: &Vector3<f64>, column: &ChangeSide) -> (f64, f64) {
    (
        column.second.dot(momentum) + transposed.dot(&column.first.angular),
        column.whirl.dot(momentum) + transposed.dot(&column.axis.angular),
    )
}
