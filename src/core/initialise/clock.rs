//! Corrects the uneven tempo of a flight by the body's rotation.
//!
//! The angular speed of a body with two or three equal moments is constant in free flight
//! (`|ω|² = ω_a² + |ω_t|²`, both terms of which are constant), so that its angle of rotation is
//! proportional to physical time. With a fast spin, a tempo that is off by tens of milliseconds
//! puts the orientation a whole turn off, from where no solver returns; these times start it at the
//! right turn.

use nalgebra::UnitQuaternion;

use crate::motion::{Scene, Segment, Sketch};
use crate::physics::body::Symmetry;

/// Angle over which a speed is measured \[rad\]: large relative to a hand's wander, and less than
/// half a turn, which would be ambiguous.
const CHORD_RAD: f64 = 0.8;
/// Angle \[rad\] at which clock and acted time have equal weight: a hand's wander in that time.
const BELIEVED_RAD: f64 = 0.3;
/// Angle between neighbours \[rad\] beyond which the direction of rotation is ambiguous.
const ALIASED_RAD: f64 = 2.0;
/// Least number of samples of a flight.
const SAMPLES_MIN: usize = 8;
/// A window that lasts so many times its share of the flight contains a gap, in which the rotation
/// is unknown.
const GAP: f64 = 2.0;
/// Least and greatest rate of the clock relative to its mean.
const RATES: (f64, f64) = (0.2, 5.0);

/// The sketch with acted times replaced by times in which its bodies rotate evenly. Between two
/// collisions the body that turns most is used. Every flight keeps its first and its last time.
pub fn even(scene: &Scene, sketch: &Sketch, segments: &[Segment]) -> Sketch {
    let mut tellers: Vec<(f64, Vec<f64>, Vec<f64>)> = Vec::new();
    for view in segments.iter().flat_map(|segment| &segment.views) {
        let mechanism = scene.mechanism_seen_by(view.track);
        let body = scene.body_of(mechanism);
        let samples = sketch.samples_of(view).iter();
        let samples = samples.filter_map(|of| Some((of.acted_s, of.seen.orientation()?)));
        let turns: Vec<Turn> = samples.collect();
        if body.symmetry() != Symmetry::Asymmetric
            && let Some((turned_rad, clock_s)) = clock(&turns)
        {
            let times_s = turns.iter().map(|(acted_s, _)| *acted_s);
            tellers.push((turned_rad, times_s.collect(), clock_s));
        }
    }
    tellers.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut map: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    let last_s = |times_s: &[f64]| times_s[times_s.len() - 1];
    for (_, times_s, clock_s) in tellers {
        let is_apart = |(other_s, _): &(Vec<f64>, Vec<f64>)| {
            last_s(&times_s) <= other_s[0] || last_s(other_s) <= times_s[0]
        };
        if map.iter().all(is_apart) {
            map.push((times_s, clock_s));
        }
    }
    map.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let at = |acted_s: f64| {
        let begun = map.partition_point(|(times_s, _)| times_s[0] < acted_s);
        let last = begun.checked_sub(1).map(|last| &map[last]);
        last.filter(|(times_s, _)| acted_s < last_s(times_s))
            .map_or(acted_s, |(times_s, clock_s)| {
                let after = times_s.partition_point(|time_s| *time_s <= acted_s);
                let (from_s, to_s) = (times_s[after - 1], times_s[after]);
                let share = (acted_s - from_s) / (to_s - from_s);
                clock_s[after - 1] + share * (clock_s[after] - clock_s[after - 1])
            })
    };
    let mut evened = sketch.clone();
    for sample in evened
        .tracks
        .iter_mut()
        .flat_map(|track| &mut track.samples)
    {
        sample.acted_s = at(sample.acted_s);
    }
    evened
        .marks_s
        .iter_mut()
        .for_each(|mark_s| *mark_s = at(*mark_s));
    evened
}

/// An orientation at an acted time \[s, world from body\].
type Turn = (f64, UnitQuaternion<f64>);

