//! Arguments of what takes motions elsewhere. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::estimate::Budget;
use super::values::{Format, rate};
use crate::service::DEFAULT_EXPORT_RATE_HZ;

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, for Blender at 30 frames a second with the performance beside the motion:\n  \
                  enact export tip.estimate.mcap --to glb --fps 30 --ghost -o tip.glb\n\
                  Exit code 3: done, but the motion is not physical or data were lost."
)]
pub(in crate::cli) struct ExportArguments {
    /// A recording with an estimate, as `replay` writes it
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// What is made of it
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(in crate::cli) to: Target,
    /// The file; - for stdout [default: IN with .glb, .csv, .tum, .bvh, .ros2.mcap or .events.csv]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Frames a second; events, beginnings and ends have keys beside them
    #[arg(long, value_name = "RATE", value_parser = rate, default_value_t = DEFAULT_EXPORT_RATE_HZ)]
    pub(in crate::cli) fps: f64,
    /// With the performance as it was acted, at its physical times
    #[arg(long)]
    pub(in crate::cli) ghost: bool,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// What `export` makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Target {
    /// Binary glTF 2.0: bodies with keys, and what stands still
    Glb,
    /// A row per frame and body
    Csv,
    /// Trajectories `t x y z qx qy qz qw`, a file per body
    Tum,
    /// A skeleton with a joint per body and rotations in degrees, on frames alone
    Bvh,
    /// A recording of ROS 2's profile with the estimate alone: PoseStamped, TFMessage, URDF
    Ros2,
    /// A table of events: a row per contact of a collision, with place, speeds and impulse
    Events,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples, a page that needs nothing else, and a picture of the motion alone:\n  \
                  enact report tip.estimate.mcap -o tip.html\n  \
                  enact report tip.estimate.mcap --svg tip.svg --view front\n\
                  Exit code 3: done, but the motion is not physical or data were lost."
)]
pub(in crate::cli) struct ReportArguments {
    /// A recording with an estimate, as `replay` writes it
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// The page; - for stdout [default: IN with .html, unless a picture is asked for]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// A strobe picture of the motion; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) svg: Option<PathBuf>,
    /// From where the picture is seen
    #[arg(long, value_enum, value_name = "VIEW", requires = "svg", default_value_t = Seen::ThreeQuarter)]
    pub(in crate::cli) view: Seen,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// From where a motion is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Seen {
    /// Level, so that it is as wide as it may be
    Front,
    /// Level, a quarter turn from there
    Side,
    /// From above
    Top,
    /// From the front, above and beside
    ThreeQuarter,
}
