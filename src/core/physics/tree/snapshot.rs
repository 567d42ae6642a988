//! A tree at one instant: accelerations with their derivatives, inverse dynamics, mass matrix, in the
//! coordinates of [`TreeState`].

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::change::Change;
use super::field::Field;
use super::hand::Anchor;
use super::kinematics::Root;
use super::model::Tree;
use super::spatial::{Force, Inertia, Motion};
use super::state::{TreeState, quaternion};

/// Room for all that is computed of a tree at one instant; used again and again.
#[derive(Clone, Debug)]
pub struct Snapshot<'t> {
    pub(super) tree: &'t Tree,
    pub(super) field: Field,
    change: Change,
    root: Root,
    gravity_m_s2: Vector3<f64>,
    /// Pose of the frame in which the field is: of a free base, or of what the tree hangs from, at the first joint's anchor.
    pub(super) turn: Matrix3<f64>,
    pub(super) origin_m: Vector3<f64>,
    pub(super) velocity_m_s: Vector3<f64>,
    /// How a hand moves from which the tree hangs.
    pub(super) held: Option<Anchor>,
    coordinates: Vec<f64>,
}

impl<'t> Snapshot<'t> {
    /// Room for a tree in a field of gravity [m/s²].
    pub fn new(tree: &'t Tree, gravity_m_s2: &Vector3<f64>) -> Self {
        Self {
            tree,
            field: Field::new(tree),
            change: Change::new(tree),
            root: if tree.is_free {
                Root::FALLING
            } else {
                Root::at_rest(gravity_m_s2)
            },
            gravity_m_s2: *gravity_m_s2,
            turn: Matrix3::identity(),
            origin_m: tree.anchor_m,
            velocity_m_s: Vector3::zeros(),
            held: None,
            coordinates: vec![0.0; tree.coordinates],
        }
    }

    /// What a clamped tree hangs from moves at this instant: its velocity and acceleration in world axes, about the
    /// first joint's anchor, the acceleration less gravity.
    pub fn with_root(self, root: Root) -> Self {
        Self { root, ..self }
    }

    /// Moves to a state.
    pub fn set(&mut self, state: &TreeState) {
        let shift = self.tree.shift();
        self.coordinates
            .copy_from_slice(&state.coordinates[shift..]);
        if self.tree.is_free {
            let q = quaternion(&self.coordinates);
            self.turn = nalgebra::UnitQuaternion::new_normalize(q)
                .to_rotation_matrix()
                .into_inner();
            self.origin_m = Vector3::from_column_slice(&state.coordinates[..3]);
            self.velocity_m_s = Vector3::from_column_slice(&state.rates[..3]);
        }
        if let Some(hand) = &self.tree.hand {
            let held = hand.anchor(&self.tree.anchor_m, state.time_s);
            self.root = Root::in_hand(&held, &self.gravity_m_s2);
            self.turn = held.turn;
            self.origin_m = held.position_m;
            self.velocity_m_s = held.velocity_m_s;
            self.held = Some(held);
        }
        self.field.evaluate(
            self.tree,
            &self.coordinates,
            &state.rates[shift..],
            &self.root,
        );
    }

    /// Velocity of what the tree hangs from.
    pub(super) fn root_velocity(&self) -> Motion {
        self.root.velocity
    }

    /// `u̇`.
    pub fn accelerations(&self, result: &mut [f64]) {
        let shift = self.tree.shift();
        if shift > 0 {
            let base = self.turn * self.field.base + self.gravity_m_s2;
            result[..3].copy_from_slice(base.as_slice());
        }
        result[shift..].copy_from_slice(&self.field.rates_by_time);
    }

