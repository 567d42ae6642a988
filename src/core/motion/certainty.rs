//! How certain a motion is along its flights.
//!
//! The state at a fixed physical time `t` depends on the unknowns `u` of its flight: the state at the epoch, and what acts
//! on the flight and was estimated. A number of it changes by `m·δu`, where `m` is the flow's derivative from the epoch to
//! `t`, and has the variance of that sum.
//!
//! Times count from the first sample used. Near an impact the state is that of the flight, continued: when the impact is
//! has a deviation of its own.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, Vector3};

use crate::math::{Pose, so3};
use crate::physics::flow::{Flown, WantedDerivatives};
use crate::physics::state::{StateTangent, part};
use crate::physics::{Body, State};

/// Greatest share of what is known of a number that is from damping; above it, it is undetermined.
const DAMPING_SHARE_MAX: f64 = 0.1;
/// Least share of it from samples, marks and wishes, or the performance does not determine it: less is rounding.
const INFORMED_SHARE_MIN: f64 = 1e-4;
/// A sum that varies by less than this share of what its unknowns would by themselves is held by constraints,
const HELD_SHARE: f64 = 1e-6;
/// and so is one of less than this variance, in SI units: a micrometre, or a microradian, squared.
const HELD: f64 = 1e-12;

/// The variance of a sum of unknowns by where it is from, or, as symmetric matrices, of every sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Variance<T> {
    /// By the inverse of the Karush–Kuhn–Tucker matrix: `mᵀ P m`.
    pub whole: T,
    /// Its part from damping.
    pub damped: T,
    /// Its part from samples, marks and goals that weigh.
    pub informed: T,
    /// Its part from all but the curvature of constraints.
    pub known: T,
    /// What the errors of samples make of it.
    pub errors: T,
    /// What the errors of priors make of it.
    pub priors: T,
}

impl Variance<f64> {
    /// Standard deviation; `None` where the performance does not determine the sum.
    pub fn sd(&self) -> Option<f64> {
        // Written so that NaN is undetermined too.
        let is_damped = !(self.damped <= DAMPING_SHARE_MAX * self.whole);
        if is_damped || self.informed < INFORMED_SHARE_MIN * self.known {
            return None;
        }
        Some((self.errors + self.priors.max(0.0)).sqrt())
    }
}

impl Variance<DMatrix<f64>> {
    /// That of one sum of the unknowns. What constraints hold is told, though no sample tells it.
    pub fn of(&self, sum: &DVector<f64>) -> Variance<f64> {
        let square = |form: &DMatrix<f64>| sum.dot(&(form * sum));
        let (whole, known) = (square(&self.whole), square(&self.known));
        let own = self.whole.diagonal().component_mul(sum).dot(sum);
        let is_held = whole <= (HELD_SHARE * own).max(HELD);
        Variance {
            informed: match is_held {
                true => known.max(0.0),
                false => square(&self.informed),
            },
            damped: match whole <= HELD {
                // What is left of it is rounding.
                true => 0.0,
                false => square(&self.damped),
            },
            // A sum of what is no number stays none.
            whole: if whole <= HELD { whole.max(0.0) } else { whole },
            known,
            // Of what is exact rounding may leave less than nothing.
            errors: square(&self.errors).max(0.0),
            priors: square(&self.priors),
        }
    }
}

/// How certain a flight is.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightCertainty {
    /// What each unknown after the twelve of the state changes.
    pub acting: Vec<FlightChange>,
    /// Of all of them.
    pub variance: Variance<DMatrix<f64>>,
}

/// A change of what acts on a flight, and of what flies, per unit of an unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightChange {
    /// Gravity, or a force per mass [m/s², world].
    pub pull_m_s2: Vector3<f64>,
    /// Linear drag [1/s] and quadratic drag [1/m].
    pub drag: [f64; 2],
    /// Lift of a ball.
    pub lift: f64,
    /// Logarithms of the principal moments.
    pub log_moments: Vector3<f64>,
    /// Centre of mass in the body [m, body].
    pub centre_m: Vector3<f64>,
    /// Friction of what supports it.
    pub friction: f64,
}

/// Standard deviations of the pose and the velocities of a frame of a body, axis by axis; `None` where the performance does
/// not determine one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateDeviation {
    /// Place of the frame's origin [m, world axes].
    pub position_m: [Option<f64>; 3],
    /// Turns about the frame's own axes \[rad\].
    pub orientation_rad: [Option<f64>; 3],
    /// Velocity of the frame's origin [m/s, world axes].
    pub velocity_m_s: [Option<f64>; 3],
    /// Angular velocity about the frame's own axes [rad/s].
    pub angular_velocity_rad_s: [Option<f64>; 3],
}

impl StateDeviation {
    /// Position, orientation, velocity and angular velocity.
    pub fn parts(&self) -> [[Option<f64>; 3]; 4] {
        [
            self.position_m,
            self.orientation_rad,
            self.velocity_m_s,
            self.angular_velocity_rad_s,
        ]
    }

