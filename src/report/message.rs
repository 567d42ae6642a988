//! The report of a file: what every report says, the motion's states and its time map.

use serde::{Deserialize, Serialize};

use super::estimate::EstimateReport;
use super::motion::phase_name;
use super::provenance::Provenance;
use super::read::from_json;
use super::reported::Reported;
use super::time_map::TimeMapMessage;
use crate::motion::{ArcEstimate, Estimate, LinkIndex, Scene, Stamp};

/// JSON schema of [`EstimateMessage`].
pub const REPORT_SCHEMA: &str = include_str!("report.schema.json");

/// The whole estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimateMessage {
    /// What every report says.
    #[serde(flatten)]
    pub report: EstimateReport,
    /// Collision-free flights, body by body in order of time.
    pub arcs: Vec<ArcLine>,
    /// Acted time against physical time.
    pub time_map: TimeMapMessage,
    /// From what it was made; none of what is shown live.
    pub provenance: Option<Provenance>,
}

/// What the message says beside the report.
#[derive(Default, Deserialize)]
#[serde(default)]
struct BesideReport {
    arcs: Vec<ArcLine>,
    time_map: TimeMapMessage,
    provenance: Option<Provenance>,
}

/// A flight, or a phase: between its start and its end the body moves as a free rigid body, or as one that a surface
/// carries, from the state at the epoch. Times are physical.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ArcLine {
    /// Name of the body.
    pub body: String,
    /// Name of the phase in which something carries it; none in flight.
    pub phase: Option<String>,
    /// When it begins.
    pub start_s: f64,
    /// When it ends.
    pub end_s: f64,
    /// When the body has the state.
    pub epoch_s: f64,
    /// Centre of mass, world axes.
    pub position_m: [f64; 3],
    /// World from the axes in which the scene gives the body, Hamilton.
    pub orientation_wxyz: [f64; 4],
    /// Velocity of the centre of mass, world axes.
    pub velocity_m_s: [f64; 3],
    /// Angular velocity, in those axes.
    pub angular_velocity_body_rad_s: [f64; 3],
}

impl EstimateMessage {
    /// Everything that the estimate says; physical time zero is stamped `zero`.
    pub fn new(of: &Reported, zero: Stamp, provenance: Option<&Provenance>) -> Self {
        let (scene, estimate) = (of.scene, of.estimate);
        let arcs = estimate.arcs.iter();
        Self {
            report: EstimateReport::new(of),
            arcs: arcs.map(|arc| ArcLine::new(scene, estimate, arc)).collect(),
            time_map: TimeMapMessage::new(scene, of.sketch, estimate, zero),
            provenance: provenance.cloned(),
        }
    }

    /// Reads what is written, of any version: what it lacks is empty. Fails where it is no such message.
    pub fn read(json: &[u8]) -> Result<Self, serde_json::Error> {
        // One after the other: serde would read a flattened report through a buffer, which knows no `null` for NaN.
        let report = EstimateReport::read(json)?;
        let beside: BesideReport = from_json(json)?;
        Ok(Self {
            report,
            arcs: beside.arcs,
            time_map: beside.time_map,
            provenance: beside.provenance,
        })
    }
}

impl ArcLine {
    fn new(scene: &Scene, estimate: &Estimate, arc: &ArcEstimate) -> Self {
        let state = &arc.state;
        let link = scene.mechanisms[arc.mechanism].links().next();
        let link = &scene.links[link.unwrap_or(LinkIndex(0))];
        let given_from_link = link.link_from_given.rotation.inverse();
        let world_from_given = state.orientation * given_from_link.inverse();
        let q = world_from_given.quaternion();
        Self {
            body: scene.name_of_mechanism(arc.mechanism).to_owned(),
            phase: phase_name(scene, estimate, arc),
            start_s: arc.start_s,
            end_s: arc.end_s,
            epoch_s: arc.epoch_s,
            position_m: state.position_m.into(),
            orientation_wxyz: [q.w, q.i, q.j, q.k],
            velocity_m_s: state.velocity_m_s.into(),
            angular_velocity_body_rad_s: (given_from_link * state.angular_velocity_rad_s).into(),
        }
    }
}

/// The bytes of a JSON message.
pub fn json<T: Serialize>(value: &T) -> Vec<u8> {
    serde_json::to_vec(value)
        .unwrap_or_else(|error| unreachable!("structs of numbers and texts serialise: {error}"))
}
