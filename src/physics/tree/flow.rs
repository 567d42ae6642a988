//! The flow of a tree: the map (state, duration) → state, with the derivatives of the very steps.
//!
//! The angular state is integrated by an explicit Runge–Kutta method in fixed steps; the quaternions
//! are points of R⁴ that are made unit after each step. Changes of the state run through the same
//! stages, so that they are derivatives of the discrete map to rounding. Of a free tree the centre of mass
//! flies on a parabola and is not integrated at all; neither are changes that only move, push
//! or turn the tree as a whole: their course is known.

use nalgebra::Vector3;

use super::articulated::LANES;
use super::centre::Centre;
use super::change::Change;
use super::field::Field;
use super::kinematics::Root;
use super::model::{Motor, Tree};
use super::state::{TreeState, quaternion};
use super::tableau::Tableau;
use super::tangent::{Tangent, coordinates_by_time, four};
use crate::math::so3;

/// The motion of a tree from a start, advanced from sample to sample.
#[derive(Clone, Debug)]
pub struct Flow<'t> {
    pub(super) tree: &'t Tree,
    tableau: Tableau,
    pub(super) root: Root,
    pub(super) gravity_m_s2: Vector3<f64>,
    pub(super) field: Field,
    change: Change,
    tangent: Tangent,
    pub(super) has_derivatives: bool,
    /// Angular coordinates, then rates; in a stage; slopes per stage.
    pub(super) state: Vec<f64>,
    stage: Vec<f64>,
    slopes: Vec<f64>,
    /// The same of the changes: rows of `stride` numbers, a direction per coordinate that counts, one
    /// per rate, then one for time. Their slopes are times the step.
    pub(super) stride: usize,
    pub(super) changes: Vec<f64>,
    stage_changes: Vec<f64>,
    change_slopes: Vec<f64>,
    /// Of a free tree: centre of mass [m, world] and its velocity, now.
    pub(super) centre_m: Vector3<f64>,
    pub(super) centre_velocity_m_s: Vector3<f64>,
    pub(super) start: Start,
    pub(super) centre: Centre,
}

/// What of the start the derivatives need.
#[derive(Clone, Debug)]
pub(super) struct Start {
    pub rotation: nalgebra::Matrix3<f64>,
    pub centre: Centre,
    pub elapsed_s: f64,
    /// Change of the elapsed time with the parameter of the last direction.
    pub elapsed_by_time: f64,
}

impl<'t> Flow<'t> {
    /// Room for a tree in a field of gravity [m/s²].
    pub fn new(tree: &'t Tree, gravity_m_s2: &Vector3<f64>, tableau: Tableau) -> Self {
        let size = tree.coordinates + tree.columns;
        let width = 2 * tree.columns - tree.first_turned() + 1;
        let stride = width.next_multiple_of(LANES);
        let stages = tableau.b.len();
        Self {
            tree,
            tableau,
            root: if tree.is_free {
                Root::FALLING
            } else {
                Root::at_rest(gravity_m_s2)
            },
            gravity_m_s2: *gravity_m_s2,
            field: Field::new(tree),
            change: Change::new(tree),
            tangent: Tangent::new(tree, stride),
            has_derivatives: false,
            state: vec![0.0; size],
            stage: vec![0.0; size],
            slopes: vec![0.0; stages * size],
            stride,
            changes: vec![0.0; size * stride],
            stage_changes: vec![0.0; size * stride],
            change_slopes: vec![0.0; stages * size * stride],
            centre_m: Vector3::zeros(),
            centre_velocity_m_s: Vector3::zeros(),
            start: Start {
                rotation: nalgebra::Matrix3::identity(),
                centre: Centre::new(tree),
                elapsed_s: 0.0,
                elapsed_by_time: 0.0,
            },
            centre: Centre::new(tree),
        }
    }

