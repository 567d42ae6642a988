//! Events and status of the daemon, for the terminal, the log and iceoryx2.

use serde::Serialize;

use super::label::TakeLabel;
use super::latency::{Latencies, LatencyLine};
use super::presence::TrackerState;
use crate::ingest::clock::ClockQuality;
use crate::ingest::live::TallyCounts;
use crate::ingest::live::{TakeRecord, TakeState};
use crate::report::RecordingReport;

/// Where other devices find the acting page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HttpsLink {
    /// The link, which has the pairing code.
    pub link: String,
    /// SHA-256 of the certificate, as browsers show it.
    pub fingerprint: String,
}

/// An event of the daemon.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum CaptureEvent {
    /// Services are open: samples are received.
    Ready {
        /// Topics of the streams.
        topics: Vec<String>,
        /// Where services made by other processes have less quality than wanted.
        shortcomings: Vec<String>,
        /// Journals that a crash left.
        abandoned: Vec<String>,
        /// Address of the WebSocket for viewers.
        viewer: Option<String>,
        /// Address of the HTTP server for health and metrics.
        metrics: Option<String>,
        /// Link to the operator's page that may direct takes: it has the token, and is for the operator alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        page: Option<String>,
        /// Link to the acting page, if it is served: it has the pairing code, and is for who acts alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        acting: Option<String>,
        /// The same for other devices, if it is served to them.
        #[serde(skip_serializing_if = "Option::is_none")]
        https: Option<HttpsLink>,
    },
    /// A take has begun.
    Started {
        /// Number of the take.
        take: u64,
        /// File of the take.
        recording: String,
        /// Topics on which nothing comes.
        unheard: Vec<String>,
        /// Samples and marks from before the start: see `pre_roll_s` of the scene.
        before: u64,
        /// What may keep it from being written.
        troubles: Vec<String>,
    },
    /// A tracker sends: its first sample came, or one after it was silent.
    Heard {
        /// Its topic.
        topic: String,
        /// Number of the running take, if there is one.
        take: Option<u64>,
    },
    /// A tracker that sent sends no more.
    Silent {
        /// Its topic.
        topic: String,
        /// Number of the running take, if there is one.
        take: Option<u64>,
        /// Time since its last sample \[s\].
        seen_s: f64,
    },
    /// A take is over and its file has its final name.
    Closed {
        /// Number of the take.
        take: u64,
        /// The file.
        recording: String,
        /// Samples and marks in it.
        messages: u64,
        /// Counts of its samples and marks.
        counts: CountsLine,
        /// What was said of it.
        label: TakeLabel,
    },
    /// A take was discarded: nothing of it is deleted.
    Discarded {
        /// Number of the take.
        take: u64,
        /// Where its file was moved; none where that failed, as a warning says.
        recording: Option<String>,
    },
    /// Recording stopped by an error; the file so far is kept.
    Broken {
        /// Number of the take.
        take: u64,
        /// The file.
        recording: String,
        /// Samples and marks in it, at most.
        messages: u64,
        /// The error.
        error: String,
    },
    /// A preview: an estimate from the events so far. Overlaps of bodies were not checked.
    SoFar {
        /// Number of the take.
        take: u64,
        /// Number of marks that it uses.
        marks: u64,
        /// Its verdict.
        verdict: &'static str,
        /// The strongest doubt, if it revokes the verdict `physical`.
        #[serde(skip_serializing_if = "Option::is_none")]
        doubt: Option<String>,
        /// Wall time of the estimation.
        seconds: f64,
    },
    /// A take's estimate is written.
    Estimated {
        /// Number of the take.
        take: u64,
        /// Report of the estimate.
        report: Box<RecordingReport>,
    },
    /// A take has no estimate.
    NotEstimated {
        /// Number of the take.
        take: u64,
        /// Its file.
        recording: String,
        /// The error.
        error: String,
    },
    /// The answer to a request for the state.
    Asked {
        /// Number of the running take, if there is one.
        take: Option<u64>,
        /// Samples and marks in it.
        messages: u64,
        /// The daemon's scene.
        scene: String,
        /// Names of the events of the scene.
        events: Vec<String>,
        /// How the trackers stand.
        trackers: Vec<TrackerState>,
        /// What keeps takes from being written, and what of this one did not arrive.
        troubles: Vec<String>,
        /// Address of the operator's page.
        page: Option<String>,
    },
    /// A control message was refused.
    Refused {
        /// Its command.
        command: u32,
        /// The reason.
        reason: String,
    },
    /// A problem that does not stop the daemon.
    Warning {
        /// The problem in words.
        text: String,
    },
}

