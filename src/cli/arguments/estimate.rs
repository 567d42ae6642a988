//! Arguments of what estimates motions. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::values::{Format, rate};
use crate::service::DEFAULT_PREDICTION_S;

/// Arguments of `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact replay tip.mcap\n\
             \x20 enact replay tip.mcap --scene other.toml -o other.mcap\n\
             \x20 enact replay tip.mcap --deadline 50ms --format ndjson\n\
             \x20 cat tip.mcap | enact replay - -o - | enact export - --to csv -o -")]
pub(in crate::cli) struct ReplayArguments {
    /// The recording, an MCAP file; - for stdin
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Where the estimate goes, - for stdout [default: IN with .estimate.mcap in place of .mcap]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// Pace: 1 is that of the performance, 2 twice as fast [default: as fast as possible]
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(in crate::cli) rate: Option<f64>,
    /// Send it over iceoryx2 too, as a live take, at RATE 1 if none is given
    #[arg(long)]
    pub(in crate::cli) publish: bool,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE", requires = "publish")]
    pub(in crate::cli) iceoryx2: Option<PathBuf>,
    /// Set free what explains a misfit: the fewest of what the scene keeps fixed
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(in crate::cli) free: Option<Free>,
    #[command(flatten)]
    pub(in crate::cli) diagnosing: Diagnosing,
    #[command(flatten)]
    pub(in crate::cli) limits: Limits,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `process`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, of a folder whose estimates of before are left as they are:\n\
             \x20 enact process takes/*.mcap -o estimates"
)]
pub(in crate::cli) struct ProcessArguments {
    /// The recordings, MCAP files or folders of them
    #[arg(value_name = "IN", required = true)]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// Keep estimates that are there of the same recordings, scenes and options, and make the others
    #[arg(long)]
    pub(in crate::cli) resume: bool,
    /// Folder for the estimates, made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(in crate::cli) output: PathBuf,
    /// Scene file for all [default: scene.toml attached to each recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// Set free what explains a misfit: the fewest of what the scenes keep fixed
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(in crate::cli) free: Option<Free>,
    #[command(flatten)]
    pub(in crate::cli) diagnosing: Diagnosing,
    #[command(flatten)]
    pub(in crate::cli) limits: Limits,
    /// How the accounts on stdout are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `predict`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact predict take.mcap\n\
             \x20 enact predict take.mcap --until bounce --limit 3 -o predicted.mcap")]
pub(in crate::cli) struct PredictArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// Where the prediction goes [default: IN with .predicted.mcap in place of .mcap]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// The event of the scene at whose mark what was seen ends [default: the first collision, else the end]
    #[arg(long, value_name = "EVENT")]
    pub(in crate::cli) until: Option<String>,
    /// Predict for so many seconds at most
    #[arg(long, value_name = "S", value_parser = rate, default_value_t = DEFAULT_PREDICTION_S)]
    pub(in crate::cli) limit: f64,
    #[command(flatten)]
    pub(in crate::cli) diagnosing: Diagnosing,
    #[command(flatten)]
    pub(in crate::cli) limits: Limits,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// What a command may cost.
#[derive(Debug, Args)]
pub(in crate::cli) struct Limits {
    /// End reading and estimating each recording after so long, as `50ms` or `2s`, with the best so far
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(in crate::cli) deadline: Option<Duration>,
}

/// Whether likely mistakes are looked for.
#[derive(Debug, Args)]
pub(in crate::cli) struct Diagnosing {
    /// Do not look for likely mistakes, which takes up to ten times as long as estimating
    #[arg(long)]
    no_diagnose: bool,
}

impl Diagnosing {
    pub(in crate::cli) fn is_wanted(&self) -> bool {
        !self.no_diagnose
    }
}

/// When a command ends that has no best so far to end with.
#[derive(Debug, Args)]
pub(in crate::cli) struct Budget {
    /// End the command after so long, as `50ms` or `2s`, as a signal would: nothing unfinished stays, exit code 1
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(in crate::cli) deadline: Option<Duration>,
}

/// What is set free beside the scene's own parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Free {
    /// Whatever explains a misfit and is told from everything else that might
    Auto,
}

fn time(text: &str) -> Result<Duration, String> {
    let time = humantime::parse_duration(text)
        .ok()
        .filter(|time| !time.is_zero());
    time.ok_or_else(|| "expected a time such as 50ms or 2s".into())
}
