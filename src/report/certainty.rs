//! How certain the motion is along its flights.

use serde::{Deserialize, Serialize};

use super::along::{AlongLine, instants_s, rounded};
use super::motion::phase_name;
use super::time_map::Time;
use crate::motion::{ArcEstimate, Estimate, Scene, Stamp, StateDeviation};

/// JSON schema of [`DeviationMessage`].
pub const DEVIATION_SCHEMA: &str = include_str!("deviation.schema.json");

/// How certain one flight is: of each quantity the root of the sum of the variances along three axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CertaintyLine {
    /// Name of the body.
    pub body: String,
    /// Name of the phase in which something carries it; none in flight.
    pub phase: Option<String>,
    /// Physical time at which the flight begins.
    pub start_s: f64,
    /// Physical time at which it ends.
    pub end_s: f64,
    /// Of the place of the frame in which the scene gives the body.
    pub position_sd_mm: AlongLine,
    /// Of its orientation.
    pub orientation_sd_deg: AlongLine,
    /// Of the velocity of its origin.
    pub velocity_sd_mm_s: AlongLine,
    /// Of its angular velocity.
    pub angular_velocity_sd_rad_s: AlongLine,
}

/// How certain a body's pose and velocities are at one instant, axis by axis: one standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DeviationMessage {
    /// When: a pose of the motion has the same stamp.
    pub timestamp: Time,
    /// Place, world axes.
    pub position_sd_m: [Option<f64>; 3],
    /// Turns about the body's axes, as the scene gives them.
    pub orientation_sd_rad: [Option<f64>; 3],
    /// Velocity of that place, world axes.
    pub velocity_sd_m_s: [Option<f64>; 3],
    /// Angular velocity about the body's axes.
    pub angular_velocity_sd_rad_s: [Option<f64>; 3],
}

impl DeviationMessage {
    /// Those at an instant, to four digits.
    pub fn new(stamp: Stamp, of: &StateDeviation) -> Self {
        let [position, orientation, velocity, spin] =
            of.parts().map(|part| part.map(|sd| sd.and_then(rounded)));
        Self {
            timestamp: stamp.into(),
            position_sd_m: position,
            orientation_sd_rad: orientation,
            velocity_sd_m_s: velocity,
            angular_velocity_sd_rad_s: spin,
        }
    }

    /// Reads what is written. Fails where it is no such message.
    pub fn read(json: &[u8]) -> Result<Self, serde_json::Error> {
        serde_json::from_slice(json)
    }

    /// When.
    pub fn stamp(&self) -> Stamp {
        self.timestamp.into()
    }

    /// Position, orientation, velocity and angular velocity, axis by axis.
    pub fn all(&self) -> [[Option<f64>; 3]; 4] {
        [
            self.position_sd_m,
            self.orientation_sd_rad,
            self.velocity_sd_m_s,
            self.angular_velocity_sd_rad_s,
        ]
    }

    /// A share of the way to another one.
    pub fn towards(&self, other: &Self, share: f64, stamp: Stamp) -> Self {
        let between = |from: [Option<f64>; 3], to: [Option<f64>; 3]| {
            let axis = |at: usize| Some((1.0 - share) * from[at]? + share * to[at]?);
            [0, 1, 2].map(axis)
        };
        Self {
            timestamp: stamp.into(),
            position_sd_m: between(self.position_sd_m, other.position_sd_m),
            orientation_sd_rad: between(self.orientation_sd_rad, other.orientation_sd_rad),
            velocity_sd_m_s: between(self.velocity_sd_m_s, other.velocity_sd_m_s),
            angular_velocity_sd_rad_s: between(
                self.angular_velocity_sd_rad_s,
                other.angular_velocity_sd_rad_s,
            ),
        }
    }
}

/// How certain the flights are of which that is known, in their order.
pub(super) fn certainty_lines(scene: &Scene, estimate: &Estimate) -> Vec<CertaintyLine> {
    let flights = estimate.arcs.iter();
    let lines = flights.filter_map(|arc| CertaintyLine::new(scene, estimate, arc));
    lines.collect()
}

impl CertaintyLine {
    fn new(scene: &Scene, estimate: &Estimate, arc: &ArcEstimate) -> Option<Self> {
        let instants = instants_s(arc).map(|time_s| {
            let deviation = arc.deviation(scene, &estimate.gravity_m_s2, time_s)?;
            Some(deviation.totals())
        });
        let instants: Vec<[Option<f64>; 4]> = instants.collect::<Option<_>>()?;
        let along = |part: usize, factor: f64| {
            let totals = instants.iter().map(|totals| Some(totals[part]? * factor));
            AlongLine::new(totals.collect::<Option<Vec<f64>>>())
        };
        Some(Self {
            body: scene.name_of_mechanism(arc.mechanism).to_owned(),
            phase: phase_name(scene, estimate, arc),
            start_s: arc.start_s,
            end_s: arc.end_s,
            position_sd_mm: along(0, 1e3),
            orientation_sd_deg: along(1, 1f64.to_degrees()),
            velocity_sd_mm_s: along(2, 1e3),
            angular_velocity_sd_rad_s: along(3, 1.0),
        })
    }
}
