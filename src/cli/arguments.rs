//! The arguments of the command line. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

use crate::service::{
    DEFAULT_EXPORT_RATE_HZ, ListedMark, MarkTime, PRESETS, TimeUnit, length_unit,
};

/// Acting capture: a performed motion goes in, the physically correct rigid-body motion that
/// fits it best comes out.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Exit codes: 0 done, 1 error, 2 usage, 3 finished but data were lost or the estimate is not physical."
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
    /// Make scenes
    Scene {
        /// Of what
        #[command(subcommand)]
        command: SceneCommand,
    },
    /// Write completions for a shell to stdout
    Completion {
        /// Which shell
        shell: clap_complete::Shell,
    },
}

/// Arguments of `capture`.
#[derive(Debug, Args)]
pub(super) struct CaptureArguments {
    /// The scene, with its `[capture]`
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Folder for takes [default: `capture.folder` of the scene]
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Begin a take at once
    #[arg(long)]
    pub(super) start: bool,
    /// Serve Foxglove and Lichtblick by WebSocket on this port, 0 for any [default:
    /// `capture.viewer_port` of the scene, or not at all]
    #[arg(long, value_name = "PORT")]
    pub(super) viewer_port: Option<u16>,
    /// Serve /health and /metrics by HTTP on this port, 0 for any [default:
    /// `capture.metrics_port` of the scene, or not at all]
    #[arg(long, value_name = "PORT")]
    pub(super) metrics_port: Option<u16>,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE")]
    pub(super) iceoryx2: Option<PathBuf>,
    /// How what happens is written on stdout
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `take`.
#[derive(Debug, Args)]
pub(super) struct TakeArguments {
    /// What is wanted
    #[arg(value_enum)]
    pub(super) wanted: Wanted,
    /// Event of the scene that `mark` stands for [default: the next one]
    #[arg(long, value_name = "NAME")]
    pub(super) event: Option<String>,
    /// Topic of marks: `marks_topic` of the scene
    #[arg(long, value_name = "TOPIC", default_value = "/marks")]
    pub(super) topic: String,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE")]
    pub(super) iceoryx2: Option<PathBuf>,
}

/// What may be wanted of a take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Wanted {
    /// Begin one
    Start,
    /// End it and estimate it
    Stop,
    /// End it and remove it
    Discard,
    /// An event happens now
    Mark,
    /// Say how it stands
    Status,
}

