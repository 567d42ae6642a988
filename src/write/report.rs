//! The estimate in words and numbers, as JSON with a schema.
//!
//! Numbers that are not finite (bounds that do not bind) are `null`; times are seconds, of
//! acted time since `origin`, of physical time since `physical_zero`.

use serde::Serialize;

use super::checks::VerificationLine;
use super::lines::{DoubtLine, SampleLine, SettledLine};
use crate::motion::{
    ArcEstimate, Estimate, EventEstimate, SampleCounts, Scene, SegmentResidual, Settled, Sketch,
    Stamp, Verification,
};

/// JSON schema of [`EstimateReport`].
pub const REPORT_SCHEMA: &str = include_str!("report.schema.json");

/// JSON schema of [`TimeMap`].
pub const TIME_MAP_SCHEMA: &str = include_str!("time_map.schema.json");

/// A stamp as foxglove's JSON has it: exact, where one number would lose nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Time {
    sec: i64,
    nsec: i64,
}

impl From<Stamp> for Time {
    fn from(stamp: Stamp) -> Self {
        Self {
            sec: stamp.0.div_euclid(1_000_000_000),
            nsec: stamp.0.rem_euclid(1_000_000_000),
        }
    }
}

/// Acted time against physical time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeMap {
    origin: Time,
    physical_zero: Time,
    bodies: Vec<BodyTimes>,
    events: Vec<EventTime>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct BodyTimes {
    body: String,
    acted_s: Vec<f64>,
    physical_s: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct EventTime {
    event: String,
    acted_s: f64,
    physical_s: f64,
}

impl TimeMap {
    /// The map of an estimate, body by body and event by event.
    pub fn new(scene: &Scene, sketch: &Sketch, estimate: &Estimate, zero: Stamp) -> Self {
        let bodies = scene.tracks.keys().map(|track| {
            let times = estimate
                .sample_times
                .iter()
                .filter(|time| time.track == track);
            let (acted_s, physical_s) = times
                .map(|time| (time.stamp.seconds_since(sketch.origin), time.time_s))
                .unzip();
            BodyTimes {
                body: scene.link_seen_by(track).name.clone(),
                acted_s,
                physical_s,
            }
        });
        let events = estimate.events.iter().map(|event| EventTime {
            event: scene.events[event.event].name.clone(),
            acted_s: event.acted_s,
            physical_s: event.time_s,
        });
        Self {
            origin: sketch.origin.into(),
            physical_zero: zero.into(),
            bodies: bodies.collect(),
            events: events.collect(),
        }
    }
}

/// What a report is about.
#[derive(Clone, Copy)]
pub struct Reported<'a> {
    /// What it was estimated for.
    pub scene: &'a Scene,
    /// The performance.
    pub sketch: &'a Sketch,
    /// What became of its samples.
    pub counts: &'a SampleCounts,
    /// The motion.
    pub estimate: &'a Estimate,
    /// What independent checks say of it, if there were any.
    pub verification: Option<&'a Verification>,
    /// How it goes on, if it does.
    pub settled: Option<&'a Settled>,
}

