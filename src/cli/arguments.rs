//! The arguments of the command line. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

use crate::service::DEFAULT_EXPORT_RATE_HZ;

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
    /// Say what is in a recording
    Inspect(InspectArguments),
    /// Say where the marks of a recording would be
    Mark(MarkArguments),
    /// Make a recording of keyframes in a file, or a file of keyframes of a recording
    Sketch(SketchArguments),
    /// Make files for other programs of the motion that `replay` found
    Export(ExportArguments),
    /// Make scenes, and say what they mean
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

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(super) struct InspectArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `mark`.
#[derive(Debug, Args)]
pub(super) struct MarkArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Propose marks where the streams have kinks
    #[arg(long, required = true)]
    pub(super) propose: bool,
    /// Write a copy of the recording with the marks
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Collisions of each body [default: as many as the scene has]
    #[arg(long, value_name = "N")]
    pub(super) count: Option<usize>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// How the proposals on stdout are written
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
    /// Make a scene of an object over a table
    New(NewSceneArguments),
    /// Say what a scene means: bodies, topics, what each mark stands for, what is missing
    Check(CheckSceneArguments),
    /// List the objects that `scene new` knows
    Objects,
    /// Write the JSON schema of scene files to stdout, for editors
    Schema,
    /// Write the reference of scene files to stdout, Markdown
    Reference,
}

/// Arguments of `scene new`.
#[derive(Debug, Args)]
pub(super) struct NewSceneArguments {
    /// An object of `scene objects`, or a mesh: a file that ends in .obj, .stl or .glb
    #[arg(value_name = "OBJECT")]
    pub(super) object: String,
    /// The scene; a file that is there is not replaced [default: the object's name with .toml]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Mass in grams; a mesh needs it [default: that of the object]
    #[arg(long, value_name = "GRAMS", value_parser = rate, allow_hyphen_values = true)]
    pub(super) mass_g: Option<f64>,
    /// Unit of length of a mesh [default: m for .glb]
    #[arg(long, value_enum)]
    pub(super) unit: Option<LengthUnit>,
    /// Take the convex hull of a mesh, as where its surface is not closed
    #[arg(long)]
    pub(super) hull: bool,
    /// Where the tracker is on the object, in millimetres along its axes [default: at its origin]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub(super) tracker_mm: Option<[f64; 3]>,
    /// How often it bounces on the table before it lands
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) bounces: usize,
    /// What the stamps of the performance are
    #[arg(long, value_enum, default_value_t = NewStamps::Tempo)]
    pub(super) stamps: NewStamps,
    /// Axis (+z, -x, …) or face that is up when it has come to rest
    #[arg(long, value_name = "UP", allow_hyphen_values = true)]
    pub(super) lands: Option<String>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Units of length of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LengthUnit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
}

impl LengthUnit {
    /// In metres.
    pub(super) fn metres(self) -> f64 {
        match self {
            LengthUnit::Mm => 1e-3,
            LengthUnit::Cm => 1e-2,
            LengthUnit::M => 1.0,
            LengthUnit::In => 0.0254,
        }
    }
}

/// What the stamps of a performance are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum NewStamps {
    /// Times of a performance whose tempo is not known
    Tempo,
    /// Times of the motion itself
    Physical,
}

/// Arguments of `scene check`.
#[derive(Debug, Args)]
pub(super) struct CheckSceneArguments {
    /// The scene
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
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

fn triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let numbers = numbers
        .ok()
        .and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let finite = numbers.filter(|numbers| numbers.iter().all(|x| x.is_finite()));
    finite.ok_or_else(|| "expected three numbers such as 12,-5,40".into())
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate > 0.0 && rate.is_finite() => Ok(rate),
        _ => Err("expected a positive number".into()),
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

    #[test]
    fn triples_are_three_finite_numbers() {
        assert_eq!(triple("12,-5, 40"), Ok([12.0, -5.0, 40.0]));
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "a,b,c"] {
            assert!(triple(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn rates_are_positive() {
        assert_eq!(rate("0.5"), Ok(0.5));
        for bad in ["0", "-1", "inf", "NaN", "fast"] {
            assert!(rate(bad).is_err(), "{bad}");
        }
    }
}
