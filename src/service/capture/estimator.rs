//! The thread that estimates takes that are over. The recording threads never wait for it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::Instant;

use tokio::sync::watch;

use super::event::CaptureEvent;
use super::metrics::Metrics;
use super::notice::{Notice, Shown, Speaker};
use super::take::now_ns;
use crate::pipeline::Outcome;
use crate::report::RecordingReport;
use crate::service::deadline::Deadline;
use crate::service::finish::{finished, open, output_path};
use crate::service::panics::guarded;
use crate::service::report::shown;
use crate::service::words;
use crate::service::working::Working;
use crate::write::live::EstimateOccasion;

/// A take whose file is complete.
pub(super) struct FinishedTake {
    /// Number of the take.
    pub(super) take: u64,
    /// The file.
    pub(super) path: PathBuf,
}

/// Estimates takes that are over, one after the other, from their files: as `enact replay` does,
/// so that the bytes are the same. Once there is `enough` of that, the rest is left to `enact process`.
pub(super) fn finals(
    queue: &Receiver<FinishedTake>,
    publisher: &Speaker,
    shown: &watch::Sender<Shown>,
    metrics: &Metrics,
    enough: &'static AtomicBool,
) {
    while let Ok(FinishedTake { take, path }) = queue.recv() {
        metrics.finals_waiting.take();
        let begun = Instant::now();
        match guarded(|| estimate_file(&path, Deadline::begin(None).or_told(enough))) {
            Ok((report, outcome, marks)) => {
                metrics.estimated(begun.elapsed());
                shown.send_replace(Some(Arc::new(outcome.clone())));
                let output = report.output.clone();
                let report = Box::new(report);
                let said = CaptureEvent::Estimated { take, report };
                publisher.say(Notice::estimated(
                    said,
                    occasion(take, marks, true),
                    outcome,
                ));
                draw(take, Path::new(&output), metrics);
            }
            Err(error) => {
                let recording = path.display().to_string();
                let error = match enough.load(Ordering::Relaxed) {
                    true => format!("{}: enact process {recording}", words(&error)),
                    false => words(&error),
                };
                let said = CaptureEvent::NotEstimated {
                    take,
                    recording,
                    error,
                };
                publisher.say(Notice::of(said));
            }
        }
    }
}

/// Draws the motion for the pages, once everybody knows of it.
fn draw(take: u64, estimate: &Path, metrics: &Metrics) {
    let keep = |glb| metrics.history.keep_checked(take, glb);
    match guarded(|| shown(estimate, keep)) {
        Ok(Some(picture)) => metrics.history.draw(take, picture),
        Ok(None) => {}
        Err(error) => tracing::warn!(%error, take, "no picture of the motion"),
    }
}

fn estimate_file(
    path: &Path,
    deadline: Deadline,
) -> anyhow::Result<(RecordingReport, Outcome, u64)> {
    let opened = open(path, None, deadline)?;
    let take = opened.recording.take(opened.scene.for_reading())?;
    let pipeline = opened.scene.pipeline(take.events);
    let output = output_path(path, None)?;
    let (report, outcome) = finished(
        &opened,
        &pipeline,
        &take.report,
        &output,
        &Working::hidden(),
    )?;
    Ok((report, outcome, pipeline.marks() as u64))
}

pub(super) fn occasion(take: u64, marks: u64, is_final: bool) -> EstimateOccasion {
    EstimateOccasion {
        take,
        marks,
        is_final,
        now_ns: now_ns(),
    }
}