/// The body's total angle \[rad\], and the clock's times of `samples`; `None` where they are too
/// few or too far apart.
fn clock(samples: &[Turn]) -> Option<(f64, Vec<f64>)> {
    let count = samples.len();
    if count < SAMPLES_MIN {
        return None;
    }
    let span_s = samples[count - 1].0 - samples[0].0;
    let mean_step_s = span_s / (count - 1) as f64;
    let speeds = |stride: usize| Speeds::new(samples, stride, mean_step_s);
    let mut found = speeds(1)?;
    if found.chord_rad > ALIASED_RAD {
        return None;
    }
    while 4 * found.stride <= count && found.chord_rad < CHORD_RAD {
        // A chord is at most as long as its parts together, which gives the least number of parts.
        let at_least = found.stride as f64 * (CHORD_RAD / found.chord_rad).min(count as f64);
        let more = found.stride + (found.stride / 16).max(1);
        found = speeds(more.max(at_least as usize).min(count / 4 + 1))?;
    }
    let square = found.chord_rad * found.chord_rad;
    let believed = square / (square + BELIEVED_RAD * BELIEVED_RAD);
    let mut clock_s = vec![0.0];
    for step in 0..count - 1 {
        let ratio = found.at(step).map_or(1.0, |speed| speed / found.mean_rad_s);
        let rate = ratio.powf(believed).clamp(RATES.0, RATES.1);
        let acted_s = samples[step + 1].0 - samples[step].0;
        clock_s.push(clock_s[step] + rate * acted_s);
    }
    let scale = span_s / clock_s[count - 1];
    for at_s in &mut clock_s {
        *at_s = samples[0].0 + scale * *at_s;
    }
    Some((found.mean_rad_s * span_s, clock_s))
}

/// Angular speeds over windows of samples.
struct Speeds {
    /// Number of sampling intervals of a window.
    stride: usize,
    /// Speed from every sample that begins a window without a gap [rad/s, acted time].
    from: Vec<Option<f64>>,
    /// Mean speed.
    mean_rad_s: f64,
    /// Mean angle in a window.
    chord_rad: f64,
}

impl Speeds {
    /// `None` where every window has a gap.
    fn new(samples: &[Turn], stride: usize, mean_step_s: f64) -> Option<Self> {
        let longest_s = GAP * stride as f64 * mean_step_s;
        let (mut turned_rad, mut lasted_s, mut windows) = (0.0, 0.0, 0.0);
        let from = samples.iter().zip(&samples[stride..]);
        let from = from.map(|(from, to)| {
            let window_s = to.0 - from.0;
            (window_s < longest_s).then(|| {
                let chord_rad = from.1.angle_to(&to.1);
                turned_rad += chord_rad;
                lasted_s += window_s;
                windows += 1.0;
                chord_rad / window_s
            })
        });
        let from = from.collect();
        (windows > 0.0).then(|| Self {
            stride,
            from,
            mean_rad_s: turned_rad / lasted_s,
            chord_rad: turned_rad / windows,
        })
    }

