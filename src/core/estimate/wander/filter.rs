//! Residuals of a process, and their derivatives, as errors that are independent and of unit variance (Kalman, 1960).
//!
//! With the state's mean `m` and covariance `P` given all samples before, and `H = (1, 0, 1)`, a sample of `r` has
//!
//! ```text
//! s² = H P Hᵀ + σ²,   e = (r − H m)/s,   k = P Hᵀ/s²,   m ← m + k (r − H m),   P ← P − k s² kᵀ
//! ```
//!
//! `e` is linear in all residuals until now, with factors that depend on times alone: columns of derivatives go the
//! same way. `Σ e²` is `rᵀ V⁻¹ r` and `Σ ln s²` is `ln |V|`, with the covariance `V` of all samples. Backwards, with `a` the
//! adjoint of `m`, it gives `u = V⁻¹ r`:
//!
//! ```text
//! u = e/s + kᵀ a,   a ← Fᵀ (a − Hᵀ u)
//! ```

use nalgebra::{Matrix3, Vector3};
use wide::f64x4;

use super::process::Process;
use crate::math::lanes::{self, LANES};

/// When a sample was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleInstant {
    /// Its time \[s, acted\].
    pub time_s: f64,
    /// Variance of its noise beside that of the process, along each axis: what its message says.
    pub noise_variance: f64,
}

/// What is known of a process along its samples, whatever they are.
#[derive(Clone, Debug)]
pub struct Filter {
    process: Process,
    /// Diagonal of the stationary covariance.
    stationary: Vector3<f64>,
    /// When the last sample was \[s\].
    last_s: Option<f64>,
    /// `P`.
    covariance: Matrix3<f64>,
    /// `Σ ln s²` of the samples until now, along one axis.
    log_variance: f64,
}

/// How a sample's numbers become independent, and what they tell of those that follow.
#[derive(Clone, Copy, Debug)]
pub struct Gain {
    /// `F` since the sample before.
    by: Matrix3<f64>,
    /// `k`.
    gain: Vector3<f64>,
    /// `1/s`.
    per_sd: f64,
}

/// Means of the process for several numbers that are filtered alike.
#[derive(Clone, Debug, Default)]
pub struct Means {
    /// Of `h`, of `ḣ`, of `o`.
    each: [Vec<f64>; 3],
}

impl Filter {
    /// Before the first sample.
    pub fn new(process: &Process) -> Self {
        let stationary = process.stationary();
        Self {
            process: *process,
            stationary: stationary.diagonal(),
            last_s: None,
            covariance: stationary,
            log_variance: 0.0,
        }
    }

    /// Goes on to a sample, no earlier than the last.
    pub fn next(&mut self, taken: &SampleInstant) -> Gain {
        let time_s = taken.time_s;
        let apart_s = self.last_s.map_or(0.0, |last_s| (time_s - last_s).max(0.0));
        self.last_s = Some(time_s);
        let by = self.process.transition(apart_s);
        let covariance = self.gone_on(&by);
        let with_sample = covariance.column(0) + covariance.column(2);
        let noise = self.process.noise_sd.powi(2) + taken.noise_variance;
        let variance = with_sample[0] + with_sample[2] + noise;
        let gain: Vector3<f64> = with_sample / variance;
        self.covariance = covariance - gain * with_sample.transpose();
        self.log_variance += variance.ln();
        Gain {
            by,
            gain,
            per_sd: variance.sqrt().recip(),
        }
    }

    /// `F P Fᵀ + Q`, gone on towards the stationary covariance: `h` and `o` go on by themselves.
    fn gone_on(&self, by: &Matrix3<f64>) -> Matrix3<f64> {
        let s = &self.stationary;
        let p = &self.covariance;
        let (a, b, c, d, r) = (by[(0, 0)], by[(0, 1)], by[(1, 0)], by[(1, 1)], by[(2, 2)]);
        let (hh, hv, vv) = (p[(0, 0)] - s[0], p[(0, 1)], p[(1, 1)] - s[1]);
        let (ho, vo, oo) = (p[(0, 2)], p[(1, 2)], p[(2, 2)] - s[2]);
        let across = (a * hh + b * hv) * c + (a * hv + b * vv) * d;
        let [place, speed] = [(a * ho + b * vo) * r, (c * ho + d * vo) * r];
        let placed = (a * hh + b * hv) * a + (a * hv + b * vv) * b + s[0];
        let sped = (c * hh + d * hv) * c + (c * hv + d * vv) * d + s[1];
        let rough = r * r * oo + s[2];
        Matrix3::new(
            placed, across, place, across, sped, speed, place, speed, rough,
        )
    }

