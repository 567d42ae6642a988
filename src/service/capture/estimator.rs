//! The threads that estimate: one from what came so far, one from takes that are over. Neither
//! is ever waited for by those that record.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::Instant;

use anyhow::anyhow;

use super::said::{Notice, Said};
use super::take::now_ns;
use crate::motion::{EventKind, Scene, TakeEvent};
use crate::pipeline::{Outcome, Pipeline};
use crate::service::Report;
use crate::service::finish::{finished, open, output_path};
use crate::service::words;
use crate::write::live::EstimateOccasion;

/// What the estimator of what came so far is told.
pub(super) enum SoFar {
    /// A take has begun; the one before it is over.
    Begin {
        /// Which.
        take: u64,
    },
    /// A mark came, and this since the last one.
    Events {
        /// In which take.
        take: u64,
        /// Marks so far.
        marks: u64,
        /// Samples and marks, in order.
        events: Vec<TakeEvent>,
    },
    /// No more of this take.
    End {
        /// Which.
        take: u64,
    },
}

/// A take whose file has its name.
pub(super) struct Finished {
    /// Which.
    pub(super) take: u64,
    /// The file.
    pub(super) path: PathBuf,
}

/// Estimates, unchecked, from what came so far, as soon as all events have their marks and after
/// every mark from then on. Of several marks that came meanwhile the last counts.
pub(super) fn so_far(scene: &Scene, queue: &Receiver<SoFar>, herald: &SyncSender<Notice>) {
    let is_marked = |kind: &EventKind| !matches!(kind, EventKind::Start);
    let wanted = scene.events.iter().filter(|event| is_marked(&event.kind));
    let wanted = wanted.count() as u64;
    let mut running: Option<(u64, Pipeline)> = None;
    while let Ok(first) = queue.recv() {
        let mut due = None;
        for message in std::iter::once(first).chain(queue.try_iter()) {
            match (message, &mut running) {
                (SoFar::Begin { take }, running) => {
                    *running = Some((take, Pipeline::new(scene.clone())));
                    due = None;
                }
                (
                    SoFar::Events {
                        take,
                        marks,
                        events,
                    },
                    Some((of, pipeline)),
                ) if *of == take => {
                    events.into_iter().for_each(|event| pipeline.push(event));
                    due = Some(marks);
                }
                (SoFar::End { take }, Some((of, _))) if *of == take => {
                    // What is due is still wanted: the last mark is often followed by the end.
                    estimate_so_far(running.take(), due.take(), wanted, herald);
                }
                (SoFar::Events { .. } | SoFar::End { .. }, _) => {}
            }
        }
        running = estimate_so_far(running, due, wanted, herald);
    }
}

/// Estimates if a mark asks for it; gives the take back.
fn estimate_so_far(
    running: Option<(u64, Pipeline)>,
    due: Option<u64>,
    wanted: u64,
    herald: &SyncSender<Notice>,
) -> Option<(u64, Pipeline)> {
    let (take, pipeline) = running?;
    let Some(marks) = due.filter(|marks| *marks >= wanted) else {
        return Some((take, pipeline));
    };
    let begun = Instant::now();
    let outcome = guarded(|| Ok(pipeline.estimate(&mut ())?));
    match outcome {
        Ok(outcome) => {
            let said = Said::SoFar {
                take,
                marks,
                verdict: outcome.estimate.verdict.word(),
                seconds: begun.elapsed().as_secs_f64(),
            };
            say(herald, said, Some((occasion(take, marks, false), outcome)));
        }
        Err(error) => tracing::info!(take, marks, error = %words(&error), "no estimate so far"),
    }
    Some((take, pipeline))
}

/// Estimates takes that are over, one after the other, from their files: as `enact replay` does,
/// so that the bytes are the same.
pub(super) fn finals(queue: &Receiver<Finished>, herald: &SyncSender<Notice>) {
    while let Ok(Finished { take, path }) = queue.recv() {
        match guarded(|| estimate_file(&path)) {
            Ok((report, outcome, marks)) => {
                let report = Box::new(report);
                let outcome = (occasion(take, marks, true), outcome);
                say(herald, Said::Estimated { take, report }, Some(outcome));
            }
            Err(error) => {
                let said = Said::NotEstimated {
                    take,
                    recording: path.display().to_string(),
                    error: words(&error),
                };
                say(herald, said, None);
            }
        }
    }
}

fn estimate_file(path: &std::path::Path) -> anyhow::Result<(Report, Outcome, u64)> {
    let opened = open(path, None)?;
    let take = opened.recording.take(&opened.scene)?;
    let mut pipeline = Pipeline::new(opened.scene.clone());
    let is_mark = |event: &&TakeEvent| matches!(event, TakeEvent::Mark(_));
    let marks = take.events.iter().filter(is_mark).count() as u64;
    for event in take.events {
        pipeline.push(event);
    }
    let output = output_path(path, None)?;
    let (report, outcome) = finished(&opened, &pipeline, &take.report, &output)?;
    Ok((report, outcome, marks))
}

/// A bug in an estimation shall not end a recording.
fn guarded<T>(estimate: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    catch_unwind(AssertUnwindSafe(estimate))
        .unwrap_or_else(|_| Err(anyhow!("the estimation panicked, which is a bug")))
}

fn occasion(take: u64, marks: u64, is_final: bool) -> EstimateOccasion {
    EstimateOccasion {
        take,
        marks,
        is_final,
        now_ns: now_ns(),
    }
}

fn say(herald: &SyncSender<Notice>, said: Said, outcome: Option<(EstimateOccasion, Outcome)>) {
    let outcome = outcome.map(|(occasion, outcome)| (occasion, Box::new(outcome)));
    // These threads may wait; a herald that is gone has nobody left to tell.
    let _ = herald.send(Notice {
        said,
        asked: None,
        outcome,
    });
}
