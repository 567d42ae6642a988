//! The state of one link as a rigid body's, with its derivatives by the state of the tree.
//!
//! A change `δ` of a coordinate turns all that hangs on its joint about the axis `a` through `p`, with
//! all that moves there against what the joint hangs from, `λ`. At a point `x` that hangs on it
//!
//! ```text
//! ∂v/∂q = a × (v − v_λ(x)) + ω_λ × (a × (x − p)),   ∂ω/∂q = a × (ω − ω_λ),   ∂v/∂u = a × (x − p),   ∂ω/∂u = a
//! ```

use nalgebra::{DMatrix, Vector3};

use super::snapshot::Snapshot;
use super::spatial::Motion;
use crate::physics::state::{self, State, StateTangent, part};

impl Snapshot<'_> {
    /// State of a link: centre of mass and its velocity in world axes, orientation, angular velocity
    /// [rad/s, link].
    pub fn link_state(&self, link: usize) -> State {
        let pose = self.world_from_link(link);
        let (velocity_m_s, angular_velocity_rad_s) = self.velocity(link);
        State {
            position_m: pose.translation.vector,
            orientation: pose.rotation,
            velocity_m_s,
            angular_velocity_rad_s,
        }
    }

    /// How a link's state changes with time where coordinates and rates of the tree stay: a hand carries it. Of what
    /// hangs from the world, or flies, it does not change.
    ///
    /// With `r` from the first joint's anchor, `v = v_A + ω × r + w`, and `w` turns with the hand.
    pub fn link_carried(&self, link: usize) -> StateTangent {
        let mut carried = StateTangent::zeros();
        let Some(held) = &self.held else {
            return carried;
        };
        let state = self.link_state(link);
        let spin = held.turn * held.spin_rad_s;
        let spin_rate = held.turn * held.spin_rate_rad_s2;
        let arm = state.position_m - held.position_m;
        let swung = held.velocity_m_s + spin.cross(&arm);
        let faster = held.acceleration_m_s2
            + spin_rate.cross(&arm)
            + spin.cross(&(spin.cross(&arm) + state.velocity_m_s - swung));
        for (row, part) in [
            (part::POSITION, swung),
            (
                part::ORIENTATION,
                state.orientation.inverse_transform_vector(&spin),
            ),
            (part::VELOCITY, faster),
            (
                part::ANGULAR_VELOCITY,
                state.orientation.inverse_transform_vector(&spin_rate),
            ),
        ] {
            carried.fixed_rows_mut::<3>(row).copy_from(&part);
        }
        carried
    }

    /// Derivative of that state's tangent by the tangent of the tree's: twelve rows, of
    /// [`State`], a column per coordinate and rate.
    pub fn link_jacobian(&self, link: usize, result: &mut DMatrix<f64>) {
        let (tree, freedoms) = (self.tree, self.tree.freedoms());
        result.fill(0.0);
        debug_assert_eq!(result.shape(), (state::DIMENSION, 2 * freedoms));
        let shift = tree.shift();
        for axis in 0..shift {
            result[(part::POSITION + axis, axis)] = 1.0;
            result[(part::VELOCITY + axis, freedoms + axis)] = 1.0;
        }
        let Some(own) = tree.links[link].0 else {
            return;
        };
        let kinematics = &self.field.kinematics;
        let pose = self.world_from_link(link);
        let place = self.turn.tr_mul(&(pose.translation.vector - self.origin_m));
        let link_from_frame = pose.rotation.to_rotation_matrix().transpose() * self.turn;
        let motion = kinematics.velocities[own];
        let mut above = Some(own);
        while let Some(index) = above {
            let node = &tree.nodes[index];
            let hung_from = match node.parent {
                Some(parent) => kinematics.velocities[parent],
                None => self.root_velocity(),
            };
            for column in node.columns() {
                let axis = &kinematics.axes[column];
                let arm = axis.at(&place);
                let against = Motion {
                    angular: motion.angular - hung_from.angular,
                    linear: motion.linear - hung_from.linear,
                };
                let faster =
                    axis.angular.cross(&against.at(&place)) + hung_from.angular.cross(&arm);
                // In the link's own axes, which turn too.
                let spun = axis.angular.cross(&(-hung_from.angular));
                let by_coordinate = [
                    (part::POSITION, self.turn * arm),
                    (part::ORIENTATION, link_from_frame * axis.angular),
                    (part::VELOCITY, self.turn * faster),
                    (part::ANGULAR_VELOCITY, link_from_frame * spun),
                ];
                let by_rate = [
                    (part::VELOCITY, self.turn * arm),
                    (part::ANGULAR_VELOCITY, link_from_frame * axis.angular),
                ];
                put(result, shift + column, &by_coordinate);
                put(result, freedoms + shift + column, &by_rate);
            }
            above = node.parent;
        }
    }
}

fn put(result: &mut DMatrix<f64>, column: usize, parts: &[(usize, Vector3<f64>)]) {
    for (row, part) in parts {
        result.fixed_view_mut::<3, 1>(*row, column).copy_from(part);
    }
}
