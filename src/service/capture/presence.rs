//! Whether trackers send, take or no take: how fast, when last, and how much of it is valid.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::ingest::live::PoseRecord;

/// Width and number of the bins that rates are counted in.
const BIN: Duration = Duration::from_millis(100);
const BINS: usize = 10;

/// Samples from which on a tracker that sends no more is missed.
const KNOWN: u64 = 3;

/// A tracker is silent after so many of its mean intervals, within these bounds.
const INTERVALS: f64 = 5.0;
const SILENT_S: (f64, f64) = (0.5, 60.0);

/// Weight of a new interval in the mean.
const WEIGHT: f64 = 0.1;

/// Whether a tracker sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Presence {
    /// Nothing came since the start.
    #[default]
    Unheard,
    /// Samples come.
    Sending,
    /// Samples came, and come no more.
    Silent,
}

impl Presence {
    /// The word for it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Unheard => "unheard",
            Self::Sending => "sending",
            Self::Silent => "silent",
        }
    }
}

/// How a tracker stands, take or no take.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackerState {
    /// Its topic.
    pub topic: String,
    /// Whether it sends.
    pub state: Presence,
    /// Rate of the last second, or of a slow tracker \[Hz\].
    pub rate_hz: f64,
    /// Share of the samples of the last second that are valid, if there are any.
    pub valid_share: Option<f64>,
    /// Time since the last sample, if there was one \[s\].
    pub seen_s: Option<f64>,
}

/// The pulse of one tracker.
#[derive(Clone, Debug)]
pub(super) struct Pulse {
    topic: String,
    first: Option<Instant>,
    last: Option<Instant>,
    samples: u64,
    /// Mean interval, weighted towards the last \[s\].
    interval_s: f64,
    /// Samples and valid ones, the latest bin first, and when that began.
    bins: [(u64, u64); BINS],
    begun: Instant,
    state: Presence,
}

impl Pulse {
    pub(super) fn new(topic: &str, now: Instant) -> Self {
        Self {
            topic: topic.to_owned(),
            first: None,
            last: None,
            samples: 0,
            interval_s: 0.0,
            bins: [(0, 0); BINS],
            begun: now,
            state: Presence::Unheard,
        }
    }

    /// Takes a sample in.
    pub(super) fn sample(&mut self, at: Instant, record: &PoseRecord) {
        self.turn(at);
        self.bins[0].0 += 1;
        let is_finite = record.position_m.iter().all(|x| x.is_finite());
        self.bins[0].1 += u64::from(record.is_valid() && is_finite);
        self.samples += 1;
        self.first.get_or_insert(at);
        if let Some(last) = self.last
            && self.state == Presence::Sending
        {
            let interval_s = at.saturating_duration_since(last).as_secs_f64();
            let weight = WEIGHT.max(1.0 / (self.samples - 1).max(1) as f64);
            self.interval_s += weight * (interval_s - self.interval_s);
        }
        self.last = Some(at);
    }

    /// The new state and for how long the tracker was silent \[s\], where the state has changed.
    pub(super) fn changed(&mut self, now: Instant) -> Option<(Presence, f64)> {
        let since_s = now.saturating_duration_since(self.last?).as_secs_f64();
        let (least_s, most_s) = SILENT_S;
        let is_silent = since_s > (INTERVALS * self.interval_s).clamp(least_s, most_s);
        let state = match (self.state, is_silent) {
            (_, false) => Presence::Sending,
            // A few samples are no tracker that is missed.
            (Presence::Sending, true) if self.samples >= KNOWN => Presence::Silent,
            (state, true) => state,
        };
        let has_changed = state != self.state;
        self.state = state;
        has_changed.then_some((state, since_s))
    }

    /// Whether samples come.
    pub(super) fn is_sending(&self) -> bool {
        self.state == Presence::Sending
    }

    pub(super) fn topic(&self) -> &str {
        &self.topic
    }

