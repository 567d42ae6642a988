//! Marks are late or early; the centre of mass tells where the kink is.
//!
//! For each collision the mark is tried at every sample within reach, and the stream is cut where
//! two things together are likeliest: what the ballistic fits of all segments leave (`prefix.rs`), and how
//! far that is from the mark. The hand wanders, so that residuals of neighbouring samples are alike:
//! they are worth few independent ones, of a size that is not known, and the logarithm of their
//! likelihood is `−½ n ln Σr²` with `n` so many. A mark is off by its standard deviation, and now and
//! then by far more: Student's distribution.

use std::ops::RangeInclusive;

use typed_index_collections::{TiSlice, TiVec};

use super::cut::median_interval_s;
use super::prefix::PrefixSums;
use crate::motion::{MarkTime, Scene, Sketch, Timing, TrackIndex, TrackSketch};

/// Samples on either side of a mark that are tried.
const REACH_SAMPLES: usize = 8;
/// Acted time on either side that is tried where the tempo is unknown \[s\].
const REACH_S: f64 = 0.12;
/// The same where times are physical \[s\]: 8 samples at 120 Hz.
const REACH_KNOWN_S: f64 = 8.0 / 120.0;
/// Samples that must remain between two marks.
const KEEP_SAMPLES: usize = 5;
/// Added to what a cut leaves \[m²\], a tenth of a millimetre at one sample: below, sums of clean
/// data differ by rounding.
const ROUNDING_M2: f64 = 1e-8;
/// A mark moves for no less than this, in the logarithm of the likelihood.
const GAIN_MIN: f64 = 1e-3;
/// So many samples of a hand that wanders are worth one independent one.
const SAMPLES_ALIKE: f64 = 10.0;
/// Degrees of freedom of Student's distribution of a mark's error.
const MARK_FREEDOM: f64 = 2.0;
/// A cut that is farther from its mark says that the mark is wrong.
const FAR_DEVIATIONS: f64 = 4.0;
/// Rounds over all marks at most.
const ROUNDS_MAX: usize = 3;

/// Moves the cuts at collisions in `sketch`; returns the number of rounds it took. The events of an
/// edited sketch stand where its segments meet, and stay.
pub fn refine(scene: &Scene, sketch: &mut Sketch) -> usize {
    if scene.timing == Timing::Edited {
        return 0;
    }
    let events: Vec<usize> = (0..scene.events.len())
        .filter(|event| scene.events[*event].kind.collision().is_some())
        .collect();
    let tracks = sketch.tracks.iter();
    let sums = tracks.map(|track| PrefixSums::of_positions(scene, track));
    let sums: TiVec<TrackIndex, PrefixSums> = sums.collect();
    let left_m2 = sums.iter_enumerated();
    let left_m2 = left_m2.map(|(track, sums)| left_m2_of(scene, sketch, sums, track));
    let mut left_m2: TiVec<TrackIndex, f64> = left_m2.collect();
    let mut rounds = 0;
    let mut moved = true;
    while moved && rounds < ROUNDS_MAX {
        moved = false;
        for event in &events {
            moved |= refine_one(scene, sketch, (&sums, &mut left_m2), *event);
        }
        rounds += 1;
        moved &= events.len() > 1;
    }
    rounds
}

/// What the flights that a track sees leave in all, cut as the sketch is \[m²\].
fn left_m2_of(scene: &Scene, sketch: &Sketch, sums: &PrefixSums, track: TrackIndex) -> f64 {
    let samples = &sketch.tracks[track].samples;
    let mechanism = scene.mechanism_seen_by(track);
    let (mut left_m2, mut begin) = (0.0, 0);
    for (event, of) in scene.events.iter().enumerate() {
        if scene.concerns(event, mechanism) {
            let at = samples.partition_point(|s| s.acted_s <= sketch.marks_s[event]);
            let beside = usize::from(of.kind.collision().is_some());
            left_m2 += sums.cost(begin, at.saturating_sub(beside));
            begin = (at + beside).min(samples.len());
        }
    }
    left_m2 + sums.cost(begin, samples.len())
}

/// Makes the deviations of marks as large as the cuts say that they are: a normal distribution then
/// pulls at an event as much as Student's does at the cut. Marks that are far from the cut are none.
pub fn loosen(sketch: &mut Sketch) {
    for (mark, cut_s) in sketch.marks.iter_mut().zip(&sketch.marks_s) {
        *mark = mark.and_then(|mark| {
            let deviations = (cut_s - mark.acted_s) / mark.sd_s;
            (deviations.abs() <= FAR_DEVIATIONS).then(|| MarkTime {
                sd_s: mark.sd_s * student_sd(deviations),
                ..mark
            })
        });
    }
}

/// Minus the logarithm of the likelihood of a mark whose event is at `acted_s`.
pub(super) fn unlikely_mark(mark: &MarkTime, acted_s: f64) -> f64 {
    let deviations = (acted_s - mark.acted_s) / mark.sd_s;
    0.5 * (MARK_FREEDOM + 1.0) * (deviations * deviations / MARK_FREEDOM).ln_1p()
}

