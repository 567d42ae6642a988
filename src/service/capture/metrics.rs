//! Counters of the daemon in the text format 0.0.4 of Prometheus.

use std::fmt::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::event::{CaptureEvent, Status, TrackerLine};
use super::health::Health;
use super::history::History;
use super::latency::Latencies;
use super::presence::{Presence, TrackerState};

/// Upper ends of the bins of histograms \[s\].
pub(super) const BOUNDS_S: [f64; 13] = [
    0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.004, 0.005, 0.01, 0.02, 0.05, 0.1, 1.0, 10.0,
];

/// A counter.
#[derive(Debug, Default)]
pub(super) struct Count(AtomicU64);

impl Count {
    pub(super) fn add(&self) {
        self.add_many(1);
    }

    pub(super) fn add_many(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A gauge of the entries in a queue.
#[derive(Debug, Default)]
pub(super) struct Depth(AtomicI64);

impl Depth {
    pub(super) fn put(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn take(&self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }

    pub(super) fn get(&self) -> i64 {
        // The receiver may count before the sender has counted.
        self.0.load(Ordering::Relaxed).max(0)
    }
}

/// A histogram of durations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Histogram {
    bins: [u64; BOUNDS_S.len() + 1],
    sum_s: f64,
}

impl Histogram {
    pub(super) fn add(&mut self, duration: Duration) {
        let seconds = duration.as_secs_f64();
        self.bins[BOUNDS_S.partition_point(|bound| *bound < seconds)] += 1;
        self.sum_s += seconds;
    }

    fn write(&self, text: &mut String, name: &str, label: &str) {
        let comma = if label.is_empty() { "" } else { "," };
        let mut below = 0;
        let ends = BOUNDS_S.iter().map(f64::to_string);
        for (bin, end) in self.bins.iter().zip(ends.chain(["+Inf".to_owned()])) {
            below += bin;
            let _ = writeln!(text, "{name}_bucket{{{label}{comma}le=\"{end}\"}} {below}");
        }
        let _ = writeln!(text, "{name}_sum{{{label}}} {}", self.sum_s);
        let _ = writeln!(text, "{name}_count{{{label}}} {below}");
    }
}

/// All counters beside those in [`Status`].
#[derive(Debug, Default)]
pub(super) struct Metrics {
    pub(super) batches_waiting: Depth,
    pub(super) previews_waiting: Depth,
    pub(super) finals_waiting: Depth,
    pub(super) notices_waiting: Depth,
    /// Samples dropped because the viewers' queue was full.
    pub(super) not_shown: Count,
    pub(super) requests_refused: Count,
    /// Connections closed because more came before they had said what they want.
    pub(super) connections_closed: Count,
    /// Viewers that are there.
    pub(super) viewers: Depth,
    pub(super) viewers_refused: Count,
    /// Viewers sent away because they did not read.
    pub(super) viewers_stalled: Count,
    /// Messages that viewers missed.
    pub(super) viewers_missed: Count,
    pub(super) health: Health,
    pub(super) history: History,
    /// Takes by their outcome: see [`TAKES`].
    takes: [Count; TAKES.len()],
    not_previewed: Count,
    so_far: Count,
    previews: Mutex<[Histogram; 2]>,
    finals: Mutex<Histogram>,
}

const TAKES: [&str; 6] = [
    "started",
    "closed",
    "discarded",
    "broken",
    "estimated",
    "not_estimated",
];

impl Metrics {
    /// Counts a preview, started from the previous one or from nothing.
    pub(super) fn preview(&self, is_warm: bool, took: Duration) {
        if let Ok(mut previews) = self.previews.lock() {
            previews[usize::from(is_warm)].add(took);
        }
    }

    /// Counts a preview that was not possible with the events so far.
    pub(super) fn no_preview(&self) {
        self.not_previewed.add();
    }

    /// Counts a take that was estimated, checked and written.
    pub(super) fn estimated(&self, took: Duration) {
        if let Ok(mut finals) = self.finals.lock() {
            finals.add(took);
        }
    }

    /// Counts an event.
    pub(super) fn said(&self, said: &CaptureEvent) {
        let kind = match said {
            CaptureEvent::Started { .. } => 0,
            CaptureEvent::Closed { .. } => 1,
            CaptureEvent::Discarded { .. } => 2,
            CaptureEvent::Broken { .. } => 3,
            CaptureEvent::Estimated { .. } => 4,
            CaptureEvent::NotEstimated { .. } => 5,
            CaptureEvent::SoFar { .. } => return self.so_far.add(),
            _ => return,
        };
        self.takes[kind].add();
    }

    /// The text of all metrics, with the status of the recorder.
    pub(super) fn text(&self, status: &Status) -> String {
        let mut text = String::new();
        trackers(&mut text, &status.totals.trackers);
        presence(&mut text, &status.trackers);
        let page = &mut text;
        let troubles = self.health.troubles(Instant::now());
        for (name, help, value) in [
            (
                "enact_healthy",
                "whether a take could be begun and written",
                u64::from(troubles.is_empty()),
            ),
            (
                "enact_folder_free_bytes",
                "free space in the folder of the takes",
                self.health.free_bytes(),
            ),
            (
                "enact_viewers",
                "viewers that are there",
                self.viewers.get().unsigned_abs(),
            ),
        ] {
            head(page, name, "gauge", help);
            let _ = writeln!(page, "{name} {value}");
        }
        let marks = &status.totals.marks;
        head(
            page,
            "enact_marks_total",
            "counter",
            "marks received in takes",
        );
        let _ = writeln!(page, "enact_marks_total {}", marks.received);
        head(
            page,
            "enact_marks_refused_total",
            "counter",
            "marks of no time or name",
        );
        let _ = writeln!(page, "enact_marks_refused_total {}", marks.refused);
        head(
            page,
            "enact_outside_total",
            "counter",
            "samples and marks outside takes",
        );
        let _ = writeln!(page, "enact_outside_total {}", status.outside);
        head(page, "enact_recording", "gauge", "whether a take runs");
        let _ = writeln!(page, "enact_recording {}", u8::from(status.take.is_some()));
        head(
            page,
            "enact_takes_total",
            "counter",
            "takes by what became of them",
        );
        for (word, count) in TAKES.iter().zip(&self.takes) {
            let _ = writeln!(
                page,
                "enact_takes_total{{state=\"{word}\"}} {}",
                count.get()
            );
        }
        let name = "enact_queue_depth";
        head(page, name, "gauge", "what waits in a queue");
        for (queue, depth) in [
            ("record", &self.batches_waiting),
            ("previews", &self.previews_waiting),
            ("finals", &self.finals_waiting),
            ("publisher", &self.notices_waiting),
        ] {
            let _ = writeln!(page, "{name}{{queue=\"{queue}\"}} {}", depth.get());
        }
        let name = "enact_journal_latency_seconds";
        head(page, name, "histogram", "from arrival to journal");
        status.latency.histogram().write(page, name, "");
        let name = "enact_preview_seconds";
        head(page, name, "histogram", "time that estimates so far take");
        if let Ok(previews) = self.previews.lock() {
            previews[1].write(page, name, "start=\"warm\"");
            previews[0].write(page, name, "start=\"cold\"");
        }
        let name = "enact_estimate_seconds";
        head(
            page,
            name,
            "histogram",
            "time that whole takes take, with checks and files",
        );
        if let Ok(finals) = self.finals.lock() {
            finals.write(page, name, "");
        }
        for (name, help, count) in [
            (
                "enact_estimates_at_marks_total",
                "estimates so far published at marks",
                &self.so_far,
            ),
            (
                "enact_previews_failed_total",
                "times with too little for a preview",
                &self.not_previewed,
            ),
            (
                "enact_viewer_dropped_total",
                "samples not shown live",
                &self.not_shown,
            ),
            (
                "enact_requests_refused_total",
                "HTTP requests refused",
                &self.requests_refused,
            ),
            (
                "enact_connections_closed_total",
                "connections closed because more came before they had said anything",
                &self.connections_closed,
            ),
            (
                "enact_viewers_refused_total",
                "viewers refused: no place, no permission, no handshake",
                &self.viewers_refused,
            ),
            (
                "enact_viewers_stalled_total",
                "viewers sent away because they did not read",
                &self.viewers_stalled,
            ),
            (
                "enact_viewers_missed_total",
                "messages that viewers were too slow for",
                &self.viewers_missed,
            ),
        ] {
            head(page, name, "counter", help);
            let _ = writeln!(page, "{name} {}", count.get());
        }
        text
    }
}

fn head(text: &mut String, name: &str, kind: &str, help: &str) {
    let _ = writeln!(text, "# HELP {name} {help}\n# TYPE {name} {kind}");
}

/// Counters of every stream.
fn trackers(text: &mut String, trackers: &[TrackerLine]) {
    let name = "enact_tracker_samples_total";
    head(
        text,
        name,
        "counter",
        "samples in takes by what became of them",
    );
    for line in trackers {
        let topic = escaped(&line.topic);
        let of = &line.counts;
        let received = [("received", of.received)].into_iter();
        let others = [
            ("gaps", of.gaps),
            ("skipped", of.skipped),
            ("clock_steps", line.clock.steps),
        ];
        // A number that comes late is no longer missing, and a counter must not fall.
        let troubles = of.troubles().into_iter();
        let troubles = troubles.filter(|(fate, _)| *fate != "missing");
        for (fate, count) in received.chain(troubles).chain(others) {
            let _ = writeln!(text, "{name}{{topic=\"{topic}\",fate=\"{fate}\"}} {count}");
        }
    }
    let name = "enact_tracker_delay_seconds";
    head(
        text,
        name,
        "gauge",
        "mean of arrival less stamp in the take that runs",
    );
    for line in trackers {
        let delay_s = line.clock.delay_ms * 1e-3;
        let _ = writeln!(
            text,
            "{name}{{topic=\"{}\"}} {delay_s}",
            escaped(&line.topic)
        );
    }
}

/// What is known of every tracker, take or no take.
fn presence(text: &mut String, trackers: &[TrackerState]) {
    type Gauge = (&'static str, &'static str, fn(&TrackerState) -> Option<f64>);
    let gauges: [Gauge; 4] = [
        (
            "enact_tracker_rate_hertz",
            "samples of the last second",
            |of| Some(of.rate_hz),
        ),
        (
            "enact_tracker_seen_seconds",
            "time since the last sample, if one came",
            |of| of.seen_s,
        ),
        (
            "enact_tracker_valid_ratio",
            "share of valid samples in the last second, if any came",
            |of| of.valid_share,
        ),
        (
            "enact_tracker_silent",
            "whether a tracker fell silent",
            |of| Some(f64::from(u8::from(of.state == Presence::Silent))),
        ),
    ];
    for (name, help, value) in gauges {
        head(text, name, "gauge", help);
        for of in trackers {
            if let Some(value) = value(of) {
                let topic = escaped(&of.topic);
                let _ = writeln!(text, "{name}{{topic=\"{topic}\"}} {value}");
            }
        }
    }
}

/// A label's value: `\`, `"` and line feeds are escaped.
fn escaped(value: &str) -> String {
    let value = value.replace('\\', "\\\\").replace('"', "\\\"");
    value.replace('\n', "\\n")
}

impl Latencies {
    /// The histogram in the bins of [`BOUNDS_S`]; each latency counts as the upper end of its finer
    /// bin.
    fn histogram(&self) -> Histogram {
        let mut histogram = Histogram::default();
        for (upper_s, count) in self.bins_s() {
            histogram.bins[BOUNDS_S.partition_point(|bound| *bound < upper_s - 1e-9)] += count;
            histogram.sum_s += count as f64 * upper_s;
        }
        histogram
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_of_a_histogram_are_cumulative_and_the_last_is_the_count() {
        let mut histogram = Histogram::default();
        for ms in [0.05, 0.1, 3.0, 40_000.0] {
            histogram.add(Duration::from_secs_f64(ms * 1e-3));
        }
        let mut text = String::new();
        histogram.write(&mut text, "x", "a=\"b\"");
        for line in [
            "x_bucket{a=\"b\",le=\"0.0001\"} 2",
            "x_bucket{a=\"b\",le=\"0.002\"} 2",
            "x_bucket{a=\"b\",le=\"0.004\"} 3",
            "x_bucket{a=\"b\",le=\"10\"} 3",
            "x_bucket{a=\"b\",le=\"+Inf\"} 4",
            "x_count{a=\"b\"} 4",
        ] {
            assert!(text.lines().any(|l| l == line), "{line} in {text}");
        }
    }

    #[test]
    fn latencies_keep_their_bins() {
        let mut latencies = Latencies::default();
        for us in [40, 99, 180, 4_990, 2_000_000] {
            latencies.add(Duration::from_micros(us));
        }
        let histogram = latencies.histogram();
        assert_eq!(histogram.bins[..2], [2, 1]);
        assert_eq!(histogram.bins[6], 1);
        assert_eq!(histogram.bins.iter().sum::<u64>(), 5);
    }

    #[test]
    fn names_that_are_odd_do_not_break_the_page() {
        assert_eq!(escaped("a\"b\\c\nd"), "a\\\"b\\\\c\\nd");
    }
}
