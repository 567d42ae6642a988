//! A flight corrected by the samples of its segment.

use enact::estimate::terms::tempo;
use enact::math::so3;
use enact::motion::{Sample, Seen};
use enact::physics::State;
use enact::physics::flow::{self, Spin};
use enact::physics::state::{StateTangent, part};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::{Matrix12, Stage};

/// Covariances grow by this at a bounce, for what is not linear.
const FADE: f64 = 1.2;
/// Steps of a correction.
const STEPS: usize = 25;

/// What a flight is corrected from.
pub(super) struct Prior<'a> {
    /// The flight's state by what is unknown, in standard deviations or in units.
    pub(super) fly: &'a dyn Fn(&StateTangent) -> Option<State>,
    pub(super) start: StateTangent,
    /// One in standard deviations; zero where nothing is known before.
    pub(super) weight: f64,
    pub(super) rate: Option<f64>,
    /// How far the times of the guess are off \[s\].
    pub(super) shift_s: f64,
}

/// A correction by samples.
pub(super) struct Correction<'a> {
    pub(super) stage: &'a Stage<'a>,
    pub(super) samples: &'a [Sample],
    pub(super) weight: f64,
    pub(super) epoch_s: f64,
    pub(super) prior: &'a Prior<'a>,
    pub(super) rate_sd: Option<f64>,
}

