//! Marks made by a person are late or early; the centre of mass tells where the kink is.
//!
//! For each collision the mark is tried at every sample within reach, and put where the
//! ballistic fits of the two neighbouring segments leave least (`prefix.rs`).

use std::ops::RangeInclusive;

use super::cut::median_interval_s;
use super::prefix::PrefixSums;
use crate::motion::{Scene, Sketch, Timing};

/// Samples on either side of a mark that are tried.
const REACH_SAMPLES: usize = 8;
/// Acted time on either side that is tried where the tempo is unknown \[s\].
const REACH_S: f64 = 0.12;
/// The same where times are physical \[s\]: 8 samples at 120 Hz.
const REACH_KNOWN_S: f64 = 8.0 / 120.0;
/// Samples that must remain between two marks.
const KEEP_SAMPLES: usize = 5;
/// A mark moves for no less than this \[m²\], a tenth of a millimetre at one sample: below, sums
/// of clean data differ by rounding.
const GAIN_MIN_M2: f64 = 1e-8;
/// Rounds over all marks at most.
const ROUNDS_MAX: usize = 3;

/// Moves the marks of collisions in `sketch`; returns the number of rounds it took. The marks of
/// an edited sketch stand where its segments meet, and stay.
pub fn refine(scene: &Scene, sketch: &mut Sketch) -> usize {
    if scene.timing == Timing::Edited {
        return 0;
    }
    let events: Vec<usize> = (0..scene.events.len())
        .filter(|event| scene.events[*event].kind.collision().is_some())
        .collect();
    let sums: Vec<PrefixSums> = sketch
        .bodies
        .iter()
        .map(|body| PrefixSums::of_positions(scene, body))
        .collect();
    for round in 1..=ROUNDS_MAX {
        let mut moved = false;
        for event in &events {
            moved |= refine_one(scene, sketch, &sums, *event);
        }
        if !moved || events.len() == 1 {
            return round;
        }
    }
    ROUNDS_MAX
}

/// What lies between the events of a body that come before and after one that it takes part in.
struct Stretch {
    body: usize,
    begin: usize,
    end: usize,
}

impl Stretch {
    fn new(scene: &Scene, sketch: &Sketch, body: usize, event: usize) -> Self {
        let samples = &sketch.bodies[body].samples;
        let concerns = |other: &usize| scene.events[*other].kind.concerns(body);
        let index_at =
            |event: usize| samples.partition_point(|s| s.acted_s <= sketch.marks_s[event]);
        // What lies beside a neighbouring collision is left out, as it is in the cut.
        let beside = |other: usize| usize::from(scene.events[other].kind.collision().is_some());
        let mut before = (0..event).rev();
        let mut after = event + 1..scene.events.len();
        Self {
            body,
            begin: before.find(concerns).map_or(0, |e| index_at(e) + beside(e)),
            end: after
                .find(concerns)
                .map_or(samples.len(), |e| index_at(e).saturating_sub(beside(e))),
        }
    }

    /// Cuts that leave enough samples on either side.
    fn cuts(&self) -> RangeInclusive<usize> {
        self.begin + KEEP_SAMPLES..=self.end.saturating_sub(KEEP_SAMPLES)
    }

    /// What a cut leaves \[m²\]: the samples beside it are left out, as they are in the cut.
    fn cost(&self, sums: &PrefixSums, cut: usize) -> f64 {
        sums.cost(self.begin, cut - 1) + sums.cost(cut + 1, self.end)
    }
}

/// How far from the event a performer's mark may be \[s\].
pub(super) fn reach_s(scene: &Scene) -> f64 {
    match scene.timing {
        Timing::Known | Timing::Edited => REACH_KNOWN_S,
        Timing::Unknown { .. } => REACH_S,
    }
}

/// Moves one mark to the best place between the neighbouring events of its bodies.
fn refine_one(scene: &Scene, sketch: &mut Sketch, sums: &[PrefixSums], event: usize) -> bool {
    let Some(collision) = scene.events[event].kind.collision() else {
        return false;
    };
    let stretches: Vec<Stretch> = collision
        .bodies()
        .map(|body| Stretch::new(scene, sketch, body, event))
        .collect();
    let samples = &sketch.bodies[collision.body].samples;
    let interval_s = median_interval_s(sketch, collision.body).max(1e-9);
    let now = samples.partition_point(|s| s.acted_s <= sketch.marks_s[event]);
    let reach = REACH_SAMPLES.max((reach_s(scene) / interval_s).round() as usize);
    let cuts = stretches[0].cuts();
    let least = now.saturating_sub(reach).max(*cuts.start());
    let most = (now + reach).min(*cuts.end());
    // Between the last sample before and the first after.
    let time_s = |cut: usize| 0.5 * (samples[cut - 1].acted_s + samples[cut].acted_s);
    let cost = |cut: usize| -> f64 {
        let mut cost = stretches[0].cost(&sums[collision.body], cut);
        for stretch in &stretches[1..] {
            let others = &sketch.bodies[stretch.body].samples;
            let cut = others.partition_point(|s| s.acted_s <= time_s(cut));
            if !stretch.cuts().contains(&cut) {
                return f64::INFINITY;
            }
            cost += stretch.cost(&sums[stretch.body], cut);
        }
        cost
    };
    let Some(best) = (least..=most).min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else {
        return false;
    };
    let is_better = cost(best) < cost(now.clamp(least, most)) - GAIN_MIN_M2;
    if best == now || !is_better {
        return false;
    }
    sketch.marks_s[event] = time_s(best);
    true
}
