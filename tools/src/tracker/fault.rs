//! What trackers do when they misbehave.

use std::ops::Range;
use std::str::FromStr;

use clap::Args;
use enact::ingest::live::PoseRecord;

/// Faults, on samples by their number in all that is sent.
#[derive(Args)]
#[command(next_help_heading = "Faults, by the numbers of samples, as in 50..80")]
pub struct Faults {
    /// Samples that are not sent, and leave a hole in the sequence
    #[arg(long)]
    drop: Vec<Span>,
    /// Samples that repeat the pose before them
    #[arg(long)]
    freeze: Vec<Span>,
    /// Samples that are sent twice
    #[arg(long)]
    double: Vec<Span>,
    /// Samples that the tracker does not vouch for
    #[arg(long)]
    invalid: Vec<Span>,
    /// Samples with garbage for numbers
    #[arg(long)]
    garbage: Vec<Span>,
    /// Pairs of samples that change places, from their first
    #[arg(long)]
    swap: Vec<Span>,
    /// The sample from which on a new session counts from zero
    #[arg(long)]
    restart: Option<u64>,
    /// The sample from which on the clocks are set forward, or back, by `--step-ms`
    #[arg(long)]
    step: Option<u64>,
    /// By how much
    #[arg(long, default_value_t = -3_600_000.0, allow_negative_numbers = true)]
    step_ms: f64,
    /// The sample before which the process kills itself, without a word
    #[arg(long)]
    kill: Option<u64>,
}

/// A range of numbers.
#[derive(Clone, Debug)]
pub struct Span(Range<u64>);

impl FromStr for Span {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once("..").and_then(|(from, to)| {
            let range = from.parse().ok()?..to.parse().ok()?;
            (!range.is_empty()).then_some(range)
        });
        parsed
            .map(Self)
            .ok_or_else(|| "expected a range such as 50..80".into())
    }
}

fn has(spans: &[Span], number: u64) -> bool {
    spans.iter().any(|span| span.0.contains(&number))
}

/// Makes faults of an honest stream.
pub struct Faulty<'a> {
    faults: &'a Faults,
    number: u64,
    begun: u64,
    last: Option<PoseRecord>,
    held: Option<(usize, PoseRecord)>,
}

impl<'a> Faulty<'a> {
    pub fn new(faults: &'a Faults) -> Self {
        Self {
            faults,
            number: 0,
            begun: 0,
            last: None,
            held: None,
        }
    }

    /// What is sent in place of a sample, with its topics.
    pub fn sent(&mut self, topic: usize, mut record: PoseRecord) -> Vec<(usize, PoseRecord)> {
        let (faults, number) = (self.faults, self.number);
        self.number += 1;
        if faults.kill == Some(number) {
            // As kill -9 does: nothing is cleaned up.
            let _ = std::process::Command::new("kill")
                .args(["-9", &std::process::id().to_string()])
                .status();
        }
        if faults.restart == Some(number) {
            self.begun = record.sequence;
        }
        if faults.restart.is_some_and(|from| number >= from) {
            record.session = record.session.wrapping_add(1);
            record.sequence -= self.begun.min(record.sequence);
        }
        if faults.step.is_some_and(|from| number >= from) {
            let step_ns = (faults.step_ms * 1e6) as i64;
            for time_ns in [&mut record.sample_ns, &mut record.device_ns] {
                if *time_ns != enact::ingest::live::NO_TIME {
                    *time_ns += step_ns;
                }
            }
        }
        if has(&faults.freeze, number)
            && let Some(last) = &self.last
        {
            record.position_m = last.position_m;
            record.quaternion_xyzw = last.quaternion_xyzw;
        }
        self.last = Some(record);
        if has(&faults.invalid, number) {
            record.flags = 0;
        }
        if has(&faults.garbage, number) {
            record.position_m = [f64::NAN, f64::INFINITY, 1e300];
            record.quaternion_xyzw = [0.0; 4];
        }
        if has(&faults.drop, number) {
            return Vec::new();
        }
        if has(&faults.swap, number) && self.held.is_none() {
            self.held = Some((topic, record));
            return Vec::new();
        }
        let mut sent = vec![(topic, record)];
        sent.extend(self.held.take());
        if has(&faults.double, number) {
            sent.push((topic, record));
        }
        sent
    }
}
