//! What every report says of an estimate.

use serde::{Deserialize, Serialize};

use super::certainty::{CertaintyLine, certainty_lines};
use super::checks::CheckLine;
use super::diagnoses::DiagnosisLine;
use super::doubts::DoubtLine;
use super::fit::{fit_note, not_told};
use super::goals::{GoalLine, goal_lines};
use super::held::{HeldLine, held_lines};
use super::motion::{
    DurationLine, EventLine, ParameterLine, SegmentLine, event_lines, parameter_lines,
    segment_lines, undetermined_names,
};
use super::read::{from_json, unknown};
use super::reason::{TerminationLine, reason_text};
use super::reported::Reported;
use super::rest::RestLine;
use super::samples::{CounterLine, Ordered, SampleLine, SettledLine};
use super::seen::SeenPhaseLine;
use super::suspects::{SuspectLine, suspect_lines};
use crate::motion::{Estimate, Fits, Sketch, Verdict};

/// An estimate in words and numbers. Physical times are seconds since the first used sample, acted
/// times seconds since the performance's origin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EstimateReport {
    /// Name of the scene.
    pub scene: String,
    /// `physical`, `plausible` or `failed`.
    pub verdict: String,
    /// Whether the motion explains the performance: `yes`, `unknown` or `no`.
    pub fits: String,
    /// Whether that was asked: not of a motion that failed, or where too little is determined.
    #[serde(rename = "fit_tested")]
    pub is_fit_tested: bool,
    /// What that rests on, as a sentence, where it does not say it all.
    pub fit_note: Option<String>,
    /// Names of what samples would tell nothing of, were it wrong in the scene: of joined bodies.
    pub not_told: Vec<String>,
    /// Whether the performance determines everything that was asked.
    pub determined: bool,
    /// What may be wrong in the scene, the likeliest first; none where the motion fits.
    pub suspects: Vec<SuspectLine>,
    /// What was set free because it explains a misfit, in order, as it was suspected.
    pub freed: Vec<SuspectLine>,
    /// Why the estimation ended, as a sentence.
    pub reason: String,
    /// The same in numbers.
    pub termination: TerminationLine,
    /// What speaks against the motion, the gravest first.
    pub doubts: Vec<DoubtLine>,
    /// Likely mistakes in what is said of the performance, that which explains most first.
    pub diagnoses: Vec<DiagnosisLine>,
    /// What is seen besides flights and not said by the scene, where something speaks against the motion.
    #[serde(default)]
    pub seen_phases: Vec<SeenPhaseLine>,
    /// Sum of squared weighted residuals, priors included.
    #[serde(default = "unknown")]
    pub objective: f64,
    /// Gravity in world axes, given or estimated.
    pub gravity_m_s2: [f64; 3],
    /// Work done.
    #[serde(flatten)]
    pub counters: CounterLine,
    /// From the first used sample to the last, as acted.
    pub acted_s: f64,
    /// How long the motion lasts.
    #[serde(flatten)]
    pub duration: DurationLine,
    /// In order of time.
    pub events: Vec<EventLine>,
    /// How far it is from the scene's goals at events.
    pub goals: Vec<GoalLine>,
    /// Free parameters by name.
    pub parameters: Ordered<ParameterLine>,
    /// Root mean square distance over all samples.
    pub residual_mm: f64,
    /// Root mean square angle over all samples.
    pub residual_deg: f64,
    /// How well each arc fits.
    pub segments: Vec<SegmentLine>,
    /// How certain each flight is, where that is known.
    pub certainty: Vec<CertaintyLine>,
    /// Bodies in the hand.
    pub held: Vec<HeldLine>,
    /// Names of what the performance does not determine.
    pub undetermined: Vec<String>,
    /// What independent checks say; none where the estimation failed or nobody asked.
    pub verification: Option<CheckLine>,
    /// How the motion goes on by simulation, if the scene asks for that.
    pub settled: Option<SettledLine>,
    /// How bodies lie at rest, if the scene asks that.
    pub rest: Option<RestLine>,
    /// What became of the samples.
    pub samples: SampleLine,
}

impl EstimateReport {
    /// Everything that the estimate says, with the scene's names for its numbers.
    pub fn new(of: &Reported) -> Self {
        let (scene, estimate) = (of.scene, of.estimate);
        let (position_m, orientation_rad) = estimate.residual_rms();
        let doubts = estimate.doubts.iter();
        Self {
            scene: scene.name.clone(),
            verdict: estimate.verdict.as_str().to_owned(),
            fits: estimate.fits().as_str().to_owned(),
            is_fit_tested: is_fit_tested(estimate),
            fit_note: fit_note(scene, estimate),
            not_told: not_told(scene, estimate),
            determined: estimate.undetermined.is_empty(),
            suspects: suspect_lines(scene, &estimate.suspects),
            freed: suspect_lines(scene, of.freed),
            reason: reason_text(scene, &estimate.reason),
            termination: TerminationLine::new(scene, &estimate.reason),
            doubts: doubts.map(|doubt| DoubtLine::new(scene, doubt)).collect(),
            diagnoses: of
                .diagnoses
                .iter()
                .map(|diagnosis| DiagnosisLine::new(scene, diagnosis))
                .collect(),
            seen_phases: of
                .seen
                .iter()
                .map(|seen| SeenPhaseLine::new(scene, seen, of.sketch.origin))
                .collect(),
            objective: estimate.objective,
            gravity_m_s2: estimate.gravity_m_s2.into(),
            counters: CounterLine::new(&estimate.counters),
            acted_s: acted_s(of.sketch),
            duration: DurationLine::new(&estimate.duration),
            events: event_lines(of),
            goals: goal_lines(scene, estimate),
            parameters: parameter_lines(scene, estimate),
            residual_mm: position_m * 1e3,
            residual_deg: orientation_rad.to_degrees(),
            segments: segment_lines(scene, estimate),
            certainty: certainty_lines(scene, estimate),
            held: held_lines(of),
            undetermined: undetermined_names(scene, estimate),
            verification: of.verification.map(|found| CheckLine::new(scene, found)),
            settled: of.settled.map(|settled| SettledLine::new(scene, settled)),
            rest: of.rest.map(|rest| RestLine::new(scene, rest)),
            samples: SampleLine::new(of.counts),
        }
    }

    /// Reads what is written, of any version: what it lacks is empty. Fails where it is no such report.
    pub fn read(json: &[u8]) -> Result<Self, serde_json::Error> {
        from_json(json)
    }

    /// Whether nothing speaks against the motion: it is physical, not known not to fit, and nothing is suspected.
    pub fn is_good(&self) -> bool {
        self.is_physical() && self.fits != Fits::No.as_str() && self.suspects.is_empty()
    }

    /// Whether it is good, and no mistake is likely.
    pub fn is_undoubted(&self) -> bool {
        self.is_good() && self.diagnoses.is_empty()
    }

    /// Whether the motion may be called physical.
    pub fn is_physical(&self) -> bool {
        self.verdict == Verdict::Physical.as_str()
    }
}

/// Whether it was asked whether a motion fits, and could be told: where noise explains what is left of joined bodies and it is
/// unknown all the same, samples have no power to tell.
fn is_fit_tested(estimate: &Estimate) -> bool {
    let fit = estimate.fit.as_ref();
    fit.is_ok_and(|fit| fit.fits != Fits::Unknown || !fit.is_noise)
}

fn acted_s(sketch: &Sketch) -> f64 {
    let last = sketch
        .tracks
        .iter()
        .filter_map(|track| track.samples.last());
    last.map(|sample| sample.acted_s).fold(0.0, f64::max)
}
