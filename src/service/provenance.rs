//! From what files are made, for the notes in them.

use std::path::Path;

use sha2::{Digest, Sha256};

use crate::ingest::Recording;
#[cfg(feature = "live")]
use crate::motion::Scene;
use crate::pipeline::Pipeline;
#[cfg(feature = "live")]
use crate::report::ExportProvenance;
use crate::report::{Provenance, command_line};

/// Program and version.
pub(super) const PROGRAM: &str = concat!("enact ", env!("CARGO_PKG_VERSION"));

/// In hexadecimal digits.
pub(super) fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The name of a file, without its folders.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// A text of TOML below a comment that says what made it.
pub(super) fn made_by(command: &str, toml: &str) -> String {
    let command: String = command
        .chars()
        .map(|of| if of.is_control() { '?' } else { of })
        .collect();
    format!("# Made by {PROGRAM}: {command}\n{toml}")
}

/// From what the daemon makes what pages show before there is a file: a scene.
#[cfg(feature = "live")]
pub(super) fn scene_provenance(scene: &Scene, verdict: &str) -> ExportProvenance {
    ExportProvenance {
        program: PROGRAM.to_owned(),
        command: "enact capture".to_owned(),
        recording: String::new(),
        recording_sha256: String::new(),
        scene: scene.name.clone(),
        scene_sha256: String::new(),
        verdict: verdict.to_owned(),
        estimate: None,
    }
}

/// From what an estimate is made: a recording, a scene's text and the file of that if it is not attached, and what was
/// asked of the pipeline. The command is that of `replay`, by whatever it is made, or of `predict`.
pub(super) fn provenance(
    recording: &Recording,
    scene_toml: &[u8],
    scene_file: Option<&Path>,
    pipeline: &Pipeline,
) -> Provenance {
    let name = file_name(recording.path());
    let mut words = vec!["enact".to_owned(), "replay".to_owned(), name.clone()];
    if let Some(scene) = scene_file {
        words.extend(["--scene".to_owned(), file_name(scene)]);
    }
    if let (true, Some(last)) = (pipeline.is_predicting(), pipeline.scene().events.last()) {
        words[1] = "predict".to_owned();
        words.extend(["--until".to_owned(), last.name.clone()]);
        let limit_s = pipeline.scene().settle_s.iter();
        words.extend(limit_s.flat_map(|limit_s| ["--limit".to_owned(), limit_s.to_string()]));
    }
    if pipeline.is_free_auto() {
        words.extend(["--free", "auto"].map(str::to_owned));
    }
    if !pipeline.is_diagnosing() {
        words.push("--no-diagnose".to_owned());
    }
    Provenance {
        program: PROGRAM.to_owned(),
        command: command_line(&words),
        recording: name,
        recording_sha256: sha256(recording.container().bytes()),
        scene_sha256: sha256(scene_toml),
        ended_after_s: None,
    }
}
