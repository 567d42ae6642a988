//! Leaves out what a contact that lasts shows: while a body presses on something it does not fly.
//!
//! Where the duration of a contact is free, samples from `a` to `b` near the mark are left out, so many that
//!
//! ```text
//! min over a ≤ b   (Σ_{i<a} |p_i − fit|² + Σ_{i≥b} |p_i − fit|²)/σ² + 3 k (b − a)
//! ```
//!
//! with the best flights on either side and the variance `σ²` of readings about them where all near the mark are left out.

use super::cut::median_interval_s;
use super::prefix::PrefixSums;
use crate::motion::{Quantity, Scene, Sketch, Timing, TrackIndex};

/// Longest contact that is looked for on either side of its mark \[s\].
const REACH_S: f64 = 0.2;
/// Greatest reach in samples.
const REACH_SAMPLES: usize = 200;
/// Least number of samples of a flight beside it.
const FLOWN_MIN: usize = 8;
/// Variances that a left out sample costs, `k`: it deviates from its flight by at least one and a half deviations in each
/// direction.
const DROPPED: f64 = 3.0;
/// Least variance of a reading \[m²\]: that of rounding.
const ROUNDING_M2: f64 = 1e-10;

/// Finds between which samples of a sketch contacts of free durations last, and moves their marks to where these begin.
pub fn press(scene: &Scene, sketch: &mut Sketch) {
    if scene.timing != Timing::Known {
        return;
    }
    for (event, of) in scene.events.iter().enumerate() {
        let Some(collision) = of.kind.collision() else {
            continue;
        };
        if !scene.frees(Quantity::ContactDuration { event }) {
            continue;
        }
        let mut tracks = scene.tracks_in(collision);
        let found = tracks.find_map(|track| pressed(scene, sketch, track, event));
        if let Some([touch_s, left_s]) = found {
            sketch.marks_s[event] = touch_s;
            sketch.contacts_s.insert(event, left_s - touch_s);
        }
    }
}

/// When what a track sees touches and comes off \[s, acted\]; `None` where too little of the flights beside it is seen.
fn pressed(scene: &Scene, sketch: &Sketch, track: TrackIndex, event: usize) -> Option<[f64; 2]> {
    let of = &sketch.tracks[track];
    let samples = &of.samples;
    samples.iter().find_map(|sample| sample.seen.position_m())?;
    let mechanism = scene.mechanism_seen_by(track);
    let interval_s = median_interval_s(of).max(1e-9);
    let index = |time_s: f64| samples.partition_point(|sample| sample.acted_s <= time_s);
    let concerns = |other: &usize| scene.concerns(*other, mechanism);
    let before = (0..event).rev().find(concerns);
    let after = (event + 1..scene.events.len()).find(concerns);
    let begin = before.map_or(0, |other| index(sketch.left_s(other) + interval_s));
    let end = after.map_or(samples.len(), |other| {
        index(sketch.marks_s[other] - interval_s)
    });
    let reach = ((REACH_S / interval_s) as usize).min(REACH_SAMPLES);
    let now = index(sketch.marks_s[event]);
    let least = now.saturating_sub(reach).max(begin + FLOWN_MIN);
    let most = (now + reach).min(end.checked_sub(FLOWN_MIN)?);
    if least > most {
        return None;
    }
    let sums = PrefixSums::of_positions(scene, track, of);
    let cost_m2 = |from: usize, to: usize| sums.cost(begin, from) + sums.cost(to, end);
    let count = (least - begin) + (end - most);
    let free = (3 * count) as f64 - 2.0 * sums.numbers() as f64;
    let variance_m2 = (cost_m2(least, most) / free.max(1.0)).max(ROUNDING_M2);
    let pairs = (least..=most).flat_map(|from| (from..=most).map(move |to| (from, to)));
    let unlikely = |(from, to): (usize, usize)| {
        cost_m2(from, to) / variance_m2 + 3.0 * DROPPED * (to - from) as f64
    };
    let (from, to) = pairs.min_by(|a, b| unlikely(*a).total_cmp(&unlikely(*b)))?;
    let between_s = |at: usize| 0.5 * (samples[at - 1].acted_s + samples[at].acted_s);
    Some([between_s(from), between_s(to)])
}
