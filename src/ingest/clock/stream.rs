//! The stamps of one stream, from any source.

use serde::Serialize;

use super::cadence::Cadence;
use super::follower::Follower;
use super::smoother::Smoother;
use crate::motion::{Stamp, StampSource};

/// In an uneven stream, a step back of more than this \[ns\] is a clock that was set: stamps jitter
/// by less.
const BACK_NS: i64 = 50_000_000;

/// In an uneven stream, a reading that leads by more than this \[ns\] is of a clock that was set:
/// less is drift, or a recording played faster than it was made.
const LEAD_NS: i64 = 500_000_000;

/// After an arrival that is off its expected time by more than this \[ns\], smoothing begins anew.
const PAUSE_NS: i64 = 500_000_000;

/// A driver's times of a sample, and its arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StampReading {
    /// A number that differs for every start of the publisher.
    pub session: u32,
    /// Counts the publisher's samples.
    pub sequence: u64,
    /// When it was measured, on the system clock \[ns\].
    pub sample_ns: Option<i64>,
    /// The device's clock \[ns, any zero\].
    pub device_ns: Option<i64>,
    /// When it arrived, on this machine's clock \[ns\].
    pub receipt_ns: i64,
}

/// How good the stamps of a stream are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ClockQuality {
    /// Their source: `sample`, `device`, `sequence` or `receipt`; `None` before the first sample.
    pub source: Option<&'static str>,
    /// How often the clock was set, or its steps could not be followed.
    pub steps: u64,
    /// How often the publisher restarted.
    pub restarts: u64,
    /// Samples without the time that the source needs; they are stamped on arrival.
    pub unstamped: u64,
    /// Mean of arrival less stamp \[ms\].
    pub delay_ms: f64,
    /// Its standard deviation \[ms\].
    pub delay_sd_ms: f64,
    /// Its greatest value \[ms\].
    pub delay_max_ms: f64,
}

/// Stamps the samples of one stream, in the order in which they come.
#[derive(Clone, Debug)]
pub struct StreamClock {
    source: Option<StampSource>,
    state: Option<ClockState>,
    /// Greatest sequence number so far, with its reading, its arrival and its stamp.
    last: Option<LastStamp>,
    cadence: Cadence,
    quality: ClockQuality,
    delays: Delays,
}

#[derive(Clone, Copy, Debug)]
struct LastStamp {
    session: u32,
    sequence: u64,
    reading_ns: i64,
    receipt_ns: i64,
    stamp_ns: i64,
}

#[derive(Clone, Copy, Debug)]
enum ClockState {
    /// Readings plus an offset, zero until a step; and the follower that detects steps.
    Given {
        added_ns: i64,
        follower: Follower,
    },
    Followed(Follower),
    Smoothed(Smoother),
}

impl StreamClock {
    /// Stamps by the given source; without one, the first sample decides.
    pub fn new(source: Option<StampSource>) -> Self {
        Self {
            source,
            state: None,
            last: None,
            cadence: Cadence::default(),
            quality: ClockQuality {
                source: source.map(StampSource::as_str),
                ..ClockQuality::default()
            },
            delays: Delays::default(),
        }
    }

    /// When the sample was measured, on this machine's clock; for the source `sample`, on the
    /// driver's.
    pub fn stamp(&mut self, reading: &StampReading) -> Stamp {
        let source = *self.source.get_or_insert(match reading {
            StampReading {
                sample_ns: Some(_), ..
            } => StampSource::Sample,
            StampReading {
                device_ns: Some(_), ..
            } => StampSource::Device,
            _ => StampSource::Receipt,
        });
        self.quality.source = Some(source.as_str());
        let Some(reading_ns) = self.reading_ns(source, reading) else {
            self.quality.unstamped += 1;
            return Stamp(reading.receipt_ns);
        };
        let is_restart = self
            .last
            .is_some_and(|last| last.session != reading.session);
        self.quality.restarts += u64::from(is_restart);
        let stamp_ns = match self.step(source, reading, reading_ns, is_restart) {
            Some(stamp_ns) => self.begin(source, reading, reading_ns, stamp_ns),
            None => self.go_on(reading, reading_ns),
        };
        let is_ahead = self
            .last
            .is_none_or(|last| last.session != reading.session || reading.sequence > last.sequence);
        if is_ahead {
            self.last = Some(LastStamp {
                session: reading.session,
                sequence: reading.sequence,
                reading_ns,
                receipt_ns: reading.receipt_ns,
                stamp_ns,
            });
        }
        self.delays.add(reading.receipt_ns.saturating_sub(stamp_ns));
        Stamp(stamp_ns)
    }

    /// How good the stamps are so far.
    pub fn quality(&self) -> ClockQuality {
        ClockQuality {
            delay_ms: self.delays.mean_ns * 1e-6,
            delay_sd_ms: self.delays.sd_ns() * 1e-6,
            delay_max_ms: self.delays.max_ns as f64 * 1e-6,
            ..self.quality
        }
    }