    /// Begins at a state.
    pub fn begin(&mut self, state: &TreeState, has_derivatives: bool) {
        let (tree, shift) = (self.tree, self.tree.shift());
        let (coordinates, rates) = self.state.split_at_mut(tree.coordinates);
        coordinates.copy_from_slice(&state.coordinates[shift..]);
        rates.copy_from_slice(&state.rates[shift..]);
        self.has_derivatives = has_derivatives;
        (self.start.elapsed_s, self.start.elapsed_by_time) = (0.0, 0.0);
        if tree.is_free {
            self.place();
            self.start.centre.clone_from(&self.centre);
            self.start.rotation = self.rotation();
            let turn = self.start.rotation;
            self.centre_m =
                Vector3::from_column_slice(&state.coordinates) + turn * self.centre.offset;
            self.centre_velocity_m_s =
                Vector3::from_column_slice(&state.rates) + turn * self.centre.velocity;
        }
        if has_derivatives {
            self.seed();
        }
    }

    /// Goes on for `duration_s` (negative: back) in `steps` equal steps, at least one. The last direction's parameter
    /// changes the duration by `duration_by_time`.
    pub fn advance(&mut self, duration_s: f64, steps: usize, duration_by_time: f64) {
        self.turn(duration_s, steps, duration_by_time);
        self.centre_m += self.centre_velocity_m_s * duration_s
            + self.gravity_m_s2 * (0.5 * duration_s * duration_s);
        self.centre_velocity_m_s += self.gravity_m_s2 * duration_s;
        self.start.elapsed_s += duration_s;
        self.start.elapsed_by_time += duration_by_time;
    }

    /// The angular state goes on.
    pub(super) fn turn(&mut self, duration_s: f64, steps: usize, duration_by_time: f64) {
        let count = steps as f64;
        for _ in 0..steps {
            self.step(duration_s / count, duration_by_time / count);
        }
    }

    /// The state now.
    pub fn state(&mut self) -> TreeState {
        let (tree, shift) = (self.tree, self.tree.shift());
        let mut coordinates = vec![0.0; shift];
        let mut rates = vec![0.0; shift];
        if tree.is_free {
            self.place();
            let turn = self.rotation();
            let position = self.centre_m - turn * self.centre.offset;
            let velocity = self.centre_velocity_m_s - turn * self.centre.velocity;
            coordinates.copy_from_slice(position.as_slice());
            rates.copy_from_slice(velocity.as_slice());
        }
        coordinates.extend_from_slice(&self.state[..tree.coordinates]);
        rates.extend_from_slice(&self.state[tree.coordinates..]);
        TreeState { coordinates, rates }
    }

    /// The free base's orientation, world from body.
    pub(super) fn rotation(&self) -> nalgebra::Matrix3<f64> {
        let unit = nalgebra::UnitQuaternion::new_unchecked(quaternion(&self.state));
        so3::matrix(&unit)
    }

    /// The centre of mass against the base, now.
    pub(super) fn place(&mut self) {
        let (coordinates, rates) = self.state.split_at(self.tree.coordinates);
        self.field.place(self.tree, coordinates, rates, &self.root);
        self.centre.evaluate(self.tree, &self.field);
    }

    /// One for each direction.
    fn seed(&mut self) {
        let (tree, stride, turned) = (self.tree, self.stride, self.tree.first_turned());
        self.changes.fill(0.0);
        for node in &tree.nodes {
            if node.column < turned {
                continue;
            }
            let direction = node.column - turned;
            match node.motor {
                Motor::Pin => self.changes[node.coordinate * stride + direction] = 1.0,
                // δQ = ½ Q θ
                Motor::Ball => {
                    let q = four(&self.state[node.coordinate..]);
                    for axis in 0..3 {
                        let mut theta = [0.0; 3];
                        theta[axis] = 0.5;
                        let moved = super::tangent::times_rate(&q, &theta);
                        for part in 0..4 {
                            self.changes[(node.coordinate + part) * stride + direction + axis] =
                                moved[part];
                        }
                    }
                }
            }
        }
        for column in 0..tree.columns {
            let direction = tree.columns - turned + column;
            self.changes[(tree.coordinates + column) * stride + direction] = 1.0;
        }
    }