    /// `Σ ln s²` of the samples until now, along one axis.
    pub fn log_variance(&self) -> f64 {
        self.log_variance
    }
}

impl Gain {
    /// How the means after the sample follow from those after the one before, where the sample shows nothing of them:
    /// `(1 − k H) F`.
    pub fn forgets(&self) -> Matrix3<f64> {
        let observed = self.by.row(0) + self.by.row(2);
        self.by - self.gain * observed
    }

    /// What slopes by its entries make of its change to another.
    pub fn change(&self, slopes: &Self, to: &Self) -> f64 {
        (to.by - self.by).dot(&slopes.by)
            + (to.gain - self.gain).dot(&slopes.gain)
            + (to.per_sd - self.per_sd) * slopes.per_sd
    }
}

impl Means {
    /// Of so many numbers, all zero.
    pub fn new(numbers: usize) -> Self {
        let mut means = Self::default();
        means.extend(numbers);
        means
    }

    /// Adds so many numbers, all zero.
    pub fn extend(&mut self, numbers: usize) {
        for each in &mut self.each {
            each.resize(each.len() + numbers, 0.0);
        }
    }

    /// Leaves out some of the numbers.
    pub fn remove(&mut self, numbers: std::ops::Range<usize>) {
        for each in &mut self.each {
            each.drain(numbers.clone());
        }
    }

    /// The means, four numbers at a time.
    fn in_lanes(&mut self) -> impl Iterator<Item = [&mut [f64]; 3]> {
        let [places, speeds, roughs] = &mut self.each;
        let moving = places.chunks_mut(LANES).zip(speeds.chunks_mut(LANES));
        let all = moving.zip(roughs.chunks_mut(LANES));
        all.map(|((places, speeds), roughs)| [places, speeds, roughs])
    }

    /// Replaces the numbers of a sample by those of `e`.
    pub fn whiten(&mut self, gain: &Gain, numbers: &mut [f64]) {
        let (by, k) = (&gain.by, &gain.gain);
        for (numbers, [places, speeds, roughs]) in numbers.chunks_mut(LANES).zip(self.in_lanes()) {
            let (place, speed) = (lanes::loaded(places), lanes::loaded(speeds));
            let rough = lanes::loaded(roughs);
            let expected = place * by[(0, 0)] + speed * by[(0, 1)];
            let expected_speed = place * by[(1, 0)] + speed * by[(1, 1)];
            let expected_rough = rough * by[(2, 2)];
            let off = lanes::loaded(numbers) - expected - expected_rough;
            lanes::store(expected + off * k[0], places);
            lanes::store(expected_speed + off * k[1], speeds);
            lanes::store(expected_rough + off * k[2], roughs);
            lanes::store(off * gain.per_sd, numbers);
        }
    }
}

/// Slopes of a number by every entry of the gains of samples, of its slopes by what is whitened with them.
#[derive(Clone, Debug)]
pub struct GainSlopes {
    /// Means before each sample.
    before: Vec<Means>,
    /// Slopes by the means after the sample.
    adjoint: Means,
}

impl GainSlopes {
    /// Of so many numbers for each sample.
    pub fn new(numbers: usize) -> Self {
        Self {
            before: Vec::new(),
            adjoint: Means::new(numbers),
        }
    }

    /// Keeps the means before a sample.
    pub fn push(&mut self, means: &Means) {
        self.before.push(means.clone());
    }

