//! Where the nodes of a tree are and how they move.
//!
//! All vectors are in one frame. For a clamped tree it has the world's axes, or those of the held body from which
//! it hangs, at this instant, and its origin where the first joint is; for a free one it is the first link's own frame, at this instant: how the links move
//! against each other does not depend on where the first one is, where it points and how fast its
//! centre flies (Galilei), so that these do not even come in.

use nalgebra::{Matrix3, Vector3};

use super::hand::Anchor;
use super::model::{Motor, Tree};
use super::spatial::Motion;
use super::state::quaternion;

/// How what the tree hangs from moves, as a [hand](super::Hand) does. For a free tree it is all zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Velocity.
    pub velocity: Motion,
    /// Acceleration, less gravity.
    pub acceleration: Motion,
    /// World from the frame,
    pub turn: Matrix3<f64>,
    /// and the frame's own velocity in the world [m/s, its axes]. These two tell what the air does.
    pub flying_m_s: Vector3<f64>,
}

impl Root {
    /// At rest in a field of gravity [m/s²].
    pub fn at_rest(gravity_m_s2: &Vector3<f64>) -> Self {
        Self {
            velocity: Motion::ZERO,
            acceleration: Motion {
                angular: Vector3::zeros(),
                linear: -gravity_m_s2,
            },
            ..Self::FALLING
        }
    }

    /// Of what hangs from a hand, in the held body's axes, in a field of gravity [m/s², world].
    pub(super) fn in_hand(anchor: &Anchor, gravity_m_s2: &Vector3<f64>) -> Self {
        let pulled_m_s2 = anchor.acceleration_m_s2 - gravity_m_s2;
        Self {
            velocity: Motion {
                angular: anchor.spin_rad_s,
                linear: Vector3::zeros(),
            },
            acceleration: Motion {
                angular: anchor.spin_rate_rad_s2,
                linear: anchor.turn.tr_mul(&pulled_m_s2),
            },
            turn: anchor.turn,
            flying_m_s: anchor.turn.tr_mul(&anchor.velocity_m_s),
        }
    }

    /// For what falls together with its frame.
    pub const FALLING: Self = Self {
        velocity: Motion::ZERO,
        acceleration: Motion::ZERO,
        turn: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        flying_m_s: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Frames, axes and velocities.
#[derive(Clone, Debug)]
pub struct Kinematics {
    /// Per node: its frame.
    pub rotations: Vec<Matrix3<f64>>,
    pub positions: Vec<Vector3<f64>>,
    /// Per column: the motion `S` of one unit of the rate.
    pub axes: Vec<Motion>,
    /// Per node: `v = v_λ + S u`.
    pub velocities: Vec<Motion>,
    /// Per node: acceleration without `u̇`, `a = a_λ + v_λ × S u`.
    pub drifts: Vec<Motion>,
}

impl Kinematics {
    /// Room for a tree.
    pub fn new(tree: &Tree) -> Self {
        let nodes = tree.nodes.len();
        Self {
            rotations: vec![Matrix3::identity(); nodes],
            positions: vec![Vector3::zeros(); nodes],
            axes: vec![Motion::ZERO; tree.columns],
            velocities: vec![Motion::ZERO; nodes],
            drifts: vec![Motion::ZERO; nodes],
        }
    }

    /// Of angular coordinates and rates, those without a free base's translation. Quaternions need not
    /// be unit, only their direction counts.
    pub fn update(&mut self, tree: &Tree, coordinates: &[f64], rates: &[f64], root: &Root) {
        for (index, node) in tree.nodes.iter().enumerate() {
            let (mut rotation, mut position, velocity, drift) = match node.parent {
                Some(parent) => (
                    self.rotations[parent] * node.rotation,
                    self.positions[parent] + self.rotations[parent] * node.translation,
                    self.velocities[parent],
                    self.drifts[parent],
                ),
                None => (
                    node.rotation,
                    node.translation,
                    root.velocity,
                    root.acceleration,
                ),
            };
            match node.motor {
                Motor::Pin => {
                    let (sin, cos) = coordinates[node.coordinate].sin_cos();
                    let (x, y) = (
                        rotation.column(0).into_owned(),
                        rotation.column(1).into_owned(),
                    );
                    rotation.set_column(0, &(x * cos + y * sin));
                    rotation.set_column(1, &(y * cos - x * sin));
                }
                Motor::Slide => {
                    let along = rotation.column(2) * coordinates[node.coordinate];
                    position += along;
                }
                // The frame is the free base's own.
                Motor::Ball if tree.is_free && index == 0 => {}
                Motor::Ball => rotation *= turn(&coordinates[node.coordinate..]),
            }
            let mut own = Motion::ZERO;
            let columns = node.columns();
            let first = 3 - columns.len();
            for (axis, column) in columns.enumerate() {
                // A pin turns about the third axis, a ball about all, and a slide moves along the third.
                let along = rotation
                    .column(if first == 0 { axis } else { 2 })
                    .into_owned();
                let moved = match node.motor {
                    Motor::Slide => Motion {
                        angular: Vector3::zeros(),
                        linear: along,
                    },
                    Motor::Pin | Motor::Ball => Motion {
                        angular: along,
                        linear: position.cross(&along),
                    },
                };
                self.axes[column] = moved;
                own += moved * rates[column];
            }
            self.rotations[index] = rotation;
            self.positions[index] = position;
            self.velocities[index] = velocity + own;
            self.drifts[index] = drift + velocity.cross(&own);
        }
    }
}

/// The rotation matrix of the direction of a quaternion.
fn turn(numbers: &[f64]) -> Matrix3<f64> {
    let q = quaternion(numbers);
    let (w, v) = (q.w, q.imag());
    let twice = 2.0 / q.norm_squared();
    let hat = v.cross_matrix();
    let square = v * v.transpose();
    let mut rotation = (hat * w + square) * twice;
    let trace = square.trace() * twice;
    for i in 0..3 {
        rotation[(i, i)] += 1.0 - trace;
    }
    rotation
}
