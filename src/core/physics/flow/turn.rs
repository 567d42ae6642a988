//! The free rotation of any body, at one duration or at many.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::asymmetric::Steps;
use super::axial::{Precession, Turning};
use super::turned::Turn;
use crate::math::so3;
use crate::physics::body::Body;

/// Free rotation for `duration_s`, with derivatives; NaN where [`super::advance`] gives NaN.
pub fn turn(
    body: &Body,
    orientation: &UnitQuaternion<f64>,
    angular_velocity_rad_s: &Vector3<f64>,
    duration_s: f64,
) -> Turn {
    Turns::new(body, orientation, angular_velocity_rad_s).after(duration_s)
}

/// Free rotations from one orientation with one angular velocity, for many durations, with all derivatives.
pub struct Turns<'b> {
    body: &'b Body,
    orientation: UnitQuaternion<f64>,
    angular_velocity_rad_s: Vector3<f64>,
    /// Where three moments differ: those of one duration serve the next.
    steps: Option<Steps>,
}

impl<'b> Turns<'b> {
    /// From an orientation with an angular velocity [rad/s, body].
    pub fn new(
        body: &'b Body,
        orientation: &UnitQuaternion<f64>,
        angular_velocity_rad_s: &Vector3<f64>,
    ) -> Self {
        let steps = Steps::needed(body, angular_velocity_rad_s);
        Self::with_steps(body, orientation, angular_velocity_rad_s, steps)
    }

    /// The same by steps that are there: none where two or three moments are equal.
    pub fn with_steps(
        body: &'b Body,
        orientation: &UnitQuaternion<f64>,
        angular_velocity_rad_s: &Vector3<f64>,
        steps: Option<Steps>,
    ) -> Self {
        Self {
            body,
            orientation: *orientation,
            angular_velocity_rad_s: *angular_velocity_rad_s,
            steps,
        }
    }

    /// The steps, for further use.
    pub fn into_steps(self) -> Option<Steps> {
        self.steps
    }

    /// What turns.
    pub fn body(&self) -> &'b Body {
        self.body
    }

    /// The rotation after a duration \[s\]; NaN where [`super::advance`] gives NaN.
    pub fn after(&mut self, duration_s: f64) -> Turn {
        let (orientation, omega) = (&self.orientation, &self.angular_velocity_rad_s);
        let Some(steps) = &mut self.steps else {
            return Turning::of(self.body).turn(orientation, omega, duration_s);
        };
        let end = steps.turned(duration_s);
        let back = so3::matrix(&end.rotation).transpose();
        Turn {
            orientation: orientation * end.rotation,
            angular_velocity_rad_s: end.omega_rad_s,
            orientation_by_orientation: back,
            orientation_by_angular_velocity: back * end.turn_by_spin,
            angular_velocity_by_angular_velocity: end.spin_by_spin,
        }
    }
}

/// The free rotation from one initial angular velocity, for many durations.
#[derive(Clone, Debug)]
pub struct Spin(TurnCase);

#[derive(Clone, Debug)]
enum TurnCase {
    Precession(Precession),
    Steps(Box<Steps>),
}

impl Spin {
    /// The rotation with the initial angular velocity `ω` [rad/s, body].
    pub fn new(body: &Body, angular_velocity_rad_s: &Vector3<f64>) -> Self {
        let steps = Steps::needed(body, angular_velocity_rad_s);
        Self::with_steps(body, angular_velocity_rad_s, steps)
    }

    /// The same by steps that are there: none where two or three moments are equal.
    pub fn with_steps(
        body: &Body,
        angular_velocity_rad_s: &Vector3<f64>,
        steps: Option<Steps>,
    ) -> Self {
        Self(match steps {
            Some(steps) => TurnCase::Steps(Box::new(steps)),
            None => TurnCase::Precession(Precession::new(body, angular_velocity_rad_s)),
        })
    }

    /// The steps, for further use: this one has none then.
    pub fn take_steps(&mut self) -> Option<Steps> {
        match &mut self.0 {
            TurnCase::Precession(_) => None,
            TurnCase::Steps(steps) => Some(steps.take()),
        }
    }

    /// The closed form, where two or three moments are equal.
    pub(in crate::physics) fn precession(&self) -> Option<&Precession> {
        match &self.0 {
            TurnCase::Precession(precession) => Some(precession),
            TurnCase::Steps(_) => None,
        }
    }

    /// `R(0)⁻¹R(s)`; with two or three equal moments, the same bits as by [`super::advance`].
    pub fn turn(&mut self, duration_s: f64) -> UnitQuaternion<f64> {
        match &mut self.0 {
            TurnCase::Precession(precession) => precession.turn(duration_s),
            TurnCase::Steps(steps) => steps.turn_and_derivative(duration_s).0,
        }
    }

    /// `R(0)⁻¹R(s)`, and the matrix `K` for which a change `δω` of the initial angular velocity
    /// turns `R(s)` by the left perturbation `s K δω`, in the frame of `R(0)`. `K ω` is `ω(s)` in
    /// that frame.
    ///
    /// The result does not depend on the order in which durations are asked for; steps computed for
    /// one serve the next.
    #[inline]
    pub fn turn_and_derivative(&mut self, duration_s: f64) -> (UnitQuaternion<f64>, Matrix3<f64>) {
        match &mut self.0 {
            TurnCase::Precession(precession) => precession.turn_and_derivative(duration_s),
            TurnCase::Steps(steps) => steps.turn_and_derivative(duration_s),
        }
    }
}
