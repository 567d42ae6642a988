//! The free rotation of a body with three different moments, by Taylor series step after step
//! ([`super::series`]).
//!
//! There is a closed form in Jacobi's elliptic functions. It loses digits of the derivatives where
//! moments are nearly equal or the body turns about a principal axis, and it costs more where one
//! arc is evaluated at many times (`tools/results`). The series have no such special cases, one step
//! serves all times within it, and its derivatives are those of the flow itself.
//!
//! Time is multiplied by the initial angular speed, rounded down to a power of two so that the
//! scaling is exact: slow and fast rotations take the same steps.

pub mod moments;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::series::{self, Columns, Series, Variables};
use crate::math::so3;
use crate::physics::body::{Body, Symmetry};

/// Longest rotation, as angle \[rad\]; since the speed is rounded down, up to twice this angle may
/// be computed. Longer ones would take too many steps to store.
pub const ANGLE_MAX_RAD: f64 = 2e3;

/// `c_i = (I_j − I_k)/I_i` of Euler's equations `ω̇_i = c_i ω_j ω_k`.
pub fn couplings(body: &Body) -> [f64; 3] {
    let moments = body.moments_kg_m2();
    [0, 1, 2].map(|i| (moments[(i + 1) % 3] - moments[(i + 2) % 3]) / moments[i])
}

/// A free rotation with its derivatives, in the units of the state.
#[derive(Clone, Debug)]
pub struct Turned {
    /// `R(0)⁻¹R(s)`.
    pub rotation: UnitQuaternion<f64>,
    /// `ω(s)` [rad/s, body].
    pub omega_rad_s: Vector3<f64>,
    /// Left perturbation of the rotation \[rad\] by `ω(0)` [rad/s].
    pub turn_by_spin: Matrix3<f64>,
    /// `∂ω(s)/∂ω(0)`.
    pub spin_by_spin: Matrix3<f64>,
}

/// The motion between two steps, in the frame of `R(0)` and in units of the speed.
#[derive(Clone, Debug)]
struct GridPoint {
    rotation: UnitQuaternion<f64>,
    variables: [f64; 3],
    /// Left perturbation of the rotation by `ω(0)`.
    turn_by_spin: Matrix3<f64>,
    /// Change of the variables by `ω(0)`.
    variables_by_spin: Matrix3<f64>,
}

/// What all steps of one rotation share.
#[derive(Clone, Debug)]
struct FlowMotion {
    /// `ω(0)`.
    omega_rad_s: Vector3<f64>,
    couplings: [f64; 3],
    moments: [f64; 3],
    variables: Variables,
    /// [`Variables::invariant`] of the start.
    invariant: f64,
    speed_rad_s: f64,
    start: GridPoint,
}

impl FlowMotion {
    fn new(body: &Body, omega_rad_s: &Vector3<f64>) -> Self {
        let couplings = couplings(body);
        let speed_rad_s = match power_of_two_below(omega_rad_s.norm()) {
            0.0 => 1.0,
            speed_rad_s => speed_rad_s,
        };
        let omega = (omega_rad_s / speed_rad_s).into();
        let variables = Variables::of(&couplings, &omega);
        let moments = body.moments_kg_m2().into();
        let start = variables.with_omega(&omega);
        Self {
            omega_rad_s: *omega_rad_s,
            couplings,
            moments,
            invariant: variables.invariant(&moments, &start),
            speed_rad_s,
            start: GridPoint {
                rotation: UnitQuaternion::identity(),
                variables: start,
                turn_by_spin: Matrix3::zeros(),
                variables_by_spin: variables.variables_by_omega(),
            },
            variables,
        }
    }

    /// Speed times duration; `None` where it is more than [`ANGLE_MAX_RAD`].
    fn angle(&self, duration_s: f64) -> Option<f64> {
        let angle = self.speed_rad_s * duration_s;
        (angle.abs() <= ANGLE_MAX_RAD).then_some(angle)
    }

    /// Variables at the end of a step, scaled to their invariant. Otherwise rounding errors of the
    /// speed would add up over many steps, and those of the angle as their sum.
    fn kept(&self, variables: [f64; 3]) -> [f64; 3] {
        let invariant = self.variables.invariant(&self.moments, &variables);
        if invariant == 0.0 {
            return variables;
        }
        let excess = (self.invariant - invariant) / invariant;
        variables.map(|variable| variable + variable * (0.5 * excess))
    }

    fn omega_rad_s(&self, node: &GridPoint) -> Vector3<f64> {
        Vector3::from(self.variables.omega(&node.variables)) * self.speed_rad_s
    }
}

/// The power of two at or below a number that is not negative; zero for the subnormal.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & 0x7ff0_0000_0000_0000)
}

/// Series of the variables, of `ω` and of the turn from a node.
struct FlowValues {
    variables: Series<3>,
    omega: Series<3>,
    turn: Series<4>,
    reach: f64,
}

