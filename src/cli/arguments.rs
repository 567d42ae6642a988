//! The arguments of the command line. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

use super::calibrate_arguments::{CalibrateCommand, SceneCalibratedArguments};
pub(super) use super::values::Format;
use super::values::rate;
use crate::service::{
    DEFAULT_EXPORT_RATE_HZ, DEFAULT_PREDICTION_S, ListedMark, MarkTime, PRESETS, TimeUnit,
    length_unit,
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
    /// Make a page to open, and a picture, of the motion that `replay` found
    Report(ReportArguments),
    /// Continue a motion from its flight until it rests, without what was seen later
    Predict(PredictArguments),
    /// Measure trackers and rooms: tip, table, noise, gravity, clocks
    Calibrate {
        /// What
        #[command(subcommand)]
        command: CalibrateCommand,
    },
    /// Make scenes, and say what they mean
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

/// Arguments of `capture`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact capture config/pencil_tip.toml -o takes\n\
             \x20 enact capture config/pencil_tip.toml --start --viewer-port 8765 --metrics-port 9464")]
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
    /// Serve the operator's page, /health and /metrics by HTTP on this port, 0 for any [default:
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
#[command(after_help = "Examples:\n\
             \x20 enact take start\n\
             \x20 enact take mark --event bounce\n\
             \x20 enact take stop --wait\n\
             Exit codes: 0 done, 1 refused or not recorded, 3 done, but something speaks against it: \
             of `status` a tracker that fell silent or a full disk, of `stop --wait` the estimate.")]
pub(super) struct TakeArguments {
    /// What is wanted
    #[command(subcommand)]
    pub(super) wanted: Wanted,
    /// Configuration file of iceoryx2 [default: where iceoryx2 looks for it]
    #[arg(long, value_name = "FILE", global = true)]
    pub(super) iceoryx2: Option<PathBuf>,
}

/// What may be wanted of a take.
#[derive(Debug, Subcommand)]
pub(super) enum Wanted {
    /// Begin one
    Start,
    /// End it and estimate it
    Stop(StopArguments),
    /// End it and remove it
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
pub(super) struct StopArguments {
    /// Wait for the estimate, and say its verdict and file
    #[arg(long)]
    pub(super) wait: bool,
    /// Name of the take, for the recording
    #[arg(long, value_name = "TEXT", value_parser = text_of::<NAME_BYTES>)]
    pub(super) name: Option<String>,
    /// A note on the take, for the recording
    #[arg(long, value_name = "TEXT", value_parser = text_of::<NOTE_BYTES>)]
    pub(super) note: Option<String>,
    /// Rating of the take, 1 (bad) to 5 (good)
    #[arg(long, value_name = "1-5", value_parser = clap::value_parser!(u32).range(1..=5))]
    pub(super) rating: Option<u32>,
}

/// Arguments of `recover`.
#[derive(Debug, Args)]
#[command(after_help = "Example, of all that a crash left in a folder:\n\
             \x20 enact recover takes\n\
             Exit code 3: recovered, but some of it could not be read. Journals are kept.")]
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
#[command(after_help = "Example:\n\
             \x20 enact doctor config/pencil_tip.toml")]
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
#[command(after_help = "Examples:\n\
             \x20 enact replay tip.mcap\n\
             \x20 enact replay tip.mcap --scene other.toml -o other.mcap\n\
             \x20 enact replay tip.mcap --deadline 50ms --format ndjson\n\
             \x20 cat tip.mcap | enact replay - -o - | enact export - --to csv -o -")]
pub(super) struct ReplayArguments {
    /// The recording, an MCAP file; - for stdin
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Where the estimate goes, - for stdout [default: IN with .estimate.mcap in place of .mcap]
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
    #[command(flatten)]
    pub(super) limits: Limits,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `process`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example, of a folder whose estimates of before are left as they are:\n\
             \x20 enact process takes/*.mcap -o estimates"
)]
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
    #[command(flatten)]
    pub(super) limits: Limits,
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
#[command(after_help = "Examples:\n\
             \x20 enact inspect tip.mcap\n\
             \x20 enact inspect tip.mcap --format ndjson | jq .topics")]
pub(super) struct InspectArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(super) limits: Limits,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// Arguments of `mark`.
#[derive(Debug, Args)]
#[command(
    after_help = "Marks are listed where nothing is asked for. TIME is in seconds since the first pose, as listed, or \
                  a stamp such as 1700000000410000000ns.\n\
                  Examples:\n\
                  \x20 enact mark in.mcap\n\
                  \x20 enact mark in.mcap --move bounce=0.954 --add 1.2:landing -o out.mcap\n\
                  \x20 enact mark in.mcap --propose -o out.mcap"
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
#[command(after_help = "Examples:\n\
             \x20 enact sketch keys.csv --scene config/pencil_tip.toml -o keys.mcap\n\
             \x20 enact sketch tip.mcap --per-flight 5 -o keys.csv")]
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
    /// The file; - for stdout [default: IN with .glb, .csv, .tum, .bvh or .ros2.mcap]
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
    /// A skeleton with a joint per body and rotations in degrees, on frames alone
    Bvh,
    /// A recording of ROS 2's profile with the estimate alone: PoseStamped, TFMessage, URDF
    Ros2,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples, a page that needs nothing else, and a picture of the motion alone:\n  \
                  enact report tip.estimate.mcap -o tip.html\n  \
                  enact report tip.estimate.mcap --svg tip.svg --view front\n\
                  Exit code 3: done, but the motion is not physical or data were lost."
)]
pub(super) struct ReportArguments {
    /// A recording with an estimate, as `replay` writes it
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// The page; - for stdout [default: IN with .html, unless a picture is asked for]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// A strobe picture of the motion; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// From where the picture is seen
    #[arg(long, value_enum, value_name = "VIEW", requires = "svg", default_value_t = Seen::ThreeQuarter)]
    pub(super) view: Seen,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
}

/// From where a motion is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Seen {
    /// Level, so that it is as wide as it may be
    Front,
    /// Level, a quarter turn from there
    Side,
    /// From above
    Top,
    /// From the front, above and beside
    ThreeQuarter,
}

/// Arguments of `predict`.
#[derive(Debug, Args)]
pub(super) struct PredictArguments {
    /// The recording, an MCAP file
    #[arg(value_name = "IN")]
    pub(super) input: PathBuf,
    /// Where the prediction goes [default: IN with .predicted.mcap in place of .mcap]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(super) scene: Option<PathBuf>,
    /// The event of the scene at whose mark what was seen ends [default: the first collision, else the end]
    #[arg(long, value_name = "EVENT")]
    pub(super) until: Option<String>,
    /// Predict for so many seconds at most
    #[arg(long, value_name = "S", value_parser = rate, default_value_t = DEFAULT_PREDICTION_S)]
    pub(super) limit: f64,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
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
    /// Make a scene with what `calibrate` found
    Calibrated(SceneCalibratedArguments),
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
#[command(after_help = "Example:\n\
             \x20 enact scene from-urdf arm.urdf -o arm.toml")]
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

/// What a command may cost.
#[derive(Debug, Args)]
pub(super) struct Limits {
    /// End reading and estimating each recording after so long, as `50ms` or `2s`, with the best so far
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(super) deadline: Option<Duration>,
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

fn time(text: &str) -> Result<Duration, String> {
    let time = humantime::parse_duration(text)
        .ok()
        .filter(|time| !time.is_zero());
    time.ok_or_else(|| "expected a time such as 50ms or 2s".into())
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
    fn triples_are_three_finite_numbers() {
        assert_eq!(triple("12,-5, 40"), Ok([12.0, -5.0, 40.0]));
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "a,b,c"] {
            assert!(triple(bad).is_err(), "{bad}");
        }
    }
}
