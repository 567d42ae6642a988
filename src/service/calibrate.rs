//! Calibrations of recordings, and scenes with them.

mod quantity;
mod room;
mod streams;
mod tip;

use std::iter;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::Serialize;

use super::output::{refuse_present, write_new_file};
use super::working::Working;
use crate::config::{Calibration, scene_calibrated};
use crate::ingest::read_text;

/// What of a recording is looked at.
#[derive(Clone, Debug, Default)]
pub struct CalibrateChoice {
    /// Topics of poses; by default those of the body, or the only ones there are.
    pub topics: Vec<String>,
    /// Scene file; by default the one attached to a recording, if there is one.
    pub scene: Option<PathBuf>,
    /// Body of the scene whose tracker it is; by default the only one.
    pub body: Option<String>,
    /// From when \[s since the first sample\].
    pub from_s: Option<f64>,
    /// To when \[s since the first sample\].
    pub to_s: Option<f64>,
}

/// What is calibrated.
#[derive(Clone, Debug)]
pub enum CalibrateKind {
    /// The tip in the tracker's axes.
    Pivot {
        /// The scene's name of the tip.
        feature: Option<String>,
    },
    /// The plane that is touched.
    Plane {
        /// What touches.
        point: TouchingPoint,
        /// When it touches \[s since the first sample\]; by default at the marks.
        at_s: Vec<f64>,
        /// For how long it stays about each of these times, to each side \[s\].
        window_s: f64,
        /// The scene's name of the plane.
        surface: String,
    },
    /// An object at rest.
    Rest {
        /// The axis or face of the body that is up, one per recording.
        stands: Vec<String>,
    },
    /// A drop or toss.
    Gravity,
    /// Two streams of one motion.
    Clock,
}

/// The point of a body that touches.
#[derive(Clone, Debug)]
pub enum TouchingPoint {
    /// A point in the tracker's axes \[mm\].
    InTracker([f64; 3]),
    /// What a `pivot` found: its file.
    Pivot(PathBuf),
    /// A feature of the scene's body.
    Feature(String),
}

/// The input of [`calibrate`].
#[derive(Clone, Debug)]
pub struct CalibrateJob {
    /// The recordings.
    pub inputs: Vec<PathBuf>,
    /// Where the calibration goes; by default it is only returned.
    pub output: Option<PathBuf>,
    /// What of them is looked at.
    pub choice: CalibrateChoice,
    /// What is calibrated.
    pub kind: CalibrateKind,
}

impl CalibrateJob {
    /// The files that it reads.
    fn files(&self) -> impl Iterator<Item = &Path> {
        let tip = match &self.kind {
            CalibrateKind::Plane {
                point: TouchingPoint::Pivot(file),
                ..
            } => Some(file),
            _ => None,
        };
        let files = self.inputs.iter().chain(&self.choice.scene).chain(tip);
        files.map(PathBuf::as_path)
    }
}

/// The result of [`calibrate`].
#[derive(Clone, Debug, Serialize)]
pub struct Calibrated {
    /// What was found.
    pub calibration: Calibration,
    /// Parts of recordings that could not be read.
    pub lost: Vec<String>,
    /// The file that was written.
    pub output: Option<String>,
    /// The calibration as TOML.
    #[serde(skip)]
    pub toml: String,
}

/// Calibrates a tracker or the room by recordings. A file that is there is not replaced.
pub fn calibrate(job: &CalibrateJob) -> anyhow::Result<Calibrated> {
    if let Some(output) = &job.output {
        refuse_present(output)?;
    }
    let _working = Working::begin("calibrating");
    let (calibration, lost) = match &job.kind {
        CalibrateKind::Pivot { feature } => {
            tip::pivot(only(&job.inputs)?, &job.choice, feature.as_deref())?
        }
        CalibrateKind::Plane {
            point,
            at_s,
            window_s,
            surface,
        } => tip::plane(
            only(&job.inputs)?,
            &job.choice,
            point,
            at_s,
            *window_s,
            surface,
        )?,
        CalibrateKind::Rest { stands } => room::rest(&job.inputs, &job.choice, stands)?,
        CalibrateKind::Gravity => room::gravity(&job.inputs, &job.choice)?,
        CalibrateKind::Clock => room::clock(only(&job.inputs)?, &job.choice)?,
    };
    let toml = calibration.to_toml()?;
    if let Some(output) = &job.output {
        let made_of: Vec<&Path> = job.files().collect();
        write_new_file(output, toml.as_bytes(), &made_of)?;
    }
    Ok(Calibrated {
        calibration,
        lost,
        output: job
            .output
            .as_ref()
            .map(|output| output.display().to_string()),
        toml,
    })
}

/// The input of [`calibrate_scene`].
#[derive(Clone, Debug)]
pub struct CalibrateSceneJob {
    /// A scene file.
    pub scene: PathBuf,
    /// Calibration files, of which later ones count.
    pub calibrations: Vec<PathBuf>,
    /// Where the new scene goes; by default it is only returned.
    pub output: Option<PathBuf>,
}

/// The result of [`calibrate_scene`].
#[derive(Clone, Debug, Serialize)]
pub struct SceneCalibrated {
    /// The scene that was read.
    pub scene: String,
    /// What changed in it.
    pub changes: Vec<String>,
    /// What speaks against the calibrations.
    pub against: Vec<String>,
    /// The file that was written.
    pub output: Option<String>,
    /// The new scene.
    #[serde(skip)]
    pub toml: String,
}

/// Puts calibrations into a scene. A file that is there is not replaced.
pub fn calibrate_scene(job: &CalibrateSceneJob) -> anyhow::Result<SceneCalibrated> {
    if let Some(output) = &job.output {
        refuse_present(output)?;
    }
    let scene = job.scene.display().to_string();
    let text = read_text(&job.scene).with_context(|| format!("{scene}: cannot read"))?;
    let mut against = Vec::new();
    let mut calibrations = Vec::new();
    for path in &job.calibrations {
        let calibration = calibration(path)?;
        let file = path.display().to_string();
        if calibration.scene.is_empty() {
            bail!(
                "{file}: has no keys of a scene; a calibration has some when its recording or \
                 --scene says which body and feature it is about"
            );
        }
        against.extend(
            calibration
                .against
                .iter()
                .map(|line| format!("{file}: {line}")),
        );
        calibrations.push((file, calibration));
    }
    let made = scene_calibrated(&text, &calibrations)
        .map_err(|error| error.in_file(format!("{scene} with its calibrations")))?;
    if let Some(output) = &job.output {
        let files = iter::once(&job.scene).chain(&job.calibrations);
        let made_of: Vec<&Path> = files.map(PathBuf::as_path).collect();
        write_new_file(output, made.toml.as_bytes(), &made_of)?;
    }
    Ok(SceneCalibrated {
        scene,
        changes: made.changes,
        against,
        output: job
            .output
            .as_ref()
            .map(|output| output.display().to_string()),
        toml: made.toml,
    })
}

/// Reads a calibration file.
fn calibration(path: &Path) -> anyhow::Result<Calibration> {
    let file = path.display().to_string();
    let text = read_text(path).with_context(|| format!("{file}: cannot read"))?;
    let read = Calibration::from_toml(&text);
    read.map_err(|error| match error {
        crate::config::CalibrationError::File(error) => error.in_file(file).into(),
        other => anyhow::Error::new(other).context(file),
    })
}

fn only(inputs: &[PathBuf]) -> anyhow::Result<&Path> {
    match inputs {
        [input] => Ok(input),
        _ => bail!("{} recordings, expected one", inputs.len()),
    }
}
