//! The turn of a body with three different moments, by Taylor series step after step
//! ([`super::series`]).
//!
//! It has a closed form in elliptic functions, which loses its derivatives' digits where
//! moments are nearly equal or the body turns about a principal axis, and costs more where one
//! arc is asked for at many times (`tools/flows`). Steps know no such cases, serve all times
//! within them, and their derivatives are those of the flow itself.
//!
//! Time is counted in units of the first angular speed, down to a power of two so that nothing
//! is rounded: slow turns and fast ones are the same steps.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::series::{self, Series, Variables};
use crate::math::so3;
use crate::physics::body::Body;

/// Turns beyond this angle \[rad\], or half of it, are not computed: their steps would be too
/// many to keep.
pub const ANGLE_MAX_RAD: f64 = 2e4;

/// `c_i = (I_j − I_k)/I_i` of Euler's equations `ω̇_i = c_i ω_j ω_k`.
pub fn couplings(body: &Body) -> [f64; 3] {
    let moments = body.moments_kg_m2();
    [0, 1, 2].map(|i| (moments[(i + 1) % 3] - moments[(i + 2) % 3]) / moments[i])
}

/// Where steps meet, seen from the epoch's frame and in units of the speed.
#[derive(Clone, Debug)]
pub struct Node {
    /// `R(0)⁻¹R`.
    pub rotation: UnitQuaternion<f64>,
    /// `ω`, body.
    pub omega: Vector3<f64>,
    /// Left perturbation of the rotation by `ω(0)`.
    pub turn_by_spin: Matrix3<f64>,
    /// `∂ω/∂ω(0)`.
    pub spin_by_spin: Matrix3<f64>,
    variables: [f64; 3],
}

/// What all steps of one turn share.
#[derive(Clone, Debug)]
struct Motion {
    couplings: [f64; 3],
    variables: Variables,
    speed_rad_s: f64,
    start: Node,
}

impl Motion {
    fn new(body: &Body, omega_rad_s: &Vector3<f64>) -> Self {
        let couplings = couplings(body);
        let speed_rad_s = match power_of_two_below(omega_rad_s.norm()) {
            0.0 => 1.0,
            speed_rad_s => speed_rad_s,
        };
        let omega = omega_rad_s / speed_rad_s;
        let variables = Variables::of(&couplings, &omega.into());
        Self {
            couplings,
            speed_rad_s,
            start: Node {
                rotation: UnitQuaternion::identity(),
                omega,
                turn_by_spin: Matrix3::zeros(),
                spin_by_spin: Matrix3::identity(),
                variables: variables.from_omega(&omega.into()),
            },
            variables,
        }
    }

    /// A duration in units of the speed; none where it is too long.
    fn angle(&self, duration_s: f64) -> Option<f64> {
        let angle = self.speed_rad_s * duration_s;
        (angle.abs() <= ANGLE_MAX_RAD).then_some(angle)
    }

    /// The end of the turn, step by step from the epoch; `None` beyond [`ANGLE_MAX_RAD`].
    fn end(&self, duration_s: f64, with_derivatives: bool) -> Option<Node> {
        let mut left = self.angle(duration_s)?;
        let mut node = self.start.clone();
        loop {
            let values = Values::new(self, &node);
            let step = left.clamp(-values.reach, values.reach);
            node = if with_derivatives {
                Step::new(self, node, values).node(self, step)
            } else {
                values.node(self, &node, step)
            };
            left -= step;
            if left == 0.0 {
                return Some(node);
            }
        }
    }
}

/// Series of `ω` and of the turn from a node.
struct Values {
    variables: Series<3>,
    omega: Series<3>,
    turn: Series<4>,
    reach: f64,
}

impl Values {
    fn new(motion: &Motion, start: &Node) -> Self {
        let (variables, omega) = motion.variables.series(&motion.couplings, &start.variables);
        let turn = series::turn(&omega);
        Self {
            reach: series::reach(&motion.variables, &variables, &turn),
            variables,
            omega,
            turn,
        }
    }

    /// The node at `angle` from the start, its derivatives as they were.
    fn node(&self, motion: &Motion, start: &Node, angle: f64) -> Node {
        let variables = series::value(&self.variables, angle);
        let turned = start.rotation.into_inner() * quaternion(series::value(&self.turn, angle));
        Node {
            rotation: UnitQuaternion::new_normalize(turned),
            omega: motion.variables.omega(&variables).into(),
            variables,
            ..start.clone()
        }
    }
}

fn quaternion([x, y, z, w]: [f64; 4]) -> Quaternion<f64> {
    Quaternion::new(w, x, y, z)
}

/// One step: the turn near a node, to both sides.
#[derive(Clone, Debug)]
struct Step {
    start: Node,
    reach: f64,
    variables: Series<3>,
    turn: Series<4>,
    /// Rows of `η` and `W`.
    derivatives: [Series<6>; 3],
}

