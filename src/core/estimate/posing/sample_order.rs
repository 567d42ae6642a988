//! Which samples whose times are not known are held in their order by a constraint.
//!
//! Beside a sample with a known time the bounds of its own parameter do
//! ([`Scene::with_sample_times`](crate::motion::Scene::with_sample_times)).

use crate::estimate::problem::{Arc, ArcSample, Beside, SampleOrder};

/// The orders of the samples of all arcs; `bounds` says whether an event has a time apart from those of
/// the samples.
pub(in crate::estimate) fn of_arcs(
    arcs: &[Arc],
    bounds: impl Fn(usize) -> bool,
) -> Vec<SampleOrder> {
    let mut orders = Vec::new();
    for (index, arc) in arcs.iter().enumerate() {
        for (track, samples) in arc.samples_as_read() {
            let mut add = |sample: &ArcSample, beside: Beside| {
                orders.push(SampleOrder {
                    arc: index,
                    track,
                    sample: *sample,
                    beside,
                });
            };
            if let (Some(first), Some(event)) = (samples.first(), arc.start)
                && first.open.is_some()
                && bounds(event)
            {
                add(first, Beside::Begin(event));
            }
            for pair in samples.windows(2) {
                if pair.iter().all(|sample| sample.open.is_some()) {
                    add(pair[0], Beside::Next(*pair[1]));
                }
            }
            if let (Some(last), Some(event)) = (samples.last(), arc.end)
                && last.open.is_some()
                && bounds(event)
            {
                add(last, Beside::End(event));
            }
        }
    }
    orders
}
