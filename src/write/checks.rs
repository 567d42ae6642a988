//! Checks of an estimate, with the scene's names, for its report.

use serde::Serialize;

use crate::motion::{Deviation, Penetration, Scene, SingleShot, Touch, Verification};

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct VerificationLine {
    tolerance_m: f64,
    deepest: Option<PenetrationLine>,
    touches: Vec<TouchLine>,
    single_shot: ShotLine,
    balance: BalanceLine,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct PenetrationLine {
    body: String,
    against: String,
    time_s: f64,
    depth_m: f64,
    point_m: [f64; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct TouchLine {
    event: String,
    body: String,
    against: String,
    expected: Vec<String>,
    found: Option<String>,
    found_point_m: [f64; 3],
    lead_m: f64,
    found_time_s: f64,
    overlap_m: f64,
    is_wrong: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct ShotLine {
    deviations: Vec<DeviationLine>,
    restarts: Vec<String>,
    missed: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct DeviationLine {
    body: String,
    event: Option<String>,
    time_s: f64,
    position_m: f64,
    orientation_rad: f64,
    velocity_m_s: f64,
    angular_velocity_rad_s: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct BalanceLine {
    flight_energy: f64,
    flight_momentum: f64,
    flight_angular_momentum: f64,
    impact_energy: f64,
    impact_momentum: f64,
    impact_angular_momentum: f64,
}

impl VerificationLine {
    pub(super) fn new(scene: &Scene, verification: &Verification) -> Self {
        let balance = &verification.balance;
        let touches = verification.touches.iter();
        Self {
            tolerance_m: verification.tolerance_m,
            deepest: verification
                .deepest
                .as_ref()
                .map(|deepest| PenetrationLine::new(scene, deepest)),
            touches: touches.map(|touch| TouchLine::new(scene, touch)).collect(),
            single_shot: ShotLine::new(scene, &verification.single_shot),
            balance: BalanceLine {
                flight_energy: balance.flight_energy,
                flight_momentum: balance.flight_momentum,
                flight_angular_momentum: balance.flight_angular_momentum,
                impact_energy: balance.impact_energy,
                impact_momentum: balance.impact_momentum,
                impact_angular_momentum: balance.impact_angular_momentum,
            },
        }
    }
}

impl PenetrationLine {
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
    fn new(scene: &Scene, shot: &SingleShot) -> Self {
        let name = |event: &usize| scene.events[*event].name.clone();
        let line = |deviation: &Deviation| DeviationLine {
            body: scene.links[deviation.link].name.clone(),
            event: deviation.event.as_ref().map(name),
            time_s: deviation.time_s,
            position_m: deviation.position_m,
            orientation_rad: deviation.orientation_rad,
            velocity_m_s: deviation.velocity_m_s,
            angular_velocity_rad_s: deviation.angular_velocity_rad_s,
        };
        Self {
            deviations: shot.deviations.iter().map(line).collect(),
            restarts: shot.restarts.iter().map(name).collect(),
            missed: shot.missed.iter().map(name).collect(),
        }
    }
}