/// The whole estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimateReport {
    scene: String,
    verdict: &'static str,
    reason: String,
    doubts: Vec<DoubtLine>,
    objective: f64,
    gravity_m_s2: [f64; 3],
    arcs: Vec<ArcLine>,
    events: Vec<EventLine>,
    duration: DurationLine,
    parameters: Vec<ParameterLine>,
    residuals: Vec<ResidualLine>,
    undetermined: Vec<String>,
    samples: SampleLine,
    counters: CounterLine,
    time_map: TimeMap,
    verification: Option<VerificationLine>,
    settled: Option<SettledLine>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct ArcLine {
    body: String,
    start_s: f64,
    end_s: f64,
    epoch_s: f64,
    position_m: [f64; 3],
    orientation_wxyz: [f64; 4],
    velocity_m_s: [f64; 3],
    angular_velocity_body_rad_s: [f64; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct EventLine {
    name: String,
    kind: &'static str,
    contact: Option<String>,
    time_s: f64,
    sd_s: Option<f64>,
    acted_s: f64,
    gap: GapLine,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct DurationLine {
    duration_s: f64,
    sd_s: Option<f64>,
    is_determined: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct GapLine {
    position_m: f64,
    orientation_rad: f64,
    velocity_m_s: f64,
    angular_velocity_rad_s: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct ParameterLine {
    name: String,
    value: f64,
    sd: Option<f64>,
    lower: f64,
    upper: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct ResidualLine {
    body: String,
    samples: usize,
    position_rms_m: f64,
    orientation_rms_rad: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct CounterLine {
    iterations: usize,
    evaluations: usize,
    factorisations: usize,
    fit_iterations: usize,
    assignment_rounds: usize,
    starts: usize,
}

impl EstimateReport {
    /// Everything that the estimate says, with the scene's names for its numbers.
    pub fn new(of: &Reported, zero: Stamp) -> Self {
        let Reported {
            scene,
            sketch,
            counts,
            estimate,
            verification,
            settled,
        } = *of;
        let counters = estimate.counters;
        Self {
            scene: scene.name.clone(),
            verdict: estimate.verdict.as_str(),
            reason: estimate.reason.clone(),
            doubts: estimate
                .doubts
                .iter()
                .map(|doubt| DoubtLine::new(scene, doubt))
                .collect(),
            objective: estimate.objective,
            gravity_m_s2: estimate.gravity_m_s2.into(),
            arcs: estimate
                .arcs
                .iter()
                .map(|arc| ArcLine::new(scene, arc))
                .collect(),
            events: estimate
                .events
                .iter()
                .map(|event| EventLine::new(scene, event))
                .collect(),
            duration: DurationLine {
                duration_s: estimate.duration.duration_s,
                sd_s: estimate.duration.sd_s,
                is_determined: estimate.duration.is_determined(),
            },
            parameters: estimate
                .parameters
                .iter()
                .map(|parameter| ParameterLine {
                    name: parameter.name.clone(),
                    value: parameter.value,
                    sd: parameter.sd,
                    lower: parameter.lower,
                    upper: parameter.upper,
                })
                .collect(),
            residuals: estimate
                .residuals
                .iter()
                .map(|residual| ResidualLine::new(scene, residual))
                .collect(),
            undetermined: estimate.undetermined.clone(),
            samples: SampleLine::new(counts),
            counters: CounterLine {
                iterations: counters.iterations,
                evaluations: counters.evaluations,
                factorisations: counters.factorisations,
                fit_iterations: counters.fit_iterations,
                assignment_rounds: counters.assignment_rounds,
                starts: counters.starts,
            },
            time_map: TimeMap::new(scene, sketch, estimate, zero),
            verification: verification
                .map(|verification| VerificationLine::new(scene, verification)),
            settled: settled.map(SettledLine::new),
        }
    }
}

impl ArcLine {
    fn new(scene: &Scene, arc: &ArcEstimate) -> Self {
        let state = &arc.state;
        let q = state.orientation.quaternion();
        Self {
            body: scene.name_of_mechanism(arc.mechanism).to_owned(),
            start_s: arc.start_s,
            end_s: arc.end_s,
            epoch_s: arc.epoch_s,
            position_m: state.position_m.into(),
            orientation_wxyz: [q.w, q.i, q.j, q.k],
            velocity_m_s: state.velocity_m_s.into(),
            angular_velocity_body_rad_s: state.angular_velocity_rad_s.into(),
        }
    }
}

impl EventLine {
    fn new(scene: &Scene, estimate: &EventEstimate) -> Self {
        let event = &scene.events[estimate.event];
        Self {
            name: event.name.clone(),
            kind: event.kind.as_str(),
            contact: scene.contact_words(estimate.event),
            time_s: estimate.time_s,
            sd_s: estimate.sd_s,
            acted_s: estimate.acted_s,
            gap: GapLine {
                position_m: estimate.gap.position_m,
                orientation_rad: estimate.gap.orientation_rad,
                velocity_m_s: estimate.gap.velocity_m_s,
                angular_velocity_rad_s: estimate.gap.angular_velocity_rad_s,
            },
        }
    }
}

impl ResidualLine {
    fn new(scene: &Scene, residual: &SegmentResidual) -> Self {
        Self {
            body: scene.link_seen_by(residual.track).name.clone(),
            samples: residual.samples,
            position_rms_m: residual.position_rms_m,
            orientation_rms_rad: residual.orientation_rms_rad,
        }
    }
}

/// The bytes of a JSON message.
pub(super) fn json<T: Serialize>(value: &T) -> Vec<u8> {
    serde_json::to_vec(value)
        .unwrap_or_else(|error| unreachable!("structs of numbers and texts serialise: {error}"))
}
