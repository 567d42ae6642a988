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
/// Windows of so many samples and more are tried at each eighth of their length alone: what takes so many to be told
/// is long.
const LONG_SAMPLES: usize = 40;
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
/// A parabola that grows is fitted anew when it has become longer by this share: until then it is updated
/// sample by sample, so that a search takes time in proportion to the samples.
const ANEW_SHARE: f64 = 0.5;
/// A sample that was in so many stretches that turned out to be no flight begins no further one.
const TRIES_MAX: u8 = 8;

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
    let path = FallPath {
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
    let mut tries = vec![0_u8; count];
    let mut found: Vec<Fall> = Vec::new();
    for (_, seed) in seeds {
        let middle = (seed.start + seed.end) / 2;
        if tries[middle] >= TRIES_MAX || is_used[seed.clone()].iter().any(|used| *used) {
            continue;
        }
        let limit = found.first().map_or(f64::INFINITY, |best| best.scatter);
        let mut longest = seed.clone();
        let grown = F_LIMITS.iter().filter_map(|f_limit| {
            let grown = path.grown(seed.clone(), &is_used, *f_limit);
            longest = longest.start.min(grown.start)..longest.end.max(grown.end);
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
        } else {
            for tried in &mut tries[longest] {
                *tried = tried.saturating_add(1);
            }
        }
    }
    found.sort_by_key(|fall| fall.samples.start);
    found
}

/// The acceleration of the parabola through a path, and the standard deviation of each component [unit of the
/// path over s²]; `None` for fewer than four samples.
pub fn acceleration(times_s: &[f64], points: &[Vector3<f64>]) -> Option<(Vector3<f64>, f64)> {
    let path = FallPath { times_s, points };
    let fall = path.parabola(0..times_s.len().min(points.len()))?.fall();
    Some((fall.acceleration, fall.acceleration_sd))
}

#[derive(Clone, Copy)]
struct FallPath<'a> {
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
    /// Sum of the squares of what is left.
    squares: f64,
    scatter: f64,
}

