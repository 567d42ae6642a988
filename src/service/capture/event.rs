//! What the daemon says: to the terminal, to a log, over iceoryx2.

use serde::Serialize;

use super::latency::{Latencies, LatencyLine};
use crate::ingest::clock::ClockQuality;
use crate::ingest::live::TallyCounts;
use crate::ingest::live::{TakeRecord, TakeState};
use crate::report::RecordingReport;

/// Something that happened.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum CaptureEvent {
    /// Services are open: samples are heard.
    Ready {
        /// Topics of the streams.
        topics: Vec<String>,
        /// In what services that others made fall short.
        shortcomings: Vec<String>,
        /// Journals that a crash left.
        abandoned: Vec<String>,
        /// Where viewers are served: a WebSocket's address.
        viewer: Option<String>,
        /// Where health and metrics are: an HTTP server's address.
        metrics: Option<String>,
    },
    /// A take has begun.
    Started {
        /// Which.
        take: u64,
        /// The file that it will be.
        recording: String,
    },
    /// A take is over and its file has its name.
    Closed {
        /// Which.
        take: u64,
        /// The file.
        recording: String,
        /// Samples and marks in it.
        messages: u64,
        /// What became of them.
        counts: CountsLine,
    },
    /// A take was thrown away.
    Discarded {
        /// Which.
        take: u64,
    },
    /// Recording stopped by an error; the file so far is kept.
    Broken {
        /// Which.
        take: u64,
        /// The file.
        recording: String,
        /// Samples and marks in it, at most.
        messages: u64,
        /// Why.
        error: String,
    },
    /// An estimate from what came so far; whether bodies run into something was not looked at.
    SoFar {
        /// Of which take.
        take: u64,
        /// Marks that it rests on.
        marks: u64,
        /// What it is.
        verdict: &'static str,
        /// What speaks against it most, if that takes the verdict `physical` back.
        #[serde(skip_serializing_if = "Option::is_none")]
        doubt: Option<String>,
        /// Wall time that it took.
        seconds: f64,
    },
    /// A take's estimate is written.
    Estimated {
        /// Of which take.
        take: u64,
        /// It.
        report: Box<RecordingReport>,
    },
    /// A take has no estimate.
    NotEstimated {
        /// Which.
        take: u64,
        /// Its file.
        recording: String,
        /// Why.
        error: String,
    },
    /// Somebody wants to know how things stand.
    Asked {
        /// The take that runs, if one does.
        take: Option<u64>,
        /// Samples and marks in it.
        messages: u64,
    },
    /// A control message makes no sense.
    Refused {
        /// Its command.
        command: u32,
        /// Why.
        reason: String,
    },
    /// Something is not as it should be, and goes on.
    Warning {
        /// What.
        text: String,
    },
}

/// What became of a take's samples and marks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CountsLine {
    /// Stream by stream.
    pub trackers: Vec<TrackerLine>,
    /// Of the marks.
    pub marks: MarkCounts,
    /// From arrival to journal.
    pub latency_ms: LatencyLine,
}

/// What became of a stream's samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackerLine {
    /// Its topic.
    pub topic: String,
    /// Counts.
    pub counts: TallyCounts,
    /// How good its stamps are.
    pub clock: ClockQuality,
}

/// What became of the marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MarkCounts {
    /// All.
    pub received: u64,
    /// Of no time or no name that a message can say.
    pub refused: u64,
}

impl CountsLine {
    /// Adds those of a later take of the same streams, whose clocks are the later ones.
    pub(super) fn add(&mut self, other: &Self) {
        for (line, of) in self.trackers.iter_mut().zip(&other.trackers) {
            line.counts.add(&of.counts);
            let (steps, restarts) = (line.clock.steps, line.clock.restarts);
            line.clock = of.clock;
            line.clock.steps += steps;
            line.clock.restarts += restarts;
        }
        if self.trackers.is_empty() {
            self.trackers.clone_from(&other.trackers);
        }
        self.marks.received += other.marks.received;
        self.marks.refused += other.marks.refused;
    }

    /// Whether a sample is known to be lost.
    pub fn is_lossy(&self) -> bool {
        let lost = |line: &TrackerLine| line.counts.missing > 0 || line.counts.unstampable > 0;
        self.trackers.iter().any(lost) || self.marks.refused > 0
    }
}

/// How the daemon is, now.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Status {
    /// The take that runs, if one does.
    pub take: Option<u64>,
    /// Its file.
    pub recording: Option<String>,
    /// Samples and marks in it.
    pub messages: u64,
    /// What became of them.
    pub counts: CountsLine,
    /// Samples and marks that came while no take ran, since the start: they are not kept.
    pub outside: u64,
    /// Counts of all takes since the start, this one too; clocks are as they are in it.
    pub totals: CountsLine,
    /// From arrival to journal, in all of them.
    #[serde(skip)]
    pub(super) latency: Latencies,
}

impl CaptureEvent {
    /// Whether it tells of data lost or of a motion that is not physical.
    pub fn is_whole(&self) -> bool {
        match self {
            CaptureEvent::Broken { .. } | CaptureEvent::NotEstimated { .. } => false,
            CaptureEvent::Closed { counts, .. } => !counts.is_lossy(),
            CaptureEvent::Estimated { report, .. } => report.estimate.is_physical(),
            _ => true,
        }
    }

    /// The same for subscribers of `enact/take`, if it concerns them.
    pub(super) fn record(
        &self,
        asked: Option<(u32, u64)>,
        sequence: u64,
        now_ns: i64,
    ) -> Option<TakeRecord> {
        let (take, messages, state) = match self {
            CaptureEvent::Ready { .. } => (0, 0, TakeState::Ready),
            CaptureEvent::Started { take, .. } => (*take, 0, TakeState::Recording),
            CaptureEvent::Closed { take, messages, .. } => (*take, *messages, TakeState::Closed),
            CaptureEvent::Discarded { take } => (*take, 0, TakeState::Discarded),
            CaptureEvent::Broken { take, messages, .. } => (*take, *messages, TakeState::Broken),
            CaptureEvent::Estimated { take, .. } => (*take, 0, TakeState::Estimated),
            CaptureEvent::NotEstimated { take, .. } => (*take, 0, TakeState::NotEstimated),
            CaptureEvent::Asked {
                take: Some(take),
                messages,
            } => (*take, *messages, TakeState::Recording),
            CaptureEvent::Asked { take: None, .. } => (0, 0, TakeState::Ready),
            CaptureEvent::Refused { .. } => (0, 0, TakeState::Refused),
            CaptureEvent::SoFar { .. } | CaptureEvent::Warning { .. } => return None,
        };
        let (control_session, control_sequence) = asked.unwrap_or((0, 0));
        Some(TakeRecord {
            sequence,
            available_ns: now_ns,
            take,
            messages,
            state: state.number(),
            control_session,
            control_sequence,
        })
    }
}