/// Arguments of `recover`.
#[derive(Debug, Args)]
pub(super) struct RecoverArguments {
    /// Journals (`….mcap.part`), or folders with such
    #[arg(value_name = "PATH", required = true)]
    pub(super) paths: Vec<PathBuf>,
    /// How the accounts on stdout are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `doctor`.
#[derive(Debug, Args)]
pub(super) struct DoctorArguments {
    /// A scene whose services and folder are looked at too
    #[arg(value_name = "SCENE")]
    pub(super) scene: Option<PathBuf>,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE")]
    pub(super) iceoryx2: Option<PathBuf>,
    /// How the findings on stdout are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub(super) struct ReplayArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Where the estimate goes [default: IN with .estimate.mcap in place of .mcap]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// Pace: 1 is that of the performance, 2 twice as fast [default: as fast as possible]
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(super) rate: Option<f64>,
    /// Send it over iceoryx2 too, as a live take, at RATE 1 if none is given
    #[arg(long)]
    pub(super) publish: bool,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE", requires = "publish")]
    pub(super) iceoryx2: Option<PathBuf>,
    /// Set free what explains a misfit: the fewest of what the scene keeps fixed
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(super) free: Option<Free>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `process`.
#[derive(Debug, Args)]
pub(super) struct ProcessArguments {
    /// The recordings, MCAP files
    #[arg(value_name = "IN", required = true)]
    pub(super) inputs: Vec<PathBuf>,
    /// Folder for the estimates, made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    /// Scene file for all [default: scene.toml attached to each recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// Set free what explains a misfit: the fewest of what the scenes keep fixed
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(super) free: Option<Free>,
    /// How the accounts on stdout are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `import`.
#[derive(Debug, Args)]
#[command(
    after_help = "Tables of EuRoC, TUM, Motive, Vicon and others with named columns are recognised; what is guessed is \
                  said. Several files, or several bodies in one, become several topics.\n\
                  Example: enact import toss.csv --scene config/cube_toss.toml -o toss.mcap\n\
                  Exit code 3: written, but what the data show speaks against how they were read, or some were lost."
)]
pub(super) struct ImportArguments {
    /// Tables of poses (CSV and the like), or one recording (MCAP) of which a part is wanted
    #[arg(value_name = "FILE", required = true)]
    pub(super) inputs: Vec<PathBuf>,
    /// The recording, an MCAP file
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,
    /// Scene file; it travels in the recording
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// Axes and units that are usual where the tables come from [default: what their heads say, else z-up]
    #[arg(long, value_name = "PRESET", value_parser = presets())]
    pub(super) from: Option<String>,
    /// Names of the columns in order, parted by commas, - for one that is not read [default: those in the file]
    #[arg(long, value_name = "NAMES", allow_hyphen_values = true)]
    pub(super) columns: Option<String>,
    /// Unit of times: s, ms, us, ns or frame [default: what the file says, else by the intervals]
    #[arg(long, value_name = "UNIT", value_parser = time_unit)]
    pub(super) time_unit: Option<TimeUnit>,
    /// Unit of positions: m, cm, mm, in or ft [default: what the file says, else that of the preset]
    #[arg(long, value_name = "UNIT", value_parser = known_length_unit)]
    pub(super) length_unit: Option<String>,
    /// Rows a second, whatever their times say; frames a second, where times count frames
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(super) rate: Option<f64>,
    /// Order of the numbers of quaternions, where names of columns do not say it
    #[arg(long, value_enum, value_name = "ORDER")]
    pub(super) quaternion: Option<Order>,
    /// What three angles mean, where a file has those
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(super) rotation: Option<Rotation>,
    /// Topic of a body, in order or by name [default: that of the scene's body, else /tracker/NAME/pose]
    #[arg(long, value_name = "[NAME=]TOPIC")]
    pub(super) topic: Vec<String>,
    /// Add a mark, in seconds since the first pose of the files
    #[arg(long, value_name = "TIME[:EVENT]", value_parser = listed_mark)]
    pub(super) mark: Vec<ListedMark>,
    /// Leave out what is before, in seconds since the first pose
    #[arg(long, value_name = "SECONDS", value_parser = since_first)]
    pub(super) start: Option<f64>,
    /// Leave out what is after
    #[arg(long, value_name = "SECONDS", value_parser = since_first)]
    pub(super) end: Option<f64>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Order of a quaternion's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Order {
    /// Scalar last
    Xyzw,
    /// Scalar first
    Wxyz,
}

/// What three angles mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Rotation {
    /// A rotation vector: axis times angle
    Vector,
    /// Turns about the body's x, then y, then z axis
    EulerXyz,
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(super) struct InspectArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `mark`.
#[derive(Debug, Args)]
#[command(
    after_help = "Marks are listed where nothing is asked for. TIME is in seconds since the first pose, as listed, or \
                  a stamp such as 1700000000410000000ns.\n\
                  Example: enact mark in.mcap --move bounce=0.954 --add 1.2:landing -o out.mcap"
)]
pub(super) struct MarkArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Propose marks where the streams have kinks
    #[arg(long, conflicts_with_all = ["add", "moves", "from", "from_topic"])]
    pub(super) propose: bool,
    /// Add a mark
    #[arg(long, value_name = "TIME[:EVENT]", value_parser = listed_mark, requires = "output")]
    pub(super) add: Vec<ListedMark>,
    /// Move a mark: its number, or the name of its event
    #[arg(long = "move", id = "moves", value_name = "MARK=TIME", value_parser = moved_mark, requires = "output")]
    pub(super) moves: Vec<(String, MarkTime)>,
    /// Leave out a mark: its number, the name of its event, or all
    #[arg(long, value_name = "MARK", requires = "output")]
    pub(super) remove: Vec<String>,
    /// Take the marks from a file, JSON or CSV, in place of those in the recording
    #[arg(long, value_name = "FILE", requires = "output")]
    pub(super) from: Option<PathBuf>,
    /// Take them from the messages on a topic of the recording, such as a button's
    #[arg(
        long,
        value_name = "TOPIC",
        requires = "output",
        conflicts_with = "from"
    )]
    pub(super) from_topic: Option<String>,
    /// Write a copy of the recording with the marks
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Collisions of each body [default: as many as the scene has]
    #[arg(long, value_name = "N", requires = "propose")]
    pub(super) count: Option<usize>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `sketch`.