    /// Speed over the window about a step.
    fn at(&self, step: usize) -> Option<f64> {
        let first = (step + 1).saturating_sub(self.stride.div_ceil(2));
        self.from[first.min(self.from.len() - 1)]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::math::so3;
    use crate::physics::Body;
    use crate::physics::flow::Spin;

    /// A flight at 120 Hz, acted 2.5 times too slowly in a tempo that wavers by a third, with a
    /// wander of 5°; each sample beside its physical time.
    fn acted(body: &Body, omega: &Vector3<f64>) -> Vec<(f64, Turn)> {
        let mut spin = Spin::new(body, omega);
        (0..100)
            .map(|index| {
                let acted_s = f64::from(index) / 120.0;
                let physical_s = 0.4 * (acted_s + 0.05 * (6.0 * acted_s).sin());
                let wander = Vector3::new(5.0 * acted_s, 8.0 * acted_s, 3.0).map(f64::sin);
                let off = so3::exp(&(wander * 5f64.to_radians()));
                let turn = spin.turn_and_derivative(physical_s).0 * off;
                (physical_s, (acted_s, turn))
            })
            .collect()
    }

    /// Largest distance of `times_s` from the best line through the physical times, in physical
    /// seconds.
    fn unevenness_s(acted: &[(f64, Turn)], times_s: &[f64]) -> f64 {
        let count = acted.len() as f64;
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
        let (x, y) = (
            mean(&mut times_s.iter().copied()),
            mean(&mut acted.iter().map(|a| a.0)),
        );
        let pairs = || times_s.iter().zip(acted).map(|(t, a)| (t - x, a.0 - y));
        let slope =
            pairs().map(|(t, p)| t * p).sum::<f64>() / pairs().map(|(t, _)| t * t).sum::<f64>();
        pairs()
            .map(|(t, p)| (p - slope * t).abs())
            .fold(0.0, f64::max)
    }

    fn both_s(acted: &[(f64, Turn)]) -> (f64, f64) {
        let samples: Vec<Turn> = acted.iter().map(|a| a.1).collect();
        let by_hand: Vec<f64> = samples.iter().map(|(acted_s, _)| *acted_s).collect();
        let clock_s = clock(&samples).unwrap().1;
        assert!(clock_s.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((clock_s[0] - by_hand[0]).abs() < 1e-12);
        assert!((clock_s[clock_s.len() - 1] - samples[samples.len() - 1].0).abs() < 1e-12);
        (unevenness_s(acted, &by_hand), unevenness_s(acted, &clock_s))
    }

    #[test]
    fn a_turning_body_tells_the_tempo_it_was_acted_in() {
        for (moments, omega) in [
            (Vector3::new(2.0, 2.0, 2.0), Vector3::new(12.0, -5.0, 9.0)),
            (Vector3::new(2.0, 2.0, 0.02), Vector3::new(14.0, 0.0, 60.0)),
            (Vector3::new(2.0, 2.0, 0.02), Vector3::new(5.0, 0.0, 200.0)),
        ] {
            let body = Body::new(1.0, moments).unwrap();
            let (hand_s, clock_s) = both_s(&acted(&body, &omega));
            assert!(
                hand_s > 0.015 && clock_s < 0.4 * hand_s,
                "{hand_s} {clock_s}"
            );
        }
    }

    #[test]
    fn what_hardly_turns_keeps_the_acted_tempo() {
        let body = Body::new(1.0, Vector3::new(2.0, 2.0, 2.0)).unwrap();
        let (hand_s, clock_s) = both_s(&acted(&body, &Vector3::new(0.1, 0.0, 0.0)));
        assert!(clock_s < 1.3 * hand_s, "{hand_s} {clock_s}");
    }

    #[test]
    fn a_turn_in_a_gap_is_not_counted() {
        let body = Body::new(1.0, Vector3::new(2.0, 2.0, 2.0)).unwrap();
        let mut acted = acted(&body, &Vector3::new(12.0, -5.0, 9.0));
        acted.drain(30..70);
        let (hand_s, clock_s) = both_s(&acted);
        assert!(clock_s < 1.3 * hand_s, "{hand_s} {clock_s}");
    }

    #[test]
    fn too_few_samples_and_too_fast_turns_tell_nothing() {
        let body = Body::new(1.0, Vector3::new(2.0, 2.0, 0.02)).unwrap();
        let samples = |omega: Vector3<f64>| -> Vec<Turn> {
            acted(&body, &omega).into_iter().map(|a| a.1).collect()
        };
        assert!(clock(&samples(Vector3::new(5.0, 0.0, 20.0))[..7]).is_none());
        assert!(clock(&samples(Vector3::new(5.0, 0.0, 800.0))).is_none());
        let still = vec![samples(Vector3::zeros())[0]; 9];
        let still: Vec<Turn> = still
            .into_iter()
            .enumerate()
            .map(|(index, _)| (0.1 * index as f64, UnitQuaternion::identity()))
            .collect();
        let (_, clock_s) = clock(&still).unwrap();
        assert!(clock_s.iter().all(|at_s| at_s.is_finite()));
    }
}
