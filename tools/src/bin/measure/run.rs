//! On what something was measured. The charts and the studies include this file.

use std::fs;
use std::process::Command;

use serde::{Deserialize, Serialize};

/// On what a part was measured.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Run {
    /// Model of the processor.
    pub processor: String,
    /// How many of it the system may use.
    pub cores: usize,
    /// Compiler.
    pub rustc: String,
    /// Git revision.
    pub revision: String,
    /// Day.
    pub date: String,
    /// Whether it was a check that everything runs, and no measurement.
    pub quick: bool,
    /// How long it took \[s\].
    pub seconds: f64,
}

impl Run {
    /// This machine, now.
    pub fn here(quick: bool) -> Self {
        Self {
            processor: processor(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            rustc: said("rustc", &["-V"]),
            revision: revision(),
            date: said("date", &["-u", "+%F"]),
            quick,
            seconds: 0.0,
        }
    }
}

/// What is measured: the last commit, and whether anything but results was changed since.
fn revision() -> String {
    let commit = said("git", &["describe", "--always"]);
    let sources = [".", ":!tools/charts", ":!tools/study/results"];
    let status = ["status", "--porcelain", "--untracked-files=no", "--"];
    let changed = output("git", &[&status[..], &sources].concat());
    match changed.as_deref() {
        Some("") => commit,
        _ => commit + "-dirty",
    }
}

fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    line.and_then(|line| line.split(": ").nth(1))
        .unwrap_or("unknown processor")
        .to_owned()
}

/// What a command says, in the project's folder.
fn said(command: &str, arguments: &[&str]) -> String {
    match output(command, arguments) {
        Some(text) if !text.is_empty() => text,
        _ => "unknown".to_owned(),
    }
}

fn output(command: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(command)
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    Some(
        String::from_utf8_lossy(&output.ok()?.stdout)
            .trim()
            .to_owned(),
    )
}
