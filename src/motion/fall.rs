//! Stretches of a path that are free flights, told by the path alone.
//!
//! A flight without drag is a parabola, `p(t) = c₀ + c₁ t + c₂ t²`. One is looked for where a window of
//! samples has the acceleration that is wanted, `a = 2 c₂`, and grown sample by sample: the next one
//! belongs to it while its distance `r` from the parabola through those before is what their own scatter
//! `σ` lets expect, `r² ≤ 3 σ² (1 + h) F`, with `h` the leverage of the prediction and `F` a quantile of
//! Fisher's distribution for three numbers. So the scatter is the path's own, whatever the tracker.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

/// Lengths of the windows that are tried, the shortest that tells its acceleration to
/// [`SEED_RELATIVE_SD`] at each place \[samples\].
const SEED_SAMPLES: [usize; 8] = [7, 10, 14, 20, 28, 40, 80, 160];
const SEED_RELATIVE_SD: f64 = 0.1;
/// Limits of `F` at infinitely many degrees of freedom, the first that makes a flight: the quantile of Fisher's
/// distribution to one in ten thousand is the second, four times as much lets a flight drift by drag or a
/// tracker's distortion, and is still far less than an impact makes of it.
const F_LIMITS: [f64; 2] = [30.0, 7.0];
/// By how much more over the number of degrees of freedom they are greater.
const F_FEW: f64 = 12.0;
/// Least scatter, over what the acceleration bends the path by: of paths without any, what rounding leaves.
const SCATTER_MIN: f64 = 1e-4;
/// Either half of a flight accelerates as the whole, up to this share: a hand's swing does not.
const HALVES_SHARE: f64 = 0.25;
/// Least number of samples of a half.
const HALF_SAMPLES: usize = 4;
/// Flights are as exact as the most exact one, up to this factor; what is less is no flight.
const SCATTER_RATIO: f64 = 8.0;

/// A stretch that is a free flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Fall {
    /// Its samples.
    pub samples: Range<usize>,
    /// Its acceleration [unit of the path over s²],
    pub acceleration: Vector3<f64>,
    /// and the standard deviation of each component.
    pub acceleration_sd: f64,
    /// Scatter of the samples about it, per axis [unit of the path].
    pub scatter: f64,
}

/// The flights of a path, in order: stretches of seven samples or more on a parabola whose acceleration, given
/// with its standard deviation, is wanted. Times \[s\] increase.
pub fn falls(
    times_s: &[f64],
    points: &[Vector3<f64>],
    is_wanted: impl Fn(&Vector3<f64>, f64) -> bool,
) -> Vec<Fall> {
    let count = times_s.len().min(points.len());
    let path = Path {
        times_s: &times_s[..count],
        points: &points[..count],
    };
    let mut seeds: Vec<(f64, Range<usize>)> = (0..count)
        .filter_map(|begin| {
            let seed = path.seed(begin, &is_wanted)?;
            Some((seed.scatter, seed.samples))
        })
        .collect();
    // The most exact first: one that reaches over a kink is none of them.
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.start.cmp(&b.1.start)));
    let mut is_used = vec![false; count];
    let mut found: Vec<Fall> = Vec::new();
    for (_, seed) in seeds {
        if is_used[seed.clone()].iter().any(|used| *used) {
            continue;
        }
        let limit = found.first().map_or(f64::INFINITY, |best| best.scatter);
        let grown = F_LIMITS.iter().filter_map(|f_limit| {
            let grown = path.grown(seed.clone(), &is_used, *f_limit);
            Some(path.parabola(grown)?.fall())
        });
        let fall = { grown }.find(|fall| {
            fall.scatter <= SCATTER_RATIO * limit
                && is_wanted(&fall.acceleration, fall.acceleration_sd)
                && path.is_steady(fall)
        });
        if let Some(fall) = fall {
            is_used[fall.samples.clone()].fill(true);
            found.push(fall);
        }
    }
    found.sort_by_key(|fall| fall.samples.start);
    found
}

/// The acceleration of the parabola through a path, and the standard deviation of each component [unit of the
/// path over s²]; `None` for fewer than four samples.
pub fn acceleration(times_s: &[f64], points: &[Vector3<f64>]) -> Option<(Vector3<f64>, f64)> {
    let path = Path { times_s, points };
    let fall = path.parabola(0..times_s.len().min(points.len()))?.fall();
    Some((fall.acceleration, fall.acceleration_sd))
}

#[derive(Clone, Copy)]
struct Path<'a> {
    times_s: &'a [f64],
    points: &'a [Vector3<f64>],
}