    /// The slopes by the gain of the last sample that is left, with what `whitened` was made of it and the slopes by that. With
    /// `x` the number's slope by `r − H F m`,
    ///
    /// ```text
    /// x = e'/s + kᵀ a,   k' = a (r − H F m),   F' = (a − Hᵀ x) mᵀ,   a ← Fᵀ (a − Hᵀ x)
    /// ```
    pub fn pop(&mut self, gain: &Gain, whitened: &[f64], slopes: &[f64]) -> Gain {
        let before = self.before.pop().expect("one for each sample");
        let (by, k, per_sd) = (&gain.by, &gain.gain, gain.per_sd);
        let mut by_sd = f64x4::ZERO;
        let mut by_gain = [f64x4::ZERO; 3];
        let mut by_expected = [f64x4::ZERO; 5];
        let mut first = 0;
        for [places, speeds, roughs] in self.adjoint.in_lanes() {
            let range = first..first + places.len();
            first = range.end;
            let (place, speed) = (lanes::loaded(places), lanes::loaded(speeds));
            let rough = lanes::loaded(roughs);
            let white = lanes::loaded(&whitened[range.clone()]);
            let slope = lanes::loaded(&slopes[range.clone()]);
            let off = white / per_sd;
            let by_off = slope * per_sd + place * k[0] + speed * k[1] + rough * k[2];
            by_sd += slope * off;
            for (sum, adjoint) in by_gain.iter_mut().zip([place, speed, rough]) {
                *sum += adjoint * off;
            }
            let expected = [place - by_off, speed, rough - by_off];
            let [m, v, o] = &before.each;
            let (m, v) = (
                lanes::loaded(&m[range.clone()]),
                lanes::loaded(&v[range.clone()]),
            );
            let o = lanes::loaded(&o[range]);
            let pairs = [
                expected[0] * m,
                expected[0] * v,
                expected[1] * m,
                expected[1] * v,
                expected[2] * o,
            ];
            for (sum, pair) in by_expected.iter_mut().zip(pairs) {
                *sum += pair;
            }
            lanes::store(expected[0] * by[(0, 0)] + expected[1] * by[(1, 0)], places);
            lanes::store(expected[0] * by[(0, 1)] + expected[1] * by[(1, 1)], speeds);
            lanes::store(expected[2] * by[(2, 2)], roughs);
        }
        let [mm, mv, vm, vv, oo] = by_expected.map(f64x4::reduce_add);
        Gain {
            by: Matrix3::new(mm, mv, 0.0, vm, vv, 0.0, 0.0, 0.0, oo),
            gain: Vector3::from(by_gain.map(f64x4::reduce_add)),
            per_sd: by_sd.reduce_add(),
        }
    }
}

/// `V⁻¹ r` of samples in order of time, three axes alike.
pub fn weighed(gains: &[Gain], residuals: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut means = Means::new(3);
    let mut weighed = residuals.to_vec();
    for (gain, numbers) in gains.iter().zip(&mut weighed) {
        means.whiten(gain, numbers);
    }
    let mut adjoints = [Vector3::<f64>::zeros(); 3];
    for (gain, numbers) in gains.iter().zip(&mut weighed).rev() {
        for (number, adjoint) in numbers.iter_mut().zip(&mut adjoints) {
            *number = *number * gain.per_sd + gain.gain.dot(adjoint);
            let observed = Vector3::new(*number, 0.0, *number);
            *adjoint = gain.by.tr_mul(&(*adjoint - observed));
        }
    }
    weighed
}

