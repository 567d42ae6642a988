//! Motions through knots.

use std::sync::Arc;

use super::jets;
use super::knot::{Driven, Knot};
use crate::physics::tree::Carrier;

/// A motion through knots: a state and its rates at every time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// At least two, strictly increasing in time.
    knots: Arc<[Knot]>,
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
            (Some(before), Some(next)) => jets::between(&self.knots[before], next, time_s),
            (Some(last), None) => jets::beyond(&self.knots[last], time_s),
            (None, _) => jets::beyond(&self.knots[0], time_s),
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

/// What joined bodies may hang from.
impl Carrier for Curve {
    fn at(&self, time_s: f64) -> Driven {
        Curve::at(self, time_s)
    }

    fn next_kink_s(&self, from_s: f64, is_later: bool) -> Option<f64> {
        let at = match is_later {
            true => Some(self.knots.partition_point(|knot| knot.time_s <= from_s)),
            false => (self.knots.partition_point(|knot| knot.time_s < from_s)).checked_sub(1),
        };
        Some(self.knots.get(at?)?.time_s)
    }
}

/// By so much an acceleration between two knots is greater than at both, in a bound.
const BULGE: f64 = 2.0;
/// Greatest time beyond its ends to which a motion goes on, in a bound \[s\].
const END_S: f64 = 0.1;
