//! How far from the truth an estimate is for the time that it takes: with fewer samples, during the
//! performance, and stopped before it has converged.

mod previews;
mod samples;
mod scenes;
mod stopped;

use std::time::Instant;

use anyhow::Result;

use crate::figure::Mark;
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};

/// Performances of each row.
const SEEDS: u64 = 40;
/// Runs of which the fastest counts.
const REPEATS: usize = 9;
/// Factors on the hand's wander, by name.
const HANDS: [(f64, &str, &str); 2] = [
    (1.0, "hand", "a hand's wander and a tracker's noise"),
    (0.0, "noise", "a tracker's noise alone"),
];

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    samples::run(options, record)?;
    previews::run(options, record)?;
    stopped::run(options, record)
}

/// What a run gives, and how long the fastest of several takes \[ms\].
fn timed<T>(mut run: impl FnMut() -> T) -> (T, f64) {
    let mut one = || {
        let begun = Instant::now();
        let result = run();
        (result, 1e3 * begun.elapsed().as_secs_f64())
    };
    let (result, first_ms) = one();
    let others_ms = (1..REPEATS).map(|_| one().1);
    (result, others_ms.fold(first_ms, f64::min))
}

/// A point: the median, with a bar up to what 95 % are below. It is a failure where there is no
/// estimate of half of the performances.
fn mark(x: f64, errors: &[f64], performances: usize) -> Mark {
    Mark {
        spread: Some([median(errors), quantile(errors, 0.95)]),
        failed: 2 * errors.len() < performances,
        ..Mark::at(x, median(errors))
    }
}
