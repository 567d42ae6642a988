//! Estimates many recordings, each on its own, as many at a time as there are cores.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use anyhow::{Context, anyhow};
use rayon::prelude::*;

use super::deadline::{Deadline, leeway};
use super::finish::{Opened, finish, opened, output_path, with_recording};
use super::folders::outputs_of;
use super::guard::Inputs;
use super::panics::guarded;
use super::provenance::provenance;
use super::read_back::ReadBack;
use super::working::Working;
use crate::ingest::Recording;
use crate::pipeline::Pipeline;
use crate::report::{EstimateReport, Provenance, RecordingReport};
use crate::write::has_estimate;

/// The input of [`process`].
#[derive(Clone, Debug)]
pub struct ProcessJob {
    /// The recordings.
    pub inputs: Vec<PathBuf>,
    /// Folder for the estimates; made if it is not there.
    pub output: PathBuf,
    /// Scene file for all; each recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// Whether what explains a misfit is set free ([`Pipeline::with_free_auto`](crate::pipeline::Pipeline::with_free_auto)).
    pub is_free_auto: bool,
    /// Whether likely mistakes are looked for ([`Pipeline::with_diagnoses`](crate::pipeline::Pipeline::with_diagnoses)).
    pub is_diagnosing: bool,
    /// How long reading and estimating each may take; no limit by default.
    pub deadline: Option<Duration>,
    /// Whether an estimate that is there is kept, where it is of the same recording, scene, program and options. One that its
    /// deadline ended is made again where it may take longer now.
    pub is_resuming: bool,
}

/// What became of a recording.
#[derive(Debug)]
pub enum Processed {
    /// It was estimated.
    Estimated(Box<RecordingReport>),
    /// Its estimate was there.
    Present {
        /// The file.
        recording: String,
        /// What it says.
        report: Box<EstimateReport>,
        /// Whether its deadline ended it.
        ended_early: bool,
    },
    /// It holds an estimate already: an output among the inputs.
    LeftAlone {
        /// The file.
        recording: String,
    },
}

/// A recording that gave no estimate.
#[derive(Debug)]
pub struct Failure {
    /// The file.
    pub recording: String,
    /// The error in words.
    pub error: anyhow::Error,
}

/// Estimates every recording but those that hold an estimate, and passes each result to `each`, in the order of the
/// inputs, as soon as it and those before it are done. One that fails does not stop the others.
///
/// Progress goes to stderr, if that is a terminal. Fails as a whole only where the outputs
/// cannot be placed, or where `each` does.
pub fn process(
    job: &ProcessJob,
    mut each: impl FnMut(Result<Processed, Failure>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let outputs = outputs(job)?;
    std::fs::create_dir_all(&job.output)
        .with_context(|| format!("{}: cannot make the folder", job.output.display()))?;
    let working = Working::of(job.inputs.len());
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        let working = &working;
        scope.spawn(move || {
            // One after the other, not by halves of the list: results of the second half would wait for the first.
            let each = job.inputs.iter().zip(&outputs).enumerate().par_bridge();
            each.for_each_with(sender, |sender, (index, (input, output))| {
                let result = in_time(job, input, output);
                working.done();
                // A receiver that has gone away has failed and reports the reason itself.
                let _ = sender.send((index, result));
            });
        });
        let mut waiting = BTreeMap::new();
        let mut next = 0;
        // Several go on at once: it says the first that is not done.
        let waits_for = |next: usize| {
            if let Some(input) = job.inputs.get(next) {
                working.now(input.display().to_string());
            }
        };
        waits_for(next);
        for (index, result) in results {
            waiting.insert(index, result);
            while let Some(result) = waiting.remove(&next) {
                working.around(|| each(result))?;
                next += 1;
            }
            waits_for(next);
        }
        Ok(())
    })
}

