//! The centre of mass of a free tree against its base, with derivatives.
//!
//! Momentum `p` of the tree moves with the coordinates of column `j` by the linear part of
//! `S_j ×* H_jᶜ + I_jᶜ (v_λ × S_j)`, `H` momenta; by the rates, as the first moment by the coordinates,
//! by that of `I_jᶜ S_j`.

use nalgebra::Vector3;

use super::field::Field;
use super::model::Tree;
use super::spatial::{Force, Inertia, Motion};

/// Where the centre of mass is and how it moves, in the free base's axes.
#[derive(Clone, Debug)]
pub struct Centre {
    /// From the base's centre of mass `r` \[m\].
    pub offset: Vector3<f64>,
    /// Velocity against that of the base's centre of mass `w` [m/s].
    pub velocity: Vector3<f64>,
    /// Per column: change of `r` by the coordinate, and of `w` by the rate.
    pub by_coordinate: Vec<Vector3<f64>>,
    /// Per column: change of `w` by the coordinate.
    pub velocity_by_coordinate: Vec<Vector3<f64>>,
    inertias: Vec<Inertia>,
    momenta: Vec<Force>,
}

impl Centre {
    /// Room for a tree.
    pub fn new(tree: &Tree) -> Self {
        Self {
            offset: Vector3::zeros(),
            velocity: Vector3::zeros(),
            by_coordinate: vec![Vector3::zeros(); tree.columns],
            velocity_by_coordinate: vec![Vector3::zeros(); tree.columns],
            inertias: vec![Inertia::ZERO; tree.nodes.len()],
            momenta: vec![Force::ZERO; tree.nodes.len()],
        }
    }

    /// Where a field is placed.
    pub fn evaluate(&mut self, tree: &Tree, field: &Field) {
        self.inertias.copy_from_slice(&field.inertias);
        self.momenta.copy_from_slice(&field.momenta);
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let (inertia, momentum) = (self.inertias[index], self.momenta[index]);
            let velocity = match node.parent {
                Some(parent) => {
                    self.inertias[parent] += inertia;
                    self.momenta[parent] += momentum;
                    field.kinematics.velocities[parent]
                }
                None => {
                    self.offset = inertia.first / tree.mass_kg;
                    self.velocity = momentum.force / tree.mass_kg;
                    Motion::ZERO
                }
            };
            for column in node.columns() {
                let axis = &field.kinematics.axes[column];
                let by_rate = inertia.of(axis).force;
                let turned = axis.cross_force(&momentum) + inertia.of(&velocity.cross(axis));
                self.by_coordinate[column] = by_rate / tree.mass_kg;
                self.velocity_by_coordinate[column] = turned.force / tree.mass_kg;
            }
        }
    }
}
