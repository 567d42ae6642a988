//! Residual sum of squares of the best flight through any stretch of a stream, in constant time.
//!
//! A fit is a projection on polynomials of degree 0, 1 (and 2 along one direction, where the
//! tempo is unknown) in acted time `a`. With the orthogonal polynomials `π_k` of the stretch,
//!
//! ```text
//! min Σ |p_i − fit(a_i)|² = Σ |p_i|² − Σ_k |Σ_i π_k(a_i) p_i|² / Σ_i π_k(a_i)²
//! ```
//!
//! so that prefix sums of `a^k`, `a^k p` and `|p|²` over the stream give the cost of any stretch.

use nalgebra::{DMatrix, Vector3};

use crate::math::so3;
use crate::motion::{Scene, Timing, TrackIndex, TrackSketch};

/// Prefix sums over a track's samples, to fit any stretch of them.
pub(super) struct PrefixSums {
    sums: Vec<RunningSums>,
    /// Direction of gravity where the tempo is unknown, so that the size of the curvature in acted
    /// time is unknown too.
    free_along: Option<Vector3<f64>>,
}

/// Coefficients of a cubic: as many as of two straight lines.
const BEND_NUMBERS: usize = 4;

/// `Σ a^k`, `Σ a^k p` and `Σ |p|²`.
#[derive(Clone, Copy, Default)]
struct RunningSums {
    powers: [f64; 5],
    moments: [Vector3<f64>; 3],
    square: f64,
}

impl PrefixSums {
    /// Sums for the centre of mass: flights under gravity and the body's constant force, without
    /// drag \[m\].
    pub(super) fn of_positions(scene: &Scene, index: TrackIndex, track: &TrackSketch) -> Self {
        let pull = scene
            .link_seen_by(index)
            .body
            .pull_m_s2(&scene.gravity_m_s2);
        let free_along = match scene.timing {
            Timing::Known | Timing::Edited => None,
            Timing::Unknown { .. } => pull.try_normalize(1e-9),
        };
        let samples = &track.samples;
        let first_m = samples.iter().find_map(|s| s.seen.position_m());
        let first_m = first_m.unwrap_or_default();
        let middle_s = middle_s(track);
        let points = samples.iter().map(|sample| {
            let a = sample.acted_s - middle_s;
            // With known times the fall is known and subtracted.
            let fall = if free_along.is_some() {
                Vector3::zeros()
            } else {
                pull * (0.5 * a * a)
            };
            Some((a, sample.seen.position_m()? - first_m - fall))
        });
        Self::new(points, free_along)
    }

    /// Sums for the integral of angular momentum \[rad, world\]:
    /// `Σ R_i (I/I_max) Log(R_{i−1}ᵀ R_i)`. In free flight angular momentum is constant, and its
    /// integral a straight line.
    pub(super) fn of_turns(scene: &Scene, index: TrackIndex, track: &TrackSketch) -> Self {
        let moments = scene.link_seen_by(index).body.moments_kg_m2();
        let moments = moments / moments.max();
        let middle_s = middle_s(track);
        let mut turned = Vector3::zeros();
        let mut before = None;
        let points = track.samples.iter().map(|sample| {
            let orientation = sample.seen.orientation()?;
            if let Some(before) = before.replace(orientation) {
                let turn = so3::log(&(before.inverse() * orientation));
                turned += orientation * moments.component_mul(&turn);
            }
            Some((sample.acted_s - middle_s, turned))
        });
        Self::new(points, None)
    }

    fn new(
        points: impl Iterator<Item = Option<(f64, Vector3<f64>)>>,
        free_along: Option<Vector3<f64>>,
    ) -> Self {
        let mut running = RunningSums::default();
        let mut sums = vec![running];
        for point in points {
            // A sample that does not show it adds nothing.
            if let Some((a, p)) = point {
                let mut power = 1.0;
                for k in 0..5 {
                    running.powers[k] += power;
                    if k < 3 {
                        running.moments[k] += p * power;
                    }
                    power *= a;
                }
                running.square += p.norm_squared();
            }
            sums.push(running);
        }
        Self { sums, free_along }
    }

    /// Sum of squared distances of samples `begin..end` from their best flight, in the square of
    /// the points' unit.
    pub(super) fn cost(&self, begin: usize, end: usize) -> f64 {
        self.cost_of(begin, end, false)
    }

    /// The same; of what a surface carries from their best parabola, since its acceleration is that of friction.
    pub(super) fn cost_of(&self, begin: usize, end: usize, is_carried: bool) -> f64 {
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
        if count > 3.0 && (is_carried || self.free_along.is_some()) {
            let slope = (powers[3] - powers[2] * mean) / first_norm;
            let second_norm =
                powers[4] - powers[2] * powers[2] / count - slope * slope * first_norm;
            let second = moments[2] - moments[0] * (powers[2] / count) - first * slope;
            // Curvature against gravity is not allowed.
            let bent = match self.free_along {
                Some(along) if !is_carried => second.dot(&along).max(0.0).powi(2),
                _ => second.norm_squared(),
            };
            if second_norm > 0.0 {
                cost -= bent / second_norm;
            }
        }
        cost.max(0.0)
    }

    /// Sum of squared distances of samples from their best cubic, which bends smoothly where two flights have
    /// a kink; and the number of samples that show something.
    pub(super) fn bent(&self, samples: impl Iterator<Item = usize>) -> (f64, usize) {
        let points = samples.filter_map(|index| {
            let (from, to) = (&self.sums[index], &self.sums[index + 1]);
            let is_shown = to.powers[0] > from.powers[0];
            is_shown.then(|| {
                let a = to.powers[1] - from.powers[1];
                (a, to.moments[0] - from.moments[0])
            })
        });
        let (times, points): (Vec<f64>, Vec<Vector3<f64>>) = points.unzip();
        let count = times.len();
        if count <= BEND_NUMBERS {
            return (0.0, count);
        }
        let middle = times.iter().sum::<f64>() / count as f64;
        let half = times.iter().map(|a| (a - middle).abs()).fold(0.0, f64::max);
        let powers = DMatrix::from_fn(count, BEND_NUMBERS, |row, degree| {
            ((times[row] - middle) / half).powi(degree as i32)
        });
        let mut points = DMatrix::from_fn(count, 3, |row, axis| points[row][axis]);
        // What is left of them is in the rows below those of the cubic.
        powers.qr().q_tr_mul(&mut points);
        let left = points.rows(BEND_NUMBERS, count - BEND_NUMBERS);
        (left.norm_squared(), count)
    }

    /// Numbers that a flight has.
    pub(super) fn numbers(&self) -> usize {
        6 + usize::from(self.free_along.is_some())
    }
}

fn middle_s(track: &TrackSketch) -> f64 {
    let samples = &track.samples;
    samples.get(samples.len() / 2).map_or(0.0, |s| s.acted_s)
}

#[cfg(test)]
mod tests;
