//! Checks that enough keyframes of a flight have times that are known to tell those of the others.

use std::collections::BTreeMap;

use super::flights::CredibleFlight;
use crate::motion::{About, Doubt, Place};

/// Least number of keyframes of a flight whose times are known, where others are not. With one, the
/// same poses at other times are passed by motions that turn otherwise.
const KNOWN: usize = 2;

pub(super) fn doubts(flights: &[CredibleFlight]) -> Vec<Doubt> {
    // Of each arc, whatever its keyframes show: how many times are known, and how many are not.
    let mut counts: BTreeMap<usize, (Place, [usize; 2])> = BTreeMap::new();
    for flight in flights {
        let of_arc = counts.entry(flight.residual.arc);
        let (_, counts) = of_arc.or_insert_with(|| (flight.place(), [0; 2]));
        for time in flight.times {
            counts[usize::from(time.is_open)] += 1;
        }
    }
    let doubts = counts.into_values().filter_map(|(place, [known, open])| {
        let least = if open > 0 { KNOWN } else { 0 };
        let lacks = least.saturating_sub(known);
        Doubt::beyond(About::OpenTimes, place, lacks as f64, 0.0)
    });
    doubts.collect()
}
