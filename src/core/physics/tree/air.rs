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

use super::kinematics::{Kinematics, Root};
use super::model::Tree;
use super::pushed::PushedLink;
use super::spatial::{Force, Motion};

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
    fn centre(&self, kinematics: &Kinematics) -> Vector3<f64> {
        kinematics.positions[self.node] + kinematics.rotations[self.node] * self.centre_m
    }

    /// Velocity of its centre of mass against the air [m/s], in the frame's axes.
    fn velocity_m_s(
        &self,
        kinematics: &Kinematics,
        root: &Root,
        centre: &Vector3<f64>,
    ) -> Vector3<f64> {
        root.flying_m_s + kinematics.velocities[self.node].at(centre)
    }

    /// The push \[N\] in the frame's axes.
    fn push_n(
        &self,
        kinematics: &Kinematics,
        root: &Root,
        velocity_m_s: &Vector3<f64>,
    ) -> Vector3<f64> {
        let spin = &kinematics.velocities[self.node].angular;
        let pushed = root.turn.tr_mul(&self.body.force_m_s2());
        (pushed + self.body.air_m_s2(velocity_m_s, spin)) * self.body.mass_kg()
    }

    /// The push where the nodes are so.
    pub fn push(&self, kinematics: &Kinematics, root: &Root) -> Force {
        let centre = self.centre(kinematics);
        let force = self.push_n(
            kinematics,
            root,
            &self.velocity_m_s(kinematics, root, &centre),
        );
        Force {
            moment: centre.cross(&force),
            force,
        }
    }

    /// Takes `∂τ` off rows of `stride` numbers, a row per column of the tree: one per coordinate, which all count where
    /// something is pushed, then one per rate.
    pub fn take_change(
        &self,
        tree: &Tree,
        kinematics: &Kinematics,
        root: &Root,
        rows: &mut [f64],
        stride: usize,
    ) {
        let centre = self.centre(kinematics);
        let velocity = self.velocity_m_s(kinematics, root, &centre);
        let push = self.push_n(kinematics, root, &velocity);
        let columns = self.columns(tree, kinematics, root, &centre, &velocity);
        for (at, of) in columns.iter().enumerate() {
            for (other, by) in columns.iter().enumerate() {
                // The way begins at the link: what comes later is nearer to the root.
                let is_beyond = by.node == of.node || at < other;
                let moved = match is_beyond {
                    true => by.axis.angular.cross(&of.arm),
                    false => of.axis.angular.cross(&by.arm),
                };
                let row = of.column * stride;
                rows[row + by.column] -= of.arm.dot(&by.by_coordinate) + moved.dot(&push);
                rows[row + tree.columns + by.column] -= of.arm.dot(&by.by_rate);
            }
        }
    }

    /// The columns on the way from the link to the root.
    fn columns(
        &self,
        tree: &Tree,
        kinematics: &Kinematics,
        root: &Root,
        centre: &Vector3<f64>,
        velocity_m_s: &Vector3<f64>,
    ) -> Vec<PushedColumn> {
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
            let above_it = node.parent.map(|parent| kinematics.velocities[parent]);
            let hung_from = above_it.unwrap_or(root.velocity);
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
