//! Takes without some of their samples, and what was left out.

use enact::motion::{PoseSample, Stamp, TakeEvent};
use enact_tools::nonsense::Asked;

/// A take without some of its samples.
pub struct Split {
    /// What the estimation gets.
    pub kept: Asked,
    /// What it does not get.
    pub held: Vec<PoseSample>,
}

impl Split {
    /// Holds out the samples of which that is true; a mark after the last one that is kept comes to it.
    pub fn of(asked: &Asked, is_held: impl Fn(&PoseSample) -> bool) -> Self {
        let mut kept = asked.clone();
        let mut held = Vec::new();
        kept.events.retain(|event| match event {
            TakeEvent::Pose { sample, .. } if is_held(sample) => {
                held.push(*sample);
                false
            }
            _ => true,
        });
        if let Some(last) = stamps(&kept.events).max() {
            for event in &mut kept.events {
                if let TakeEvent::Mark(mark) = event {
                    mark.stamp = mark.stamp.min(last);
                }
            }
        }
        Self { kept, held }
    }

    /// Holds out the samples from one time to another [s since the first sample].
    pub fn between(asked: &Asked, from_s: f64, to_s: f64) -> Self {
        let zero = stamps(&asked.events).min().unwrap_or(Stamp(0));
        Self::of(asked, |sample| {
            (from_s..to_s).contains(&sample.stamp.seconds_since(zero))
        })
    }
}

/// Stamps of the samples.
fn stamps(events: &[TakeEvent]) -> impl Iterator<Item = Stamp> {
    events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    })
}