/// The output file of each recording. Fails where two are equal or one is an input.
fn outputs(job: &ProcessJob) -> anyhow::Result<Vec<PathBuf>> {
    let outputs = outputs_of(&job.inputs, |input| output_path(input, Some(&job.output)))?;
    let inputs = job.inputs.iter().chain(&job.scene);
    let inputs = Inputs::of(inputs.map(PathBuf::as_path));
    for output in &outputs {
        inputs.keep_from(output)?;
    }
    Ok(outputs)
}

/// [`one`] that is waited for no longer than it may take: what does not end is told to, and left.
fn in_time(job: &ProcessJob, input: &Path, output: &Path) -> Result<Processed, Failure> {
    // For as long as the process: what is left may outlive everything here.
    let told: &'static AtomicBool = Box::leak(Box::default());
    let Some(limit) = job.deadline else {
        return one(job, input, output, told);
    };
    let (sender, done) = mpsc::channel();
    let owned = (job.clone(), input.to_owned(), output.to_owned());
    thread::spawn(move || {
        let (job, input, output) = owned;
        let _ = sender.send(one(&job, &input, &output, told));
    });
    done.recv_timeout(limit.saturating_add(leeway(limit)))
        .unwrap_or_else(|_| {
            told.store(true, Ordering::Relaxed);
            let (recording, limit) = (input.display(), humantime::format_duration(limit));
            Err(Failure {
                recording: recording.to_string(),
                error: anyhow!(
                    "{recording}: not done at the deadline of {limit}; nothing was written, give it more by \
                     --deadline"
                ),
            })
        })
}

fn one(
    job: &ProcessJob,
    input: &Path,
    output: &Path,
    told: &'static AtomicBool,
) -> Result<Processed, Failure> {
    let name = || input.display().to_string();
    let deadline = Deadline::begin(job.deadline).or_told(told);
    let estimate = |recording: Recording| {
        if has_estimate(recording.container()) {
            return Ok(Processed::LeftAlone { recording: name() });
        }
        let opened = opened(recording, job.scene.as_deref(), deadline)?;
        let take = opened.recording.take(opened.scene.for_reading())?;
        let pipeline = opened.scene.pipeline(take.events);
        let pipeline = pipeline.with_free_auto(job.is_free_auto);
        let pipeline = pipeline.with_diagnoses(job.is_diagnosing);
        if job.is_resuming
            && let Some(present) = present(&opened, &pipeline, job.deadline, output)
        {
            return Ok(present);
        }
        let report = finish(&opened, &pipeline, &take.report, output, &Working::hidden())?;
        Ok(Processed::Estimated(Box::new(report)))
    };
    // A bug that one recording meets is an error of that recording.
    guarded(|| with_recording(input, deadline, estimate)).map_err(|error| Failure {
        recording: name(),
        error,
    })
}

/// The estimate that is there, if it is the one that would be made. One that was ended is so where there is no more time now: from
/// the same time another machine, or hour, makes another, and none is better for that.
fn present(
    opened: &Opened,
    pipeline: &Pipeline,
    deadline: Option<Duration>,
    output: &Path,
) -> Option<Processed> {
    let read = ReadBack::open(output).ok()?;
    if !read.lost().is_empty() {
        return None;
    }
    let motion = read.motion;
    let scene_file = opened.scene_file.as_deref();
    let made_of = provenance(&opened.recording, &opened.scene_toml, scene_file, pipeline);
    let ended_after_s = motion.provenance.as_ref()?.ended_after_s;
    let would_be = Provenance {
        ended_after_s,
        ..made_of
    };
    let is_longer_now = |ended_s: f64| deadline.is_none_or(|now| now.as_secs_f64() > ended_s);
    if motion.provenance != Some(would_be) || ended_after_s.is_some_and(is_longer_now) {
        return None;
    }
    let report: EstimateReport = serde_json::from_slice(&motion.report).ok()?;
    Some(Processed::Present {
        recording: opened.recording.path().display().to_string(),
        report: Box::new(report),
        ended_early: ended_after_s.is_some(),
    })
}
