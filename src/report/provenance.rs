//! By what, with which command and from what a file was made.
//!
//! Nothing here says when or where: the same input and the same command give the same bytes. Files are said by
//! name, without folders, and by their SHA-256, in hexadecimal digits.

use serde::{Deserialize, Serialize};

/// From what an estimate was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// The command that makes it, whichever way it was made: by `process`, `replay` and `capture` a
    /// recording has one estimate.
    pub command: String,
    /// Name of the recording.
    pub recording: String,
    /// Of the recording's bytes.
    pub recording_sha256: String,
    /// Of the scene's text.
    pub scene_sha256: String,
    /// The time after which it was ended before all was tried \[s\]: what the command makes may be another, then.
    pub ended_after_s: Option<f64>,
}

/// From what a file for other programs or for people was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExportProvenance {
    /// Program and version.
    pub program: String,
    /// The command line.
    pub command: String,
    /// Name of the file of the estimate.
    pub recording: String,
    /// Of that file's bytes.
    pub recording_sha256: String,
    /// Name of the scene.
    pub scene: String,
    /// Of the scene's text.
    pub scene_sha256: String,
    /// `physical`, `plausible` or `failed`.
    pub verdict: String,
    /// From what that estimate was made, if it says so.
    pub estimate: Option<Provenance>,
}

impl ExportProvenance {
    /// Lines for people, without what begins a comment.
    pub fn lines(&self) -> Vec<String> {
        let Self {
            program,
            command,
            recording,
            recording_sha256,
            scene,
            scene_sha256,
            verdict,
            estimate,
        } = self;
        let mut lines = vec![format!(
            "{program}: {verdict} motion of {recording:?} (SHA-256 {recording_sha256}), scene {scene:?} (SHA-256 \
             {scene_sha256}), by {command:?}"
        )];
        lines.extend(estimate.as_ref().map(|of| {
            let ended = of.ended_after_s;
            let ended = ended.map_or(String::new(), |s| format!(", ended after {s} s"));
            format!(
                "estimated by {} from {:?} (SHA-256 {}), by {:?}{ended}",
                of.program, of.recording, of.recording_sha256, of.command
            )
        }));
        lines
    }
}

/// Words of a command as a shell takes them: those with other than plain characters in quotes.
pub fn command_line(words: &[String]) -> String {
    let quoted = |word: &String| {
        let is_plain =
            |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | '/' | '=' | ',');
        match !word.is_empty() && word.chars().all(is_plain) {
            true => word.clone(),
            false => format!("'{}'", word.replace('\'', "'\\''")),
        }
    };
    let words: Vec<String> = words.iter().map(quoted).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_words_that_were_given() {
        let words = ["enact", "a b.mcap", "", "it's", "x=1"].map(str::to_owned);
        assert_eq!(command_line(&words), r"enact 'a b.mcap' '' 'it'\''s' x=1");
    }
}