impl Correction<'_> {
    pub(super) fn rate(&self, times_s: &[f64]) -> f64 {
        let last = self.samples.len() - 1;
        (times_s[last] - times_s[0]) / (self.samples[last].acted_s - self.samples[0].acted_s)
    }

    /// Gauss–Newton with damping: cost, state, times, covariance of the state.
    pub(super) fn solved(&self, mut times_s: Vec<f64>) -> Option<(f64, State, Vec<f64>, Matrix12)> {
        let mut z = self.prior.start;
        let mut state = (self.prior.fly)(&z)?;
        let mut data = self.normal(&state, &times_s)?;
        let own = |z: &StateTangent| 0.5 * self.prior.weight * z.norm_squared();
        let mut cost = data.0 + own(&z);
        let mut damping = 1e-4;
        let (mut image, mut gradient, mut hessian) = self.seen(&z, &data)?;
        for _ in 0..STEPS {
            let mut damped = hessian.clone();
            for index in 0..damped.nrows() {
                damped[(index, index)] *= 1.0 + damping;
            }
            let step = -damped.cholesky()?.solve(&gradient);
            let moved = z + step.fixed_rows::<12>(0);
            let mut moved_s = times_s.clone();
            for (time_s, by) in moved_s.iter_mut().zip(step.iter().skip(12)) {
                *time_s += by;
            }
            let next = (self.prior.fly)(&moved).and_then(|state| {
                let data = self.normal(&state, &moved_s)?;
                (data.0 + own(&moved) < cost).then_some((state, data))
            });
            match next {
                Some(next) => {
                    (state, data) = next;
                    (z, times_s) = (moved, moved_s);
                    let gain = cost - data.0 - own(&z);
                    cost -= gain;
                    (image, gradient, hessian) = self.seen(&z, &data)?;
                    damping = (damping * 0.1).max(1e-9);
                    if gain < 1e-2 * (1.0 + cost) {
                        break;
                    }
                }
                None => damping *= 30.0,
            }
        }
        let of_z: Matrix12 = hessian
            .cholesky()?
            .inverse()
            .fixed_view::<12, 12>(0, 0)
            .into();
        let covariance = image * of_z * image.transpose() * FADE;
        let covariance = 0.5 * (covariance + covariance.transpose()) + self.stage.floor();
        Some((cost, state, times_s, covariance))
    }

    /// What the state changes by each unknown, and gradient and Hessian by these and the times.
    fn seen(
        &self,
        z: &StateTangent,
        (_, by_state, square): &(f64, DVector<f64>, DMatrix<f64>),
    ) -> Option<(Matrix12, DVector<f64>, DMatrix<f64>)> {
        let mut image = Matrix12::zeros();
        for axis in 0..12 {
            // Where much of a unit does not touch, a part of it does.
            let moved = [0.2, 0.02].into_iter().find_map(|share| {
                let mut by = StateTangent::zeros();
                by[axis] = share;
                let ahead = (self.prior.fly)(&(z + by))?;
                let behind = (self.prior.fly)(&(z - by))?;
                Some(ahead.minus(&behind) * (0.5 / share))
            })?;
            image.set_column(axis, &moved);
        }
        let (mut gradient, mut hessian) = (by_state.clone(), square.clone());
        let own = image.tr_mul(&by_state.fixed_rows::<12>(0)) + z * self.prior.weight;
        gradient.rows_mut(0, 12).copy_from(&own);
        let own: Matrix12 = image.tr_mul(&(square.fixed_view::<12, 12>(0, 0) * image))
            + Matrix12::identity() * self.prior.weight;
        hessian.view_mut((0, 0), (12, 12)).copy_from(&own);
        let times = gradient.len() - 12;
        let cross = image.tr_mul(&square.view((0, 12), (12, times)));
        hessian.view_mut((0, 12), (12, times)).copy_from(&cross);
        hessian
            .view_mut((12, 0), (times, 12))
            .copy_from(&cross.transpose());
        Some((image, gradient, hessian))
    }

    /// Cost, gradient and Gauss–Newton's Hessian by the state, then by the times where these are
    /// unknown; `None` where times are out of order.
    fn normal(&self, state: &State, times_s: &[f64]) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
        if times_s.windows(2).any(|pair| !(pair[0] < pair[1])) {
            return None;
        }
        let scene = self.stage.scene;
        let is_timed = self.stage.tempo_sd.is_none();
        let size = 12 + if is_timed { 0 } else { times_s.len() };
        let (mut gradient, mut hessian) = (DVector::zeros(size), DMatrix::zeros(size, size));
        let mut cost = 0.0;
        let mut spin = Spin::new(self.stage.body, &state.angular_velocity_rad_s);
        let weights = [
            self.weight / scene.weights.position_m.powi(2),
            self.weight / scene.weights.orientation_rad.powi(2),
        ];
        for (index, (sample, time_s)) in self.samples.iter().zip(times_s).enumerate() {
            let s = time_s - self.epoch_s;
            let Seen::Pose {
                position_m,
                orientation,
            } = sample.seen
            else {
                unreachable!("performances are of poses");
            };
            let shift = flow::position(self.stage.body, &scene.gravity_m_s2, state, s) - position_m;
            let (turn, k) = spin.turn_and_derivative(s);
            let error = so3::log(&(turn * (orientation.inverse() * state.orientation)));
            let velocity = state.velocity_m_s + scene.gravity_m_s2 * s;
            let terms = [
                (shift, part::POSITION, Matrix3::identity() * s, velocity),
                (
                    error,
                    part::ORIENTATION,
                    k * s,
                    k * state.angular_velocity_rad_s,
                ),
            ];
            for (weight, (residual, at, by_rate, by_time)) in weights.iter().zip(terms) {
                cost += 0.5 * weight * residual.norm_squared();
                let mut add = |row: usize, value: Vector3<f64>| {
                    for axis in 0..3 {
                        gradient[row + axis] += weight * value[axis];
                    }
                };
                add(at, residual);
                add(at + 6, by_rate.tr_mul(&residual));
                let square = by_rate.tr_mul(&by_rate);
                for i in 0..3 {
                    hessian[(at + i, at + i)] += weight;
                    for j in 0..3 {
                        hessian[(at + i, at + 6 + j)] += weight * by_rate[(i, j)];
                        hessian[(at + 6 + j, at + i)] += weight * by_rate[(i, j)];
                        hessian[(at + 6 + i, at + 6 + j)] += weight * square[(i, j)];
                    }
                }
                if !is_timed {
                    let t = 12 + index;
                    gradient[t] += weight * by_time.dot(&residual);
                    hessian[(t, t)] += weight * by_time.norm_squared();
                    let cross = by_rate.tr_mul(&by_time);
                    for i in 0..3 {
                        for (row, value) in [(at + i, by_time[i]), (at + 6 + i, cross[i])] {
                            hessian[(row, t)] += weight * value;
                            hessian[(t, row)] += weight * value;
                        }
                    }
                }
            }
        }
        if let Some(sd) = self.stage.tempo_sd {
            cost += self.add_tempo(sd, times_s, &mut gradient, &mut hessian);
        }
        Some((cost, gradient, hessian))
    }

    fn add_tempo(
        &self,
        sd: f64,
        times_s: &[f64],
        gradient: &mut DVector<f64>,
        hessian: &mut DMatrix<f64>,
    ) -> f64 {
        let mut cost = 0.0;
        let mut add = |residual: f64, by: &[(usize, f64)]| {
            cost += 0.5 * residual * residual;
            for (i, a) in by {
                gradient[12 + i] += residual * a;
                for (j, b) in by {
                    hessian[(12 + i, 12 + j)] += a * b;
                }
            }
        };
        for first in 0..times_s.len().saturating_sub(2) {
            let times = [times_s[first], times_s[first + 1], times_s[first + 2]];
            let acted = [0, 1, 2].map(|i: usize| self.samples[first + i].acted_s);
            let term = tempo::term(&times, &acted, sd);
            let by = [0, 1, 2].map(|i: usize| (first + i, term.jacobian[i]));
            add(term.residual, &by);
        }
        let last = times_s.len() - 1;
        if let (Some(rate), Some(rate_sd)) = (self.prior.rate, self.rate_sd) {
            let residual = (self.rate(times_s) / rate).ln() / rate_sd;
            let slope = 1.0 / ((times_s[last] - times_s[0]) * rate_sd);
            add(residual, &[(0, -slope), (last, slope)]);
        }
        if self.prior.weight == 0.0 {
            // The zero of time is a convention.
            hessian[(12, 12)] *= 1e6;
        }
        cost
    }
}
