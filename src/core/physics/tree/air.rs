//! What pushes a link beside gravity: a force on its centre of mass, and the air.
//!
//! With `c` the centre of mass of a link, `J_i` how it moves with a column `i`, and `F(v, ω)` the push,
//!
//! ```text
//! τ_i = J_i·F,   ∂τ_i/∂q_k = J_i·∂F/∂q_k + (∂J_i/∂q_k)·F,   ∂τ_i/∂u_k = J_i·∂F/∂u_k
//! ∂J_i/∂q_k = ω_k × J_i      i at or beyond k
//! ∂J_i/∂q_k = ω_i × J_k      i before k
//! ```
//!
//! for columns on the way from the root to the link. The frame turns with nothing, so that the push is felt in it as in
//! the world once its own velocity is added.

use nalgebra::Vector3;

use super::field::Field;
use super::kinematics::Root;
use super::model::Tree;
use super::spatial::{Force, Motion};
use crate::physics::body::Body;

/// A link that is pushed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushedLink {
    /// Its node.
    pub node: usize,
    /// Its centre of mass in the node's frame \[m\].
    pub centre_m: Vector3<f64>,
    /// Its mass, the force per mass, drag and lift.
    pub body: Body,
}

/// A column on the way from the root to a link.
struct PushedColumn {
    column: usize,
    node: usize,
    axis: Motion,
    /// `J`: how the centre of mass moves with its coordinate.
    arm: Vector3<f64>,
    /// Changes of the push by its coordinate and by its rate \[N\].
    by_coordinate: Vector3<f64>,
    by_rate: Vector3<f64>,
}

impl PushedLink {
    /// A body of which something but gravity acts on the centre of mass.
    pub fn is_pushed(body: &Body) -> bool {
        !body.feels_no_air() || body.force_m_s2() != Vector3::zeros()
    }

    fn centre(&self, field: &Field) -> Vector3<f64> {
        let kinematics = &field.kinematics;
        kinematics.positions[self.node] + kinematics.rotations[self.node] * self.centre_m
    }

    /// Velocity of its centre of mass against the air [m/s], in the frame's axes.
    fn velocity_m_s(&self, field: &Field, root: &Root, centre: &Vector3<f64>) -> Vector3<f64> {
        root.flying_m_s + field.kinematics.velocities[self.node].at(centre)
    }

    /// The push \[N\] in the frame's axes.
    fn push_n(&self, field: &Field, root: &Root, velocity_m_s: &Vector3<f64>) -> Vector3<f64> {
        let spin = &field.kinematics.velocities[self.node].angular;
        let pushed = root.turn.tr_mul(&self.body.force_m_s2());
        (pushed + self.body.air_m_s2(velocity_m_s, spin)) * self.body.mass_kg()
    }

    /// The push where a field is placed.
    pub fn push(&self, field: &Field, root: &Root) -> Force {
        let centre = self.centre(field);
        let force = self.push_n(field, root, &self.velocity_m_s(field, root, &centre));
        Force {
            moment: centre.cross(&force),
            force,
        }
    }

    /// Takes `∂τ` where a field stands off rows of `stride` numbers, a row per column of the tree: one per coordinate
    /// that counts, then one per rate.
    pub fn take_change(
        &self,
        tree: &Tree,
        field: &Field,
        root: &Root,
        rows: &mut [f64],
        stride: usize,
    ) {
        let turned = tree.first_turned();
        let by_rate = tree.columns - turned;
        let centre = self.centre(field);
        let velocity = self.velocity_m_s(field, root, &centre);
        let push = self.push_n(field, root, &velocity);
        let columns = self.columns(tree, field, root, &centre, &velocity);
        for (at, of) in columns.iter().enumerate() {
            for (other, by) in columns.iter().enumerate() {
                // The way begins at the link: what comes later is nearer to the root.
                let is_beyond = by.node == of.node || at < other;
                let moved = match is_beyond {
                    true => by.axis.angular.cross(&of.arm),
                    false => of.axis.angular.cross(&by.arm),
                };
                let row = of.column * stride;
                if by.column >= turned {
                    rows[row + by.column - turned] -=
                        of.arm.dot(&by.by_coordinate) + moved.dot(&push);
                }
                rows[row + by_rate + by.column] -= of.arm.dot(&by.by_rate);
            }
        }
    }

    /// The columns on the way from the link to the root.
    fn columns(
        &self,
        tree: &Tree,
        field: &Field,
        root: &Root,
        centre: &Vector3<f64>,
        velocity_m_s: &Vector3<f64>,
    ) -> Vec<PushedColumn> {
        let kinematics = &field.kinematics;
        let own = kinematics.velocities[self.node];
        let mass_kg = self.body.mass_kg();
        let by_velocity = self.body.air_by_velocity_per_s(velocity_m_s, &own.angular);
        let pushed = |faster: Vector3<f64>, spun: Vector3<f64>| {
            (by_velocity * faster + spun.cross(velocity_m_s) * self.body.lift()) * mass_kg
        };
        let mut columns = Vec::new();
        let mut above = Some(self.node);
        while let Some(index) = above {
            let node = &tree.nodes[index];
            let (hung_from, _) = field.above(node, root);
            let against = own - hung_from;
            for column in node.columns() {
                let axis = kinematics.axes[column];
                let arm = axis.at(centre);
                let faster =
                    axis.angular.cross(&against.at(centre)) + hung_from.angular.cross(&arm);
                columns.push(PushedColumn {
                    column,
                    node: index,
                    axis,
                    arm,
                    by_coordinate: pushed(faster, axis.angular.cross(&against.angular)),
                    by_rate: pushed(arm, axis.angular),
                });
            }
            above = node.parent;
        }
        columns
    }
}
