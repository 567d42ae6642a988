//! What checks said of an estimate, with names in place of indices.

use serde::Serialize;

use crate::motion::{Scene, Verification};

/// What independent checks say.
#[derive(Clone, Debug, Serialize)]
pub struct CheckLine {
    /// Overlaps up to this depth are not counted.
    pub tolerance_m: f64,
    /// The deepest overlap beyond it that no expected contact explains.
    pub deepest: Option<OverlapLine>,
    /// Parts that would have touched before the expected ones.
    pub wrong_features: Vec<WrongLine>,
    /// Deepest overlap about features that stand for more of a shape than they are.
    pub simplified_m: f64,
    /// How far a simulation from the first states alone is off at the end.
    pub single_shot: Option<ShotLine>,
    /// Collisions after which that simulation had to begin anew.
    pub restarts: Vec<String>,
    /// Collisions that it did not find.
    pub missed: Vec<String>,
    /// Largest relative violation of a law of conservation.
    pub imbalance: f64,
}

/// A body inside of something.
#[derive(Clone, Debug, Serialize)]
pub struct OverlapLine {
    /// Which body.
    pub body: String,
    /// Inside of what.
    pub against: String,
    /// When.
    pub time_s: f64,
    /// How deep.
    pub depth_m: f64,
}

/// Another part than expected would have touched first.
#[derive(Clone, Debug, Serialize)]
pub struct WrongLine {
    /// At which collision.
    pub event: String,
    /// Of which body.
    pub body: String,
    /// What should have touched.
    pub expected: Vec<String>,
    /// What would have, if the scene names it.
    pub found: Option<String>,
    /// Where it is, in body axes.
    pub found_point_m: [f64; 3],
    /// How much nearer it is.
    pub lead_m: f64,
    /// When it would have touched.
    pub found_time_s: f64,
}

/// Distances of the single shot from the estimate.
#[derive(Clone, Debug, Serialize)]
pub struct ShotLine {
    /// Of centres of mass.
    pub position_m: f64,
    /// Of orientations.
    pub orientation_rad: f64,
    /// Of velocities.
    pub velocity_m_s: f64,
    /// Of angular velocities.
    pub angular_velocity_rad_s: f64,
}

impl CheckLine {
    pub(super) fn new(scene: &Scene, verification: &Verification) -> Self {
        let shot = &verification.single_shot;
        let balance = &verification.balance;
        let event = |event: &usize| scene.events[*event].name.clone();
        let wrong = verification.wrong_features().map(|touch| {
            let body = &scene.links[touch.link];
            let feature = |feature: &usize| body.features[*feature].name.clone();
            WrongLine {
                event: event(&touch.event),
                body: body.name.clone(),
                expected: touch.expected.iter().map(feature).collect(),
                found: touch.found.as_ref().map(feature),
                found_point_m: touch.found_point_m.into(),
                lead_m: touch.lead_m,
                found_time_s: touch.found_time_s,
            }
        });
        Self {
            tolerance_m: verification.tolerance_m,
            deepest: verification.deepest.as_ref().map(|deepest| OverlapLine {
                body: scene.links[deepest.link].name.clone(),
                against: scene.name_of(deepest.against).to_owned(),
                time_s: deepest.time_s,
                depth_m: deepest.depth_m,
            }),
            wrong_features: wrong.collect(),
            simplified_m: verification
                .touches
                .iter()
                .map(|touch| touch.overlap_m)
                .fold(0.0, f64::max),
            single_shot: shot.at_end().map(|end| ShotLine {
                position_m: end.position_m,
                orientation_rad: end.orientation_rad,
                velocity_m_s: end.velocity_m_s,
                angular_velocity_rad_s: end.angular_velocity_rad_s,
            }),
            restarts: shot.restarts.iter().map(event).collect(),
            missed: shot.missed.iter().map(event).collect(),
            imbalance: [
                balance.flight_energy,
                balance.flight_momentum,
                balance.flight_angular_momentum,
                balance.impact_energy,
                balance.impact_momentum,
                balance.impact_angular_momentum,
            ]
            .into_iter()
            .fold(0.0, f64::max),
        }
    }
}
