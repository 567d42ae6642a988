//! `enact replay`, run as people run it: for tests of what the program says.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The program, by its path.
#[derive(Clone, Copy, Debug)]
pub struct Program(pub &'static str);

/// What became of a replay.
#[derive(Debug)]
pub struct Replayed<T> {
    /// The exit code; none where a signal ended it.
    pub code: Option<i32>,
    /// What it said on stdout.
    pub said: T,
    /// What it said on stderr.
    pub errors: String,
    /// The file that it wrote, if it did: beside the recording.
    pub output: PathBuf,
}

impl Program {
    /// A replay with its account.
    pub fn account(self, recording: &Path, options: &[&str]) -> Replayed<String> {
        self.replayed(recording, "text", options)
    }

    /// A replay with its JSON object.
    ///
    /// # Panics
    /// Where stdout is no such object.
    pub fn report(self, recording: &Path, options: &[&str]) -> Replayed<Value> {
        let replayed = self.replayed(recording, "ndjson", options);
        let object = serde_json::from_str(&replayed.said);
        let said = object.unwrap_or_else(|error| panic!("{error}: {replayed:?}"));
        let Replayed {
            code,
            errors,
            output,
            ..
        } = replayed;
        Replayed {
            code,
            said,
            errors,
            output,
        }
    }

    fn replayed(self, recording: &Path, format: &str, options: &[&str]) -> Replayed<String> {
        let output = recording.with_extension("out.mcap");
        let mut command = Command::new(self.0);
        command.env_remove("RUST_LOG").env("NO_COLOR", "1");
        command.arg("replay").arg(recording).arg("-o").arg(&output);
        command.args(["--format", format]).args(options);
        let Output {
            status,
            stdout,
            stderr,
        } = command.output().expect("the program runs");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        Replayed {
            code: status.code(),
            said: text(stdout),
            errors: text(stderr),
            output,
        }
    }
}
