//! A take that runs: its journal, its streams, what of it is not handed on yet.

use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::event::{CountsLine, MarkCounts, TrackerLine};
use super::latency::Latencies;
use crate::config::CaptureSettings;
use crate::ingest::live::{MarkRecord, PoseRecord};
use crate::ingest::live::{Stream, StreamTopic, Streamed, stamp_mark};
use crate::motion::{Scene, Stamp, TakeEvent};
use crate::write::{Journal, WriteError};

/// Of the time that samples may be in an open chunk, how much the chunk is kept open: the rest
/// is for polling, queueing and writing, all of which a kill cuts short too.
const CHUNK_SHARE: f64 = 0.75;

/// Now on the system clock [ns since 1970].
pub(in crate::service) fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
    })
}

/// Our clock during a take: the system's at its beginning, and from then on one that is never
/// set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    wall_ns: i64,
    at: Instant,
}

impl Anchor {
    pub(super) fn now() -> Self {
        Self {
            wall_ns: now_ns(),
            at: Instant::now(),
        }
    }

    /// What that instant is on our clock.
    pub(super) fn stamp(&self, at: Instant) -> Stamp {
        let nanos = |span: Duration| i64::try_from(span.as_nanos()).unwrap_or(i64::MAX);
        let since_ns = match at.checked_duration_since(self.at) {
            Some(after) => nanos(after),
            None => -nanos(self.at.duration_since(at)),
        };
        Stamp(self.wall_ns.saturating_add(since_ns))
    }
}

/// A take that runs.
pub(super) struct Take {
    pub(super) number: u64,
    pub(super) journal: Journal,
    anchor: Anchor,
    topics: Vec<StreamTopic>,
    streams: Vec<Stream>,
    marks: MarkCounts,
    pub(super) latencies: Latencies,
    /// Events that the estimator has not been given.
    pub(super) pending: Vec<TakeEvent>,
    pub(super) chunk_begun: Instant,
    pub(super) synced: Instant,
    pub(super) counted: Instant,
    /// When the last sample or mark came.
    latest: Instant,
}

impl Take {
    /// Begins the journal at that path.
    pub(super) fn begin(
        number: u64,
        path: &Path,
        scene: &Scene,
        scene_toml: &[u8],
        topics: &[StreamTopic],
        settings: &CaptureSettings,
    ) -> Result<Self, WriteError> {
        let names: Vec<String> = topics.iter().map(|topic| topic.topic.clone()).collect();
        let anchor = Anchor::now();
        let stream = |topic: &StreamTopic| Stream::new(settings.stamps[topic.track]);
        Ok(Self {
            number,
            journal: Journal::create(path, &names, &scene.marks_topic, scene_toml)?,
            anchor,
            topics: topics.to_vec(),
            streams: topics.iter().map(stream).collect(),
            marks: MarkCounts::default(),
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
        self.latencies.add(at.elapsed());
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
        self.latencies.add(at.elapsed());
        self.pending.extend(mark.map(TakeEvent::Mark));
        Ok(())
    }

    /// When something came, on our clock.
    fn receipt(&mut self, at: Instant) -> Stamp {
        self.latest = self.latest.max(at);
        self.anchor.stamp(at)
    }

    /// Closes the chunk and notes the counts, where it is time.
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

    /// Writes the counts so far into the journal, at the time of the last thing that came: what
    /// waits in the queue came before now, and a journal is in order.
    pub(super) fn note_counts(&mut self) -> Result<(), WriteError> {
        let json = serde_json::to_vec(&self.counts()).expect("names and numbers are JSON");
        self.journal.counts(self.anchor.stamp(self.latest), &json)
    }

    /// Marks that count.
    pub(super) fn marks(&self) -> u64 {
        self.marks.received - self.marks.refused
    }

    /// What became of the samples so far.
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
