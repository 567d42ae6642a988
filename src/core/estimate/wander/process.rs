//! A hand's wander and a tracker's noise, along one axis.
//!
//! ```text
//! r(t) = h(t) + o(t) + ε
//! cov h = a² (1 + λd) exp(−λd)      λ = √3/ℓ     smooth: Matérn's kernel of order 3/2
//! cov o = b² exp(−d/m)                           rough: Ornstein and Uhlenbeck's
//! var ε = σ²                                     white, sample by sample
//! ```
//!
//! at times a distance `d` apart. With the state `x = (h, ḣ, o)` this is a linear system (Hartikainen and Särkkä, IEEE
//! MLSP, 2010): over a time `d` the state becomes `F x + w`, where `cov w = Q = P − F P Fᵀ` keeps the stationary
//! covariance `P = diag (a², λ²a², b²)`.

use nalgebra::{Matrix3, Vector3};

/// Sizes and times of a process; sizes are in units of residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Process {
    /// Standard deviation of the smooth part, `a`.
    pub smooth_sd: f64,
    /// Its correlation time, `ℓ` \[s\].
    pub smooth_s: f64,
    /// Standard deviation of the rough part, `b`.
    pub rough_sd: f64,
    /// Its correlation time, `m` \[s\].
    pub rough_s: f64,
    /// Standard deviation of the white part, `σ`.
    pub noise_sd: f64,
}

/// Least standard deviation of a part that is there, in units of residuals: what numbers in files are rounded to.
const LEAST: f64 = 1e-5;

/// The logarithm of each number of a [`Process`], in the order of its fields.
pub type LogProcess = [f64; Process::COUNT];

impl Process {
    /// Number of its numbers.
    pub const COUNT: usize = 5;

    /// Place of the size of the smooth part among them,
    const SMOOTH: usize = 0;
    /// of that of the rough part,
    const ROUGH: usize = 2;
    /// and of the noise.
    pub const NOISE: usize = 4;

    /// The same of which nothing strays.
    pub fn without_wander(&self) -> Self {
        let nothing = f64::MIN_POSITIVE.sqrt();
        Self {
            smooth_sd: nothing,
            rough_sd: nothing,
            ..*self
        }
    }

    /// Whether it has a part that strays.
    pub fn wanders(&self) -> bool {
        self.has(Self::SMOOTH) || self.has(Self::ROUGH)
    }

    /// Whether a number, by its place in [`LogProcess`], is of a part that is there.
    pub fn has(&self, number: usize) -> bool {
        let size = [
            self.smooth_sd,
            self.smooth_sd,
            self.rough_sd,
            self.rough_sd,
            self.noise_sd,
        ][number];
        size > f64::MIN_POSITIVE.powf(0.25)
    }

    /// Whether a number, by its place in [`LogProcess`], is a size that is the least there is.
    pub fn is_least(&self, number: usize) -> bool {
        let is_least = |size: f64| size <= LEAST * (1.0 + 1e-9);
        match number {
            Self::SMOOTH => is_least(self.smooth_sd),
            Self::ROUGH => is_least(self.rough_sd),
            Self::NOISE => is_least(self.noise_sd),
            _ => false,
        }
    }

    /// Variance of what strays.
    pub fn stray_variance(&self) -> f64 {
        self.smooth_sd.powi(2) + self.rough_sd.powi(2)
    }

    /// Variance of the rate of its smooth part [1/s²].
    pub fn stray_rate_variance(&self) -> f64 {
        3.0 * (self.smooth_sd / self.smooth_s).powi(2)
    }