    /// Derivative of `u̇` by the tangent of the state: a row per rate, columns `(δq, δu)`.
    pub fn acceleration_derivatives(&mut self, result: &mut DMatrix<f64>) {
        let (tree, shift, turned) = (self.tree, self.tree.shift(), self.tree.first_turned());
        self.change
            .evaluate(tree, &mut self.field, &self.coordinates, &self.root);
        let (freedoms, columns) = (tree.freedoms(), tree.columns);
        result.fill(0.0);
        let rows = self.change.rows.chunks_exact(self.change.stride);
        for (row, numbers) in rows.enumerate() {
            let to = (row + shift) % freedoms;
            let (by_coordinate, by_rate) = numbers.split_at(columns - turned);
            for (column, number) in by_coordinate.iter().enumerate() {
                result[(to, shift + turned + column)] = *number;
            }
            for (column, number) in by_rate[..columns].iter().enumerate() {
                result[(to, freedoms + shift + column)] = *number;
            }
        }
        if shift > 0 {
            for column in 0..2 * freedoms {
                let own = Vector3::new(
                    result[(0, column)],
                    result[(1, column)],
                    result[(2, column)],
                );
                let world = self.turn * own;
                for row in 0..3 {
                    result[(row, column)] = world[row];
                }
            }
            let by_turn = -self.turn * self.field.base.cross_matrix();
            result.view_mut((0, 3), (3, 3)).copy_from(&by_turn);
        }
    }

    /// Forces along the rates that make the accelerations `u̇`: inverse dynamics, by the recursion of
    /// Newton and Euler. Dampers and springs are not in it.
    pub fn inverse_dynamics(&self, rates_by_time: &[f64], result: &mut [f64]) {
        let (tree, shift) = (self.tree, self.tree.shift());
        let mut base = Motion::ZERO;
        if shift > 0 {
            let world = Vector3::from_column_slice(&rates_by_time[..3]) - self.gravity_m_s2;
            base.linear = self.turn.tr_mul(&world);
        }
        let mut added = vec![base; tree.nodes.len()];
        let mut forces = self.field.forces.clone();
        for (index, node) in tree.nodes.iter().enumerate() {
            let mut own = node.parent.map_or(base, |parent| added[parent]);
            for column in node.columns() {
                own += self.field.kinematics.axes[column] * rates_by_time[shift + column];
            }
            added[index] = own;
            forces[index] += self.field.inertias[index].of(&own);
        }
        let mut root = Force::ZERO;
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            for column in node.columns() {
                result[shift + column] = self.field.kinematics.axes[column].dot(&forces[index]);
            }
            let own = forces[index];
            *node.parent.map_or(&mut root, |parent| &mut forces[parent]) += own;
        }
        if shift > 0 {
            result[..3].copy_from_slice((self.turn * root.force).as_slice());
        }
    }

    /// The mass matrix, by inertias of all that hangs on each joint.
    pub fn mass_matrix(&self, result: &mut DMatrix<f64>) {
        let (tree, shift) = (self.tree, self.tree.shift());
        result.fill(0.0);
        let mut inertias = self.field.inertias.clone();
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            for row in node.columns() {
                let momentum = inertias[index].of(&self.field.kinematics.axes[row]);
                let mut above = Some(index);
                while let Some(at) = above {
                    for column in tree.nodes[at].columns() {
                        let entry = self.field.kinematics.axes[column].dot(&momentum);
                        result[(shift + row, shift + column)] = entry;
                        result[(shift + column, shift + row)] = entry;
                    }
                    above = tree.nodes[at].parent;
                }
                if shift > 0 {
                    let world = self.turn * momentum.force;
                    for axis in 0..3 {
                        result[(axis, shift + row)] = world[axis];
                        result[(shift + row, axis)] = world[axis];
                    }
                }
            }
            let own: Inertia = inertias[index];
            if let Some(parent) = node.parent {
                inertias[parent] += own;
            }
        }
        for axis in 0..shift {
            result[(axis, axis)] = tree.mass_kg;
        }
    }

    pub(super) fn gravity_m_s2(&self) -> &Vector3<f64> {
        &self.gravity_m_s2
    }
}