/// The parabola of least squares through some samples.
struct Parabola {
    samples: Range<usize>,
    middle_s: f64,
    /// Time is counted in halves of the stretch.
    half_s: f64,
    coefficients: [Vector3<f64>; 3],
    covariance: Matrix3<f64>,
    scatter: f64,
}

impl Path<'_> {
    fn parabola(self, samples: Range<usize>) -> Option<Parabola> {
        let times_s = &self.times_s[samples.clone()];
        let points = &self.points[samples.clone()];
        let (first_s, last_s) = (*times_s.first()?, *times_s.last()?);
        let (middle_s, half_s) = (0.5 * (first_s + last_s), 0.5 * (last_s - first_s));
        if times_s.len() < 4 || !(half_s > 0.0) {
            return None;
        }
        let powers = |time_s: f64| {
            let u = (time_s - middle_s) / half_s;
            Vector3::new(1.0, u, u * u)
        };
        // About its own first point, so that squares of a distant origin do not swamp it.
        let origin = points[0];
        let mut gram = Matrix3::zeros();
        let mut moments = Matrix3::zeros();
        for (time_s, point) in times_s.iter().zip(points) {
            let powers = powers(*time_s);
            gram += powers * powers.transpose();
            moments += powers * (point - origin).transpose();
        }
        let covariance = gram.try_inverse()?;
        let solution = covariance * moments;
        let mut coefficients: [Vector3<f64>; 3] =
            std::array::from_fn(|power| solution.row(power).transpose());
        let left = times_s.iter().zip(points).map(|(time_s, point)| {
            let at = solution.transpose() * powers(*time_s);
            (point - origin - at).norm_squared()
        });
        let squares: f64 = left.sum();
        coefficients[0] += origin;
        let freedom = 3.0 * (times_s.len() as f64 - 3.0);
        let least = SCATTER_MIN * coefficients[2].norm();
        let scatter = (squares / freedom).sqrt().max(least);
        scatter.is_finite().then_some(Parabola {
            samples,
            middle_s,
            half_s,
            coefficients,
            covariance,
            scatter,
        })
    }

    /// The shortest window from a sample on that tells its acceleration, if that is wanted.
    fn seed(self, begin: usize, is_wanted: impl Fn(&Vector3<f64>, f64) -> bool) -> Option<Fall> {
        let windows = SEED_SAMPLES.iter().map(|count| begin..begin + count);
        let windows = windows.take_while(|window| window.end <= self.times_s.len());
        let mut falls = windows.filter_map(|window| Some(self.parabola(window)?.fall()));
        let told = falls
            .find(|fall| fall.acceleration_sd <= SEED_RELATIVE_SD * fall.acceleration.norm())?;
        is_wanted(&told.acceleration, told.acceleration_sd).then_some(told)
    }

    /// Whether both halves accelerate as the whole does.
    fn is_steady(self, fall: &Fall) -> bool {
        let Range { start, end } = fall.samples.clone();
        let half = ((end - start) / 2).max(HALF_SAMPLES);
        [start..start + half, end - half..end]
            .into_iter()
            .filter_map(|samples| self.parabola(samples))
            .all(|parabola| {
                let parabola = Parabola {
                    scatter: parabola.scatter.max(fall.scatter),
                    ..parabola
                };
                let of = parabola.fall();
                let off = (of.acceleration - fall.acceleration).norm();
                off <= HALVES_SHARE * fall.acceleration.norm() + 3.0 * of.acceleration_sd
            })
    }

    /// The stretch about a window up to where samples leave its parabola, or are used.
    fn grown(self, seed: Range<usize>, is_used: &[bool], f_limit: f64) -> Range<usize> {
        let mut range = seed;
        loop {
            let next = range.end;
            if next >= self.times_s.len() || is_used[next] || !self.belongs(&range, next, f_limit) {
                break;
            }
            range.end = next + 1;
        }
        while let Some(next) = range.start.checked_sub(1) {
            if is_used[next] || !self.belongs(&range, next, f_limit) {
                break;
            }
            range.start = next;
        }
        range
    }

    fn belongs(self, range: &Range<usize>, next: usize, f_limit: f64) -> bool {
        self.parabola(range.clone()).is_some_and(|parabola| {
            let (time_s, point) = (self.times_s[next], self.points[next]);
            parabola.expects(time_s, &point, f_limit)
        })
    }
}

impl Parabola {
    fn powers(&self, time_s: f64) -> Vector3<f64> {
        let u = (time_s - self.middle_s) / self.half_s;
        Vector3::new(1.0, u, u * u)
    }

