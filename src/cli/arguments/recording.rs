//! Arguments of what makes recordings, looks into them and changes them. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, ValueEnum};

use super::estimate::{Budget, Limits};
use super::values::{Format, rate};
use crate::service::{
    AngleUnit, ListedMark, MarkColumn, MarkTime, PRESETS, TURNS, TimeUnit, length_unit,
};

/// Arguments of `import`.
#[derive(Debug, Args)]
#[command(
    after_help = "Tables of EuRoC, TUM, KITTI, Motive, Vicon, Qualisys, TRC and others with named columns are recognised; what is \
                  assumed is said. Several files, or several bodies in one, become several topics.\n\
                  Example: enact import toss.csv --scene config/cube_toss.toml -o toss.mcap\n\
                  Exit code 3: written, but what the data show speaks against how they were read, or some were lost."
)]
pub(in crate::cli) struct ImportArguments {
    /// Tables of poses (CSV and the like), or one recording (MCAP) of which a part is wanted
    #[arg(value_name = "FILE", required = true)]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// The recording, an MCAP file; a folder with --each
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: PathBuf,
    /// Make a recording of each file, in the folder that -o names
    #[arg(long)]
    pub(in crate::cli) each: bool,
    /// Scene file; it travels in the recording
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// Axes and units that are usual where the tables come from [default: what their heads say, else z-up]
    #[arg(long, value_name = "PRESET", value_parser = presets())]
    pub(in crate::cli) from: Option<String>,
    /// Names of the columns in order, parted by commas, - for one that is not read [default: those in the file]
    #[arg(long, value_name = "NAMES", allow_hyphen_values = true)]
    pub(in crate::cli) columns: Option<String>,
    /// Unit of times: s, ms, us, 100ns, ns or frame [default: what the file says, else by the intervals]
    #[arg(long, value_name = "UNIT", value_parser = time_unit)]
    pub(in crate::cli) time_unit: Option<TimeUnit>,
    /// Unit of positions: m, cm, mm, in or ft [default: what the file says, else that of the preset]
    #[arg(long, value_name = "UNIT", value_parser = known_length_unit)]
    pub(in crate::cli) length_unit: Option<String>,
    /// Rows a second, whatever their times say; frames a second, where times count frames
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(in crate::cli) rate: Option<f64>,
    /// Order of the numbers of quaternions, where names of columns do not say it
    #[arg(long, value_enum, value_name = "ORDER")]
    pub(in crate::cli) quaternion: Option<Order>,
    /// What three angles mean, where a file has those and does not say it
    #[arg(long, value_name = "WHAT", value_parser = turns())]
    pub(in crate::cli) rotation: Option<String>,
    /// Unit of angles: deg or rad [default: what the file says, else by their values]
    #[arg(long, value_name = "UNIT", value_parser = angle_unit)]
    pub(in crate::cli) angle_unit: Option<AngleUnit>,
    /// Topic of a body, in order or by name [default: that of the scene's body, else /tracker/NAME/pose]
    #[arg(long, value_name = "[NAME=]TOPIC")]
    pub(in crate::cli) topic: Vec<String>,
    /// Add a mark, in seconds since the first pose of the files
    #[arg(long, value_name = "TIME[:EVENT]", value_parser = listed_mark)]
    pub(in crate::cli) mark: Vec<ListedMark>,
    /// A button that is a mark where it goes down: a column of the table (with the value above which it is down), or a
    /// button of a captured session [default: none of tables, trigger of sessions]
    #[arg(long, value_name = "NAME[=LEVEL]", value_parser = mark_column, conflicts_with = "mark")]
    pub(in crate::cli) mark_column: Vec<MarkColumn>,
    /// Leave out what is before, in seconds since the first pose
    #[arg(long, value_name = "SECONDS", value_parser = since_first)]
    pub(in crate::cli) start: Option<f64>,
    /// Leave out what is after
    #[arg(long, value_name = "SECONDS", value_parser = since_first)]
    pub(in crate::cli) end: Option<f64>,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Order of a quaternion's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Order {
    /// Scalar last
    Xyzw,
    /// Scalar first
    Wxyz,
}

/// Arguments of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact inspect tip.mcap\n\
             \x20 enact inspect tip.mcap --format ndjson | jq .topics")]
