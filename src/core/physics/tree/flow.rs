//! The flow of a tree: the map (state, duration) → state, with the derivatives of the very steps.
//!
//! The angular state is integrated by an explicit Runge–Kutta method in fixed steps, and told within a step by the
//! method's own polynomial; the quaternions are points of R⁴, of which the direction counts. Changes of the state run
//! through the same stages and polynomials, so that they are derivatives of the discrete map to rounding. Of a free tree
//! the centre of mass flies on a parabola and is not integrated at all; neither are changes that only move, push
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
use super::tangent::{Tangent, four, times_rate};
use crate::math::so3;

/// Most steps from the start to a time.
const MOST_STEPS: f64 = 2e4;

/// The motion of a tree from a start, advanced from sample to sample.
#[derive(Clone, Debug)]
pub struct Flow<'t> {
    pub(super) tree: &'t Tree,
    pub(super) tableau: Tableau,
    pub(super) root: Root,
    pub(super) gravity_m_s2: Vector3<f64>,
    pub(super) field: Field,
    pub(super) change: Change,
    pub(super) tangent: Tangent,
    pub(super) has_derivatives: bool,
    /// Angular coordinates, then rates: now, where the step began, in a stage.
    pub(super) state: Vec<f64>,
    pub(super) from: Vec<f64>,
    pub(super) stage: Vec<f64>,
    /// Their slopes per stage.
    pub(super) slopes: Vec<f64>,
    /// The same of the changes: rows of `stride` numbers, a direction per coordinate that counts, then one
    /// per rate. Their slopes are times the step.
    pub(super) stride: usize,
    pub(super) changes: Vec<f64>,
    pub(super) from_changes: Vec<f64>,
    pub(super) stage_changes: Vec<f64>,
    pub(super) change_slopes: Vec<f64>,
    /// How many of the step's stages are computed,
    pub(super) stages: usize,
    /// its length \[s\], which is asked for, and how many went before from the start; when it began \[s, since the start\], and
    /// which share of it is over.
    pub(super) step_s: f64,
    asked_s: f64,
    step_number: usize,
    pub(super) begun_s: f64,
    pub(super) share: f64,
    pub(super) start: FlowStart,
    /// Time since the start \[s\].
    pub(super) elapsed_s: f64,
    pub(super) centre: Centre,
}

/// What is kept of the start.
#[derive(Clone, Debug)]
pub(super) struct FlowStart {
    pub state: Vec<f64>,
    pub time_s: f64,
    pub rotation: nalgebra::Matrix3<f64>,
    pub centre: Centre,
    /// Of a free tree: centre of mass [m, world] and its velocity.
    pub centre_m: Vector3<f64>,
    pub centre_velocity_m_s: Vector3<f64>,
}

