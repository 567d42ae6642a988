//! What is asked of an export, and what it says.

use std::path::PathBuf;

use serde::Serialize;

/// What a motion is exported as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Binary glTF 2.0.
    Glb,
    /// A table.
    Csv,
    /// Trajectories, a file per body.
    Tum,
    /// A skeleton with frames.
    Bvh,
    /// A recording of ROS 2's profile.
    Ros2,
    /// A table of events.
    Events,
}

impl ExportFormat {
    /// How names of such files end.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Csv => "csv",
            Self::Tum => "tum",
            Self::Bvh => "bvh",
            Self::Ros2 => "ros2.mcap",
            Self::Events => "events.csv",
        }
    }
}

/// The input of [`export`](super::export).
#[derive(Clone, Debug)]
pub struct ExportJob {
    /// A recording with an estimate.
    pub input: PathBuf,
    /// Where it goes: that file, files named after it, or [stdout](crate::service::is_pipe); by default the file with
    /// the ending of its format beside the recording.
    pub output: Option<PathBuf>,
    /// As what.
    pub format: ExportFormat,
    /// Frames a second.
    pub frame_rate_hz: f64,
    /// Whether the performance goes along, as it was acted.
    pub with_acted: bool,
    /// The command line, to be noted in the file.
    pub command: String,
}

/// The result of [`export`](super::export).
#[derive(Clone, Debug, Serialize)]
pub struct Exported {
    /// The file that was read.
    pub input: String,
    /// The files that were written.
    pub outputs: Vec<String>,
    /// Name of the scene.
    pub scene: String,
    /// `physical`, `plausible` or `failed`.
    pub verdict: String,
    /// Bodies.
    pub bodies: usize,
    /// Keys of the motion, of all bodies.
    pub keys: usize,
    /// Parts of the recording that could not be read.
    pub lost: Vec<String>,
    /// What to know.
    pub warnings: Vec<String>,
}