impl Step {
    fn new(motion: &Motion, start: Node, values: Values) -> Self {
        Self {
            start,
            reach: values.reach,
            variables: values.variables,
            turn: values.turn,
            derivatives: series::derivatives(&motion.couplings, &values.omega),
        }
    }

    /// Rotation and its left perturbation by `ω(0)`, at `angle` from the start.
    #[inline]
    fn turn(&self, angle: f64) -> (UnitQuaternion<f64>, Matrix3<f64>, [[f64; 6]; 3]) {
        let turned = quaternion(series::value(&self.turn, angle));
        let rotation = UnitQuaternion::new_unchecked(self.start.rotation.into_inner() * turned);
        let rows = [0, 1, 2].map(|axis| series::value(&self.derivatives[axis], angle));
        let eta = Matrix3::from_fn(|i, j| rows[i][j]);
        let by_spin =
            self.start.turn_by_spin + so3::matrix(&rotation) * (eta * self.start.spin_by_spin);
        (rotation, by_spin, rows)
    }

    fn node(&self, motion: &Motion, angle: f64) -> Node {
        let variables = series::value(&self.variables, angle);
        let (rotation, turn_by_spin, rows) = self.turn(angle);
        Node {
            rotation: UnitQuaternion::new_normalize(rotation.into_inner()),
            omega: motion.variables.omega(&variables).into(),
            turn_by_spin,
            spin_by_spin: Matrix3::from_fn(|i, j| rows[i][3 + j]) * self.start.spin_by_spin,
            variables,
        }
    }
}

/// The power of two at or below a number that is not negative; zero for the subnormal.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & 0x7ff0_0000_0000_0000)
}

/// `R(0)⁻¹R(s)` and `ω(s)` [rad/s, body] alone.
pub fn advance(
    body: &Body,
    omega_rad_s: &Vector3<f64>,
    duration_s: f64,
) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let motion = Motion::new(body, omega_rad_s);
    let node = motion.end(duration_s, false).unwrap_or_else(unknown);
    (node.rotation, node.omega * motion.speed_rad_s)
}

/// The end of a turn in the units of the state: \[rad\] and [rad/s].
pub fn turn(body: &Body, omega_rad_s: &Vector3<f64>, duration_s: f64) -> Node {
    let motion = Motion::new(body, omega_rad_s);
    let mut node = motion.end(duration_s, true).unwrap_or_else(unknown);
    node.omega *= motion.speed_rad_s;
    node.turn_by_spin /= motion.speed_rad_s;
    node
}

/// Not a number, throughout.
fn unknown() -> Node {
    let unknown = Vector3::repeat(f64::NAN);
    Node {
        rotation: UnitQuaternion::new_unchecked(Quaternion::from_parts(f64::NAN, unknown)),
        omega: unknown,
        turn_by_spin: Matrix3::repeat(f64::NAN),
        spin_by_spin: Matrix3::repeat(f64::NAN),
        variables: unknown.into(),
    }
}

/// The turn of one angular velocity: its steps, made when a time is first asked for.
#[derive(Clone, Debug)]
pub struct Steps {
    motion: Motion,
    /// After the epoch, and before it.
    sides: [Side; 2],
}

/// Steps in one direction, and the distance of each one's start from the epoch.
#[derive(Clone, Debug, Default)]
struct Side {
    starts: Vec<f64>,
    steps: Vec<Step>,
}

impl Steps {
    /// The turn that begins with `ω` [rad/s, body].
    pub fn new(body: &Body, omega_rad_s: &Vector3<f64>) -> Self {
        Self {
            motion: Motion::new(body, omega_rad_s),
            sides: [Side::default(), Side::default()],
        }
    }

    /// See [`super::Spin::turn_and_derivative`].
    pub fn turn_and_derivative(&mut self, duration_s: f64) -> (UnitQuaternion<f64>, Matrix3<f64>) {
        let Some(angle) = self.motion.angle(duration_s) else {
            let unknown = unknown();
            return (unknown.rotation, unknown.turn_by_spin);
        };
        if angle == 0.0 {
            return (UnitQuaternion::identity(), Matrix3::identity());
        }
        let side = &mut self.sides[usize::from(angle < 0.0)];
        let distance = angle.abs();
        while side.end() < distance {
            side.extend(&self.motion, angle.signum());
        }
        let at = side.starts.partition_point(|start| *start < distance) - 1;
        let step = &side.steps[at];
        let (rotation, by_spin, _) = step.turn((distance - side.starts[at]).copysign(angle));
        (rotation, by_spin / angle)
    }
}

impl Side {
    /// How far from the epoch the steps reach.
    fn end(&self) -> f64 {
        match (self.starts.last(), self.steps.last()) {
            (Some(start), Some(step)) => start + step.reach,
            _ => 0.0,
        }
    }

    fn extend(&mut self, motion: &Motion, direction: f64) {
        let node = match self.steps.last() {
            Some(step) => step.node(motion, step.reach * direction),
            None => motion.start.clone(),
        };
        self.starts.push(self.end());
        let values = Values::new(motion, &node);
        self.steps.push(Step::new(motion, node, values));
    }
}