#[derive(Debug, Args)]
pub(super) struct SketchArguments {
    /// Keyframes (.csv, .toml) or a recording (.mcap)
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// The other of the two [default: IN with .mcap, or with .csv]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Scene file; it travels in the recording [default: scene.toml attached to a recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// So many keyframes of each flight [default: every sample]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), conflicts_with = "per_second")]
    pub(super) per_flight: Option<u16>,
    /// So many keyframes a second
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(super) per_second: Option<f64>,
    /// Keyframes of the motion that is estimated from the recording
    #[arg(long)]
    pub(super) estimated: bool,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, for Blender at 30 frames a second with the performance beside the motion:\n  \
                  enact export tip.estimate.mcap --to glb --fps 30 --ghost -o tip.glb\n\
                  Exit code 3: done, but the motion is not physical or data were lost."
)]
pub(super) struct ExportArguments {
    /// A recording with an estimate, as `replay` writes it
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// What is made of it
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(super) to: Target,
    /// The file; - for stdout [default: IN with .glb, .csv or .tum]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Frames a second; events, beginnings and ends have keys beside them
    #[arg(long, value_name = "RATE", value_parser = rate, default_value_t = DEFAULT_EXPORT_RATE_HZ)]
    pub(super) fps: f64,
    /// With the performance as it was acted, at its physical times
    #[arg(long)]
    pub(super) ghost: bool,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// What `export` makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Target {
    /// Binary glTF 2.0: bodies with keys, and what stands still
    Glb,
    /// A row per frame and body
    Csv,
    /// Trajectories `t x y z qx qy qz qw`, a file per body
    Tum,
}

/// The commands of `scene`.
#[derive(Debug, Subcommand)]
pub(super) enum SceneCommand {
    /// Make a scene with the mechanism of a URDF file
    FromUrdf(FromUrdfArguments),
}

/// Arguments of `scene from-urdf`.
#[derive(Debug, Args)]
pub(super) struct FromUrdfArguments {
    /// The robot description, a URDF file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// The scene; a file that is there is not replaced [default: IN with .toml]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// How an account is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// For people
    Text,
    /// One JSON object per recording and line
    Ndjson,
}

/// What is set free beside the scene's own parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Free {
    /// Whatever explains a misfit and is told from everything else that might
    Auto,
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate > 0.0 && rate.is_finite() => Ok(rate),
        _ => Err("expected a positive number".into()),
    }
}

fn since_first(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds >= 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("expected seconds, 0 or more".into()),
    }
}

fn mark_time(text: &str) -> Result<MarkTime, String> {
    let expected = "expected seconds since the first pose, such as 0.41, or a stamp, such as 1700000000410000000ns";
    MarkTime::parse(text).ok_or_else(|| expected.into())
}

fn listed_mark(text: &str) -> Result<ListedMark, String> {
    match text.split_once(':') {
        Some((time, event)) if !event.is_empty() => Ok((mark_time(time)?, Some(event.to_owned()))),
        Some((time, _)) => Ok((mark_time(time)?, None)),
        None => Ok((mark_time(text)?, None)),
    }
}

fn moved_mark(text: &str) -> Result<(String, MarkTime), String> {
    let Some((which, time)) = text.rsplit_once('=') else {
        return Err("expected a mark and where it goes, such as bounce=0.41".into());
    };
    Ok((which.to_owned(), mark_time(time)?))
}

fn time_unit(text: &str) -> Result<TimeUnit, String> {
    TimeUnit::of(text).ok_or_else(|| "expected s, ms, us, ns or frame".into())
}

fn known_length_unit(text: &str) -> Result<String, String> {
    let known = length_unit(text).map(|_| text.to_owned());
    known.ok_or_else(|| "expected m, cm, mm, in or ft".into())
}

fn presets() -> PossibleValuesParser {
    let values = PRESETS
        .iter()
        .map(|preset| PossibleValue::new(preset.name).help(preset.about));
    PossibleValuesParser::new(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_commands_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn rates_are_positive() {
        assert_eq!(rate("0.5"), Ok(0.5));
        for bad in ["0", "-1", "inf", "NaN", "fast"] {
            assert!(rate(bad).is_err(), "{bad}");
        }
    }
}