impl FlowValues {
    fn new(motion: &FlowMotion, start: &GridPoint) -> Self {
        let (variables, omega) = motion.variables.series(&motion.couplings, &start.variables);
        let turn = series::turn(&omega);
        Self {
            reach: series::reach(&motion.variables, &variables, &turn),
            variables,
            omega,
            turn,
        }
    }

    /// The node at `angle` from the start, with the derivatives left as they were.
    fn node(&self, motion: &FlowMotion, start: &GridPoint, angle: f64) -> GridPoint {
        let turned = start.rotation.into_inner() * quaternion(series::value(&self.turn, angle));
        GridPoint {
            rotation: UnitQuaternion::new_normalize(turned),
            variables: motion.kept(series::value(&self.variables, angle)),
            ..start.clone()
        }
    }
}

fn quaternion([x, y, z, w]: [f64; 4]) -> Quaternion<f64> {
    Quaternion::new(w, x, y, z)
}

/// One step: the rotation near a node, to both sides.
///
/// Euler's equations are homogeneous: a rotation twice as fast is the same in half the time. So the
/// derivative in the direction of the variables `z` themselves is known, `z + t ż` for the
/// variables and `η = t ω` for the rotation; series are needed for two other directions only.
#[derive(Clone, Debug)]
struct FlowStep {
    start: GridPoint,
    reach: f64,
    variables: Series<3>,
    turn: Series<4>,
    /// Derivatives of the variables, and `η`, by two of the variables at the start.
    variables_by_start: Columns,
    eta: Columns,
    /// A change of `ω(0)` as coefficients: of the direction `z`, then of the two variables.
    parts: Matrix3<f64>,
    /// The direction in place of `z` where all variables are zero; zero elsewhere.
    stand_in: Vector3<f64>,
}

impl FlowStep {
    fn new(motion: &FlowMotion, start: GridPoint) -> Self {
        let values = FlowValues::new(motion, &start);
        let z = &start.variables;
        let largest = Vector3::from(*z).iamax();
        let by = [(largest + 1) % 3, (largest + 2) % 3];
        let (variables_by_start, w) =
            motion
                .variables
                .derivatives(&motion.couplings, &values.variables, by);
        let eta = series::turn_derivatives(&values.omega, &w);
        let changes = &start.variables_by_spin;
        let mut stand_in = Vector3::zeros();
        if z[largest] == 0.0 {
            stand_in[largest] = 1.0;
        }
        let along = changes.row(largest) / (z[largest] + stand_in[largest]);
        let parts = Matrix3::from_rows(&[
            along,
            changes.row(by[0]) - along * z[by[0]],
            changes.row(by[1]) - along * z[by[1]],
        ]);
        Self {
            reach: values.reach.min(series::derivatives_reach(&eta)),
            variables: values.variables,
            turn: values.turn,
            variables_by_start,
            eta,
            parts,
            stand_in,
            start,
        }
    }

    /// Rotation, its left perturbation by `ω(0)`, and the variables, at `angle` from the start.
    #[inline]
    fn turn(
        &self,
        motion: &FlowMotion,
        angle: f64,
    ) -> (UnitQuaternion<f64>, Matrix3<f64>, [f64; 3]) {
        let turned = quaternion(series::value(&self.turn, angle));
        let rotation = UnitQuaternion::new_unchecked(self.start.rotation.into_inner() * turned);
        let variables = series::value(&self.variables, angle);
        let along = Vector3::from(variables) + self.stand_in;
        let along = Vector3::from(motion.variables.omega(&along.into())) * angle;
        let [first, second] = series::columns(&self.eta, angle);
        let eta = Matrix3::from_columns(&[along, first, second]) * self.parts;
        let by_spin = self.start.turn_by_spin + so3::matrix(&rotation) * eta;
        (rotation, by_spin, variables)
    }

    fn node(&self, motion: &FlowMotion, angle: f64) -> GridPoint {
        let (rotation, turn_by_spin, variables) = self.turn(motion, angle);
        let rate = motion.variables.rate(&motion.couplings, &variables);
        let along = Vector3::from(variables) + self.stand_in + Vector3::from(rate) * angle;
        let [first, second] = series::columns(&self.variables_by_start, angle);
        GridPoint {
            rotation: UnitQuaternion::new_normalize(rotation.into_inner()),
            variables: motion.kept(variables),
            turn_by_spin,
            variables_by_spin: Matrix3::from_columns(&[along, first, second]) * self.parts,
        }
    }
}

