//! The arguments of `calibrate`. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand};

use super::estimate::Budget;
use super::values::{Format, rate, triple};

/// The commands of `calibrate`.
#[derive(Debug, Subcommand)]
pub(in crate::cli) enum CalibrateCommand {
    /// The tip in the tracker's axes: hold it in one place, swing the object about two axes
    Pivot(PivotArguments),
    /// A plane: touch it with the tip, three times or more, not in a line
    Plane(PlaneArguments),
    /// The tracker's noise, and how it is turned on the body: the object stands still
    Rest(RestArguments),
    /// Gravity in the tracker's frame: drop or toss the object
    Gravity(GravityArguments),
    /// Offset and drift between two clocks: turn an object with two trackers to and fro
    Clock(ClockArguments),
}

impl CalibrateCommand {
    pub(super) fn common(&self) -> &Common {
        match self {
            Self::Pivot(of) => &of.common,
            Self::Plane(of) => &of.common,
            Self::Rest(of) => &of.common,
            Self::Gravity(of) => &of.common,
            Self::Clock(of) => &of.common,
        }
    }
}

/// What all of them have.
#[derive(Debug, Args)]
pub(in crate::cli) struct Common {
    /// Scene file [default: scene.toml attached to the recording, if there is one]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// The scene's body that carries the tracker [default: the only one]
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) body: Option<String>,
    /// Only from so many seconds after the first sample
    #[arg(long, value_name = "S")]
    pub(in crate::cli) from: Option<f64>,
    /// Only until so many seconds after the first sample
    #[arg(long, value_name = "S")]
    pub(in crate::cli) to: Option<f64>,
    /// Where the calibration goes, TOML; a file that is there is not replaced [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `calibrate pivot`.
#[derive(Debug, Args)]
pub(in crate::cli) struct PivotArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Topic of the tracker's poses [default: the body's, or the only one]
    #[arg(long, value_name = "TOPIC")]
    pub(in crate::cli) topic: Option<String>,
    /// The scene's name of the tip: the tracker's mount follows from it
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) feature: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) common: Common,
}

/// Arguments of `calibrate plane`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("touching").required(true).args(["point", "tip", "feature"])))]
pub(in crate::cli) struct PlaneArguments {
    /// The recording, an MCAP file, with a mark at each touch
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Topic of the tracker's poses [default: the body's, or the only one]
    #[arg(long, value_name = "TOPIC")]
    pub(in crate::cli) topic: Option<String>,
    /// What touches: a point in the tracker's axes, in millimetres
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub(in crate::cli) point: Option<[f64; 3]>,
    /// What touches: the tip in a file of `calibrate pivot`
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) tip: Option<PathBuf>,
    /// What touches: a feature of the scene's body
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) feature: Option<String>,
    /// When it touches, in seconds after the first sample [default: at the marks]
    #[arg(long, value_name = "S,S,S", value_delimiter = ',')]
    pub(in crate::cli) at: Vec<f64>,
    /// For how long it stays where it touches, before and after, in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 50.0, value_parser = rate)]
    pub(in crate::cli) window_ms: f64,
    /// The scene's name of the plane
    #[arg(long, value_name = "NAME", default_value = "table")]
    pub(in crate::cli) surface: String,
    #[command(flatten)]
    pub(in crate::cli) common: Common,
}

/// Arguments of `calibrate rest`.
#[derive(Debug, Args)]
pub(in crate::cli) struct RestArguments {
    /// The recordings, MCAP files
    #[arg(value_name = "IN", required = true)]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// Topic of the tracker's poses [default: the body's, or the only one]
    #[arg(long, value_name = "TOPIC")]
    pub(in crate::cli) topic: Option<String>,
    /// The body's axis or face that is up, such as +z; one for each recording
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub(in crate::cli) stands: Vec<String>,
    #[command(flatten)]
    pub(in crate::cli) common: Common,
}

/// Arguments of `calibrate gravity`.
#[derive(Debug, Args)]
pub(in crate::cli) struct GravityArguments {
    /// The recordings, MCAP files; their flights are searched for, unless --from and --to say where one is
    #[arg(value_name = "IN", required = true)]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// Topic of the tracker's poses [default: the body's, or the only one]
    #[arg(long, value_name = "TOPIC")]
    pub(in crate::cli) topic: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) common: Common,
}

/// Arguments of `calibrate clock`.
#[derive(Debug, Args)]
pub(in crate::cli) struct ClockArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Topics of the two streams; offset and drift are those of the second [default: the body's, or the only two]
    #[arg(long, value_name = "TOPIC", num_args = 2)]
    pub(in crate::cli) topics: Vec<String>,
    #[command(flatten)]
    pub(in crate::cli) common: Common,
}

/// Arguments of `scene calibrated`.
#[derive(Debug, Args)]
pub(in crate::cli) struct SceneCalibratedArguments {
    /// The scene
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// Files of `calibrate`; where two are about the same, the later one counts
    #[arg(value_name = "CALIBRATION", required = true)]
    pub(in crate::cli) calibrations: Vec<PathBuf>,
    /// The new scene; a file that is there is not replaced [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}
