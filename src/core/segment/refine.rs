//! Refines marks, which are late or early by reaction time, to the kink in the path of the centre
//! of mass.
//!
//! For each collision every sample within reach of the mark is tried as the cut `k`, and the one of
//! greatest likelihood is taken:
//!
//! ```text
//! min over k   ½ n ln Σ r²(k) + ½ (ν + 1) ln(1 + d²(k)/ν)
//! ```
//!
//! The first term is that of the residuals `r` of the ballistic fits of all segments (`prefix.rs`),
//! with an unknown variance; since the hand wanders, neighbouring residuals are correlated, and `n`
//! is the number of independent ones. The second is Student's t distribution with `ν` degrees of
//! freedom of the mark's error `d` in standard deviations: now and then a mark is off by far more
//! than that.

use std::ops::{Range, RangeInclusive};

use typed_index_collections::{TiSlice, TiVec};

use super::cut::median_interval_s;
use super::prefix::PrefixSums;
use crate::motion::{MarkTime, Scene, Sketch, Timing, TrackIndex, TrackSketch};

/// Reach in samples on either side of a mark.
const REACH_SAMPLES: usize = 8;
/// Reach in acted time where the tempo is unknown \[s\].
const REACH_S: f64 = 0.12;
/// Reach where times are physical \[s\]: 8 samples at 120 Hz.
const REACH_KNOWN_S: f64 = 8.0 / 120.0;
/// Least number of samples between two marks.
const KEEP_SAMPLES: usize = 5;
/// Added to the residual sum of squares of a cut \[m²\], a tenth of a millimetre at one sample:
/// below it, sums of clean data differ by rounding.
const ROUNDING_M2: f64 = 1e-8;
/// Least gain in the logarithm of the likelihood for which a mark moves.
const GAIN_MIN: f64 = 1e-3;
/// Residuals so far from each other are independent \[s\].
const APART_S: f64 = 10.0 / 120.0;
/// Degrees of freedom of Student's distribution of a mark's error.
const MARK_FREEDOM: f64 = 2.0;
/// A mark that is farther from its cut, in standard deviations, is wrong.
const FAR_DEVIATIONS: f64 = 4.0;
/// Greatest number of rounds over all marks.
const ROUNDS_MAX: usize = 3;

/// Moves the cuts at collisions in `sketch`; returns the number of rounds. The events of an edited
/// sketch are at the joints of its segments and stay.
pub fn refine(scene: &Scene, sketch: &mut Sketch) -> usize {
    if scene.timing == Timing::Edited {
        return 0;
    }
    let events: Vec<usize> = (0..scene.events.len())
        .filter(|event| scene.jolts(*event))
        // A fixed time is that of the mark as it was made.
        .filter(|event| scene.time_is_free(*event))
        .collect();
    let tracks = sketch.tracks.iter_enumerated();
    let sums = tracks.map(|(index, track)| PrefixSums::of_positions(scene, index, track));
    let sums: TiVec<TrackIndex, PrefixSums> = sums.collect();
    let left_m2 = sums.iter_enumerated();
    let left_m2 = left_m2.map(|(track, sums)| left_m2_of(scene, sketch, sums, track));
    let mut left_m2: TiVec<TrackIndex, f64> = left_m2.collect();
    let mut rounds = 0;
    let mut moved = true;
    while moved && rounds < ROUNDS_MAX {
        moved = false;
        for event in &events {
            moved |= refine_one(scene, sketch, &sums, &mut left_m2, *event);
        }
        rounds += 1;
        moved &= events.len() > 1;
    }
    rounds
}

/// Residual sum of squares of all flights of a track, with the cuts of the sketch \[m²\].
fn left_m2_of(scene: &Scene, sketch: &Sketch, sums: &PrefixSums, track: TrackIndex) -> f64 {
    let samples = &sketch.tracks[track].samples;
    let mechanism = scene.mechanism_seen_by(track);
    let (mut left_m2, mut begin) = (0.0, 0);
    for event in 0..scene.events.len() {
        if scene.concerns(event, mechanism) {
            let at = samples.partition_point(|s| s.acted_s <= sketch.marks_s[event]);
            let beside = usize::from(scene.jolts(event));
            let ends = scene.phase_beside(mechanism, event, false);
            left_m2 += sums.cost_of(begin, at.saturating_sub(beside), ends.is_some());
            begin = (at + beside).min(samples.len());
        }
    }
    // Every phase ends at an event.
    left_m2 + sums.cost(begin, samples.len())
}

/// Enlarges the standard deviations `σ` of marks to `σ √((ν + d²)/(ν + 1))`, at least `σ`: at the
/// cut, the gradient of a normal distribution then equals that of Student's. Removes marks that are
/// far from their cut.
/// Marks with bounds relative to them stay as they are.
pub fn loosen(scene: &Scene, sketch: &mut Sketch) {
    let marks = sketch.marks.iter_mut().zip(&sketch.marks_s);
    for ((mark, cut_s), event) in marks.zip(&scene.events) {
        if event.time.is_bounded() {
            continue;
        }
        *mark = mark.and_then(|mark| {
            let deviations = (cut_s - mark.acted_s) / mark.sd_s;
            (deviations.abs() <= FAR_DEVIATIONS).then(|| MarkTime {
                sd_s: mark.sd_s * student_sd(deviations),
                ..mark
            })
        });
    }
}

