//! From what files are made, for the notes in them.

use std::path::Path;

use sha2::{Digest, Sha256};

use super::finish::Opened;
use crate::pipeline::Pipeline;
use crate::report::{Provenance, command_line};

/// Program and version.
pub(super) const PROGRAM: &str = concat!("enact ", env!("CARGO_PKG_VERSION"));

/// In hexadecimal digits.
pub(super) fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The name of a file, without its folders.
pub(super) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// From what an estimate is made. The command is that of `replay`, by whatever it is made, or of `predict`.
pub(super) fn provenance(opened: &Opened, pipeline: &Pipeline) -> Provenance {
    let recording = file_name(opened.recording.path());
    let mut words = vec!["enact".to_owned(), "replay".to_owned(), recording.clone()];
    if let Some(scene) = &opened.scene_file {
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
    Provenance {
        program: PROGRAM.to_owned(),
        command: command_line(&words),
        recording,
        recording_sha256: sha256(opened.recording.container().bytes()),
        scene_sha256: sha256(&opened.scene_toml),
    }
}
