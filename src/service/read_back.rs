//! An estimate that was written, read back.

use std::path::Path;

use anyhow::{Context, bail};

use super::deadline::Deadline;
use super::finish::with_recording;
use super::provenance::{PROGRAM, file_name, sha256};
use crate::config::scene_from_toml;
use crate::ingest::Recording;
use crate::motion::Scene;
use crate::report::ExportProvenance;
use crate::write::export::{WrittenMotion, scene_of_estimate};

/// A recording with an estimate.
pub(super) struct ReadBack {
    pub(super) recording: Recording,
    /// The scene of the estimate.
    pub(super) scene: Scene,
    pub(super) motion: WrittenMotion,
    scene_sha256: String,
}

impl ReadBack {
    /// Reads all of it. Fails where there is no estimate, or where some of it cannot be read.
    pub(super) fn open(input: &Path) -> anyhow::Result<Self> {
        with_recording(input, Deadline::begin(None), |recording| {
            Self::of(input, recording)
        })
    }

    fn of(input: &Path, recording: Recording) -> anyhow::Result<Self> {
        let path = input.display();
        let container = recording.container();
        let Some(scene_toml) = scene_of_estimate(container) else {
            bail!(
                "{path}: has no scene and no estimate, expected what `enact replay` writes of it"
            );
        };
        let text = std::str::from_utf8(scene_toml)
            .with_context(|| format!("{path}: the attached scene is not UTF-8"))?;
        let scene =
            scene_from_toml(text).map_err(|error| error.in_file(format!("{path}#scene")))?;
        let motion = WrittenMotion::read(input, container, &scene)?;
        let scene_sha256 = sha256(scene_toml);
        Ok(Self {
            recording,
            scene,
            motion,
            scene_sha256,
        })
    }

    /// From what a file is made that this command makes of it.
    pub(super) fn provenance(&self, command: &str) -> ExportProvenance {
        ExportProvenance {
            program: PROGRAM.to_owned(),
            command: command.to_owned(),
            recording: file_name(self.recording.path()),
            recording_sha256: sha256(self.recording.container().bytes()),
            scene: self.scene.name.clone(),
            scene_sha256: self.scene_sha256.clone(),
            verdict: self.motion.verdict.clone(),
            estimate: self.motion.provenance.clone(),
        }
    }

    /// What of the file could not be read.
    pub(super) fn lost(&self) -> Vec<String> {
        let damages = self.recording.container().damages();
        let lost = damages.first().iter().filter(|_| damages.is_loss());
        lost.map(ToString::to_string).collect()
    }
}
