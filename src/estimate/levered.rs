//! The terms of points beside the centre of mass and of directions, summed into one small block per view.
//!
//! With `q = T(s) p` of a point `p`, or `T(s) a` of an axis, in the frame of the arc's epoch
//! (`T = R₀ᵀ R`), the residual `e` in that frame changes by
//!
//! ```text
//! δe = (δθ + s K δω) × q + R₀ᵀ (δx + s δv)
//! ```
//!
//! the last part for points alone. All rows weigh the same, so that the frame does not matter, and of the
//! products of derivatives only `[q]× K` differs from sample to sample in a way that no few numbers tell.

use nalgebra::{Matrix3, Vector3};

use super::observed::{Observer, Swung};
use super::problem::{Shows, View};
use super::samples::{Between, TimeTerms};
use crate::math::so3;

/// Half the sum of squares with its derivatives by the arc's state, in the frame of the epoch.
#[derive(Clone, Debug, Default)]
pub(super) struct LeverTerms {
    pub(super) cost: f64,
    /// By position, orientation, velocity and angular velocity.
    pub(super) gradient: [Vector3<f64>; 4],
    /// `Σ s^k`, k = 0…2; zero for directions.
    pub(super) powers: [f64; 3],
    /// By position (rows) and orientation, and by velocity and orientation.
    pub(super) by_turn: [Matrix3<f64>; 2],
    /// By position (rows) and angular velocity, and by velocity and angular velocity.
    pub(super) by_spin: [Matrix3<f64>; 2],
    /// By orientation twice, by it and angular velocity, by angular velocity twice.
    pub(super) turns: [Matrix3<f64>; 3],
}

impl LeverTerms {
    /// Terms of every `stride`-th sample of a view, with the weight of `stride`. Where times are unknown
    /// `each` is called with its nodes in order and their terms.
    pub(super) fn of(
        observer: &mut Observer,
        (view, stride): (&View, usize),
        times_s: &[f64],
        each: Option<impl FnMut(usize, TimeTerms)>,
    ) -> Self {
        let samples = (0..view.samples.len()).skip(stride / 2).step_by(stride);
        let for_each = view.samples.len() as f64 / samples.len().max(1) as f64;
        let is_point = view.shows == Shows::Point;
        let unit = view.units[usize::from(!is_point)];
        let weight = for_each / (unit * unit);
        let first = samples.clone().next().map_or(0, |at| view.samples[at].node);
        let mut between = each.map(|each| Between::new(first, each));
        let mut terms = Self::default();
        for index in samples {
            let swung = observer.swung(index, times_s);
            let change = terms.add(&swung, is_point, weight);
            if let Some(between) = &mut between {
                between.add(
                    &view.samples[index],
                    &observer.by_time(&swung, &change, weight),
                );
            }
        }
        if let Some(between) = between {
            between.end();
        }
        terms
    }

    /// Adds a sample; returns `[q]× K`.
    fn add(&mut self, swung: &Swung, is_point: bool, weight: f64) -> Matrix3<f64> {
        let Swung {
            s,
            k,
            lever: q,
            residual: e,
            ..
        } = swung;
        let cross = so3::hat(q);
        let spun = cross * k;
        let (pull, ws) = (e * weight, weight * s);
        // Turned by `δ` the lever changes by `−[q]× δ`.
        self.cost += 0.5 * weight * e.norm_squared();
        self.gradient[1] += q.cross(&pull);
        self.gradient[3] -= spun.tr_mul(&pull) * *s;
        self.turns[0] += cross.tr_mul(&cross) * weight;
        self.turns[1] += cross.tr_mul(&spun) * ws;
        self.turns[2] += spun.tr_mul(&spun) * (ws * s);
        if is_point {
            self.gradient[0] += pull;
            self.gradient[2] += pull * *s;
            let mut power = weight;
            for (order, entry) in self.powers.iter_mut().enumerate() {
                *entry += power;
                if order < 2 {
                    self.by_turn[order] -= cross * power;
                    self.by_spin[order] -= spun * (power * s);
                }
                power *= s;
            }
        }
        spun
    }
}
