//! Scenes of robot descriptions.

use std::path::PathBuf;

use anyhow::Context;
use serde::Serialize;

use super::output::{refuse_present, write_new_file};
use super::provenance::made_by;
use crate::config::scene_from_urdf;
use crate::ingest::regular;

/// The input of [`from_urdf`].
#[derive(Clone, Debug)]
pub struct FromUrdfJob {
    /// A URDF file.
    pub input: PathBuf,
    /// The scene, TOML; beside the input with the ending `.toml` by default.
    pub output: Option<PathBuf>,
    /// The command that asks for it, which is noted in the scene.
    pub command: String,
}

/// The result of [`from_urdf`].
#[derive(Clone, Debug, Serialize)]
pub struct UrdfImported {
    /// The file that was read.
    pub input: String,
    /// The file that was written.
    pub output: String,
    /// Name of the scene.
    pub scene: String,
    /// Bodies.
    pub bodies: usize,
    /// Joints.
    pub joints: usize,
    /// What changes the motion and is not in the scene.
    pub lost: Vec<String>,
    /// What else is not, and what was made of what.
    pub warnings: Vec<String>,
}

/// Writes a scene with the mechanism of a URDF file. Never replaces a file: a scene is worked on by
/// hand.
pub fn from_urdf(job: &FromUrdfJob) -> anyhow::Result<UrdfImported> {
    let path = job.input.display();
    let output = job
        .output
        .clone()
        .unwrap_or_else(|| job.input.with_extension("toml"));
    let text = regular::read_text(&job.input).with_context(|| format!("{path}: cannot read"))?;
    let made = scene_from_urdf(&text).map_err(|error| error.in_file(path.to_string()))?;
    refuse_present(&output)?;
    write_new_file(&output, made_by(&job.command, &made.toml).as_bytes())?;
    Ok(UrdfImported {
        input: path.to_string(),
        output: output.display().to_string(),
        scene: made.name,
        bodies: made.bodies,
        joints: made.joints,
        lost: made.lost,
        warnings: made.notes,
    })
}