    /// Whether a sample beyond the ends is where the others let expect it.
    fn expects(&self, time_s: f64, point: &Vector3<f64>, f_limit: f64) -> bool {
        let powers = self.powers(time_s);
        let terms = self.coefficients.iter().zip(powers.iter());
        let at: Vector3<f64> = terms.map(|(c, power)| c * *power).sum();
        let leverage = (powers.transpose() * self.covariance * powers)[0];
        let freedom = 3.0 * (self.samples.len() as f64 - 3.0);
        let limit = f_limit * (1.0 + F_FEW / freedom);
        let off = (point - at).norm_squared();
        off <= 3.0 * self.scatter.powi(2) * (1.0 + leverage) * limit
    }

    fn fall(self) -> Fall {
        let per_s2 = 2.0 / self.half_s.powi(2);
        Fall {
            acceleration: self.coefficients[2] * per_s2,
            acceleration_sd: self.scatter * self.covariance[(2, 2)].sqrt() * per_s2,
            scatter: self.scatter,
            samples: self.samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RATE_HZ: f64 = 150.0;
    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.8);

    fn is_gravity(of: &Vector3<f64>, sd: f64) -> bool {
        (of - GRAVITY).norm() <= 1.5 + 3.0 * sd
    }

    /// Carried by a hand for a while, thrown, bounced at once after so many seconds, then at rest.
    fn toss(noise: f64) -> (Vec<f64>, Vec<Vector3<f64>>) {
        let path = |t: f64| {
            if t < 0.5 {
                // A hand that gathers pace upwards as it throws.
                Vector3::new(0.2 * t, 0.0, 0.4 + 8.0 * t * t * t)
            } else if t < 1.1 {
                let s = t - 0.5;
                Vector3::new(0.1 + 0.3 * s, 0.0, 1.4 + 1.2 * s - 4.9 * s * s)
            } else if t < 1.4 {
                let s = t - 1.1;
                Vector3::new(0.28 + 0.1 * s, 0.0, 0.356 + 1.0 * s - 4.9 * s * s)
            } else {
                Vector3::new(0.31, 0.0, 0.215)
            }
        };
        let times = (0..270).map(|i| f64::from(i) / RATE_HZ);
        let points = times.clone().enumerate().map(|(i, t)| {
            let i = i as f64;
            let wobble = Vector3::new((12.9 * i).sin(), (78.2 * i).sin(), (37.7 * i).sin());
            path(t) + wobble * noise
        });
        (times.collect(), points.collect())
    }

    #[test]
    fn flights_are_found_from_release_to_impact_whatever_the_noise() {
        for noise in [0.0, 2e-5, 1e-3] {
            let (times_s, points) = toss(noise);
            let found = falls(&times_s, &points, is_gravity);
            let [first, second] = &found[..] else {
                panic!("{noise}: {found:?}");
            };
            for (found, begin_s, end_s) in [(first, 0.5, 1.1), (second, 1.1, 1.4)] {
                let (begin, end) = (begin_s * RATE_HZ, end_s * RATE_HZ);
                let off_begin = found.samples.start as f64 - begin;
                let off_end = found.samples.end as f64 - end;
                assert!(off_begin.abs() <= 4.0, "{noise}: {found:?}");
                assert!((-1.0..=2.0).contains(&off_end), "{noise}: {found:?}");
                assert!(
                    (found.acceleration - GRAVITY).norm() < 0.3,
                    "{noise}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn a_hand_and_a_rest_are_no_flights() {
        let times_s: Vec<f64> = (0..300).map(|i| f64::from(i) / RATE_HZ).collect();
        let swing = times_s
            .iter()
            .map(|t| Vector3::new((3.0 * t).sin(), 0.2, (2.0 * t).cos()));
        let rest = times_s.iter().map(|_| Vector3::new(1.0, 2.0, 3.0));
        assert!(falls(&times_s, &swing.collect::<Vec<_>>(), is_gravity).is_empty());
        assert!(falls(&times_s, &rest.collect::<Vec<_>>(), is_gravity).is_empty());
    }

    proptest! {
        #[test]
        fn any_path_is_answered_with_stretches_in_order(
            steps in prop::collection::vec((0.0..0.02, prop::array::uniform3(-1.0..1.0)), 0..120),
            scale in prop::sample::select(vec![0.0, 1e-9, 1.0, 1e12]),
        ) {
            let mut time_s = 0.0;
            let (times_s, points): (Vec<f64>, Vec<Vector3<f64>>) = steps
                .into_iter()
                .map(|(step_s, at): (f64, [f64; 3])| {
                    time_s += step_s;
                    (time_s, Vector3::from(at) * scale)
                })
                .unzip();
            let found = falls(&times_s, &points, |_, _| true);
            for fall in &found {
                prop_assert!(fall.samples.len() >= 7 && fall.samples.end <= times_s.len());
            }
            for pair in found.windows(2) {
                prop_assert!(pair[0].samples.end <= pair[1].samples.start);
            }
        }
    }
}
