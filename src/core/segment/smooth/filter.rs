//! The fixed-interval smoother: Kalman's filter forward, then the recursion of Rauch, Tung and
//! Striebel backward (AIAA Journal 3, 1965). It is linear in the number of samples; for places it is
//! exact, for orientations exact to first order in errors.

use nalgebra::{Cholesky, Matrix3, SMatrix, U9, Vector3};

use super::chain::{Chain, Nine, Nines};

/// Strengths of the noises of a chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noises {
    /// Variance of a reading per axis.
    pub(super) reading: f64,
    /// Spectral density of the jerk per axis.
    pub(super) jerk: f64,
}

/// A time of the smoother, with what was read there, if anything.
#[derive(Clone, Debug)]
pub(super) struct Timed<R> {
    pub(super) time_s: f64,
    pub(super) reading: Option<R>,
}

/// A chain with the covariance of its error.
#[derive(Clone, Debug)]
pub(super) struct Believed<C> {
    pub(super) chain: C,
    pub(super) covariance: Nines,
}

/// One step of the filter.
struct FilterStep<C> {
    /// Before the reading.
    predicted: Believed<C>,
    /// After it.
    updated: Believed<C>,
    /// How errors grew since the step before.
    transition: Nines,
}

/// Minus twice the logarithm of the likelihood of the readings, up to a constant, as a sum.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Surprise {
    /// Number of readings counted.
    pub(super) readings: usize,
    /// `Σ eᵀ S⁻¹ e` of the innovations `e` with covariances `S`.
    pub(super) square: f64,
    /// `Σ log|S|`.
    pub(super) log_determinant: f64,
}

impl Surprise {
    pub(super) fn add(&mut self, other: &Self) {
        self.readings += other.readings;
        self.square += other.square;
        self.log_determinant += other.log_determinant;
    }

    /// Number of numbers read, at least one.
    pub(super) fn count(&self) -> f64 {
        3.0 * self.readings.max(1) as f64
    }
}

/// Readings that only begin the filter: value, rate and acceleration.
const BEGINNING: usize = 3;
/// Standard deviations of rate and acceleration at the first reading, as multiples of the greatest
/// rate between two readings, and of that over an interval.
const VAGUE: f64 = 10.0;

/// Filters and smooths; the states at all times. The first has a reading, and there are at least two.
pub(super) fn smooth<C: Chain>(timed: &[Timed<C::Reading>], noises: &Noises) -> Vec<Believed<C>> {
    let mut surprise = Surprise::default();
    let steps: Vec<FilterStep<C>> = filter(timed, noises, &mut surprise);
    let mut smoothed: Vec<Believed<C>> = Vec::with_capacity(steps.len());
    let mut after: Option<&FilterStep<C>> = None;
    for step in steps.iter().rev() {
        let here = match (after, smoothed.last()) {
            (Some(next), Some(later)) => backward(&step.updated, next, later),
            _ => step.updated.clone(),
        };
        smoothed.push(here);
        after = Some(step);
    }
    smoothed.reverse();
    smoothed
}

/// How surprising the readings are under these noises.
pub(super) fn surprise<C: Chain>(timed: &[Timed<C::Reading>], noises: &Noises) -> Surprise {
    let mut surprise = Surprise::default();
    filter::<C>(timed, noises, &mut surprise);
    surprise
}

/// The same up to each of the readings.
pub(super) fn surprises<C: Chain>(timed: &[Timed<C::Reading>], noises: &Noises) -> Vec<Surprise> {
    let mut sums = Vec::with_capacity(timed.len());
    filter_each::<C>(timed, noises, &mut Surprise::default(), |sum| {
        sums.push(*sum)
    });
    sums
}

fn filter<C: Chain>(
    timed: &[Timed<C::Reading>],
    noises: &Noises,
    surprise: &mut Surprise,
) -> Vec<FilterStep<C>> {
    filter_each(timed, noises, surprise, |_| ())
}

/// Calls `each` with the sum after every step.
fn filter_each<C: Chain>(
    timed: &[Timed<C::Reading>],
    noises: &Noises,
    surprise: &mut Surprise,
    mut each: impl FnMut(&Surprise),
) -> Vec<FilterStep<C>> {
    let mut steps: Vec<FilterStep<C>> = Vec::with_capacity(timed.len());
    let mut read = 0;
    for (index, one) in timed.iter().enumerate() {
        let (predicted, transition) = match steps.last() {
            None => (begin(timed, noises), Nines::identity()),
            Some(before) => {
                let lasting_s = one.time_s - timed[index - 1].time_s;
                predict(&before.updated, lasting_s, noises)
            }
        };
        let updated = match &one.reading {
            None => predicted.clone(),
            Some(reading) => {
                let counted = (read >= BEGINNING).then_some(&mut *surprise);
                read += 1;
                update(&predicted, reading, noises, counted)
            }
        };
        steps.push(FilterStep {
            predicted,
            updated,
            transition,
        });
        each(surprise);
    }
    steps
}

