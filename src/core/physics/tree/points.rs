//! Links and their points: poses, velocities, Jacobians, and what an impulse at a point does.

use nalgebra::{DMatrix, UnitQuaternion, Vector3};

use super::snapshot::Snapshot;
use super::spatial::{Force, Motion};
use crate::math::{Pose, so3};

impl Snapshot<'_> {
    /// Pose of a link.
    pub fn world_from_link(&self, link: usize) -> Pose {
        let (node, node_from_link) = &self.tree.links[link];
        let (rotation, position) = match node {
            Some(node) => (
                self.turn * self.field.kinematics.rotations[*node],
                self.origin_m + self.turn * self.field.kinematics.positions[*node],
            ),
            None => (self.turn, self.origin_m),
        };
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(rotation);
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
        Pose::from_parts(position.into(), rotation) * node_from_link
    }

    /// Velocity of a link's centre of mass [m/s, world] and its angular velocity [rad/s, link].
    pub fn velocity(&self, link: usize) -> (Vector3<f64>, Vector3<f64>) {
        let (node, node_from_link) = &self.tree.links[link];
        let motion = self.motion_of(*node);
        let centre = self.in_frame(link, &Vector3::zeros());
        let turn = so3::matrix(&node_from_link.rotation);
        let rotation = node.map_or(turn, |node| self.field.kinematics.rotations[node] * turn);
        (
            self.velocity_m_s + self.turn * motion.at(&centre),
            rotation.tr_mul(&motion.angular),
        )
    }

    /// A point of a link [m, link] in the world \[m\].
    pub fn point(&self, link: usize, point: &Vector3<f64>) -> Vector3<f64> {
        self.origin_m + self.turn * self.in_frame(link, point)
    }

    /// Velocity [m/s, world] of a point of a link.
    pub fn point_velocity(&self, link: usize, point: &Vector3<f64>) -> Vector3<f64> {
        let motion = self.motion_of(self.tree.links[link].0);
        self.velocity_m_s + self.turn * motion.at(&self.in_frame(link, point))
    }

    /// Derivative of a point's velocity by the rates, and of its position by the coordinates: three
    /// rows, a column per rate.
    pub fn point_jacobian(&self, link: usize, point: &Vector3<f64>, result: &mut DMatrix<f64>) {
        let shift = self.tree.shift();
        let place = self.in_frame(link, point);
        result.fill(0.0);
        let mut above = self.tree.links[link].0;
        while let Some(index) = above {
            for column in self.tree.nodes[index].columns() {
                let world = self.turn * self.field.kinematics.axes[column].at(&place);
                result
                    .fixed_view_mut::<3, 1>(0, shift + column)
                    .copy_from(&world);
            }
            above = self.tree.nodes[index].parent;
        }
        for axis in 0..shift {
            result[(axis, axis)] = 1.0;
        }
    }

    /// Change of the rates by an impulse [N s, world] at a point of a link, `M⁻¹ Jᵀ p`.
    pub fn impulse_response(
        &self,
        link: usize,
        point: &Vector3<f64>,
        impulse: &Vector3<f64>,
        result: &mut [f64],
    ) {
        let shift = self.tree.shift();
        result.fill(0.0);
        let Some(node) = self.tree.links[link].0 else {
            return;
        };
        let force = self.turn.tr_mul(impulse);
        let moment = self.in_frame(link, point).cross(&force);
        let mut forces = vec![Force::ZERO; self.tree.nodes.len()];
        forces[node] = Force { moment, force } * -1.0;
        // The solution for this right side must not take the place of the accelerations.
        let mut articulated = self.field.articulated.clone();
        let base = articulated.solve(self.tree, &forces, &mut result[shift..]);
        if shift > 0 {
            result[..3].copy_from_slice((self.turn * base).as_slice());
        }
    }

    /// Kinetic and potential energy \[J\], springs' included; heights are against the world's origin.
    pub fn energy(&self, spring_j: f64) -> f64 {
        let potential = self.field.inertias.iter().map(|inertia| {
            let place = self.origin_m * inertia.mass + self.turn * inertia.first;
            -place.dot(self.gravity_m_s2())
        });
        spring_j + self.kinetic_energy() + potential.sum::<f64>()
    }

    /// Kinetic energy \[J\].
    pub fn kinetic_energy(&self) -> f64 {
        let base = Motion {
            angular: Vector3::zeros(),
            linear: self.turn.tr_mul(&self.velocity_m_s),
        };
        let moving = self
            .field
            .inertias
            .iter()
            .zip(&self.field.kinematics.velocities);
        let energies = moving.map(|(inertia, velocity)| {
            let moved = *velocity + base;
            0.5 * moved.dot(&inertia.of(&moved))
        });
        energies.sum()
    }

    /// Centre of mass \[m\], momentum [kg m/s] and angular momentum about the centre of mass
    /// [kg m²/s], in the world.
    pub fn momentum(&self) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
        let (mut first, mut total) = (Vector3::zeros(), Force::ZERO);
        for index in 0..self.tree.nodes.len() {
            first += self.field.inertias[index].first;
            total += self.field.momenta[index];
        }
        let centre = first / self.tree.mass_kg;
        let spin = total.moment - centre.cross(&total.force);
        (
            self.origin_m + self.turn * centre,
            self.velocity_m_s * self.tree.mass_kg + self.turn * total.force,
            self.turn * spin,
        )
    }

    /// Velocity of a node; of none that of what the tree hangs from.
    fn motion_of(&self, node: Option<usize>) -> Motion {
        node.map_or(self.root_velocity(), |node| {
            self.field.kinematics.velocities[node]
        })
    }

    fn in_frame(&self, link: usize, point: &Vector3<f64>) -> Vector3<f64> {
        let (node, node_from_link) = &self.tree.links[link];
        let place = node_from_link.transform_point(&(*point).into()).coords;
        match node {
            Some(node) => {
                self.field.kinematics.positions[*node]
                    + self.field.kinematics.rotations[*node] * place
            }
            None => place,
        }
    }
}
