//! Arguments of what records live takes, and of what looks after them. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::estimate::Budget;
use super::values::Format;

/// Arguments of `capture`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact capture config/pencil_tip.toml -o takes\n\
             \x20 enact capture config/pencil_tip.toml --start --viewer-port 8765 --metrics-port 9464\n\
             \x20 enact capture config/pencil_tip.toml --acting")]
pub(in crate::cli) struct CaptureArguments {
    /// The scene, with its `[capture]`
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Folder for takes [default: `capture.folder` of the scene]
    #[arg(short, long, value_name = "DIR")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Begin a take at once
    #[arg(long)]
    pub(in crate::cli) start: bool,
    /// Serve Foxglove and Lichtblick by WebSocket on this port, 0 for any [default:
    /// `capture.viewer_port` of the scene, or not at all]
    #[arg(long, value_name = "PORT")]
    pub(in crate::cli) viewer_port: Option<u16>,
    /// Serve the operator's page, /health and /metrics by HTTP on this port, 0 for any [default:
    /// `capture.metrics_port` of the scene, or not at all]
    #[arg(long, value_name = "PORT")]
    pub(in crate::cli) metrics_port: Option<u16>,
    /// Serve the acting page, a tracker in a browser, beside the operator's page, at port 9464 if none is said
    /// [FILE: the page, by default `acting.html` beside the program or what was made in tools/acting]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub(in crate::cli) acting: Option<Option<PathBuf>>,
    /// Serve it by HTTPS, too, to headsets and phones on the network [PORT: 9465 if none is said, 0 for any]; the certificate is
    /// made at the first start and kept in ~/.local/share/enact
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, requires = "acting")]
    pub(in crate::cli) https: Option<Option<u16>>,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) iceoryx2: Option<PathBuf>,
    /// How what happens is written on stdout
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `take`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact take start\n\
             \x20 enact take mark --event bounce\n\
             \x20 enact take stop --wait\n\
             Exit codes: 0 done, 1 refused or not recorded, 3 done, but something speaks against it: \
             of `start` that it may not be written, of `status` a tracker that fell silent or a full disk, of \
             `stop --wait` the estimate.")]
pub(in crate::cli) struct TakeArguments {
    /// What is wanted
    #[command(subcommand)]
    pub(in crate::cli) wanted: Wanted,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE", global = true)]
    pub(in crate::cli) iceoryx2: Option<PathBuf>,
    /// File with the daemon's token, where the daemon is on another machine [default: that of the daemon on this
    /// one]
    #[arg(long, value_name = "FILE", global = true)]
    pub(in crate::cli) token: Option<PathBuf>,
}

/// What may be wanted of a take.
#[derive(Debug, Subcommand)]
pub(in crate::cli) enum Wanted {
    /// Begin one
    Start,
    /// End it and estimate it
    Stop(StopArguments),
    /// End it and move it aside, into the folder `discarded`: nothing is deleted
    Discard,
    /// An event happens now
    Mark {
        /// Event of the scene that it stands for [default: the next one]
        #[arg(long, value_name = "NAME")]
        event: Option<String>,
        /// Topic of marks: `marks_topic` of the scene
        #[arg(long, value_name = "TOPIC", default_value = "/marks")]
        topic: String,
    },
    /// Say how the take and the trackers stand
    Status,
    /// List the takes in a folder, with what was said of them
    List {
        /// The folder
        #[arg(value_name = "DIR", default_value = "takes")]
        folder: PathBuf,
        /// How the list on stdout is written
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
}

/// Arguments of `take stop`.
#[derive(Debug, Args)]
pub(in crate::cli) struct StopArguments {
    /// Wait for the estimate, and say its verdict and file
    #[arg(long)]
    pub(in crate::cli) wait: bool,
    /// Name of the take, for the recording
    #[arg(long, value_name = "TEXT", value_parser = text_of::<NAME_BYTES>)]
    pub(in crate::cli) name: Option<String>,
    /// A note on the take, for the recording
    #[arg(long, value_name = "TEXT", value_parser = text_of::<NOTE_BYTES>)]
    pub(in crate::cli) note: Option<String>,
    /// Rating of the take, 1 (bad) to 5 (good)
    #[arg(long, value_name = "1-5", value_parser = clap::value_parser!(u32).range(1..=5))]
    pub(in crate::cli) rating: Option<u32>,
}

/// Arguments of `recover`.
#[derive(Debug, Args)]
#[command(after_help = "Example, of all that a crash left in a folder:\n\
             \x20 enact recover takes\n\
             Exit code 3: recovered, but some of it could not be read. Journals are kept.")]
pub(in crate::cli) struct RecoverArguments {
    /// Journals (`….mcap.part`), or folders with such
    #[arg(value_name = "PATH", required = true)]
    pub(in crate::cli) paths: Vec<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the accounts on stdout are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `doctor`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n\
             \x20 enact doctor config/pencil_tip.toml")]
pub(in crate::cli) struct DoctorArguments {
    /// A scene whose services and folder are looked at too
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) iceoryx2: Option<PathBuf>,
    /// How the findings on stdout are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Longest name and note of a take \[bytes\].
const NAME_BYTES: usize = 256;

const NOTE_BYTES: usize = 1024;

fn text_of<const N: usize>(text: &str) -> Result<String, String> {
    match text.len() {
        0 => Err("expected a text".into()),
        length if length > N => Err(format!("{length} bytes long, at most {N}")),
        _ => Ok(text.to_owned()),
    }
}