/// A vague belief at the first reading.
fn begin<C: Chain>(timed: &[Timed<C::Reading>], noises: &Noises) -> Believed<C> {
    let read = || {
        timed
            .iter()
            .filter_map(|one| Some((one.time_s, one.reading.as_ref()?)))
    };
    let pairs = || read().zip(read().skip(1));
    let shortest_s = pairs()
        .map(|(from, to)| to.0 - from.0)
        .fold(f64::INFINITY, f64::min);
    let rates = pairs().map(|(from, to)| C::apart(from.1, to.1) / (to.0 - from.0));
    let fastest = rates.fold(0.0, f64::max);
    let noise = noises.reading.sqrt();
    let vague_rate = VAGUE * (fastest + noise / shortest_s);
    let vague_acceleration = vague_rate / shortest_s;
    let mut covariance = Nines::zeros();
    for axis in 0..3 {
        covariance[(axis, axis)] = VAGUE * VAGUE * noises.reading;
        covariance[(3 + axis, 3 + axis)] = vague_rate * vague_rate;
        covariance[(6 + axis, 6 + axis)] = vague_acceleration * vague_acceleration;
    }
    let (from, to) = pairs().next().expect("at least two readings");
    Believed {
        chain: C::begin(from.1, to.1, to.0 - from.0),
        covariance,
    }
}

/// What is believed of a chain some time before or after it is believed so \[s\], where nothing else is read.
pub(super) fn beyond<C: Chain>(from: &Believed<C>, by_s: f64, noises: &Noises) -> Believed<C> {
    predict(from, by_s, noises).0
}

fn predict<C: Chain>(from: &Believed<C>, h: f64, noises: &Noises) -> (Believed<C>, Nines) {
    let (chain, transition) = from.chain.advance(h);
    let mut covariance = transition * from.covariance * transition.transpose();
    // The covariance of integrals of white noise; backward, the odd ones have the other sign, as the powers do.
    let growth = [
        [h.powi(5) / 20.0, h.powi(4) / 8.0, h.powi(3) / 6.0],
        [h.powi(4) / 8.0, h.powi(3) / 3.0, h * h / 2.0],
        [h.powi(3) / 6.0, h * h / 2.0, h],
    ];
    for (row, of_row) in growth.iter().enumerate() {
        for (column, entry) in of_row.iter().enumerate() {
            for axis in 0..3 {
                covariance[(3 * row + axis, 3 * column + axis)] += entry * noises.jerk * h.signum();
            }
        }
    }
    (Believed { chain, covariance }, transition)
}

/// The belief after a reading, in Joseph's form, which stays positive.
fn update<C: Chain>(
    predicted: &Believed<C>,
    reading: &C::Reading,
    noises: &Noises,
    counted: Option<&mut Surprise>,
) -> Believed<C> {
    let miss: Vector3<f64> = predicted.chain.miss(reading);
    let of_value = predicted.covariance.fixed_columns::<3>(0).into_owned();
    let mut spread: Matrix3<f64> = of_value.fixed_rows::<3>(0).into();
    for axis in 0..3 {
        spread[(axis, axis)] += noises.reading;
    }
    // Only of numbers beyond all measure, which the caller refuses afterwards.
    let Some(factor) = Cholesky::new(spread) else {
        return predicted.clone();
    };
    if let Some(surprise) = counted {
        surprise.readings += 1;
        surprise.square += miss.dot(&factor.solve(&miss));
        let diagonal = factor.l_dirty().diagonal();
        surprise.log_determinant += 2.0 * diagonal.map(f64::ln).sum();
    }
    let gain: SMatrix<f64, 9, 3> = of_value * factor.inverse();
    let mut kept = Nines::identity();
    let mut value = kept.fixed_columns_mut::<3>(0);
    value -= gain;
    let covariance =
        kept * predicted.covariance * kept.transpose() + gain * gain.transpose() * noises.reading;
    Believed {
        chain: predicted.chain.retract(&(gain * miss)),
        covariance: symmetric(&covariance),
    }
}

/// The belief at a time with all readings, given that at the next.
fn backward<C: Chain>(
    here: &Believed<C>,
    next: &FilterStep<C>,
    later: &Believed<C>,
) -> Believed<C> {
    let across = next.transition * here.covariance;
    let Some(gain) = solved(&next.predicted.covariance, &across) else {
        return here.clone();
    };
    let gain = gain.transpose();
    let correction: Nine = gain * later.chain.minus(&next.predicted.chain);
    let spread = later.covariance - next.predicted.covariance;
    Believed {
        chain: here.chain.retract(&correction),
        covariance: symmetric(&(here.covariance + gain * spread * gain.transpose())),
    }
}

/// `A⁻¹ B` of a covariance `A`, in the units of its diagonal.
fn solved(covariance: &Nines, right: &Nines) -> Option<Nines> {
    let scale = covariance
        .diagonal()
        .map(|variance| variance.sqrt().recip());
    let scaled = Nines::from_fn(|i, j| covariance[(i, j)] * scale[i] * scale[j]);
    let factor: Cholesky<f64, U9> = Cholesky::new(scaled)?;
    let right = Nines::from_fn(|i, j| right[(i, j)] * scale[i]);
    let solved = factor.solve(&right);
    Some(Nines::from_fn(|i, j| solved[(i, j)] * scale[i]))
}

fn symmetric(covariance: &Nines) -> Nines {
    0.5 * (covariance + covariance.transpose())
}
