//! Moves the marks at which a hand lets go of a body, or takes it, to where its tracker shows that.
//!
//! Until a body is let go, its tracker moves as a hand does, with white jerk, and from then on it flies. Every sample near
//! the mark is tried as the first of the flight, and the cut `k` of greatest likelihood is taken:
//!
//! ```text
//! min over k   ½ Σ_{i<k} (log|S_i| + eᵢᵀ S_i⁻¹ eᵢ)  +  ½ Σ_{i≥k} (3 log r + |p_i − fit|²/r)  +  mark
//! ```
//!
//! with the innovations `e` of the hand's filter and their covariances `S`, the variance `r` of a reading, the best flight
//! through the rest, and the mark's error as in [`refine`](super::refine). Where a body is taken, time runs backward.
//!
//! Its deviation is that of all cuts about it, each with its likelihood; the estimate's own is that of one cut.
//!
//! A performer who acts the flight holds the body all the time: then it does not fly as exactly as the tracker sees, and
//! the mark stays.

use super::cut::median_interval_s;
use super::prefix::PrefixSums;
use super::refine::{reach_s, unlikely_mark};
use super::smooth::{SAMPLES_MIN, surprises};
use crate::math::Pose;
use crate::motion::{InHand, Sample, Scene, Sketch, Timing};

/// Least number of samples of the flight beyond the reach.
const FLOWN_MIN: usize = 6;

/// A flight is seen exactly if what it leaves is so many times the variance of a reading at most.
const EXACT: f64 = 9.0;

/// Moves the marks of a sketch.
pub fn regrip(scene: &Scene, sketch: &mut Sketch) {
    if scene.timing == Timing::Edited {
        return;
    }
    for phase in &scene.phases {
        let mechanism = scene.mechanism_of(phase.link);
        let own = scene.seen_in_hand(phase);
        let Some(hand) = own.filter(|_| scene.moves(mechanism)) else {
            continue;
        };
        for (side, event) in phase.events.into_iter().enumerate() {
            let is_release = side == 1;
            let flies = scene.phase_beside(mechanism, event, is_release).is_none();
            let is_change = scene.events[event].kind.change().is_some();
            if !flies || !is_change || !scene.time_is_free(event) {
                continue;
            }
            let other = phase.events[1 - side];
            let mut others = (0..scene.events.len()).filter(|of| scene.concerns(*of, mechanism));
            let flown_to = match is_release {
                true => others.find(|of| *of > event),
                false => others.take_while(|of| *of < event).last(),
            };
            if let Some(flown_to) = flown_to
                && let Some(cut) = cut(scene, sketch, hand, [other, event, flown_to])
            {
                sketch.marks_s[event] = cut.time_s;
                sketch.cuts_sd_s.insert(event, cut.sd_s);
            }
        }
    }
}

/// A cut between the hand's motion and the flight.
struct GripCut {
    /// Where it is best \[s\].
    time_s: f64,
    /// How far others are from it, each as likely as the samples say \[s\].
    sd_s: f64,
}

/// The best cut between the hand's motion and the flight; the events are those at which the hand's motion begins
/// or ends, the cut, and the other end of the flight. `None` where nothing shows that.
fn cut(scene: &Scene, sketch: &Sketch, hand: &InHand, events: [usize; 3]) -> Option<GripCut> {
    let of = &sketch.tracks[hand.track];
    let interval_s = median_interval_s(of).max(1e-9);
    let [far_s, mark_s, end_s] = events.map(|event| sketch.marks_s[event]);
    let is_release = far_s < end_s;
    // Beside the other ends a sample may belong to either side, and where a mark of another change is, for longer.
    let beside_s = |event: usize| match &scene.events[event].kind {
        kind if kind.collision().is_some() => interval_s,
        kind if kind.change().is_some() => {
            let halfway_s = 0.5 * (sketch.marks_s[event] - mark_s).abs();
            reach_s(scene).min(halfway_s)
        }
        _ => 0.0,
    };
    let [far_by_s, end_by_s] = [events[0], events[2]].map(beside_s);
    let [first_s, last_s] = match is_release {
        true => [far_s + far_by_s, end_s - end_by_s],
        false => [end_s + end_by_s, far_s - far_by_s],
    };
    let first = of.samples.partition_point(|of| of.acted_s < first_s);
    let last = of.samples.partition_point(|of| of.acted_s <= last_s);
    let samples = of.samples.get(first..last)?;
    let count = samples.len();
    let now = samples.partition_point(|of| of.acted_s <= mark_s);
    let reach = (reach_s(scene) / interval_s).round() as usize;
    // Along the way from the hand into the flight.
    let along = |cut: usize| if is_release { cut } else { count - cut };
    let (least, most) = (along(now).saturating_sub(reach), along(now) + reach);
    let (least, most) = (
        least.max(SAMPLES_MIN),
        most.min(count.checked_sub(FLOWN_MIN)?),
    );
    if least >= most {
        return None;
    }
    let ordered: Vec<&Sample> = match is_release {
        true => samples.iter().collect(),
        false => samples.iter().rev().collect(),
    };
    let places = ordered.iter().map(|of| {
        let place = of.seen.position_m().zip(of.seen.orientation());
        place.map(|(place_m, turn)| Pose::from_parts(place_m.into(), turn) * hand.link_from_tracker)
    });
    let places: Vec<Pose> = places.collect::<Option<_>>()?;
    let sign = if is_release { 1.0 } else { -1.0 };
    let timed = ordered.iter().zip(&places);
    let timed = timed.map(|(of, pose)| (sign * of.acted_s, pose.translation.vector));
    let timed: Vec<_> = timed.collect();
    let (noise_m2, held) = surprises(&timed, least, interval_s);
    let sums = PrefixSums::of_positions(scene, hand.track, of);
    let flown_m2 = |cut: usize| match is_release {
        true => sums.cost(first + cut, last),
        false => sums.cost(first, last - cut),
    };
    let numbers = |cut: usize| (3 * (count - cut)) as f64;
    let free = numbers(most) - sums.numbers() as f64;
    let left_m2 = flown_m2(most) / free.max(1.0);
    if left_m2 > EXACT * noise_m2 {
        return None;
    }
    let variance_m2 = left_m2.max(noise_m2);
    let time_s = |cut: usize| 0.5 * (ordered[cut - 1].acted_s + ordered[cut].acted_s);
    let unlikely = |cut: usize| {
        let flown = numbers(cut) * variance_m2.ln() + flown_m2(cut) / variance_m2;
        let mark = sketch.marks[events[1]].map_or(0.0, |mark| unlikely_mark(&mark, time_s(cut)));
        0.5 * (held[cut] + flown) + mark
    };
    let each: Vec<(f64, f64)> = (least..=most)
        .map(|cut| (time_s(cut), unlikely(cut)))
        .collect();
    let (best_s, fewest) = *each.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let weights = each.iter().map(|(_, unlikely)| (fewest - unlikely).exp());
    let square_s2 = each.iter().zip(weights.clone());
    let square_s2: f64 = square_s2
        .map(|((time_s, _), weight)| weight * (time_s - best_s).powi(2))
        .sum();
    Some(GripCut {
        time_s: best_s,
        sd_s: (square_s2 / weights.sum::<f64>()).sqrt(),
    })
}