    /// The same with all sizes so many times as great.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            smooth_sd: factor * self.smooth_sd,
            rough_sd: factor * self.rough_sd,
            noise_sd: factor * self.noise_sd,
            ..*self
        }
    }

    /// What is expected before anything is seen: a hand that strays by about a unit, a tracker a twentieth of it.
    pub const EXPECTED: Self = Self {
        smooth_sd: 1.0,
        smooth_s: 1.1,
        rough_sd: 0.1,
        rough_s: 0.15,
        noise_sd: 0.05,
    };

    /// The logarithms of its numbers.
    pub fn logs(&self) -> LogProcess {
        [
            self.smooth_sd,
            self.smooth_s,
            self.rough_sd,
            self.rough_s,
            self.noise_sd,
        ]
        .map(f64::ln)
    }

    /// The process with these logarithms.
    pub fn of_logs(logs: &LogProcess) -> Self {
        let [smooth_sd, smooth_s, rough_sd, rough_s, noise_sd] = logs.map(f64::exp);
        let of = Self {
            smooth_sd,
            smooth_s,
            rough_sd,
            rough_s,
            noise_sd,
        };
        let at_least = |number: usize, size: f64| match of.has(number) {
            true => size.max(LEAST),
            false => size,
        };
        Self {
            smooth_sd: at_least(Self::SMOOTH, smooth_sd),
            rough_sd: at_least(Self::ROUGH, rough_sd),
            noise_sd: noise_sd.max(LEAST),
            ..of
        }
    }

    /// `P`, whose entries off the diagonal are zero.
    pub fn stationary(&self) -> Matrix3<f64> {
        let rate = self.rate_per_s();
        let speed_sd = rate * self.smooth_sd;
        let each = Vector3::new(self.smooth_sd, speed_sd, self.rough_sd);
        Matrix3::from_diagonal(&each.component_mul(&each))
    }

    /// `F` over a time \[s\].
    pub fn transition(&self, apart_s: f64) -> Matrix3<f64> {
        let rate = self.rate_per_s();
        let along = rate * apart_s;
        let kept = (-along).exp();
        Matrix3::new(
            kept * (1.0 + along),
            kept * apart_s,
            0.0,
            -kept * rate * along,
            kept * (1.0 - along),
            0.0,
            0.0,
            0.0,
            (-apart_s / self.rough_s).exp(),
        )
    }

    /// Covariance of the process without its white part, at times so far apart \[s\].
    pub(super) fn covariance(&self, apart_s: f64) -> f64 {
        let along = self.rate_per_s() * apart_s;
        let smooth = self.smooth_sd.powi(2) * (1.0 + along) * (-along).exp();
        smooth + self.rough_sd.powi(2) * (-apart_s / self.rough_s).exp()
    }

    /// `λ`.
    pub(super) fn rate_per_s(&self) -> f64 {
        3_f64.sqrt() / self.smooth_s
    }
}

/// The greatest change of a logarithm of the numbers of processes.
pub fn change(before: &[Process; 2], after: &[Process; 2]) -> f64 {
    let logs = |of: &[Process; 2]| [of[0].logs(), of[1].logs()].concat();
    let (before, after) = (logs(before), logs(after));
    let pairs = before.iter().zip(&after);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `F` and `P` make the covariance that the kernels state.
    #[test]
    fn its_state_has_the_covariance_of_its_kernels() {
        let process = Process {
            smooth_sd: 1.3,
            smooth_s: 0.7,
            rough_sd: 0.4,
            rough_s: 0.15,
            noise_sd: 0.1,
        };
        let observed = Vector3::new(1.0, 0.0, 1.0);
        for apart_s in [0.0, 0.004, 0.1, 0.8] {
            let moved = process.transition(apart_s) * process.stationary();
            let given = (observed.transpose() * moved * observed).x;
            let stated = process.covariance(apart_s);
            assert!((given - stated).abs() < 1e-14, "{apart_s}");
        }
    }

    /// Over a time and another it becomes what it does over both.
    #[test]
    fn transitions_follow_one_another() {
        let process = Process::EXPECTED;
        let both = process.transition(0.03) * process.transition(0.2);
        assert!((both - process.transition(0.23)).amax() < 1e-14);
    }

    #[test]
    fn logarithms_are_those_of_the_same_process() {
        let again = Process::of_logs(&Process::EXPECTED.logs());
        assert!((again.smooth_s - 1.1).abs() < 1e-15 && (again.noise_sd - 0.05).abs() < 1e-15);
    }
}