    fn step(&mut self, step_s: f64, step_by_time: f64) {
        for (stage, weights) in self.tableau.a.iter().enumerate() {
            combine(&self.state, step_s, weights, &self.slopes, &mut self.stage);
            self.slope(stage);
            if self.has_derivatives {
                combine(
                    &self.changes,
                    1.0,
                    weights,
                    &self.change_slopes,
                    &mut self.stage_changes,
                );
                self.change_slope(stage, step_s, step_by_time);
            }
        }
        add(&mut self.state, step_s, self.tableau.b, &self.slopes);
        if self.has_derivatives {
            add(&mut self.changes, 1.0, self.tableau.b, &self.change_slopes);
        }
        self.normalise();
    }

    /// `f(Y)`.
    fn slope(&mut self, stage: usize) {
        let tree = self.tree;
        let (coordinates, rates) = self.stage.split_at(tree.coordinates);
        self.field.evaluate(tree, coordinates, rates, &self.root);
        let size = self.stage.len();
        let slope = &mut self.slopes[stage * size..(stage + 1) * size];
        coordinates_by_time(tree, &self.stage, slope);
        slope[tree.coordinates..].copy_from_slice(&self.field.rates_by_time);
    }

    /// `h f'(Y) δY + δh f(Y)`.
    fn change_slope(&mut self, stage: usize, step_s: f64, step_by_time: f64) {
        let (tree, size, wide) = (self.tree, self.state.len(), self.changes.len());
        let coordinates = &self.stage[..tree.coordinates];
        self.change
            .evaluate(tree, &mut self.field, coordinates, &self.root);
        let slope = &mut self.change_slopes[stage * wide..(stage + 1) * wide];
        self.tangent
            .slope(tree, &self.stage, &self.change, &self.stage_changes, slope);
        for number in slope.iter_mut() {
            *number *= step_s;
        }
        if step_by_time == 0.0 {
            return;
        }
        let time = 2 * tree.columns - tree.first_turned();
        for row in 0..size {
            slope[row * self.stride + time] += step_by_time * self.slopes[stage * size + row];
        }
    }

    /// Makes the quaternions unit, `Q/|Q|`, with their changes.
    fn normalise(&mut self) {
        let stride = self.stride;
        for node in self
            .tree
            .nodes
            .iter()
            .filter(|node| node.motor == Motor::Ball)
        {
            let range = node.coordinates();
            let q = four(&self.state[range.start..]);
            let inverse = 1.0 / q.iter().map(|part| part * part).sum::<f64>().sqrt();
            let unit = q.map(|part| part * inverse);
            self.state[range.clone()].copy_from_slice(&unit);
            if !self.has_derivatives {
                continue;
            }
            let rows = &mut self.changes[range.start * stride..range.end * stride];
            for lane in 0..stride {
                let along: f64 = (0..4)
                    .map(|part| unit[part] * rows[part * stride + lane])
                    .sum();
                for part in 0..4 {
                    let row = &mut rows[part * stride + lane];
                    *row = (*row - unit[part] * along) * inverse;
                }
            }
        }
    }
}

/// `y + h Σ a_j k_j`.
fn combine(from: &[f64], step: f64, weights: &[f64], slopes: &[f64], to: &mut [f64]) {
    to.copy_from_slice(from);
    add(to, step, weights, slopes);
}

fn add(to: &mut [f64], step: f64, weights: &[f64], slopes: &[f64]) {
    for (weight, slope) in weights.iter().zip(slopes.chunks_exact(to.len())) {
        if *weight != 0.0 {
            let weight = step * weight;
            for (sum, number) in to.iter_mut().zip(slope) {
                *sum += weight * number;
            }
        }
    }
}