    /// Of each part the root of the sum of the variances along its axes; `None` where one of them is.
    pub fn totals(&self) -> [Option<f64>; 4] {
        self.parts().map(|part| {
            let squares = part.iter().map(|sd| sd.map(|sd| sd * sd));
            squares.sum::<Option<f64>>().map(f64::sqrt)
        })
    }
}

impl FlightCertainty {
    /// Deviations `duration_s` after the epoch, at which the flight has the state, of a frame that is fixed in the body.
    pub fn deviation(
        &self,
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
        duration_s: f64,
        body_from_frame: &Pose,
    ) -> StateDeviation {
        let is_wanted = WantedDerivatives {
            by_drag: self.acting.iter().any(|by| by.drag != [0.0; 2]),
            by_lift: self.acting.iter().any(|by| by.lift != 0.0),
            by_moments: self
                .acting
                .iter()
                .any(|by| by.log_moments != Vector3::zeros()),
        };
        let flown = Flown::new(body, gravity_m_s2, state, duration_s, is_wanted);
        let then = flown.state();
        let frame = FrameRows::new(&then, body_from_frame);
        let by_state = frame.by_state * flown.by_state();
        let by_acting = self.acting.iter();
        let by_acting =
            by_acting.map(|change| frame.by_state * change.of(&flown) + frame.by(change));
        let by_acting: Vec<StateTangent> = by_acting.collect();
        let sds: [Option<f64>; 12] = std::array::from_fn(|row| {
            let by_state = by_state.row(row);
            let all = by_state.iter().copied();
            let all = all.chain(by_acting.iter().map(|by| by[row]));
            let sum = DVector::from_iterator(by_state.len() + by_acting.len(), all);
            self.variance.of(&sum).sd()
        });
        let three = |at: usize| [sds[at], sds[at + 1], sds[at + 2]];
        StateDeviation {
            position_m: three(part::POSITION),
            orientation_rad: three(part::ORIENTATION),
            velocity_m_s: three(part::VELOCITY),
            angular_velocity_rad_s: three(part::ANGULAR_VELOCITY),
        }
    }
}

impl FlightChange {
    /// The change of the state.
    fn of(&self, flown: &Flown) -> StateTangent {
        let mut by = StateTangent::zeros();
        for axis in 0..3 {
            by += flown.by_pull(axis) * self.pull_m_s2[axis];
            by += flown.by_log_moment(axis) * self.log_moments[axis];
        }
        for (order, change) in self.drag.iter().enumerate() {
            by += flown.by_drag(order) * *change;
        }
        if self.lift != 0.0 {
            by += flown.by_lift() * self.lift;
        }
        by + flown.by_friction() * self.friction
    }
}

/// Derivatives of a frame's pose and velocities by the state of the body in which it is fixed: of its origin at `r` in the
/// body, `x + R r` and `v + R (ω × r)`, and of turns and angular velocity in its own axes.
struct FrameRows {
    by_state: SMatrix<f64, 12, 12>,
    world_from_body: Matrix3<f64>,
    omega: Vector3<f64>,
}

impl FrameRows {
    fn new(state: &State, body_from_frame: &Pose) -> Self {
        let world_from_body = so3::matrix(&state.orientation);
        let omega = state.angular_velocity_rad_s;
        let r = body_from_frame.translation.vector;
        let frame_from_body = so3::matrix(&body_from_frame.rotation.inverse());
        let lever = -(world_from_body * so3::hat(&r));
        let swept = -(world_from_body * so3::hat(&omega.cross(&r)));
        let mut by_state = SMatrix::<f64, 12, 12>::identity();
        let mut set = |row: usize, column: usize, block: &Matrix3<f64>| {
            by_state
                .fixed_view_mut::<3, 3>(row, column)
                .copy_from(block);
        };
        set(part::POSITION, part::ORIENTATION, &lever);
        set(part::VELOCITY, part::ORIENTATION, &swept);
        set(part::VELOCITY, part::ANGULAR_VELOCITY, &lever);
        for at in [part::ORIENTATION, part::ANGULAR_VELOCITY] {
            set(at, at, &frame_from_body);
        }
        Self {
            by_state,
            world_from_body,
            omega,
        }
    }

    /// By the place of the centre of mass in the body: `r` is from there.
    fn by(&self, change: &FlightChange) -> StateTangent {
        let mut by = StateTangent::zeros();
        let moved = -(self.world_from_body * change.centre_m);
        let swept = -(self.world_from_body * self.omega.cross(&change.centre_m));
        by.fixed_rows_mut::<3>(part::POSITION).copy_from(&moved);
        by.fixed_rows_mut::<3>(part::VELOCITY).copy_from(&swept);
        by
    }
}

#[cfg(test)]
mod tests;