impl FallPath<'_> {
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
        let parabola = Parabola {
            samples,
            middle_s,
            half_s,
            coefficients,
            covariance,
            squares,
            scatter: 0.0,
        };
        parabola.scattered()
    }

    /// The shortest window from a sample on that tells its acceleration, if that is wanted.
    fn seed(self, begin: usize, is_wanted: impl Fn(&Vector3<f64>, f64) -> bool) -> Option<Fall> {
        let mut parabola: Option<Parabola> = None;
        for count in SEED_SAMPLES {
            let window = begin..begin + count;
            let is_between = count >= LONG_SAMPLES && !begin.is_multiple_of(count / 8);
            if is_between || window.end > self.times_s.len() {
                return None;
            }
            let longer = match parabola.take() {
                Some(shorter) => self.lengthened(shorter, window.end),
                None => self.parabola(window),
            };
            let told = longer?;
            let fall = told.fall();
            if fall.acceleration_sd <= SEED_RELATIVE_SD * fall.acceleration.norm() {
                return is_wanted(&fall.acceleration, fall.acceleration_sd).then_some(fall);
            }
            parabola = Some(told);
        }
        None
    }

    /// A parabola with the samples up to an end as well.
    fn lengthened(self, mut parabola: Parabola, end: usize) -> Option<Parabola> {
        while parabola.samples.end < end {
            let next = parabola.samples.end;
            parabola.samples.end = next + 1;
            parabola = parabola.with(self.times_s[next], &self.points[next])?;
        }
        Some(parabola)
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
        let mut range = seed.clone();
        let Some(mut parabola) = self.parabola(seed) else {
            return range;
        };
        let mut fitted = range.len();
        // First to the end, then to the begin.
        for is_forward in [true, false] {
            loop {
                let next = match is_forward {
                    true => Some(range.end).filter(|next| *next < self.times_s.len()),
                    false => range.start.checked_sub(1),
                };
                let Some(next) = next.filter(|next| !is_used[*next]) else {
                    break;
                };
                let (time_s, point) = (self.times_s[next], &self.points[next]);
                if !parabola.expects(time_s, point, f_limit) {
                    break;
                }
                range = range.start.min(next)..range.end.max(next + 1);
                parabola.samples = range.clone();
                let longer = if range.len() as f64 > fitted as f64 * (1.0 + ANEW_SHARE) {
                    fitted = range.len();
                    self.parabola(range.clone())
                } else {
                    parabola.with(time_s, point)
                };
                let Some(longer) = longer else {
                    return range;
                };
                parabola = longer;
            }
        }
        range
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
        let at = self.at(&powers);
        let leverage = (powers.transpose() * self.covariance * powers)[0];
        let freedom = 3.0 * (self.samples.len() as f64 - 3.0);
        let limit = f_limit * (1.0 + F_FEW / freedom);
        let off = (point - at).norm_squared();
        off <= 3.0 * self.scatter.powi(2) * (1.0 + leverage) * limit
    }

    /// With its scatter; `None` where that is no number.
    fn scattered(self) -> Option<Self> {
        let freedom = 3.0 * (self.samples.len() as f64 - 3.0);
        let least = SCATTER_MIN * self.coefficients[2].norm();
        let scatter = (self.squares / freedom).sqrt().max(least);
        scatter.is_finite().then_some(Self { scatter, ..self })
    }

    /// The parabola of least squares through one sample more, which its samples count already: the update of
    /// recursive least squares, exact but for rounding.
    fn with(mut self, time_s: f64, point: &Vector3<f64>) -> Option<Self> {
        let powers = self.powers(time_s);
        let spread = self.covariance * powers;
        let weight = 1.0 / (1.0 + powers.dot(&spread));
        let off = point - self.at(&powers);
        for (coefficient, gain) in self.coefficients.iter_mut().zip(spread.iter()) {
            *coefficient += off * (gain * weight);
        }
        self.covariance -= spread * spread.transpose() * weight;
        self.squares += off.norm_squared() * weight;
        self.scattered()
    }

    fn at(&self, powers: &Vector3<f64>) -> Vector3<f64> {
        let terms = self.coefficients.iter().zip(powers.iter());
        terms.map(|(c, power)| c * *power).sum()
    }

    fn fall(&self) -> Fall {
        let per_s2 = 2.0 / self.half_s.powi(2);
        Fall {
            acceleration: self.coefficients[2] * per_s2,
            acceleration_sd: self.scatter * self.covariance[(2, 2)].sqrt() * per_s2,
            scatter: self.scatter,
            samples: self.samples.clone(),
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

    #[test]
    fn long_paths_are_searched_too() {
        // Tosses and a hand in turn, and a path that is a parabola all along and yet no flight.
        let (toss_s, toss) = toss(1e-3);
        let repeats = 4_000 / toss.len();
        let many: Vec<Vector3<f64>> = toss
            .iter()
            .cycle()
            .take(repeats * toss.len())
            .copied()
            .collect();
        let many_s: Vec<f64> = (0..many.len()).map(|i| i as f64 / RATE_HZ).collect();
        let found = falls(&many_s, &many, is_gravity);
        let of_one = falls(&toss_s, &toss, is_gravity).len();
        assert!(
            found.len() >= repeats * of_one,
            "{} of {}",
            found.len(),
            repeats * of_one
        );
        let bent = many_s.iter().enumerate().map(|(i, t)| {
            let sway = 0.4 * (0.5 * t).sin();
            let wobble = Vector3::new((12.9 * i as f64).sin(), (78.2 * i as f64).sin(), 0.0) * 1e-3;
            Vector3::new(0.0, 0.0, -4.9 * t * t + sway) + wobble
        });
        assert!(falls(&many_s, &bent.collect::<Vec<_>>(), is_gravity).len() < repeats);
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
