//! Checks that enough keyframes of a flight have times that are known to tell those of the others.

use std::collections::BTreeMap;

use crate::motion::{About, Doubt, Estimate, Place};

/// Least number of keyframes of a flight whose times are known, where others are not. With one, the
/// same poses at other times are passed by motions that turn otherwise.
const KNOWN: usize = 2;

pub(super) fn doubts(estimate: &Estimate) -> Vec<Doubt> {
    // Keyframes of each flight: whose times are known, and whose are not.
    let mut counts: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
    let mut times = estimate.sample_times.iter();
    for residual in &estimate.residuals {
        for time in times.by_ref().take(residual.samples) {
            counts.entry(residual.arc).or_default()[usize::from(time.is_open)] += 1;
        }
    }
    let doubts = counts.into_iter().filter_map(|(arc, [known, open])| {
        let of = &estimate.arcs[arc];
        let place = Place::Flight {
            mechanism: of.mechanism,
            start_s: of.start_s,
        };
        let lacks = if open > 0 {
            KNOWN.saturating_sub(known)
        } else {
            0
        };
        Doubt::beyond(About::OpenTimes, place, lacks as f64, 0.0)
    });
    doubts.collect()
}
