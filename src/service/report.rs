//! What became of one recording, with names in place of indices: one JSON object, or the
//! numbers of a text.

use serde::Serialize;

use super::checks::CheckLine;
use super::doubts::DoubtLine;
use crate::motion::{Estimate, Phase, Quantity, Scene, Sketch};
use crate::pipeline::Outcome;
use crate::write::lines::{Ordered, SampleLine, SettledLine};

/// A finished recording. SI units unless a name says otherwise; numbers that do not exist, such
/// as infinite bounds, are `null` in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The file that was read.
    pub recording: String,
    /// Name of the scene.
    pub scene: String,
    /// `physical`, `plausible` or `failed`.
    pub verdict: &'static str,
    /// Why the solver stopped.
    pub reason: String,
    /// What speaks against the motion, the gravest first.
    pub doubts: Vec<DoubtLine>,
    /// Sum of squared weighted residuals, priors included.
    pub objective: f64,
    /// Evaluations with a factorisation.
    pub iterations: usize,
    /// Rounds of mark refinement and of time assignment.
    pub assignment_rounds: usize,
    /// Wall time of the estimation, without checks and settling.
    pub solve_seconds: f64,
    /// Wall time of the pipeline by phase, in order.
    pub phase_seconds: Ordered<f64>,
    /// From the first used sample to the last, as acted.
    pub acted_s: f64,
    /// From the beginning of the estimated motion to its end.
    pub physical_s: f64,
    /// Its standard deviation, zero where it is fixed; none where nothing determines it.
    pub physical_sd_s: Option<f64>,
    /// Whether that deviation is within a tenth of it.
    pub physical_is_determined: bool,
    /// In order of time.
    pub events: Vec<EventLine>,
    /// Free quantities by name.
    pub parameters: Ordered<ParameterLine>,
    /// Root mean square distance over all samples.
    pub residual_mm: f64,
    /// Root mean square angle over all samples.
    pub residual_deg: f64,
    /// Arc by arc.
    pub segments: Vec<SegmentLine>,
    /// What the performance does not determine.
    pub undetermined: Vec<String>,
    /// What independent checks say; none where the estimation failed.
    pub verification: Option<CheckLine>,
    /// How the motion goes on by simulation, if the scene asks for that.
    pub settled: Option<SettledLine>,
    /// What became of the samples.
    pub samples: SampleLine,
    /// What of the recording could not be read.
    pub lost: Vec<String>,
    /// What in it was read with reservations.
    pub warnings: Vec<String>,
    /// The file that was written.
    pub output: String,
}

/// An event as estimated.
#[derive(Clone, Debug, Serialize)]
pub struct EventLine {
    /// Name in the scene.
    pub name: String,
    /// `start`, `collision` or `end`.
    pub kind: &'static str,
    /// Physical time since the first sample.
    pub time_s: f64,
    /// Its standard deviation, where it is not fixed and is determined.
    pub time_sd_s: Option<f64>,
    /// Acted time since the first sample.
    pub acted_s: f64,
    /// Whom it concerns.
    pub bodies: Vec<String>,
    /// What touches, at a collision.
    pub contact: Option<String>,
    /// Whether that was inferred: the scene leaves it open.
    pub contact_inferred: bool,
    /// Largest position gap.
    pub gap_m: f64,
    /// Largest orientation gap.
    pub gap_rad: f64,
    /// Largest velocity gap.
    pub gap_m_s: f64,
    /// Largest angular velocity gap.
    pub gap_rad_s: f64,
}

/// A free quantity as estimated.
#[derive(Clone, Debug, Serialize)]
pub struct ParameterLine {
    /// Its value.
    pub value: f64,
    /// Its standard deviation, where it is determined.
    pub sd: Option<f64>,
    /// Least and greatest value allowed.
    pub bounds: [f64; 2],
    /// Unit of them all.
    pub unit: &'static str,
}

/// How one arc fits.
#[derive(Clone, Debug, Serialize)]
pub struct SegmentLine {
    /// Whose.
    pub body: String,
    /// Physical time at which it begins.
    pub start_s: f64,
    /// Physical time at which it ends.
    pub end_s: f64,
    /// Samples in the objective.
    pub samples: usize,
    /// Root mean square distance.
    pub residual_mm: f64,
    /// Root mean square angle.
    pub residual_deg: f64,
}

/// What the driver knows and the pipeline does not.
pub(super) struct Circumstances {
    pub(super) recording: String,
    pub(super) output: String,
    pub(super) solve_seconds: f64,
    pub(super) phase_seconds: Vec<(Phase, f64)>,
    pub(super) lost: Vec<String>,
    pub(super) warnings: Vec<String>,
}

