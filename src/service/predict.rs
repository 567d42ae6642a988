//! Continues the motion of a recording from its flight, without what was seen later.

use std::iter;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::bail;

use super::deadline::Deadline;
use super::finish::{beside, finish, open};
use super::guard::Inputs;
use super::working::Working;
use crate::motion::{EventKind, Scene};
use crate::report::RecordingReport;

/// How long is simulated at most, where nobody says otherwise \[s\].
pub const DEFAULT_PREDICTION_S: f64 = 10.0;

/// The input of [`predict`].
#[derive(Clone, Debug)]
pub struct PredictJob {
    /// The recording.
    pub input: PathBuf,
    /// File of the prediction; IN with `.predicted.mcap` by default.
    pub output: Option<PathBuf>,
    /// Scene file; the recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// The event at which what was seen ends; the first collision by default, else the end.
    pub until: Option<String>,
    /// How long is simulated at most \[s\].
    pub limit_s: f64,
    /// Whether likely mistakes are looked for ([`Pipeline::with_diagnoses`](crate::pipeline::Pipeline::with_diagnoses)).
    pub is_diagnosing: bool,
    /// How long reading and estimating may take; no limit by default.
    pub deadline: Option<Duration>,
}

/// Estimates the motion up to an event, predicts it from there until it rests, and writes both as an estimate.
///
/// Fails where the scene has no such event or the recording no mark of it.
pub fn predict(job: &PredictJob) -> anyhow::Result<RecordingReport> {
    let output = match &job.output {
        Some(output) => output.clone(),
        None => beside(&job.input, "predicted.mcap")?,
    };
    let inputs = iter::once(job.input.as_path()).chain(job.scene.as_deref());
    Inputs::of(inputs).keep_from(&output)?;
    let working = Working::begin("reading");
    let opened = open(
        &job.input,
        job.scene.as_deref(),
        Deadline::begin(job.deadline),
    )?;
    let path = job.input.display();
    let take = opened.recording.take(opened.scene.for_reading())?;
    let pipeline = opened.scene.pipeline(take.events);
    let scene = pipeline.scene().with_marks(pipeline.marks());
    let event =
        last(&scene, job.until.as_deref()).map_err(|error| error.context(path.to_string()))?;
    let name = scene.events[event].name.clone();
    if let Some(phase) = scene.tied_at(event) {
        if phase.stuck_to().is_some() {
            bail!(
                "{path}: bodies stick together ({:?}) at {name:?} or before, expected --until an event before that: how both go on as one is not predicted",
                phase.name
            );
        }
        bail!(
            "{path}: {:?} ties {:?} until {name:?}, expected --until an event at which nothing holds it: how it is let go is not known",
            phase.name,
            scene.links[phase.link].name
        );
    }
    let pipeline = pipeline.in_scene(scene).predicting(event, job.limit_s);
    let Some(pipeline) = pipeline else {
        bail!(
            "{path}: no mark of {name:?}, expected one: the motion is predicted from there; `enact mark` proposes marks"
        );
    };
    let pipeline = pipeline.with_diagnoses(job.is_diagnosing);
    finish(&opened, &pipeline, &take.report, &output, &working)
}

fn last(scene: &Scene, until: Option<&str>) -> anyhow::Result<usize> {
    let mut events = scene.events.iter();
    let found = match until {
        Some(name) => events.position(|event| event.name == name),
        None => events
            .position(|event| event.kind.collision().is_some())
            .or_else(|| {
                scene
                    .events
                    .iter()
                    .position(|event| event.kind == EventKind::End)
            }),
    };
    match found {
        Some(0) if scene.events[0].kind == EventKind::Start => {
            bail!(
                "nothing was seen before {:?}, expected a later event",
                scene.events[0].name
            )
        }
        Some(found) => Ok(found),
        None => {
            let names: Vec<&str> = scene
                .events
                .iter()
                .map(|event| event.name.as_str())
                .collect();
            bail!(
                "the scene has no event {:?} to predict from, expected one of {}",
                until.unwrap_or("that ends it"),
                names.join(", ")
            )
        }
    }
}