/// Minus the logarithm of the likelihood of a mark whose event is at `acted_s`, up to a constant:
/// `½ (ν + 1) ln(1 + d²/ν)`.
pub(super) fn unlikely_mark(mark: &MarkTime, acted_s: f64) -> f64 {
    let deviations = (acted_s - mark.acted_s) / mark.sd_s;
    0.5 * (MARK_FREEDOM + 1.0) * (deviations * deviations / MARK_FREEDOM).ln_1p()
}

/// Minus the logarithm of the likelihood of residuals with a sum of squares, in any unit, up to a
/// constant: `½ n ln Σr²`.
pub(super) fn unlikely_residuals(track: &TrackSketch, square: f64) -> f64 {
    let alike = (APART_S / median_interval_s(track)).max(1.0);
    0.5 * track.samples.len() as f64 / alike * square.ln()
}

/// Standard deviation of the normal distribution with the same gradient as Student's at `d`, at
/// least one: `√((ν + d²)/(ν + 1))`.
fn student_sd(deviations: f64) -> f64 {
    let square = (MARK_FREEDOM + deviations * deviations) / (MARK_FREEDOM + 1.0);
    square.max(1.0).sqrt()
}

/// The samples of a track between the events before and after some collisions, which follow each
/// other so closely that no flight between them can be fitted. A cut is that at the first of them.
struct Stretch {
    track: TrackIndex,
    begin: usize,
    end: usize,
    /// Number of samples between the first of the collisions and the last.
    span: usize,
    /// Whether a surface carries what is seen, before and after.
    carries: [bool; 2],
}

impl Stretch {
    fn new(scene: &Scene, sketch: &Sketch, track: TrackIndex, events: &[usize]) -> Self {
        let samples = &sketch.tracks[track].samples;
        let mechanism = scene.mechanism_seen_by(track);
        let concerns = |other: &usize| scene.concerns(*other, mechanism);
        let index_at = |event: usize| cut_at(sketch, track, event);
        let (first, last) = (events[0], events[events.len() - 1]);
        // Samples beside a neighbouring collision are left out, as in the cut.
        let beside = |other: usize| usize::from(scene.jolts(other));
        let mut before = (0..first).rev();
        let mut after = last + 1..scene.events.len();
        let begin = before.find(concerns).map_or(0, |e| index_at(e) + beside(e));
        Self {
            track,
            begin: begin.min(samples.len()),
            end: after
                .find(concerns)
                .map_or(samples.len(), |e| index_at(e).saturating_sub(beside(e))),
            span: index_at(last).saturating_sub(index_at(first)),
            carries: [(first, false), (last, true)].map(|(event, is_after)| {
                let phase = scene.phase_beside(mechanism, event, is_after);
                phase.is_some()
            }),
        }
    }

    /// Cuts that leave enough samples on either side.
    fn cuts(&self) -> RangeInclusive<usize> {
        let most = self.end.saturating_sub(KEEP_SAMPLES + self.span);
        self.begin + KEEP_SAMPLES..=most
    }

    /// Residual sum of squares with a cut \[m²\]; the samples beside it are left out.
    fn cost(&self, sums: &PrefixSums, cut: usize) -> f64 {
        let [before, after] = self.flights(cut);
        let [slides, stays] = self.carries;
        sums.cost_of(before.start, before.end, slides) + sums.cost_of(after.start, after.end, stays)
    }

    fn flights(&self, cut: usize) -> [Range<usize>; 2] {
        let next = cut + self.span + 1;
        [
            self.begin..cut.saturating_sub(1).max(self.begin),
            next.min(self.end)..self.end,
        ]
    }
}

/// The first sample of a track after an event's mark.
fn cut_at(sketch: &Sketch, track: TrackIndex, event: usize) -> usize {
    let samples = &sketch.tracks[track].samples;
    samples.partition_point(|s| s.acted_s <= sketch.marks_s[event])
}

/// A collision and those after it that follow so closely, one after the other, that no flight
/// between them can be fitted; empty where it follows another one so itself. Collisions of several
/// tracks are each by itself.
fn close_events(scene: &Scene, sketch: &Sketch, event: usize) -> Vec<usize> {
    let track_of = |event: usize| {
        let mut tracks = scene.tracks_jolted(event).into_iter();
        tracks.next().filter(|_| tracks.next().is_none())
    };
    let Some(track) = track_of(event) else {
        return vec![event];
    };
    let mechanism = scene.mechanism_seen_by(track);
    let concerns = |other: &usize| scene.concerns(*other, mechanism);
    let is_close = |before: usize, after: usize| {
        let [from, to] = [before, after].map(|event| cut_at(sketch, track, event));
        let both = [before, after].map(track_of);
        both == [Some(track); 2] && to < from + KEEP_SAMPLES
    };
    if (0..event)
        .rev()
        .find(concerns)
        .is_some_and(|before| is_close(before, event))
    {
        return Vec::new();
    }
    let mut close = vec![event];
    for next in (event + 1..scene.events.len()).filter(concerns) {
        if !is_close(close[close.len() - 1], next) {
            break;
        }
        close.push(next);
    }
    close
}

