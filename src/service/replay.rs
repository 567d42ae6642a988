//! Plays one recording through the pipeline, event by event.

use std::iter;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use super::deadline::Deadline;
use super::finish::{Opened, finished, opened, output_path, with_recording};
use super::guard::Inputs;
use super::publish::Publication;
use super::working::Working;
use crate::ingest::Source;
use crate::motion::Stamp;
use crate::report::RecordingReport;

/// The input of [`replay`].
#[derive(Clone, Debug)]
pub struct ReplayJob {
    /// The recording.
    pub input: PathBuf,
    /// File of the estimate; beside the recording by default.
    pub output: Option<PathBuf>,
    /// Scene file; the recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// Whether what explains a misfit is set free ([`Pipeline::with_free_auto`](crate::pipeline::Pipeline::with_free_auto)).
    pub is_free_auto: bool,
    /// Pace relative to that of the performance; as fast as possible by default.
    pub rate: Option<f64>,
    /// Publish it over iceoryx2 too, as its trackers and a daemon would have: at the pace of the
    /// performance unless `rate` is given.
    pub publish: Option<PublishJob>,
    /// Whether likely mistakes are looked for ([`Pipeline::with_diagnoses`](crate::pipeline::Pipeline::with_diagnoses)).
    pub is_diagnosing: bool,
    /// How long reading and estimating may take; no limit by default.
    pub deadline: Option<Duration>,
}

impl ReplayJob {
    fn inputs(&self) -> Inputs {
        let publish = self.publish.as_ref();
        let iceoryx2 = publish.and_then(|publish| publish.iceoryx2.as_deref());
        let own = iter::once(self.input.as_path());
        Inputs::of(own.chain(self.scene.as_deref()).chain(iceoryx2))
    }
}

/// Settings for publishing a recording.
#[derive(Clone, Debug, Default)]
pub struct PublishJob {
    /// Configuration of iceoryx2; by default where iceoryx2 looks for it.
    pub iceoryx2: Option<PathBuf>,
}

/// Replays a recording and writes its estimate.
pub fn replay(job: &ReplayJob) -> anyhow::Result<RecordingReport> {
    let output = match &job.output {
        Some(output) => output.clone(),
        None => output_path(&job.input, None)?,
    };
    job.inputs().keep_from(&output)?;
    let deadline = Deadline::begin(job.deadline);
    let working = Working::begin("reading");
    with_recording(&job.input, deadline, |recording| {
        replayed(
            job,
            opened(recording, job.scene.as_deref(), deadline)?,
            &output,
            &working,
        )
    })
}

fn replayed(
    job: &ReplayJob,
    opened: Opened,
    output: &Path,
    working: &Working,
) -> anyhow::Result<RecordingReport> {
    let mut source = opened.recording.source(opened.scene.for_reading())?;
    let mut pipeline = opened.scene.pipeline([]);
    let publish = job.publish.as_ref();
    let mut publication = publish
        .map(|publish| Publication::begin(opened.scene.for_reading(), publish.iceoryx2.as_deref()))
        .transpose()?;
    let mut pace = job.rate.or(publish.map(|_| 1.0)).map(ReplayPace::new);
    while let Some((log_time, event)) = source.next()? {
        if let Some(pace) = &mut pace {
            pace.wait_until(log_time);
        }
        if let Some(publication) = &mut publication {
            publication.event(log_time, &event)?;
        }
        pipeline.push(event);
    }
    let pipeline = pipeline.with_free_auto(job.is_free_auto);
    let pipeline = pipeline.with_diagnoses(job.is_diagnosing);
    let (report, outcome) = finished(&opened, &pipeline, source.report(), output, working)?;
    if let Some(publication) = publication {
        publication.end(&outcome)?;
    }
    Ok(report)
}

/// Waits for the intervals of log times, divided by a rate.
struct ReplayPace {
    rate: f64,
    begun: Option<(Instant, Stamp)>,
}

impl ReplayPace {
    fn new(rate: f64) -> Self {
        Self { rate, begun: None }
    }

    fn wait_until(&mut self, log_time: Stamp) {
        let (begun, first) = *self.begun.get_or_insert((Instant::now(), log_time));
        let due_s = i128::from(log_time.0) - i128::from(first.0);
        let due_s = due_s as f64 * 1e-9 / self.rate;
        // Messages of the past, and those with senseless log times, are due at once.
        let Ok(due) = Duration::try_from_secs_f64(due_s) else {
            return;
        };
        thread::sleep(due.saturating_sub(begun.elapsed()));
    }
}