/// Counts of a take's samples and marks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CountsLine {
    /// Counts of samples, stream by stream.
    pub trackers: Vec<TrackerLine>,
    /// Counts of marks.
    pub marks: MarkCounts,
    /// Latency from arrival to journal.
    pub latency_ms: LatencyLine,
}

/// Counts of a stream's samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackerLine {
    /// Its topic.
    pub topic: String,
    /// Counts.
    pub counts: TallyCounts,
    /// How good its stamps are.
    pub clock: ClockQuality,
}

/// Counts of marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MarkCounts {
    /// All marks that arrived.
    pub received: u64,
    /// Marks with a time or name that no message can hold.
    pub refused: u64,
}

impl CountsLine {
    /// Adds the counts of a later take of the same streams; clock qualities are those of the later
    /// take.
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
}

/// The current status of the daemon.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Status {
    /// Number of the running take, if there is one.
    pub take: Option<u64>,
    /// Its file.
    pub recording: Option<String>,
    /// Samples and marks in it.
    pub messages: u64,
    /// Counts of its samples and marks.
    pub counts: CountsLine,
    /// How the trackers stand.
    pub trackers: Vec<TrackerState>,
    /// Samples and marks that came while no take ran, since the start; those of the last
    /// `pre_roll_s` are kept for a take that starts.
    pub outside: u64,
    /// Counts of all takes since the start, including the running one, whose clock qualities are
    /// used.
    pub totals: CountsLine,
    /// Latencies from arrival to journal in all takes.
    #[serde(skip)]
    pub(super) latency: Latencies,
}

impl CaptureEvent {
    /// True if it reports that samples that were sent are not in a file as they should be. What was refused is in it, as it came.
    pub fn is_loss(&self) -> bool {
        match self {
            CaptureEvent::Broken { .. } => true,
            CaptureEvent::Closed { counts, .. } => {
                let mut trackers = counts.trackers.iter();
                trackers.any(|line| line.counts.lacks_samples())
            }
            _ => false,
        }
    }

    /// The event as JSON for `enact/answer`, without token and pairing code; of an estimate it has what a director needs.
    pub(super) fn answer(&self) -> Option<String> {
        if let CaptureEvent::Ready { .. } = self {
            let mut said = self.clone();
            if let CaptureEvent::Ready {
                page,
                acting,
                https,
                ..
            } = &mut said
            {
                (*page, *acting, *https) = (None, None, None);
            }
            return serde_json::to_string(&said).ok();
        }
        let CaptureEvent::Estimated { take, report } = self else {
            return serde_json::to_string(self).ok();
        };
        let of = &report.estimate;
        let json = serde_json::json!({
            "what": "estimated",
            "take": take,
            "recording": report.recording,
            "output": report.output,
            "verdict": of.verdict,
            "fits": of.fits,
            "is_good": of.is_good(),
            "reason": of.reason,
            "doubts": of.doubts.iter().map(|doubt| &doubt.text).collect::<Vec<_>>(),
        });
        Some(json.to_string())
    }

    /// The event as a record for `enact/take`; `None` where it has none.
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
            CaptureEvent::Discarded { take, .. } => (*take, 0, TakeState::Discarded),
            CaptureEvent::Broken { take, messages, .. } => (*take, *messages, TakeState::Broken),
            CaptureEvent::Estimated { take, .. } => (*take, 0, TakeState::Estimated),
            CaptureEvent::NotEstimated { take, .. } => (*take, 0, TakeState::NotEstimated),
            CaptureEvent::Asked {
                take: Some(take),
                messages,
                ..
            } => (*take, *messages, TakeState::Recording),
            CaptureEvent::Asked { take: None, .. } => (0, 0, TakeState::Ready),
            CaptureEvent::Refused { .. } => (0, 0, TakeState::Refused),
            CaptureEvent::SoFar { .. }
            | CaptureEvent::Warning { .. }
            | CaptureEvent::Heard { .. }
            | CaptureEvent::Silent { .. } => return None,
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
