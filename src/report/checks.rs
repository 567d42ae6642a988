//! What checks said of an estimate, with the scene's names.

use serde::{Deserialize, Serialize};

use super::read::{number, unknown};
use crate::motion::{Balance, Deviation, Penetration, Scene, Touch, Verification};

/// What independent checks say.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CheckLine {
    /// Overlaps up to this depth are not counted.
    pub tolerance_m: f64,
    /// The deepest overlap beyond it that no expected contact explains.
    pub deepest: Option<OverlapLine>,
    /// What touches first, collision by collision.
    pub touches: Vec<TouchLine>,
    /// Those of them where another part than expected would have touched first.
    pub wrong_features: Vec<TouchLine>,
    /// Deepest overlap about features that stand for more of a shape than they are.
    pub simplified_m: f64,
    /// How far a simulation from the first states alone is off at the end.
    pub single_shot: Option<ShotLine>,
    /// How far it is off just before every collision of every body, and at its end.
    pub deviations: Vec<DeviationLine>,
    /// Collisions after which that simulation had to begin anew.
    pub restarts: Vec<String>,
    /// Collisions that it did not find.
    pub missed: Vec<String>,
    /// Largest relative violation of a law of conservation.
    #[serde(default = "unknown")]
    pub imbalance: f64,
    /// Largest relative violations of each law.
    pub balance: BalanceLine,
}

/// A body inside of something.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct OverlapLine {
    /// Name of the body.
    pub body: String,
    /// Name of what it is inside of.
    pub against: String,
    /// Physical time at which it is deepest \[s\].
    pub time_s: f64,
    /// How deep, positive.
    pub depth_m: f64,
    /// The body's deepest point, body axes.
    pub point_m: [f64; 3],
}

/// What of a body touches first at a collision, by its whole shape.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TouchLine {
    /// Name of the collision.
    pub event: String,
    /// Name of the body.
    pub body: String,
    /// Name of what it hits.
    pub against: String,
    /// Features that should touch.
    pub expected: Vec<String>,
    /// The feature that is nearest then, if the scene names it.
    pub found: Option<String>,
    /// Where that is, body axes.
    pub found_point_m: [f64; 3],
    /// How much nearer it is.
    pub lead_m: f64,
    /// When it would have touched.
    pub found_time_s: f64,
    /// Deepest overlap of the shape about expected features in the flights before and after.
    pub overlap_m: f64,
    /// Whether another part than expected leads by more than the tolerance.
    pub is_wrong: bool,
}

/// Distances of the single shot from the estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ShotLine {
    /// Of centres of mass.
    #[serde(default = "unknown", deserialize_with = "number")]
    pub position_m: f64,
    /// Of orientations.
    #[serde(default = "unknown", deserialize_with = "number")]
    pub orientation_rad: f64,
    /// Of velocities.
    #[serde(deserialize_with = "number")]
    pub velocity_m_s: f64,
    /// Of angular velocities.
    #[serde(deserialize_with = "number")]
    pub angular_velocity_rad_s: f64,
}

/// The same of one body at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DeviationLine {
    /// Name of the body.
    pub body: String,
    /// The collision that is about to happen; none: the end.
    pub event: Option<String>,
    /// Difference of the instants.
    pub time_s: f64,
    /// Distances.
    #[serde(flatten)]
    pub distances: ShotLine,
}

/// Largest relative violations of the laws of conservation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BalanceLine {
    /// Of energy over flights.
    pub flight_energy: f64,
    /// Of momentum over flights.
    pub flight_momentum: f64,
    /// Of angular momentum over flights.
    pub flight_angular_momentum: f64,
    /// Of kinetic energy over impacts, beside what restitution and friction take.
    pub impact_energy: f64,
    /// Of momentum over impacts.
    pub impact_momentum: f64,
    /// Of each body's angular momentum about the contact over impacts.
    pub impact_angular_momentum: f64,
}

impl CheckLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, verification: &Verification) -> Self {
        let shot = &verification.single_shot;
        let deepest = verification.deepest.as_ref();
        let (touches, wrong) = (verification.touches.iter(), verification.wrong_features());
        let touch = |touch: &Touch| TouchLine::new(scene, touch);
        let event = |event: &usize| scene.events[*event].name.clone();
        let deviation = |of: &Deviation| DeviationLine {
            body: scene.links[of.link].name.clone(),
            event: of.event.as_ref().map(event),
            time_s: of.time_s,
            distances: ShotLine::new(of),
        };
        let balance = BalanceLine::new(&verification.balance);
        let overlaps_m = touches.clone().map(|touch| touch.overlap_m);
        Self {
            tolerance_m: verification.tolerance_m,
            deepest: deepest.map(|deepest| OverlapLine::new(scene, deepest)),
            simplified_m: overlaps_m.fold(0.0, f64::max),
            touches: touches.map(touch).collect(),
            wrong_features: wrong.map(touch).collect(),
            single_shot: shot.at_end().as_ref().map(ShotLine::new),
            deviations: shot.deviations.iter().map(deviation).collect(),
            restarts: shot.restarts.iter().map(event).collect(),
            missed: shot.missed.iter().map(event).collect(),
            imbalance: balance.largest(),
            balance,
        }
    }
}

impl OverlapLine {
    fn new(scene: &Scene, deepest: &Penetration) -> Self {
        Self {
            body: scene.links[deepest.link].name.clone(),
            against: scene.name_of(deepest.against).to_owned(),
            time_s: deepest.time_s,
            depth_m: deepest.depth_m,
            point_m: deepest.point_m.into(),
        }
    }
}

impl TouchLine {
    fn new(scene: &Scene, touch: &Touch) -> Self {
        let body = &scene.links[touch.link];
        let name = |feature: &usize| body.features[*feature].name.clone();
        Self {
            event: scene.events[touch.event].name.clone(),
            body: body.name.clone(),
            against: scene.name_of(touch.against).to_owned(),
            expected: touch.expected.iter().map(name).collect(),
            found: touch.found.as_ref().map(name),
            found_point_m: touch.found_point_m.into(),
            lead_m: touch.lead_m,
            found_time_s: touch.found_time_s,
            overlap_m: touch.overlap_m,
            is_wrong: touch.is_wrong,
        }
    }
}

impl ShotLine {
    fn new(of: &Deviation) -> Self {
        Self {
            position_m: of.position_m,
            orientation_rad: of.orientation_rad,
            velocity_m_s: of.velocity_m_s,
            angular_velocity_rad_s: of.angular_velocity_rad_s,
        }
    }
}

impl BalanceLine {
    fn new(balance: &Balance) -> Self {
        Self {
            flight_energy: balance.flight_energy,
            flight_momentum: balance.flight_momentum,
            flight_angular_momentum: balance.flight_angular_momentum,
            impact_energy: balance.impact_energy,
            impact_momentum: balance.impact_momentum,
            impact_angular_momentum: balance.impact_angular_momentum,
        }
    }

    fn largest(&self) -> f64 {
        let flight = [
            self.flight_energy,
            self.flight_momentum,
            self.flight_angular_momentum,
        ];
        let impact = [
            self.impact_energy,
            self.impact_momentum,
            self.impact_angular_momentum,
        ];
        flight.into_iter().chain(impact).fold(0.0, f64::max)
    }
}