impl<'t> Flow<'t> {
    /// Room for a tree in a field of gravity [m/s²].
    pub fn new(tree: &'t Tree, gravity_m_s2: &Vector3<f64>, tableau: Tableau) -> Self {
        let size = tree.coordinates + tree.columns;
        let width = 2 * tree.columns - tree.first_turned();
        let stride = width.next_multiple_of(LANES);
        let stages = tableau.stages();
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
            from: vec![0.0; size],
            stage: vec![0.0; size],
            slopes: vec![0.0; stages * size],
            stride,
            changes: vec![0.0; size * stride],
            from_changes: vec![0.0; size * stride],
            stage_changes: vec![0.0; size * stride],
            change_slopes: vec![0.0; stages * size * stride],
            stages: 0,
            step_s: 0.0,
            asked_s: 0.0,
            step_number: 0,
            begun_s: 0.0,
            share: 0.0,
            start: FlowStart {
                state: vec![0.0; size],
                time_s: 0.0,
                rotation: nalgebra::Matrix3::identity(),
                centre: Centre::new(tree),
                centre_m: Vector3::zeros(),
                centre_velocity_m_s: Vector3::zeros(),
            },
            elapsed_s: 0.0,
            centre: Centre::new(tree),
        }
    }

    /// Begins at a state.
    pub fn begin(&mut self, state: &TreeState, has_derivatives: bool) {
        let (tree, shift) = (self.tree, self.tree.shift());
        let (coordinates, rates) = self.start.state.split_at_mut(tree.coordinates);
        coordinates.copy_from_slice(&state.coordinates[shift..]);
        rates.copy_from_slice(&state.rates[shift..]);
        self.start.time_s = state.time_s;
        self.has_derivatives = has_derivatives;
        self.restart();
        if tree.is_free {
            self.place();
            self.start.centre.clone_from(&self.centre);
            self.start.rotation = self.rotation();
            let turn = self.start.rotation;
            self.start.centre_m =
                Vector3::from_column_slice(&state.coordinates) + turn * self.centre.offset;
            self.start.centre_velocity_m_s =
                Vector3::from_column_slice(&state.rates) + turn * self.centre.velocity;
        }
    }

    /// Back to the start.
    fn restart(&mut self) {
        self.state.copy_from_slice(&self.start.state);
        if self.has_derivatives {
            self.seed();
        }
        (self.elapsed_s, self.asked_s, self.step_number) = (0.0, 0.0, 0);
        self.begin_step(0.0);
    }

    /// A step begins now, at a time since the start \[s\].
    fn begin_step(&mut self, begun_s: f64) {
        self.begun_s = begun_s;
        self.from.copy_from_slice(&self.state);
        if self.has_derivatives {
            self.from_changes.copy_from_slice(&self.changes);
        }
        (self.stages, self.share) = (0, 0.0);
    }

    /// Goes on for `duration_s` (negative: back) in `steps` equal steps, at least one.
    pub fn advance(&mut self, duration_s: f64, steps: usize) {
        let step_s = duration_s / steps as f64;
        match &self.tree.hand {
            Some(_) => self.advance_in_hand(duration_s, step_s),
            None => {
                self.step_s = step_s;
                for step in 0..steps {
                    self.begin_step(self.elapsed_s + step as f64 * step_s);
                    self.end_step();
                }
            }
        }
        self.elapsed_s += duration_s;
        self.begin_step(self.elapsed_s);
        // No step from the start: what reaches a time begins there again.
        self.asked_s = 0.0;
    }

    /// Goes on in steps that are not longer, and end where the hand's motion is not smooth.
    fn advance_in_hand(&mut self, duration_s: f64, most_s: f64) {
        let end_s = self.elapsed_s + duration_s;
        let mut now_s = self.elapsed_s;
        while (end_s - now_s) * most_s > 0.0 {
            self.begin_step(now_s);
            self.step_s = self.next_step_s(now_s, end_s, most_s);
            self.end_step();
            now_s = match now_s + self.step_s {
                // Rounding: no step of next to nothing.
                next_s if (end_s - next_s).abs() < 1e-6 * most_s.abs() => end_s,
                next_s => next_s,
            };
        }
    }

    /// The step in a hand from a time towards an end, since the start \[s\].
    fn next_step_s(&self, from_s: f64, end_s: f64, most_s: f64) -> f64 {
        let start_s = self.start.time_s;
        let hand = self.tree.hand.as_ref();
        hand.map_or(most_s, |hand| {
            hand.step_s(start_s + from_s, start_s + end_s, most_s)
        })
    }

    /// Goes to a time since the start (negative: before it), on or back, in steps of a length, the last one as far as
    /// needed: the same state whatever came before. Back within what is passed costs the way from the start. The state
    /// is no number at times that are none, or twenty thousand steps away.
    pub fn reach(&mut self, elapsed_s: f64, step_s: f64) {
        let step_s = step_s.copysign(elapsed_s);
        let elapsed_s = match (elapsed_s / step_s).abs() < MOST_STEPS {
            true => elapsed_s,
            false => f64::NAN,
        };
        let far_s = f64::INFINITY.copysign(step_s);
        let is_passed = (elapsed_s - self.begun_s) * step_s < 0.0;
        if step_s != self.asked_s || is_passed {
            self.restart();
            self.asked_s = step_s;
            self.step_s = self.next_step_s(0.0, far_s, step_s);
        }
        let is_in_hand = self.tree.is_in_hand();
        let share = loop {
            let share = match is_in_hand {
                true => (elapsed_s - self.begun_s) / self.step_s,
                false => elapsed_s / step_s - self.step_number as f64,
            };
            if !(share > 1.0) {
                break share;
            }
            self.end_step();
            let has_end = self.stages > self.tableau.b.len();
            self.step_number += 1;
            let begins_s = match is_in_hand {
                true => self.begun_s + self.step_s,
                false => self.step_number as f64 * step_s,
            };
            self.begin_step(begins_s);
            if is_in_hand {
                // Of another length: slopes of changes are times the step.
                self.step_s = self.next_step_s(begins_s, far_s, step_s);
            } else if has_end {
                self.keep_end();
            }
        };
        self.elapsed_s = elapsed_s;
        self.tell(share);
    }

    /// The state now.
    pub fn state(&mut self) -> TreeState {
        let (tree, shift) = (self.tree, self.tree.shift());
        let mut coordinates = vec![0.0; shift];
        let mut rates = vec![0.0; shift];
        if tree.is_free {
            self.place();
            let turn = self.rotation();
            let (centre_m, velocity_m_s) = self.flown();
            let position = centre_m - turn * self.centre.offset;
            let velocity = velocity_m_s - turn * self.centre.velocity;
            coordinates.copy_from_slice(position.as_slice());
            rates.copy_from_slice(velocity.as_slice());
        }
        coordinates.extend_from_slice(&self.state[..tree.coordinates]);
        rates.extend_from_slice(&self.state[tree.coordinates..]);
        for node in tree.nodes.iter().filter(|node| node.motor == Motor::Ball) {
            let range = node.coordinates();
            let turn = &mut coordinates[shift + range.start..shift + range.end];
            let inverse = 1.0 / turn.iter().map(|part| part * part).sum::<f64>().sqrt();
            turn.iter_mut().for_each(|part| *part *= inverse);
        }
        TreeState {
            coordinates,
            rates,
            time_s: self.start.time_s + self.elapsed_s,
        }
    }

    /// Centre of mass of a free tree now [m, world], and its velocity.
    pub(super) fn flown(&self) -> (Vector3<f64>, Vector3<f64>) {
        let (start, for_s) = (&self.start, self.elapsed_s);
        (
            start.centre_m
                + start.centre_velocity_m_s * for_s
                + self.gravity_m_s2 * (0.5 * for_s * for_s),
            start.centre_velocity_m_s + self.gravity_m_s2 * for_s,
        )
    }

    /// The free base's orientation, world from body.
    pub(super) fn rotation(&self) -> nalgebra::Matrix3<f64> {
        let unit = nalgebra::UnitQuaternion::new_normalize(quaternion(&self.state));
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
                Motor::Pin | Motor::Slide => {
                    self.changes[node.coordinate * stride + direction] = 1.0;
                }
                // δQ = ½ Q θ
                Motor::Ball => {
                    let q = four(&self.state[node.coordinate..]);
                    for axis in 0..3 {
                        let mut theta = [0.0; 3];
                        theta[axis] = 0.5;
                        let moved = times_rate(&q, &theta);
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
}
