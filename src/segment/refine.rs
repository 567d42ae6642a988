//! Marks made by a person are late or early; the centre of mass tells where the kink is.
//!
//! For each collision the mark is tried at every sample within reach, and put where the
//! ballistic fits of the two neighbouring segments leave least. A fit is a projection on
//! polynomials of degree 0, 1 (and 2 along gravity, where the tempo is unknown), so that sums
//! over prefixes of the stream give the cost of any segment without looking at its samples.

use nalgebra::Vector3;

use super::cut::median_interval_s;
use crate::motion::{BodySketch, EventKind, Scene, Sketch, Timing};

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

/// Moves the marks of collisions in `sketch`; returns the number of rounds it took.
pub fn refine(scene: &Scene, sketch: &mut Sketch) -> usize {
    let collisions: Vec<(usize, usize)> = (0..scene.events.len())
        .filter_map(|event| match scene.events[event].kind {
            EventKind::Collision { body, .. } => Some((event, body)),
            _ => None,
        })
        .collect();
    let bodies: Vec<(PrefixSums, f64)> = (0..sketch.bodies.len())
        .map(|body| {
            let interval_s = median_interval_s(sketch, body).max(1e-9);
            (PrefixSums::new(scene, &sketch.bodies[body]), interval_s)
        })
        .collect();
    for round in 1..=ROUNDS_MAX {
        let mut moved = false;
        for (event, body) in &collisions {
            moved |= refine_one(scene, sketch, &bodies[*body], *event, *body);
        }
        if !moved || collisions.len() == 1 {
            return round;
        }
    }
    ROUNDS_MAX
}

/// Moves one mark to the best place between its body's neighbouring events.
fn refine_one(
    scene: &Scene,
    sketch: &mut Sketch,
    (sums, interval_s): &(PrefixSums, f64),
    event: usize,
    body: usize,
) -> bool {
    let samples = &sketch.bodies[body].samples;
    let concerns = |other: usize| match scene.events[other].kind {
        EventKind::Collision { body: b, .. } => b == body,
        _ => true,
    };
    let index_at = |acted_s: f64| samples.partition_point(|s| s.acted_s <= acted_s);
    // What lies beside a neighbouring collision is left out, as it is in the cut.
    let beside = |other: usize| {
        usize::from(matches!(
            scene.events[other].kind,
            EventKind::Collision { .. }
        ))
    };
    let begin = (0..event)
        .rev()
        .find(|e| concerns(*e))
        .map_or(0, |e| index_at(sketch.marks_s[e]) + beside(e));
    let end = (event + 1..scene.events.len())
        .find(|e| concerns(*e))
        .map_or(samples.len(), |e| {
            index_at(sketch.marks_s[e]).saturating_sub(beside(e))
        });
    let now = index_at(sketch.marks_s[event]);
    let reach_s = match scene.timing {
        Timing::Known => REACH_KNOWN_S,
        Timing::Unknown { .. } => REACH_S,
    };
    let reach = REACH_SAMPLES.max((reach_s / interval_s).round() as usize);
    let least = now.saturating_sub(reach).max(begin + KEEP_SAMPLES);
    let most = (now + reach).min(end.saturating_sub(KEEP_SAMPLES));
    // The samples beside the collision are left out on either side, as they are in the cut.
    let cost = |cut: usize| sums.cost(begin, cut - 1) + sums.cost(cut + 1, end);
    let Some(best) = (least..=most).min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else {
        return false;
    };
    if best == now || !(cost(best) < cost(now.clamp(least, most)) - GAIN_MIN_M2) {
        return false;
    }
    // Between the last sample before and the first after.
    sketch.marks_s[event] = 0.5 * (samples[best - 1].acted_s + samples[best].acted_s);
    true
}

/// Running sums over a body's samples, to fit any stretch of them.
struct PrefixSums {
    sums: Vec<Sums>,
    /// Direction of gravity where its size in acted time is unknown.
    free_along: Option<Vector3<f64>>,
}

/// `Σ a^k`, `Σ a^k p` and `Σ |p|²`.
#[derive(Clone, Copy, Default)]
struct Sums {
    powers: [f64; 5],
    moments: [Vector3<f64>; 3],
    square: f64,
}

impl PrefixSums {
    fn new(scene: &Scene, body: &BodySketch) -> Self {
        let gravity = scene.gravity_m_s2;
        let free_along = match scene.timing {
            Timing::Known => None,
            Timing::Unknown { .. } => gravity.try_normalize(1e-9),
        };
        let samples = &body.samples;
        let centre_s = samples
            .get(samples.len() / 2)
            .map_or(0.0, |sample| sample.acted_s);
        let mut running = Sums::default();
        let mut sums = vec![running];
        for sample in samples {
            let a = sample.acted_s - centre_s;
            // Known times leave no curvature unknown.
            let fall = if free_along.is_some() {
                Vector3::zeros()
            } else {
                gravity * (0.5 * a * a)
            };
            let p = sample.position_m - samples[0].position_m - fall;
            let mut power = 1.0;
            for k in 0..5 {
                running.powers[k] += power;
                if k < 3 {
                    running.moments[k] += p * power;
                }
                power *= a;
            }
            running.square += p.norm_squared();
            sums.push(running);
        }
        Self { sums, free_along }
    }

    /// Sum of squared distances \[m²\] of samples `begin..end` from their best flight.
    fn cost(&self, begin: usize, end: usize) -> f64 {
        let (from, to) = (&self.sums[begin], &self.sums[end.max(begin)]);
        let mut powers = [0.0; 5];
        let mut moments = [Vector3::zeros(); 3];
        for k in 0..5 {
            powers[k] = to.powers[k] - from.powers[k];
        }
        for k in 0..3 {
            moments[k] = to.moments[k] - from.moments[k];
        }
        let count = powers[0];
        if count < 2.0 {
            return 0.0;
        }
        // Gram–Schmidt on 1, a, a².
        let mean = powers[1] / count;
        let first_norm = powers[2] - mean * powers[1];
        let first = moments[1] - moments[0] * mean;
        let mut cost = to.square - from.square - moments[0].norm_squared() / count;
        if first_norm > 0.0 {
            cost -= first.norm_squared() / first_norm;
        }
        if let Some(along) = self.free_along
            && count > 3.0
        {
            let slope = (powers[3] - powers[2] * mean) / first_norm;
            let second_norm =
                powers[4] - powers[2] * powers[2] / count - slope * slope * first_norm;
            let second = moments[2] - moments[0] * (powers[2] / count) - first * slope;
            // Falling up is no better than not falling.
            let fall = second.dot(&along).max(0.0);
            if second_norm > 0.0 {
                cost -= fall * fall / second_norm;
            }
        }
        cost.max(0.0)
    }
}