/// The same of residuals that leave that sum of squares, in any unit.
pub(super) fn unlikely_residuals(track: &TrackSketch, square: f64) -> f64 {
    0.5 * track.samples.len() as f64 / SAMPLES_ALIKE * square.ln()
}

/// The standard deviation of the normal distribution that pulls as much as Student's does there, where
/// that is more than one.
fn student_sd(deviations: f64) -> f64 {
    let square = (MARK_FREEDOM + deviations * deviations) / (MARK_FREEDOM + 1.0);
    square.max(1.0).sqrt()
}

/// What of a track lies between the events of its mechanism that come before and after one that it
/// takes part in.
struct Stretch {
    track: TrackIndex,
    begin: usize,
    end: usize,
}

impl Stretch {
    fn new(scene: &Scene, sketch: &Sketch, track: TrackIndex, event: usize) -> Self {
        let samples = &sketch.tracks[track].samples;
        let mechanism = scene.mechanism_seen_by(track);
        let concerns = |other: &usize| scene.concerns(*other, mechanism);
        let index_at =
            |event: usize| samples.partition_point(|s| s.acted_s <= sketch.marks_s[event]);
        // What lies beside a neighbouring collision is left out, as it is in the cut.
        let beside = |other: usize| usize::from(scene.events[other].kind.collision().is_some());
        let mut before = (0..event).rev();
        let mut after = event + 1..scene.events.len();
        Self {
            track,
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

/// Moves one mark to the best place between the neighbouring events of its tracks.
fn refine_one(
    scene: &Scene,
    sketch: &mut Sketch,
    (sums, left_m2): (
        &TiSlice<TrackIndex, PrefixSums>,
        &mut TiSlice<TrackIndex, f64>,
    ),
    event: usize,
) -> bool {
    let Some(collision) = scene.events[event].kind.collision() else {
        return false;
    };
    let tracks = scene.tracks_in(collision);
    let stretches = tracks.map(|track| Stretch::new(scene, sketch, track, event));
    let stretches: Vec<Stretch> = stretches.collect();
    let Some(first) = stretches.first().map(|stretch| stretch.track) else {
        return false;
    };
    let samples = &sketch.tracks[first].samples;
    let interval_s = median_interval_s(&sketch.tracks[first]).max(1e-9);
    let now = samples.partition_point(|s| s.acted_s <= sketch.marks_s[event]);
    let reach = REACH_SAMPLES.max((reach_s(scene) / interval_s).round() as usize);
    let cuts = stretches[0].cuts();
    let least = now.saturating_sub(reach).max(*cuts.start());
    let most = (now + reach).min(*cuts.end());
    // Between the last sample before and the first after.
    let time_s = |cut: usize| 0.5 * (samples[cut - 1].acted_s + samples[cut].acted_s);
    let mark = sketch.marks[event];
    let cost_m2 = |stretch: &Stretch, cut: usize| {
        let is_first = stretch.track == first;
        let of_other = || {
            let others = &sketch.tracks[stretch.track].samples;
            others.partition_point(|s| s.acted_s <= time_s(cut))
        };
        let cut = if is_first { cut } else { of_other() };
        stretch
            .cuts()
            .contains(&cut)
            .then(|| stretch.cost(&sums[stretch.track], cut))
    };
    let now_m2: Vec<f64> = stretches
        .iter()
        .map(|stretch| cost_m2(stretch, now).unwrap_or(0.0))
        .collect();
    // Minus the logarithm of the likelihood, up to a constant.
    let unlikely = |cut: usize| -> f64 {
        let mut sum = 0.0;
        for (stretch, now_m2) in stretches.iter().zip(&now_m2) {
            let Some(cost_m2) = cost_m2(stretch, cut) else {
                return f64::INFINITY;
            };
            let others_m2 = (left_m2[stretch.track] - now_m2).max(0.0);
            let all_m2 = others_m2 + cost_m2 + ROUNDING_M2;
            sum += unlikely_residuals(&sketch.tracks[stretch.track], all_m2);
        }
        sum + mark.map_or(0.0, |mark| {
            // Between its two samples a cut may be anywhere.
            let [from_s, to_s] = [cut - 1, cut].map(|sample| samples[sample].acted_s);
            unlikely_mark(&mark, mark.acted_s.clamp(from_s, to_s))
        })
    };
    let Some(best) = (least..=most).min_by(|a, b| unlikely(*a).total_cmp(&unlikely(*b))) else {
        return false;
    };
    // A cut that leaves no room is no better than any other.
    if best == now || !(unlikely(best) < unlikely(now) - GAIN_MIN) {
        return false;
    }
    for (stretch, now_m2) in stretches.iter().zip(&now_m2) {
        left_m2[stretch.track] += cost_m2(stretch, best).unwrap_or(*now_m2) - now_m2;
    }
    sketch.marks_s[event] = time_s(best);
    true
}