/// `V u` of samples in order of time, three axes alike: what [`weighed`] undoes.
pub fn covered(gains: &[Gain], weighed: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut covered = weighed.to_vec();
    let mut adjoints = [Vector3::<f64>::zeros(); 3];
    for (gain, numbers) in gains.iter().zip(&mut covered).rev() {
        for (number, adjoint) in numbers.iter_mut().zip(&mut adjoints) {
            let observed = Vector3::new(*number, 0.0, *number);
            *number = (*number - gain.gain.dot(adjoint)) / gain.per_sd;
            *adjoint = gain.by.tr_mul(&(*adjoint - observed));
        }
    }
    let mut means = [Vector3::<f64>::zeros(); 3];
    for (gain, numbers) in gains.iter().zip(&mut covered) {
        for (number, mean) in numbers.iter_mut().zip(&mut means) {
            let expected = gain.by * *mean;
            let off = *number / gain.per_sd;
            *number = off + expected.x + expected.z;
            *mean = expected + gain.gain * off;
        }
    }
    covered
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::math::random::Random;

    const PROCESS: Process = Process {
        smooth_sd: 1.3,
        smooth_s: 0.6,
        rough_sd: 0.4,
        rough_s: 0.1,
        noise_sd: 0.05,
    };

    /// Uneven times with two of them at once, of uneven noise.
    fn taken(random: &mut Random) -> Vec<SampleInstant> {
        let mut times_s: Vec<f64> = (0..40)
            .map(|at| 0.02 * (f64::from(at) + 0.4 * random.signed()))
            .collect();
        times_s[7] = times_s[6];
        let taken = times_s.into_iter().map(|time_s| SampleInstant {
            time_s,
            noise_variance: (0.1 * random.signed()).powi(2),
        });
        taken.collect()
    }

    /// Against the whole covariance of all samples.
    #[test]
    fn what_is_whitened_has_the_products_of_the_inverse_covariance() {
        let mut random = Random::default();
        let taken = taken(&mut random);
        let columns = DMatrix::from_fn(40, 3, |_, _| random.signed());
        let mut covariance = DMatrix::from_fn(40, 40, |a, b| {
            PROCESS.covariance((taken[a].time_s - taken[b].time_s).abs())
        });
        for at in 0..40 {
            covariance[(at, at)] += PROCESS.noise_sd.powi(2) + taken[at].noise_variance;
        }
        let factor = covariance.cholesky().expect("a covariance");
        let stated = columns.tr_mul(&factor.solve(&columns));
        let (mut filter, mut means) = (Filter::new(&PROCESS), Means::new(3));
        let mut white = DMatrix::zeros(40, 3);
        let gains: Vec<Gain> = taken.iter().map(|taken| filter.next(taken)).collect();
        for (row, gain) in gains.iter().enumerate() {
            let mut numbers: Vec<f64> = columns.row(row).iter().copied().collect();
            means.whiten(gain, &mut numbers);
            white.set_row(row, &DVector::from_vec(numbers).transpose());
        }
        let given = white.tr_mul(&white);
        assert!((&given - &stated).amax() < 1e-9 * stated.amax(), "{given}");
        let log = filter.log_variance();
        assert!((log - factor.ln_determinant()).abs() < 1e-9, "{log}");
        let residuals: Vec<[f64; 3]> = columns
            .row_iter()
            .map(|row| [row[0], row[1], row[2]])
            .collect();
        let solved = factor.solve(&columns);
        for (given, stated) in covered(&gains, &weighed(&gains, &residuals))
            .iter()
            .zip(&residuals)
        {
            for (given, stated) in given.iter().zip(stated) {
                assert!((given - stated).abs() < 1e-9, "{given} {stated}");
            }
        }
        for (row, three) in weighed(&gains, &residuals).iter().enumerate() {
            for (column, number) in three.iter().enumerate() {
                let off = (number - solved[(row, column)]).abs();
                assert!(off < 1e-9 * solved.amax(), "{row} {column}: {off}");
            }
        }
    }

    /// A number that is zero from some sample on leaves what [`Gain::forgets`] says.
    #[test]
    fn what_is_over_is_forgotten_as_the_gains_say() {
        let mut random = Random::default();
        let (mut filter, mut means) = (Filter::new(&PROCESS), Means::new(1));
        let mut left: Option<Vector3<f64>> = None;
        for (index, taken) in taken(&mut random).iter().enumerate() {
            let gain = filter.next(taken);
            let mut number = [f64::from(u8::from(index < 5))];
            means.whiten(&gain, &mut number);
            let mean = Vector3::from_fn(|row, _| means.each[row][0]);
            left = match left {
                Some(before) if index >= 5 => Some(gain.forgets() * before),
                _ => Some(mean),
            };
            let off = left.map_or(0.0, |left| (left - mean).amax());
            assert!(off < 1e-13, "{index}: {off}");
        }
    }
}
