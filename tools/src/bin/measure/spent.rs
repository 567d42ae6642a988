//! How far from the truth an estimate is for the time that it takes: with fewer samples, during the
//! performance, and stopped by a deadline.

mod deadline;
mod previews;
mod samples;
mod scenes;

use anyhow::Result;

use crate::figure::Mark;
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};

/// Performances of each row.
const SEEDS: u64 = 40;

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    samples::run(options, record)?;
    previews::run(options, record)?;
    deadline::run(options, record)
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
