//! A running take: its journal, its streams, and the events that were not handed on yet.

use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::event::{CountsLine, MarkCounts, TrackerLine};
use super::label::TakeLabel;
use super::latency::Latencies;
use crate::config::CaptureSettings;
use crate::ingest::live::{Before, Stream, StreamTopic, Streamed, stamp_mark};
use crate::ingest::live::{MarkRecord, PoseRecord};
use crate::motion::{Scene, Stamp, TakeEvent};
use crate::write::topics::TAKE_METADATA;
use crate::write::{Journal, WriteError};

/// A chunk is closed after this share of the time that samples may be in an open one: the rest is
/// for polling, queueing and writing, during which a kill loses them too.
const CHUNK_SHARE: f64 = 0.75;

/// Now on the system clock [ns since 1970].
pub(in crate::service) fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
    })
}

/// The clock of a take: the system clock at its beginning, continued by a monotonic clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct TakeAnchor {
    wall_ns: i64,
    at: Instant,
}

impl TakeAnchor {
    pub(super) fn now() -> Self {
        Self {
            wall_ns: now_ns(),
            at: Instant::now(),
        }
    }

    /// The time of an instant on this clock.
    pub(super) fn stamp(&self, at: Instant) -> Stamp {
        let nanos = |span: Duration| i64::try_from(span.as_nanos()).unwrap_or(i64::MAX);
        let since_ns = match at.checked_duration_since(self.at) {
            Some(after) => nanos(after),
            None => -nanos(self.at.duration_since(at)),
        };
        Stamp(self.wall_ns.saturating_add(since_ns))
    }
}

/// A running take.
pub(super) struct OpenTake {
    pub(super) number: u64,
    pub(super) journal: Journal,
    anchor: TakeAnchor,
    topics: Vec<StreamTopic>,
    streams: Vec<Stream>,
    marks: MarkCounts,
    pub(super) label: TakeLabel,
    /// Whether what comes was kept from before the take.
    pub(super) is_catching_up: bool,
    pub(super) latencies: Latencies,
    /// Events that were not yet handed to the previewer.
    pub(super) pending: Vec<TakeEvent>,
    pub(super) chunk_begun: Instant,
    pub(super) synced: Instant,
    pub(super) counted: Instant,
    /// Arrival of the last sample or mark.
    latest: Instant,
}

impl OpenTake {
    /// Begins a take with its journal at a path; `before` is the last sample of each stream that
    /// came before it.
    pub(super) fn begin(
        number: u64,
        path: &Path,
        scene: &Scene,
        scene_toml: &[u8],
        topics: &[StreamTopic],
        settings: &CaptureSettings,
        before: &dyn Fn(usize) -> Option<Before>,
    ) -> Result<Self, WriteError> {
        let names: Vec<String> = topics.iter().map(|topic| topic.topic.clone()).collect();
        let anchor = TakeAnchor::now();
        let stream = |(number, topic): (usize, &StreamTopic)| {
            Stream::after(before(number), settings.stamps[topic.track])
        };
        Ok(Self {
            number,
            journal: Journal::create(path, &names, &scene.marks_topic, scene_toml)?,
            anchor,
            topics: topics.to_vec(),
            streams: topics.iter().enumerate().map(stream).collect(),
            marks: MarkCounts::default(),
            label: TakeLabel::default(),
            is_catching_up: false,
            latencies: Latencies::default(),
            pending: Vec::new(),
            chunk_begun: anchor.at,
            synced: anchor.at,
            counted: anchor.at,
            latest: anchor.at,
        })
    }

    /// Journals a sample, then takes it in.
    pub(super) fn pose(
        &mut self,
        at: Instant,
        stream: usize,
        record: &PoseRecord,
        is_overflow: bool,
    ) -> Result<(), WriteError> {
        let receipt = self.receipt(at);
        let streamed = self.streams[stream].take(record, receipt.0, is_overflow);
        let sample = match streamed {
            Streamed::Sample(sample) => Some(sample),
            Streamed::Refused => None,
        };
        self.journal
            .pose(stream, receipt, record, sample.as_ref())?;
        self.late_by(at);
        let topic = &self.topics[stream];
        self.pending.extend(sample.map(|sample| TakeEvent::Pose {
            track: topic.track,
            stream: topic.stream,
            sample,
        }));
        Ok(())
    }

    /// Journals a mark, then takes it in.
    pub(super) fn mark(&mut self, at: Instant, record: &MarkRecord) -> Result<(), WriteError> {
        let receipt = self.receipt(at);
        let mark = stamp_mark(record, receipt.0).and_then(|stamp| record.mark(stamp));
        self.marks.received += 1;
        self.marks.refused += u64::from(mark.is_none());
        self.journal.mark(receipt, record, mark.as_ref())?;
        self.late_by(at);
        self.pending.extend(mark.map(TakeEvent::Mark));
        Ok(())
    }

    /// Counts the latency of what has just been journalled, unless it was kept from before the take.
    fn late_by(&mut self, at: Instant) {
        if !self.is_catching_up {
            self.latencies.add(at.elapsed());
        }
    }

    /// Arrival on the take's clock.
    fn receipt(&mut self, at: Instant) -> Stamp {
        self.latest = self.latest.max(at);
        self.anchor.stamp(at)
    }

    /// Closes the chunk and writes the counts, when they are due.
    pub(super) fn tick(
        &mut self,
        now: Instant,
        settings: &CaptureSettings,
    ) -> Result<(), WriteError> {
        if now.duration_since(self.counted) >= settings.sync {
            self.counted = now;
            self.note_counts()?;
        }
        if now.duration_since(self.chunk_begun) >= settings.chunk.mul_f64(CHUNK_SHARE) {
            self.chunk_begun = now;
            self.journal.close_chunk()?;
        }
        Ok(())
    }

    /// Writes the counts so far into the journal, stamped with the last arrival: entries in the
    /// queue arrived before now, and a journal is in order of time.
    pub(super) fn note_counts(&mut self) -> Result<(), WriteError> {
        let json = serde_json::to_vec(&self.counts()).expect("names and numbers are JSON");
        self.journal.counts(self.anchor.stamp(self.latest), &json)
    }

    /// Writes the counts and what was said of the take, at its end.
    pub(super) fn note_end(&mut self) -> Result<(), WriteError> {
        self.note_counts()?;
        let pairs = self.label.pairs(self.number);
        self.journal.note(TAKE_METADATA, pairs)
    }

    /// Number of accepted marks.
    pub(super) fn marks(&self) -> u64 {
        self.marks.received - self.marks.refused
    }

    /// What of it did not arrive, in words.
    pub(super) fn lost(&self) -> Option<String> {
        let counts = || self.streams.iter().map(Stream::counts);
        let missing: u64 = counts().map(|counts| counts.missing).sum();
        let lacks = counts().any(|counts| counts.lacks_samples());
        lacks.then(|| {
            let number = self.number;
            match missing {
                0 => {
                    format!("samples before the first of a publisher are missing in take {number}")
                }
                1 => format!("1 sample is missing in take {number}"),
                _ => format!("{missing} samples are missing in take {number}"),
            }
        })
    }

    /// The counts so far.
    pub(super) fn counts(&self) -> CountsLine {
        let lines = self.topics.iter().zip(&self.streams);
        CountsLine {
            trackers: lines
                .map(|(topic, stream)| TrackerLine {
                    topic: topic.topic.clone(),
                    counts: stream.counts(),
                    clock: stream.quality(),
                })
                .collect(),
            marks: self.marks,
            latency_ms: self.latencies.line(),
        }
    }
}

#[cfg(test)]
mod tests;