impl Report {
    pub(super) fn new(outcome: &Outcome, circumstances: Circumstances) -> Self {
        let scene = &outcome.scene;
        let estimate = &outcome.estimate;
        let (residual_mm, residual_deg) = whole_residual(estimate);
        Self {
            recording: circumstances.recording,
            scene: scene.name.clone(),
            verdict: estimate.verdict.as_str(),
            reason: estimate.reason.clone(),
            doubts: estimate
                .doubts
                .iter()
                .map(|doubt| DoubtLine::new(scene, doubt))
                .collect(),
            objective: estimate.objective,
            iterations: estimate.counters.iterations,
            assignment_rounds: estimate.counters.assignment_rounds,
            solve_seconds: circumstances.solve_seconds,
            phase_seconds: Ordered(
                circumstances
                    .phase_seconds
                    .into_iter()
                    .map(|(phase, seconds)| (phase.as_str().to_owned(), seconds))
                    .collect(),
            ),
            acted_s: acted_s(&outcome.sketch),
            physical_s: estimate.duration.duration_s,
            physical_sd_s: estimate.duration.sd_s,
            physical_is_determined: estimate.duration.is_determined(),
            events: event_lines(outcome),
            parameters: parameter_lines(scene, estimate),
            residual_mm,
            residual_deg,
            segments: segment_lines(scene, estimate),
            undetermined: estimate.undetermined.clone(),
            verification: outcome
                .verification
                .as_ref()
                .map(|verification| CheckLine::new(scene, verification)),
            settled: outcome.settled.as_ref().map(SettledLine::new),
            samples: SampleLine::new(&outcome.counts),
            lost: circumstances.lost,
            warnings: circumstances.warnings,
            output: circumstances.output,
        }
    }

    /// Whether nothing was lost and the motion is physical.
    pub fn is_whole(&self) -> bool {
        self.lost.is_empty() && self.verdict == crate::motion::Verdict::Physical.as_str()
    }
}

fn acted_s(sketch: &Sketch) -> f64 {
    let last = sketch.tracks.iter().filter_map(|b| b.samples.last());
    last.map(|sample| sample.acted_s).fold(0.0, f64::max)
}

fn whole_residual(estimate: &Estimate) -> (f64, f64) {
    let samples: usize = estimate.residuals.iter().map(|r| r.samples).sum();
    let rms = |square: &dyn Fn(&crate::motion::SegmentResidual) -> f64| {
        let sum: f64 = estimate
            .residuals
            .iter()
            .map(|r| r.samples as f64 * square(r))
            .sum();
        (sum / samples.max(1) as f64).sqrt()
    };
    (
        rms(&|r| r.position_rms_m.powi(2)) * 1e3,
        rms(&|r| r.orientation_rms_rad.powi(2)).to_degrees(),
    )
}

fn event_lines(outcome: &Outcome) -> Vec<EventLine> {
    let Outcome {
        scene, estimate, ..
    } = outcome;
    let all = || scene.links.iter().map(|b| b.name.clone()).collect();
    estimate
        .events
        .iter()
        .map(|event| {
            let of_scene = &scene.events[event.event];
            EventLine {
                name: of_scene.name.clone(),
                kind: of_scene.kind.as_str(),
                time_s: event.time_s,
                time_sd_s: event.sd_s,
                acted_s: event.acted_s,
                bodies: match of_scene.kind.collision() {
                    Some(collision) => collision
                        .links()
                        .map(|link| scene.links[link].name.clone())
                        .collect(),
                    None => all(),
                },
                contact: scene.contact_words(event.event),
                contact_inferred: outcome.inferred.contains(&event.event),
                gap_m: event.gap.position_m,
                gap_rad: event.gap.orientation_rad,
                gap_m_s: event.gap.velocity_m_s,
                gap_rad_s: event.gap.angular_velocity_rad_s,
            }
        })
        .collect()
}

fn parameter_lines(scene: &Scene, estimate: &Estimate) -> Ordered<ParameterLine> {
    let unit_of = |name: &str| {
        let free = scene.parameters.iter().find(|free| free.name == name);
        match free.map(|free| free.quantity) {
            Some(Quantity::Gravity { .. }) => "m/s²",
            Some(Quantity::Tilt { .. }) => "rad",
            Some(Quantity::Restitution { .. } | Quantity::Friction { .. }) | None => "",
        }
    };
    Ordered(
        estimate
            .parameters
            .iter()
            .map(|parameter| {
                let line = ParameterLine {
                    value: parameter.value,
                    sd: parameter.sd,
                    bounds: [parameter.lower, parameter.upper],
                    unit: unit_of(&parameter.name),
                };
                (parameter.name.clone(), line)
            })
            .collect(),
    )
}

fn segment_lines(scene: &Scene, estimate: &Estimate) -> Vec<SegmentLine> {
    estimate
        .residuals
        .iter()
        .zip(&estimate.arcs)
        .map(|(residual, arc)| SegmentLine {
            body: scene.link_seen_by(residual.track).name.clone(),
            start_s: arc.start_s,
            end_s: arc.end_s,
            samples: residual.samples,
            residual_mm: residual.position_rms_m * 1e3,
            residual_deg: residual.orientation_rms_rad.to_degrees(),
        })
        .collect()
}
