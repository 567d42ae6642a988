//! Pose CSV → recording, for trackers that export nothing better.
//!
//! ```text
//! cargo run --release -p enact-tools --bin pose_csv -- IN.csv --scene config/x.toml [--topic T]
//!     [--mark SECONDS[:EVENT]]... [--rate-hz R] -o OUT.mcap
//! ```
//!
//! The first line names the columns; `t` \[s\], `x`, `y`, `z` \[m\], `qw`, `qx`, `qy`, `qz` are
//! read, others ignored. Poses become `foxglove.PoseInFrame` on the topic of the scene's body,
//! marks `foxglove.Event`s on its marks topic, the scene an attachment. With `--rate-hz` the
//! stamps are index/rate: what a camera that counts frames really means.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use clap::Parser;
use enact::config::scene_from_toml;
use enact::motion::{Mark, PoseSample, Scene, Stamp};
use enact::write::{DEFAULT_WORLD_FRAME, RecordingWriter};
use nalgebra::Vector3;

#[derive(Parser)]
#[command(about = "Pose CSV (t,x,y,z,qw,qx,qy,qz) to an MCAP recording")]
struct Arguments {
    /// The CSV file.
    input: PathBuf,
    /// The scene, attached as it is.
    #[arg(long)]
    scene: PathBuf,
    /// Topic of the poses; by default that of the scene's only body.
    #[arg(long)]
    topic: Option<String>,
    /// When an event was marked, in seconds on the clock of the stamps; and its name, if it is
    /// not simply the next one.
    #[arg(long = "mark", value_name = "SECONDS[:EVENT]")]
    marks: Vec<String>,
    /// Stamp the samples with their index over this rate instead of column t.
    #[arg(long)]
    rate_hz: Option<f64>,
    /// The recording.
    #[arg(short, long)]
    output: PathBuf,
}

enum Entry {
    Pose(PoseSample),
    Mark(Mark),
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let scene_toml = std::fs::read_to_string(&arguments.scene)
        .with_context(|| format!("cannot read {}", arguments.scene.display()))?;
    let scene =
        scene_from_toml(&scene_toml).with_context(|| format!("{}", arguments.scene.display()))?;
    let csv = std::fs::read_to_string(&arguments.input)
        .with_context(|| format!("cannot read {}", arguments.input.display()))?;
    let samples = samples(&csv, arguments.rate_hz)
        .with_context(|| format!("{}", arguments.input.display()))?;
    let topic = topic(arguments.topic, &scene)?;
    let mut entries: Vec<(Stamp, Entry)> = samples
        .into_iter()
        .map(|sample| (sample.stamp, Entry::Pose(sample)))
        .collect();
    let poses = entries.len();
    for text in &arguments.marks {
        let mark = mark(text, &scene)?;
        entries.push((mark.stamp, Entry::Mark(mark)));
    }
    entries.sort_by_key(|(stamp, _)| *stamp);
    let mut recording = RecordingWriter::create(&arguments.output)?;
    recording.attach("scene.toml", "application/toml", scene_toml.as_bytes())?;
    for (stamp, entry) in &entries {
        match entry {
            Entry::Pose(sample) => recording.pose(&topic, DEFAULT_WORLD_FRAME, *stamp, sample)?,
            Entry::Mark(mark) => recording.mark(&scene.marks_topic, *stamp, mark)?,
        }
    }
    recording.finish()?;
    println!(
        "{}: {poses} poses on {topic}, {} marks on {}",
        arguments.output.display(),
        arguments.marks.len(),
        scene.marks_topic
    );
    Ok(())
}

fn topic(given: Option<String>, scene: &Scene) -> Result<String> {
    match (given, &scene.tracks.raw[..]) {
        (Some(topic), _) => Ok(topic),
        (None, [track]) => Ok(track.topic.clone()),
        (None, tracks) => {
            let topics: Vec<_> = tracks.iter().map(|track| track.topic.as_str()).collect();
            bail!("--topic is needed, one of {}", topics.join(", "))
        }
    }
}

fn samples(csv: &str, rate_hz: Option<f64>) -> Result<Vec<PoseSample>> {
    if let Some(rate_hz) = rate_hz {
        ensure!(
            rate_hz > 0.0 && rate_hz.is_finite(),
            "--rate-hz {rate_hz}, expected a positive number"
        );
    }
    let mut lines = csv.lines().enumerate();
    let (_, header) = lines.next().context("the file is empty")?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let column = |name: &str| {
        let found = names.iter().position(|&other| other == name);
        found.with_context(|| format!("line 1: no column {name} among {header}"))
    };
    let columns = ["t", "x", "y", "z", "qx", "qy", "qz", "qw"];
    let columns = columns
        .into_iter()
        .map(column)
        .collect::<Result<Vec<usize>>>()?;
    let mut samples = Vec::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let numbers = columns
            .iter()
            .map(|&column| {
                let field = fields.get(column).copied().unwrap_or("");
                let number = field.parse::<f64>();
                number
                    .with_context(|| format!("line {}: {} is {field:?}", index + 1, names[column]))
            })
            .collect::<Result<Vec<f64>>>()?;
        let [t, x, y, z, qx, qy, qz, qw] = numbers[..] else {
            unreachable!("one number per column");
        };
        let seconds = rate_hz.map_or(t, |rate_hz| samples.len() as f64 / rate_hz);
        samples.push(PoseSample::new(
            stamp(seconds).with_context(|| format!("line {}", index + 1))?,
            Vector3::new(x, y, z),
            [qx, qy, qz, qw],
        ));
    }
    ensure!(!samples.is_empty(), "no samples");
    Ok(samples)
}

fn stamp(seconds: f64) -> Result<Stamp> {
    let nanoseconds = (seconds * 1e9).round();
    // Message stamps reach to 2^32 s.
    ensure!(
        (0.0..4.294_967_296e18).contains(&nanoseconds),
        "{seconds} s is no stamp"
    );
    Ok(Stamp(nanoseconds as i64))
}

fn mark(text: &str, scene: &Scene) -> Result<Mark> {
    let (seconds, event) = match text.split_once(':') {
        Some((seconds, event)) => (seconds, Some(event)),
        None => (text, None),
    };
    if let Some(name) = event
        && !scene.events.iter().any(|event| event.name == name)
    {
        let names: Vec<_> = scene
            .events
            .iter()
            .map(|event| event.name.as_str())
            .collect();
        bail!("--mark {text}: the scene's events are {}", names.join(", "));
    }
    let seconds: f64 = seconds
        .parse()
        .with_context(|| format!("--mark {text}: expected SECONDS[:EVENT]"))?;
    Ok(Mark {
        stamp: stamp(seconds).with_context(|| format!("--mark {text}"))?,
        event: event.map(str::to_owned),
    })
}
