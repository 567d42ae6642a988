//! What the smoother found of a tracker.

use super::curve::Curve;
use super::knot::{Driven, StateCovariance};

/// A tracker's state at a collision, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Index into `Scene::events`.
    pub event: usize,
    /// Acted time at which the covariance holds [s since `Sketch::origin`].
    pub acted_s: f64,
    /// Covariance of the tracker's state; velocities are per second of acted time.
    pub covariance: StateCovariance,
    /// Standard deviations per axis of the tracker's acceleration and angular acceleration, per second of acted time squared
    /// [m/s², rad/s²].
    pub acceleration_sds: [f64; 2],
}

/// The smoothed motion of the tracker on a held body.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldMotion {
    /// The motion, in acted time.
    pub curve: Curve,
    /// Its collisions, in order.
    pub meetings: Vec<Meeting>,
    /// Standard deviations of the tracker's noise per axis, of positions \[m\] and orientations \[rad\].
    pub noise_sd: [f64; 2],
    /// How often the covariances count in the objective, where samples count once (see
    /// [`MarkTime::counted`](crate::motion::MarkTime::counted)).
    pub counted: f64,
}

impl HeldMotion {
    /// The tracker's state at an acted time.
    pub fn at(&self, acted_s: f64) -> Driven {
        self.curve.at(acted_s)
    }

    /// Whether every number in it is finite, and every variance above zero.
    pub fn is_finite(&self) -> bool {
        let mut knots = self.curve.knots().iter().map(|knot| &knot.driven);
        let mut covariances = self.meetings.iter().map(|meeting| &meeting.covariance);
        knots.all(|driven| {
            let rates = [driven.acceleration_m_s2, driven.angular_acceleration_rad_s2];
            driven.state.is_finite() && rates.iter().flatten().all(|x| x.is_finite())
        }) && covariances.all(|covariance| {
            covariance.iter().all(|x| x.is_finite()) && covariance.diagonal().min() > 0.0
        })
    }

    /// The meeting at an event.
    pub fn meeting(&self, event: usize) -> Option<&Meeting> {
        self.meetings.iter().find(|meeting| meeting.event == event)
    }
}