    /// The source's time of a reading \[ns, any zero\]; `None` where the reading lacks it.
    fn reading_ns(&self, source: StampSource, reading: &StampReading) -> Option<i64> {
        match source {
            StampSource::Sample => reading.sample_ns,
            StampSource::Device => reading.device_ns,
            StampSource::Sequence { rate_hz } => {
                // Relative to the first number, so that the float is precise.
                let first = self.last.map_or(reading.sequence, |last| last.sequence);
                let steps = i128::from(reading.sequence) - i128::from(first);
                let since_ns = (steps as f64 / rate_hz * 1e9).round() as i64;
                let from_ns = self.last.map_or(0, |last| last.reading_ns);
                let is_new = self
                    .last
                    .is_some_and(|last| last.session != reading.session);
                Some(if is_new {
                    0
                } else {
                    from_ns.saturating_add(since_ns)
                })
            }
            StampSource::Receipt => Some(reading.receipt_ns),
        }
    }

    /// The stamp with which to begin anew: at the first sample, after a restart, after a step of
    /// the clock; `None` where the stream continues.
    fn step(
        &mut self,
        source: StampSource,
        reading: &StampReading,
        reading_ns: i64,
        is_restart: bool,
    ) -> Option<i64> {
        let (Some(last), Some(state)) = (self.last, &self.state) else {
            return Some(match source {
                StampSource::Sample => reading_ns,
                _ => reading.receipt_ns,
            });
        };
        let arrived_ns = reading.receipt_ns.saturating_sub(last.receipt_ns);
        let silence_ns = arrived_ns.max(1);
        let went_on_ns = last.stamp_ns.saturating_add(silence_ns);
        let is_ahead = reading.sequence > last.sequence;
        let advance_ns = reading_ns.saturating_sub(last.reading_ns);
        let is_back = is_ahead && advance_ns < -BACK_NS;
        let jump_ns = match state {
            ClockState::Given { .. } | ClockState::Followed(_) if is_ahead && !is_restart => {
                let numbers = reading.sequence - last.sequence;
                self.cadence.step_ns(advance_ns, arrived_ns, numbers)
            }
            _ => None,
        };
        // A step forward must lead the earlier delays too: the predecessor may have been late.
        let is_out = |follower: &Follower| {
            let lead_ns = follower.lead_ns(reading_ns, reading.receipt_ns);
            let is_jump = jump_ns.is_some_and(|jump_ns| jump_ns < 0 || lead_ns > jump_ns / 2);
            is_back || lead_ns > LEAD_NS || is_jump
        };
        match state {
            // The system clock continues over restarts, unless it was set meanwhile.
            ClockState::Given { follower, .. } => {
                let is_step = is_out(follower) || (is_restart && advance_ns < -BACK_NS);
                self.quality.steps += u64::from(is_step);
                is_step.then_some(went_on_ns)
            }
            ClockState::Followed(_) if is_restart => Some(reading.receipt_ns),
            ClockState::Followed(follower) => {
                let is_step = is_out(follower);
                self.quality.steps += u64::from(is_step);
                is_step.then_some(went_on_ns.min(reading.receipt_ns))
            }
            ClockState::Smoothed(_) if is_restart => Some(reading.receipt_ns),
            ClockState::Smoothed(smoother) => {
                let steps = reading.sequence.saturating_sub(last.sequence);
                let surprise_ns = smoother.surprise_ns(reading.receipt_ns, steps);
                let is_lost = surprise_ns.abs() > PAUSE_NS;
                self.quality.steps += u64::from(is_lost);
                is_lost.then_some(reading.receipt_ns.max(last.stamp_ns))
            }
        }
    }

    fn begin(
        &mut self,
        source: StampSource,
        reading: &StampReading,
        reading_ns: i64,
        stamp_ns: i64,
    ) -> i64 {
        self.state = Some(match source {
            StampSource::Sample => ClockState::Given {
                added_ns: stamp_ns.saturating_sub(reading_ns),
                follower: Follower::new(reading_ns, reading.receipt_ns),
            },
            StampSource::Device | StampSource::Sequence { .. } => {
                ClockState::Followed(Follower::new(reading_ns, stamp_ns))
            }
            StampSource::Receipt => ClockState::Smoothed(Smoother::new(stamp_ns)),
        });
        stamp_ns
    }

    fn go_on(&mut self, reading: &StampReading, reading_ns: i64) -> i64 {
        let last = self.last;
        match self.state.as_mut() {
            Some(ClockState::Given { added_ns, follower }) => {
                follower.stamp(reading_ns, reading.receipt_ns);
                reading_ns.saturating_add(*added_ns)
            }
            Some(ClockState::Followed(follower)) => follower.stamp(reading_ns, reading.receipt_ns),
            Some(ClockState::Smoothed(smoother)) => {
                let before = last.map_or(0, |last| last.sequence);
                smoother.stamp(reading.receipt_ns, reading.sequence.saturating_sub(before))
            }
            None => reading.receipt_ns,
        }
    }
}

/// Mean and variance of a stream, by Welford's recurrence.
#[derive(Clone, Copy, Debug, Default)]
struct Delays {
    count: u64,
    mean_ns: f64,
    squares: f64,
    max_ns: i64,
}

impl Delays {
    fn add(&mut self, delay_ns: i64) {
        self.max_ns = if self.count == 0 {
            delay_ns
        } else {
            self.max_ns.max(delay_ns)
        };
        self.count += 1;
        let off = delay_ns as f64 - self.mean_ns;
        self.mean_ns += off / self.count as f64;
        self.squares += off * (delay_ns as f64 - self.mean_ns);
    }

    fn sd_ns(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests;