    /// How it stands.
    pub(super) fn state(&mut self, now: Instant) -> TrackerState {
        self.turn(now);
        let (samples, valid) = self
            .bins
            .iter()
            .fold((0, 0), |(all, valid), bin| (all + bin.0, valid + bin.1));
        let age_s =
            |at: Option<Instant>| at.map(|at| now.saturating_duration_since(at).as_secs_f64());
        // The bins begin with the tracker, and the last one has only begun.
        let in_bin = now.saturating_duration_since(self.begun);
        let span_s = ((BINS as u32 - 1) * BIN + in_bin).as_secs_f64();
        let span_s = age_s(self.first).map_or(span_s, |age_s| age_s.clamp(0.1, span_s));
        let is_slow = self.interval_s > 2.0 * BIN.as_secs_f64();
        let rate_hz = match self.state {
            Presence::Sending if is_slow => 1.0 / self.interval_s,
            _ => samples as f64 / span_s,
        };
        TrackerState {
            topic: self.topic.clone(),
            state: self.state,
            rate_hz,
            valid_share: (samples > 0).then(|| valid as f64 / samples as f64),
            seen_s: age_s(self.last),
        }
    }

    /// Begins bins that are due.
    fn turn(&mut self, now: Instant) {
        let mut turned = 0;
        while now.saturating_duration_since(self.begun) >= BIN {
            if turned == BINS {
                self.begun = now;
                break;
            }
            self.bins.rotate_right(1);
            self.bins[0] = (0, 0);
            self.begun += BIN;
            turned += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(is_valid: bool) -> PoseRecord {
        PoseRecord {
            flags: u32::from(is_valid),
            ..PoseRecord::numbered(0)
        }
    }

    #[test]
    fn a_tracker_is_known_by_rate_share_and_silence() {
        let begun = Instant::now();
        let mut pulse = Pulse::new("/tracker/a/pose", begun);
        assert_eq!(pulse.changed(begun), None);
        assert_eq!(pulse.state(begun).state, Presence::Unheard);
        for k in 0..500_u64 {
            let at = begun + Duration::from_millis(4 * k);
            pulse.sample(at, &record(k % 4 > 0));
            let changed = pulse.changed(at);
            assert_eq!(changed.is_some(), k == 0, "{k}: {changed:?}");
        }
        let end = begun + Duration::from_secs(2);
        let state = pulse.state(end);
        assert_eq!(state.state, Presence::Sending);
        assert!((state.rate_hz - 250.0).abs() < 10.0, "{state:?}");
        assert!(
            (state.valid_share.expect("samples") - 0.75).abs() < 0.02,
            "{state:?}"
        );
        assert!(state.seen_s.is_some_and(|s| s < 0.01), "{state:?}");
        assert_eq!(pulse.changed(end + Duration::from_millis(400)), None);
        let later = end + Duration::from_millis(600);
        assert_eq!(pulse.changed(later).map(|c| c.0), Some(Presence::Silent));
        assert_eq!(pulse.changed(later), None);
        let state = pulse.state(later + Duration::from_secs(3));
        assert_eq!((state.rate_hz, state.valid_share), (0.0, None));
        pulse.sample(later, &record(true));
        assert_eq!(pulse.changed(later).map(|c| c.0), Some(Presence::Sending));
    }

    #[test]
    fn a_slow_tracker_is_not_called_silent_between_its_samples() {
        let begun = Instant::now();
        let mut pulse = Pulse::new("/tracker/a/pose", begun);
        for k in 0..20 {
            let at = begun + Duration::from_secs(k);
            pulse.sample(at, &record(true));
            let before = at + Duration::from_millis(999);
            assert_eq!(pulse.changed(at).is_some(), k == 0);
            if k > 0 {
                assert_eq!(pulse.changed(before), None, "{k}");
            }
        }
        let state = pulse.state(begun + Duration::from_secs(19));
        assert!((state.rate_hz - 1.0).abs() < 0.05, "{state:?}");
    }
}