pub(in crate::cli) struct InspectArguments {
    /// The recordings, MCAP files or folders of them
    #[arg(value_name = "IN", required = true)]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) limits: Limits,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
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
pub(in crate::cli) struct MarkArguments {
    /// The recording, an MCAP file; with --propose several, or folders of them
    #[arg(value_name = "IN", required = true)]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// Propose marks where the streams have kinks
    #[arg(long, conflicts_with_all = ["add", "moves", "from", "from_topic"])]
    pub(in crate::cli) propose: bool,
    /// Add a mark
    #[arg(long, value_name = "TIME[:EVENT]", value_parser = listed_mark, requires = "output")]
    pub(in crate::cli) add: Vec<ListedMark>,
    /// Move a mark: its number, or the name of its event
    #[arg(long = "move", id = "moves", value_name = "MARK=TIME", value_parser = moved_mark, requires = "output")]
    pub(in crate::cli) moves: Vec<(String, MarkTime)>,
    /// Leave out a mark: its number, the name of its event, or all
    #[arg(long, value_name = "MARK", requires = "output")]
    pub(in crate::cli) remove: Vec<String>,
    /// Take the marks from a file, JSON or CSV, in place of those in the recording
    #[arg(long, value_name = "FILE", requires = "output")]
    pub(in crate::cli) from: Option<PathBuf>,
    /// Take them from the messages on a topic of the recording, such as a button's
    #[arg(
        long,
        value_name = "TOPIC",
        requires = "output",
        conflicts_with = "from"
    )]
    pub(in crate::cli) from_topic: Option<String>,
    /// Write a copy of the recording with the marks; of several recordings a folder for these
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Collisions of each body [default: as many as the scene has]
    #[arg(long, value_name = "N", requires = "propose")]
    pub(in crate::cli) count: Option<usize>,
    /// Scene file [default: scene.toml attached to the recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `sketch`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact sketch keys.csv --scene config/pencil_tip.toml -o keys.mcap\n\
             \x20 enact sketch tip.mcap --per-flight 5 -o keys.csv")]
pub(in crate::cli) struct SketchArguments {
    /// Keyframes (.csv, .toml) or a recording (.mcap)
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// The other of the two [default: IN with .mcap, or with .csv]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Scene file; it travels in the recording [default: scene.toml attached to a recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// So many keyframes of each flight [default: every sample]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), conflicts_with = "per_second")]
    pub(in crate::cli) per_flight: Option<u16>,
    /// So many keyframes a second
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(in crate::cli) per_second: Option<f64>,
    /// Keyframes of the motion that is estimated from the recording
    #[arg(long)]
    pub(in crate::cli) estimated: bool,
    #[command(flatten)]
    pub(in crate::cli) limits: Limits,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

fn since_first(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds >= 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("expected seconds, 0 or more".into()),
    }
}

fn mark_column(text: &str) -> Result<MarkColumn, String> {
    let (name, level) =
        match text.rsplit_once('=') {
            None => (text, None),
            Some((name, level)) => match level.trim().parse::<f64>() {
                Ok(level) if level.is_finite() => (name, Some(level)),
                _ => return Err(
                    "expected the name of a column or a button, with a number after = if at all"
                        .into(),
                ),
            },
        };
    match name.trim() {
        "" => Err("expected the name of a column or a button".into()),
        name => Ok(MarkColumn {
            name: name.to_owned(),
            level,
        }),
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
    TimeUnit::of(text).ok_or_else(|| "expected s, ms, us, 100ns, ns or frame".into())
}

fn known_length_unit(text: &str) -> Result<String, String> {
    let known = length_unit(text).map(|_| text.to_owned());
    known.ok_or_else(|| "expected m, cm, mm, in or ft".into())
}

fn angle_unit(text: &str) -> Result<AngleUnit, String> {
    AngleUnit::of(text).ok_or_else(|| "expected deg or rad".into())
}

fn turns() -> PossibleValuesParser {
    let values = TURNS
        .iter()
        .map(|turn| PossibleValue::new(turn.name).help(turn.about));
    PossibleValuesParser::new(values)
}

fn presets() -> PossibleValuesParser {
    let values = PRESETS
        .iter()
        .map(|preset| PossibleValue::new(preset.name).help(preset.about));
    PossibleValuesParser::new(values)
}