/// Greatest distance of a performer's mark from its event \[s\].
pub(super) fn reach_s(scene: &Scene) -> f64 {
    match scene.timing {
        Timing::Known | Timing::Edited => REACH_KNOWN_S,
        Timing::Unknown { .. } => REACH_S,
    }
}

/// Moves the mark of a collision, and of those that follow it closely, to the best place between
/// the neighbouring events of its tracks. Marks of close collisions keep their distances.
fn refine_one(
    scene: &Scene,
    sketch: &mut Sketch,
    sums: &TiSlice<TrackIndex, PrefixSums>,
    left_m2: &mut TiSlice<TrackIndex, f64>,
    event: usize,
) -> bool {
    let close = close_events(scene, sketch, event);
    if close.is_empty() {
        return false;
    }
    let tracks = scene.tracks_jolted(event).into_iter();
    let stretches = tracks.map(|track| Stretch::new(scene, sketch, track, &close));
    let stretches: Vec<Stretch> = stretches.collect();
    let Some(first) = stretches.first().map(|stretch| stretch.track) else {
        return false;
    };
    let samples = &sketch.tracks[first].samples;
    let interval_s = median_interval_s(&sketch.tracks[first]).max(1e-9);
    let Some(last_cut) = samples.len().checked_sub(1).filter(|last| *last > 0) else {
        return false;
    };
    // Marks of keyframes are on the right side of each.
    if stretches
        .iter()
        .any(|stretch| scene.has_keyframes(sketch, stretch.track))
    {
        return false;
    }
    let now = cut_at(sketch, first, event).clamp(1, last_cut);
    let reach = REACH_SAMPLES.max((reach_s(scene) / interval_s).round() as usize);
    let cuts = stretches[0].cuts();
    // Beside a flight of a few samples fits say nothing of the mark.
    if !cuts.contains(&now) {
        return false;
    }
    let least = now.saturating_sub(reach).max(*cuts.start()).max(1);
    let most = (now + reach).min(*cuts.end()).min(last_cut);
    // The middle between the last sample before the cut and the first after it.
    let time_s = |cut: usize| 0.5 * (samples[cut - 1].acted_s + samples[cut].acted_s);
    let others_cut = |stretch: &Stretch, cut: usize| {
        if stretch.track == first {
            return cut;
        }
        let others = &sketch.tracks[stretch.track].samples;
        others.partition_point(|s| s.acted_s <= time_s(cut))
    };
    let cost_m2 = |stretch: &Stretch, cut: usize| {
        let cut = others_cut(stretch, cut);
        let fits = stretch.cuts().contains(&cut);
        fits.then(|| stretch.cost(&sums[stretch.track], cut))
    };
    let now_m2: Vec<f64> = stretches
        .iter()
        .map(|stretch| cost_m2(stretch, now).unwrap_or(0.0))
        .collect();
    let marks_off = |cut: usize| -> f64 {
        let marks = close.iter().filter_map(|close| {
            let mark = sketch.marks[*close]?;
            let cut = (cut + cut_at(sketch, first, *close)).saturating_sub(now);
            let cut = cut.clamp(1, last_cut);
            // Between its two samples a cut may be anywhere.
            let [from_s, to_s] = [cut - 1, cut].map(|sample| samples[sample].acted_s);
            Some(unlikely_mark(&mark, mark.acted_s.clamp(from_s, to_s)))
        });
        marks.sum()
    };
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
        sum + marks_off(cut)
    };
    let Some(best) = (least..=most).min_by(|a, b| unlikely(*a).total_cmp(&unlikely(*b))) else {
        return false;
    };
    // Where no cut leaves enough samples, all are infinite and the mark stays.
    if best == now || !(unlikely(best) < unlikely(now) - GAIN_MIN) {
        return false;
    }
    for (stretch, now_m2) in stretches.iter().zip(&now_m2) {
        let best_m2 = cost_m2(stretch, best).unwrap_or(*now_m2);
        left_m2[stretch.track] += best_m2 - now_m2;
    }
    let best_s = time_s(best);
    let first_s = sketch.marks_s[event];
    // No farther than to the cut.
    let [from_s, to_s] = [best - 1, best].map(|sample| samples[sample].acted_s);
    let shift_s = first_s.clamp(from_s, to_s - 1e-3 * (to_s - from_s)) - first_s;
    match close.as_slice() {
        [event] => sketch.marks_s[*event] = best_s,
        close => close
            .iter()
            .for_each(|event| sketch.marks_s[*event] += shift_s),
    }
    true
}
