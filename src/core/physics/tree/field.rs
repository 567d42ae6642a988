//! The vector field of a tree: `u̇ = −M⁻¹ (ID(q, u, 0) − τ)`, with the moments `τ` of dampers and springs.

use nalgebra::{UnitQuaternion, Vector3};

use super::articulated::Articulated;
use super::kinematics::{Kinematics, Root};
use super::model::{Motor, Tree, TreeNode};
use super::spatial::{Force, Inertia, Motion};
use super::state::quaternion;
use crate::math::so3;

/// All that one evaluation of the vector field computes.
#[derive(Clone, Debug)]
pub struct Field {
    pub kinematics: Kinematics,
    /// Per node: inertia and momentum.
    pub inertias: Vec<Inertia>,
    pub momenta: Vec<Force>,
    /// Per node: force that its motion without `u̇` needs, `I a + v ×* I v`.
    pub forces: Vec<Force>,
    /// Per node: the same less what pushes its links; only of a tree of which something is pushed.
    loads: Vec<Force>,
    pub articulated: Articulated,
    /// `u̇` per column.
    pub rates_by_time: Vec<f64>,
    /// Acceleration of a free base's centre of mass in its own axes.
    pub base: Vector3<f64>,
}

impl Field {
    /// Room for a tree.
    pub fn new(tree: &Tree) -> Self {
        let nodes = tree.nodes.len();
        Self {
            kinematics: Kinematics::new(tree),
            inertias: vec![Inertia::ZERO; nodes],
            momenta: vec![Force::ZERO; nodes],
            forces: vec![Force::ZERO; nodes],
            loads: vec![Force::ZERO; if tree.pushed.is_empty() { 0 } else { nodes }],
            articulated: Articulated::new(tree),
            rates_by_time: vec![0.0; tree.columns],
            base: Vector3::zeros(),
        }
    }

    /// Frames, inertias, momenta and forces without `u̇`.
    pub fn place(&mut self, tree: &Tree, coordinates: &[f64], rates: &[f64], root: &Root) {
        self.kinematics.update(tree, coordinates, rates, root);
        for (index, node) in tree.nodes.iter().enumerate() {
            if node.inertia.mass == 0.0 {
                continue;
            }
            let inertia = node.inertia.placed(
                &self.kinematics.rotations[index],
                &self.kinematics.positions[index],
            );
            let velocity = &self.kinematics.velocities[index];
            let momentum = inertia.of(velocity);
            self.forces[index] =
                inertia.of(&self.kinematics.drifts[index]) + velocity.cross_force(&momentum);
            self.inertias[index] = inertia;
            self.momenta[index] = momentum;
        }
    }

    /// Everything.
    pub fn evaluate(&mut self, tree: &Tree, coordinates: &[f64], rates: &[f64], root: &Root) {
        self.place(tree, coordinates, rates, root);
        for node in &tree.nodes {
            passive(node, coordinates, rates, &mut self.rates_by_time);
        }
        self.articulated
            .factor(tree, &self.inertias, &self.kinematics.axes);
        let loads = match tree.pushed.is_empty() {
            true => &self.forces,
            false => {
                self.loads.copy_from_slice(&self.forces);
                for link in &tree.pushed {
                    self.loads[link.node] += link.push(&self.kinematics, root) * -1.0;
                }
                &self.loads
            }
        };
        self.base = self.articulated.solve(tree, loads, &mut self.rates_by_time);
    }

    /// Acceleration of a node, `u̇` included.
    #[inline(always)]
    pub fn acceleration(&self, index: usize) -> Motion {
        self.kinematics.drifts[index] + self.articulated.accelerations()[index]
    }

    /// Velocity and acceleration of what a node hangs from.
    #[inline(always)]
    pub fn above(&self, node: &TreeNode, root: &Root) -> (Motion, Motion) {
        match node.parent {
            Some(parent) => (
                self.kinematics.velocities[parent],
                self.acceleration(parent),
            ),
            None => {
                let base = Motion {
                    angular: Vector3::zeros(),
                    linear: self.base,
                };
                (root.velocity, root.acceleration + base)
            }
        }
    }
}

/// Moments of dampers and springs: `−d u − k (q − q₀)`.
#[inline(always)]
fn passive(node: &TreeNode, coordinates: &[f64], rates: &[f64], moments: &mut [f64]) {
    for column in node.columns() {
        moments[column] = -node.damping_n_m_s * rates[column];
    }
    if node.stiffness_n_m == 0.0 {
        return;
    }
    match node.motor {
        Motor::Pin | Motor::Slide => {
            let turned = coordinates[node.coordinate] - node.rest_rad;
            moments[node.column] -= node.stiffness_n_m * turned;
        }
        Motor::Ball => {
            let turned = twist(&coordinates[node.coordinates()]);
            for axis in 0..3 {
                moments[node.column + axis] -= node.stiffness_n_m * turned[axis];
            }
        }
    }
}

/// The rotation vector of the direction of a quaternion.
pub fn twist(numbers: &[f64]) -> Vector3<f64> {
    so3::log(&UnitQuaternion::new_normalize(quaternion(numbers)))
}
