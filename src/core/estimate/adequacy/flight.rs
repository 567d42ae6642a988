//! The test of a flight by itself: is what is left of its samples only errors?
//!
//! A flight that ends at no contact, impact or goal has nothing with which it must agree. What its model leaves out,
//! a force, a torque, contents that move, bends its fall and its turn. Means of the residuals over bins, in deviations
//! of white noise, are looked at beyond the directions `A` that the flight's own fit absorbs:
//!
//! ```text
//! y = Bᵀ r,   B an orthonormal basis of (1 − A A⁺) M,   M = [P₂(t) e_i, P₃(t) e_i]
//! yᵀ (1 + Bᵀ K B)⁻¹ y/d   ~   F(d, ν)
//! ```
//!
//! with Legendre's polynomials of the second and third degree along each axis of place and turn. The size of the wander's
//! covariance `K` is estimated beyond `A` and `M`, so that a bent flight is not taken for a hand: a hand that bends it so much strays in
//! quicker ways, too. All that is beyond `A` is tested alike, for a wander that is as large as any hand's may still be less than
//! what is left; the less probable of the two counts. White noise is compared with all that is beyond `A`.

use nalgebra::{DMatrix, DVector};

use super::alone::Alone;
use super::hand::{Expected, Wander};
use super::part::{self, Part, PartTest};
use crate::estimate::covariance::bins::{Bins, Six};
use crate::estimate::covariance::noise;
use crate::estimate::covariance::trace::Design;
use crate::estimate::terms::context::SolveContext;
use crate::math::span::Span;
use crate::motion::Place;

/// A pivot below which a direction depends on others.
const DEPENDENT: f64 = 1e-6;
/// Least number of mean residuals beyond what is absorbed and bent: fewer tell nothing of their errors.
const LEAST: usize = 6;
/// Least variance of white noise, in squared units: what numbers in files are rounded to.
const ROUNDED: f64 = 1e-10;

/// The test of an arc; `None` where its samples are too few.
pub(super) fn test(context: &SolveContext, alone: &Alone, arc: usize) -> Option<PartTest> {
    let problem = context.problem;
    let bins = Bins::fine(problem, &alone.point, arc);
    if bins.count() == 0 {
        return None;
    }
    let errors = alone.errors[problem.views_of(arc)].to_vec();
    let white = noise::white(&errors).map(|variance| variance.max(ROUNDED));
    let weights = BinWeights::new(&bins, white);
    let design = Design::of(context, &alone.point, &bins, &[arc]);
    let mut known = part::absorbed(context, alone, &bins, &design, &[arc]);
    let columns = |of: &[Vec<Six>]| -> Vec<DVector<f64>> {
        of.iter().map(|column| weights.flat(column)).collect()
    };
    let absorbed = Span::of(&columns(&known), weights.count(), DEPENDENT);
    let bends = bends(&bins);
    let bent = absorbed.beyond(DMatrix::from_columns(&columns(&bends)));
    let bent: Vec<DVector<f64>> = bent.column_iter().map(|of| of.into_owned()).collect();
    let beyond = bins.dimension().saturating_sub(absorbed.rank());
    let basis = Span::of(&bent, weights.count() - absorbed.rank(), DEPENDENT).basis();
    if beyond < basis.ncols() + LEAST || basis.ncols() == 0 {
        return None;
    }
    known.extend(bends);
    let hands = part::hands(context, &bins, &errors, &known, white, Expected::Usual);
    let means = weights.flat(&bins.mean_residuals(&errors));
    let left = absorbed.beyond(DMatrix::from_columns(&[means]));
    let wander = weights.wander(&hands);
    let wander = absorbed.beyond(absorbed.beyond(wander).transpose());
    // Each second difference tells about half of what a sample would.
    let noise_freedom = part::seen(&errors).saturating_sub(absorbed.rank()) / 2;
    let by_noise = part::tested(left.norm_squared(), beyond, noise_freedom)?;
    let bend = square(&basis.tr_mul(&left), &(basis.tr_mul(&wander) * &basis))?;
    let bend = part::tested(bend, basis.ncols(), beyond - basis.ncols())?;
    let all = part::tested(square(&left, &wander)?, beyond, beyond)?;
    let mut by_hand = if all.probability < bend.probability {
        all
    } else {
        bend
    };
    by_hand.probability = (2.0 * by_hand.probability).min(1.0);
    let times_s = problem.arcs[arc].views.iter().flat_map(|view| {
        let samples = view.samples.iter();
        samples.map(|sample| problem.sample_time_s(arc, view.track, sample, &alone.point))
    });
    let place = Place::Flight {
        mechanism: problem.arcs[arc].mechanism,
        start_s: times_s.fold(f64::INFINITY, f64::min),
    };
    Some(PartTest::new(
        Part::Flight(arc),
        place,
        white,
        &hands,
        by_noise,
        by_hand,
    ))
}

/// `yᵀ (1 + K)⁻¹ y` of one column.
fn square(column: &DMatrix<f64>, wander: &DMatrix<f64>) -> Option<f64> {
    let covariance = DMatrix::identity(wander.nrows(), wander.ncols()) + wander;
    Some(column.dot(&covariance.cholesky()?.solve(column)))
}

/// The polynomials along each axis, at the bins.
fn bends(bins: &Bins) -> Vec<Vec<Six>> {
    let times = || bins.bins.iter().map(|bin| bin.time_s);
    let from_s = times().fold(f64::INFINITY, f64::min);
    let to_s = times().fold(f64::NEG_INFINITY, f64::max);
    let second = |x: f64| 0.5 * (3.0 * x * x - 1.0);
    let third = |x: f64| 0.5 * (5.0 * x * x - 3.0) * x;
    let of_axis = |axis: usize| {
        [second, third as fn(f64) -> f64].map(|polynomial| {
            let along = |time_s: f64| {
                let mut six = [0.0; 6];
                six[axis] = polynomial((2.0 * time_s - from_s - to_s) / (to_s - from_s));
                six
            };
            times().map(along).collect()
        })
    };
    (0..6).flat_map(of_axis).collect()
}

/// Weights of the bins' means, axis by axis: the inverse deviations of white noise, and zero of what is not seen.
struct BinWeights<'b> {
    bins: &'b Bins,
    white: [f64; 2],
}

impl<'b> BinWeights<'b> {
    fn new(bins: &'b Bins, white: [f64; 2]) -> Self {
        Self { bins, white }
    }

    /// Number of means.
    fn count(&self) -> usize {
        6 * self.bins.count()
    }

    fn of(&self, row: usize) -> f64 {
        let (bin, kind) = (&self.bins.bins[row / 6], row % 6 / 3);
        match bin.kinds[kind] {
            true => (bin.samples as f64 / self.white[kind]).sqrt(),
            false => 0.0,
        }
    }

    /// A column, weighted.
    fn flat(&self, column: &[Six]) -> DVector<f64> {
        DVector::from_fn(self.count(), |row, _| {
            self.of(row) * column[row / 6][row % 6]
        })
    }

    /// Covariance of the wander, weighted.
    fn wander(&self, hands: &[Wander; 2]) -> DMatrix<f64> {
        DMatrix::from_fn(self.count(), self.count(), |row, column| {
            if row % 6 != column % 6 {
                return 0.0;
            }
            let hand = &hands[row % 6 / 3];
            hand.between(row / 6, column / 6) * self.of(row) * self.of(column)
        })
    }
}
