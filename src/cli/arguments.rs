//! The arguments of the command line. Doc comments of the fields are the text of `--help`.

mod calibrate;
mod estimate;
mod fit;
mod live;
mod output;
mod recording;
mod scene;
mod values;

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgAction, Parser, Subcommand};

pub(super) use calibrate::{CalibrateCommand, Common, SceneCalibratedArguments};
pub(super) use estimate::{Free, PredictArguments, ProcessArguments, ReplayArguments};
pub(super) use fit::FitArguments;
#[cfg(feature = "live")]
pub(super) use live::Wanted;
pub(super) use live::{CaptureArguments, DoctorArguments, RecoverArguments, TakeArguments};
pub(super) use output::{ExportArguments, ReportArguments, Seen, Target};
pub(super) use recording::{
    ImportArguments, InspectArguments, MarkArguments, Order, SketchArguments,
};
pub(super) use scene::{
    CheckSceneArguments, FromUrdfArguments, LengthUnit, NewSceneArguments, NewStamps, SceneCommand,
};
pub(super) use values::Format;

/// Acting capture: a performed motion goes in, the physically correct rigid-body motion that
/// fits it best comes out.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Exit codes: 0 done, 1 error, 2 usage, 3 finished, but data were lost, the motion is not physical, or something speaks against it."
)]
pub(super) struct Arguments {
    /// Say more on stderr; also set by RUST_LOG, such as `enact=debug`
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub(super) verbose: u8,
    #[command(subcommand)]
    pub(super) command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Record live takes and estimate them
    Capture(CaptureArguments),
    /// Direct a `capture` that runs: start, stop, discard, mark, status
    Take(TakeArguments),
    /// Make recordings of what a crash left of live takes
    Recover(RecoverArguments),
    /// Say what stands between trackers and a take
    Doctor(DoctorArguments),
    /// Play a recording through the pipeline and write its estimate
    Replay(ReplayArguments),
    /// Estimate many recordings, as fast as they come
    Process(ProcessArguments),
    /// Make a recording of tables of poses, or of a part of a recording
    Import(ImportArguments),
    /// Say what is in a recording
    Inspect(InspectArguments),
    /// List the marks of a recording, propose some, or change them
    Mark(MarkArguments),
    /// Make a recording of keyframes in a file, or a file of keyframes of a recording
    Sketch(SketchArguments),
    /// Make files for other programs of the motion that `replay` found
    Export(ExportArguments),
    /// Make a page to open, and a picture, of the motion that `replay` found
    Report(ReportArguments),
    /// Continue a motion from its flight until it rests, without what was seen later
    Predict(PredictArguments),
    /// Measure trackers and rooms: tip, table, noise, gravity, clocks
    #[command(after_help = "Examples:\n\
             \x20 enact calibrate pivot swing.mcap --feature tip -o tip.toml\n\
             \x20 enact calibrate plane touches.mcap --tip tip.toml -o table.toml\n\
             \x20 enact scene calibrated scene.toml tip.toml table.toml -o measured.toml")]
    Calibrate {
        /// What
        #[command(subcommand)]
        command: CalibrateCommand,
    },
    /// Find what many takes share: restitution, friction, gravity, mounts
    Fit(FitArguments),
    /// Make scenes, and say what they mean
    #[command(after_help = "Examples:\n\
             \x20 enact scene new pencil -o pencil.toml\n\
             \x20 enact scene new mug.stl --unit mm --mass-g 320 --lands +z -o mug.toml\n\
             \x20 enact scene new ball --material tennis-ball -o ball.toml\n\
             \x20 enact scene check pencil.toml")]
    Scene {
        /// Of what
        #[command(subcommand)]
        command: SceneCommand,
    },
    /// Write completions for a shell to stdout
    #[command(
        after_help = "Example:\n  enact completion bash > ~/.local/share/bash-completion/completions/enact"
    )]
    Completion {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Write man pages into a folder
    #[command(
        after_help = "Example:\n  enact manual -o ~/.local/share/man/man1 && man enact-replay"
    )]
    Manual {
        /// The folder, made if it is not there
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
}

impl Command {
    /// When it is to end wherever it is: commands that can end with the best so far do that themselves.
    pub(super) fn deadline(&self) -> Option<Duration> {
        let budget = match self {
            Self::Recover(of) => &of.budget,
            Self::Import(of) => &of.budget,
            Self::Mark(of) => &of.budget,
            Self::Export(of) => &of.budget,
            Self::Report(of) => &of.budget,
            Self::Calibrate { command } => &command.common().budget,
            Self::Fit(of) => &of.budget,
            _ => return None,
        };
        budget.deadline
    }

    /// When it is to end with the best so far.
    pub(super) fn limit(&self) -> Option<Duration> {
        let limits = match self {
            Self::Replay(of) => &of.limits,
            Self::Predict(of) => &of.limits,
            Self::Inspect(of) => &of.limits,
            Self::Sketch(of) => &of.limits,
            _ => return None,
        };
        limits.deadline
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_commands_are_consistent() {
        Arguments::command().debug_assert();
    }
}