/// `R(0)⁻¹R(s)` and `ω(s)` [rad/s, body] without derivatives; NaN beyond [`ANGLE_MAX_RAD`].
pub fn advance(
    body: &Body,
    omega_rad_s: &Vector3<f64>,
    duration_s: f64,
) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let motion = FlowMotion::new(body, omega_rad_s);
    let Some(angle) = motion.angle(duration_s) else {
        let unknown = unknown();
        return (unknown.rotation, unknown.omega_rad_s);
    };
    let mut node = motion.start.clone();
    let mut left = angle;
    while left != 0.0 {
        let values = FlowValues::new(&motion, &node);
        let step = left.clamp(-values.reach, values.reach);
        node = values.node(&motion, &node, step);
        left -= step;
    }
    (node.rotation, motion.omega_rad_s(&node))
}

/// All NaN.
fn unknown() -> Turned {
    let unknown = Vector3::repeat(f64::NAN);
    Turned {
        rotation: UnitQuaternion::new_unchecked(Quaternion::from_parts(f64::NAN, unknown)),
        omega_rad_s: unknown,
        turn_by_spin: Matrix3::repeat(f64::NAN),
        spin_by_spin: Matrix3::repeat(f64::NAN),
    }
}

/// The rotation from one initial angular velocity: its steps, computed when first needed.
#[derive(Clone, Debug)]
pub struct Steps {
    motion: FlowMotion,
    /// Steps after the start, and before it.
    sides: [OneWay; 2],
}

/// Steps in one direction of time, and the distance of each one's beginning from the start.
#[derive(Clone, Debug, Default)]
struct OneWay {
    starts: Vec<f64>,
    /// Kilobytes each: apart, so that none is moved where there are more.
    #[allow(clippy::vec_box)]
    steps: Vec<Box<FlowStep>>,
}

impl Steps {
    /// The rotation with the initial angular velocity `ω` [rad/s, body].
    pub fn new(body: &Body, omega_rad_s: &Vector3<f64>) -> Self {
        Self {
            motion: FlowMotion::new(body, omega_rad_s),
            sides: [OneWay::default(), OneWay::default()],
        }
    }

    /// Those of a body that needs them: with three different moments.
    pub fn needed(body: &Body, omega_rad_s: &Vector3<f64>) -> Option<Self> {
        (body.symmetry() == Symmetry::Asymmetric).then(|| Self::new(body, omega_rad_s))
    }

    /// All of them: none are left here, to be computed anew where one is needed.
    pub fn take(&mut self) -> Self {
        Self {
            motion: self.motion.clone(),
            sides: std::mem::take(&mut self.sides),
        }
    }

    /// Whether they are those of a body with an initial angular velocity [rad/s, body].
    pub fn are_of(&self, body: &Body, omega_rad_s: &Vector3<f64>) -> bool {
        let moments: [f64; 3] = body.moments_kg_m2().into();
        self.motion.omega_rad_s == *omega_rad_s && self.motion.moments == moments
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
        self.reach(angle);
        let (step, further) = self.sides[usize::from(angle < 0.0)].at(angle);
        let (rotation, by_spin, _) = step.turn(&self.motion, further);
        (rotation, by_spin / angle)
    }

    /// The rotation with all its derivatives; NaN beyond [`ANGLE_MAX_RAD`].
    pub fn turned(&mut self, duration_s: f64) -> Turned {
        let Some(angle) = self.motion.angle(duration_s) else {
            return unknown();
        };
        self.reach(angle);
        let motion = &self.motion;
        let node = match angle {
            0.0 => motion.start.clone(),
            _ => {
                let (step, further) = self.sides[usize::from(angle < 0.0)].at(angle);
                step.node(motion, further)
            }
        };
        Turned {
            rotation: node.rotation,
            omega_rad_s: motion.omega_rad_s(&node),
            turn_by_spin: node.turn_by_spin / motion.speed_rad_s,
            spin_by_spin: motion.variables.omega_by_variables() * node.variables_by_spin,
        }
    }

    /// Computes the steps up to an angle.
    fn reach(&mut self, angle: f64) {
        let side = &mut self.sides[usize::from(angle < 0.0)];
        while side.end() < angle.abs() {
            side.extend(&self.motion, angle.signum());
        }
    }
}

impl OneWay {
    /// How far from the start the steps reach.
    fn end(&self) -> f64 {
        match (self.starts.last(), self.steps.last()) {
            (Some(start), Some(step)) => start + step.reach,
            _ => 0.0,
        }
    }

    /// The step that an angle is in, other than zero, and how far from the step's beginning.
    fn at(&self, angle: f64) -> (&FlowStep, f64) {
        let distance = angle.abs();
        let at = self.starts.partition_point(|start| *start < distance) - 1;
        (
            &self.steps[at],
            (distance - self.starts[at]).copysign(angle),
        )
    }

    fn extend(&mut self, motion: &FlowMotion, direction: f64) {
        let node = match self.steps.last() {
            Some(step) => step.node(motion, step.reach * direction),
            None => motion.start.clone(),
        };
        self.starts.push(self.end());
        self.steps.push(Box::new(FlowStep::new(motion, node)));
    }
}
