//! A performance with known truth, recorded, estimated and written: something to open in a
//! viewer, and what `tools/check_clients.sh` checks.
//!
//! ```text
//! cargo run --release -p enact-tools --bin sample_output -- DIRECTORY
//! ```
//!
//! Writes `pencil_in.mcap` (the recording) and `pencil_out.mcap` (with the estimate).

use std::path::PathBuf;

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::TakeEvent;
use enact::pipeline::Pipeline;
use enact::report::Reported;
use enact::write::{
    DEFAULT_FRAME_RATE_HZ, DEFAULT_WORLD_FRAME, EstimateFile, RecordingWriter, write_estimate,
};

use enact_tools::perform::{self, Acting, Style};

fn main() -> Result<()> {
    let directory = std::env::args()
        .nth(1)
        .context("usage: sample_output DIRECTORY")?;
    let directory = PathBuf::from(directory);
    let (input, output) = (
        directory.join("pencil_in.mcap"),
        directory.join("pencil_out.mcap"),
    );
    let scene_toml = Style::Tip.scene_toml();
    let scene = scene_from_toml(scene_toml)?;
    let performance = perform::perform(&Style::Tip.truth(), &Acting::default(), 1);
    let mut recording = RecordingWriter::create(&input)?;
    recording.attach("scene.toml", "application/toml", scene_toml.as_bytes())?;
    for (event, &arrival) in performance.events.iter().zip(&performance.arrivals) {
        match event {
            TakeEvent::Pose { track, sample, .. } => {
                let topic = &scene.tracks[*track].topic;
                recording.pose(topic, DEFAULT_WORLD_FRAME, arrival, sample)?;
            }
            TakeEvent::Mark(mark) => recording.mark(&scene.marks_topic, arrival, mark)?,
        }
    }
    recording.finish()?;

    let recording = Recording::open(&input)?;
    let take = recording.take(&scene)?;
    let outcome = Pipeline::of(scene.clone(), take.events).finish(&mut ())?;
    let world_frame = take.report.frame_ids.first();
    let written = write_estimate(
        &output,
        &EstimateFile {
            input: recording.container(),
            made_of: &[recording.path()],
            of: Reported {
                scene: &scene,
                inferred: &outcome.inferred,
                sketch: &outcome.sketch,
                counts: &outcome.counts,
                estimate: &outcome.estimate,
                verification: outcome.verification.as_ref(),
                settled: outcome.settled.as_ref(),
                diagnoses: &outcome.diagnoses,
                seen: &outcome.seen,
                freed: &outcome.freed,
                rest: outcome.rest.as_ref(),
            },
            scene_toml: scene_toml.as_bytes(),
            provenance: None,
            world_frame: world_frame.map_or(DEFAULT_WORLD_FRAME, String::as_str),
            log_offset_ns: take.report.log_offset_ns.unwrap_or(0),
            frame_rate_hz: DEFAULT_FRAME_RATE_HZ,
        },
    )?;
    println!(
        "{}: {}, {} messages copied, {} added",
        output.display(),
        outcome.estimate.verdict.as_str(),
        written.copied,
        written.added
    );
    Ok(())
}
