//! The motion of a body in the hand: what its tracker saw, smoothed.
//!
//! A held body does not fly. Whatever hits it bounces off a body of infinite mass that moves as it
//! was tracked: the hand is stronger than the impact. Its motion is a curve through knots
//! ([`Knot`]), the poses, velocities and accelerations of the tracker that the smoother
//! ([`smooth`](crate::segment::smooth)) found at every sample; at its collisions there is their
//! covariance too. Times are acted times. Between two knots, positions are the polynomial of fifth
//! degree with their places, velocities and accelerations, the most likely path where the jerk is
//! white noise; rotations are the same in the tangent space of the earlier knot ([`curve`]).
//!
//! The body's own state ([`Mounted`]) follows from the tracker's by how the tracker is mounted and
//! by how fast acted time runs.

pub mod curve;
pub mod estimate;
pub mod mounted;

use std::sync::Arc;

use nalgebra::{SMatrix, Vector3};

pub use estimate::{HeldEstimate, Passed};
pub use mounted::Mounted;

use crate::physics::State;

/// Covariance of a state, in its tangent.
pub type StateCovariance = SMatrix<f64, 12, 12>;

/// A state with its rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// The state.
    pub state: State,
    /// Its acceleration [m/s², world].
    pub acceleration_m_s2: Vector3<f64>,
    /// Its angular acceleration [rad/s², body].
    pub angular_acceleration_rad_s2: Vector3<f64>,
}

impl Driven {
    /// The same motion where time passes `rate` times as fast.
    pub fn at_rate(&self, rate: f64) -> Self {
        Self {
            state: State {
                velocity_m_s: self.state.velocity_m_s * rate,
                angular_velocity_rad_s: self.state.angular_velocity_rad_s * rate,
                ..self.state
            },
            acceleration_m_s2: self.acceleration_m_s2 * (rate * rate),
            angular_acceleration_rad_s2: self.angular_acceleration_rad_s2 * (rate * rate),
        }
    }
}

/// A state at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Time \[s\].
    pub time_s: f64,
    /// The state there.
    pub driven: Driven,
}

/// A tracker's state at a collision, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Index into `Scene::events`.
    pub event: usize,
    /// Acted time at which the covariance holds [s since `Sketch::origin`].
    pub acted_s: f64,
    /// Covariance of the tracker's state; velocities are per second of acted time.
    pub covariance: StateCovariance,
}

/// A motion through knots: a state and its rates at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// At least two, strictly increasing in time.
    knots: Arc<[Knot]>,
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
    /// [`MarkTime::counted`](super::MarkTime::counted)).
    pub counted: f64,
}

impl Curve {
    /// A motion through knots.
    ///
    /// # Panics
    /// With fewer than two knots, or where times do not increase.
    pub fn new(knots: Vec<Knot>) -> Self {
        assert!(knots.len() >= 2, "a curve has two ends");
        let increases = |pair: &[Knot]| pair[0].time_s < pair[1].time_s;
        assert!(knots.windows(2).all(increases), "knots in order of time");
        Self {
            knots: knots.into(),
        }
    }

    /// Its knots.
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// The state at a time. Beyond its ends the motion goes on with the accelerations there.
    pub fn at(&self, time_s: f64) -> Driven {
        let after = self.knots.partition_point(|knot| knot.time_s <= time_s);
        match (after.checked_sub(1), self.knots.get(after)) {
            (Some(before), Some(next)) => curve::between((&self.knots[before], next), time_s),
            (Some(last), None) => curve::beyond(&self.knots[last], time_s),
            (None, _) => curve::beyond(&self.knots[0], time_s),
        }
    }

    /// Upper bounds of the speed [m/s] and the angular speed [rad/s] between two times.
    pub fn speed_bounds(&self, from_s: f64, to_s: f64) -> [f64; 2] {
        let first = self.knots.partition_point(|knot| knot.time_s <= from_s);
        let last = self.knots.partition_point(|knot| knot.time_s < to_s);
        let near = &self.knots[first.saturating_sub(1)..(last + 1).min(self.knots.len())];
        let apart_s = near.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        let beyond_s = to_s - from_s;
        let longest_s = apart_s.fold(beyond_s.min(END_S), f64::max);
        let largest = |of: &dyn Fn(&Driven) -> f64| {
            near.iter().map(|knot| of(&knot.driven)).fold(0.0, f64::max)
        };
        // Between knots an acceleration may exceed those at both.
        let speed = largest(&|driven| driven.state.velocity_m_s.norm());
        let change = largest(&|driven| driven.acceleration_m_s2.norm());
        let spin = largest(&|driven| driven.state.angular_velocity_rad_s.norm());
        let bend = largest(&|driven| driven.angular_acceleration_rad_s2.norm());
        [
            speed + BULGE * change * longest_s,
            spin + BULGE * bend * longest_s,
        ]
    }
}

/// By so much an acceleration between two knots is greater than at both, in a bound.
const BULGE: f64 = 2.0;
/// Greatest time beyond its ends to which a motion goes on, in a bound \[s\].
const END_S: f64 = 0.1;

impl HeldMotion {
    /// The tracker's state at an acted time.
    pub fn at(&self, acted_s: f64) -> Driven {
        self.curve.at(acted_s)
    }

    /// Whether every number in it is finite, and every variance above zero.
    pub fn is_finite(&self) -> bool {
        let mut knots = self.curve.knots.iter().map(|knot| &knot.driven);
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
