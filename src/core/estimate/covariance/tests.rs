//! Compares the parts with independent computations: numeric derivatives, dense algebra, made
//! noise.

use std::cell::Cell;

use nalgebra::{DMatrix, DVector};

use super::bins::{Bin, Bins, Residuals, Six};
use super::likelihood::{Columns, Cosines, log_likelihood};
use super::noise::Noise;
use super::trace::Design;
use super::{Covariance, Moment};
use crate::estimate::outcome;
use crate::estimate::terms::context::Guidance;
use crate::estimate::tests::each_case;
use crate::motion::TrackIndex;
use crate::optimise::Program;

/// Pseudo-random noise from a fixed seed, uniform with variance one.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        3_f64.sqrt() * ((self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    }

    fn six(&mut self) -> Six {
        std::array::from_fn(|_| self.next())
    }
}

#[test]
fn traces_are_the_residuals_derivatives() {
    each_case(0.0, |context, _, point, lengths| {
        let problem = context.problem;
        let mut random = Random(7);
        let step = DVector::from_iterator(lengths.len(), lengths.iter().map(|l| l * random.next()));
        let bins = Bins::new(problem, point);
        let residuals = |share: f64| {
            let mut there = point.clone();
            there.retract_from(point, problem, context.layout, &(&step * share));
            let errors = outcome::errors(problem, context, &there).into_iter();
            errors.flat_map(|of| of.each).collect::<Vec<Six>>()
        };
        const SHARE: f64 = 1e-5;
        let (before, after) = (residuals(-SHARE), residuals(SHARE));
        let (mut sums, mut squares) = (vec![[0.0; 6]; bins.count()], [0.0; 2]);
        for ((before, after), bin) in before.iter().zip(&after).zip(&bins.of_samples) {
            for axis in 0..6 {
                let change = (after[axis] - before[axis]) / (2.0 * SHARE);
                sums[*bin][axis] += change;
                squares[axis / 3] += change * change;
            }
        }
        let exact = Design::new(context, point, &bins).trace(&step);
        let agree = |numeric: f64, exact: f64| {
            let error = (numeric - exact).abs();
            assert!(error < 1e-5 * (1.0 + numeric.abs()), "{numeric} {exact}");
        };
        for (numeric, exact) in sums.iter().flatten().zip(exact.sums.iter().flatten()) {
            agree(*numeric, *exact);
        }
        agree(squares[0], exact.squares[0]);
        agree(squares[1], exact.squares[1]);
    });
}

/// One sum at a time goes along all samples; together they go over products of pairs.
#[test]
fn what_is_told_of_unknowns_together_is_what_is_told_of_each_sum() {
    let (told, open) = (Cell::new(0), Cell::new(0));
    each_case(0.0, |context, _, point, lengths| {
        let mut random = Random(11);
        let system = context.evaluated(&Guidance::none(), point);
        let rows: usize = system.blocks.iter().map(|of| of.values.len()).sum();
        let mut residuals = outcome::errors(context.problem, context, point);
        for of in &mut residuals {
            of.each.iter_mut().for_each(|each| *each = random.six());
        }
        let multipliers = vec![0.0; rows];
        let covariance = Covariance::new(context, point, &system, &multipliers, &residuals);
        let Some(covariance) = covariance else { return };
        for arc in 0..context.problem.arcs.len() {
            let parameters = context.layout.parameters.iter().copied();
            let unknowns: Vec<usize> = context.layout.state(arc).chain(parameters).collect();
            let jointly = covariance.jointly(&unknowns);
            for _ in 0..8 {
                let sum = unknowns.iter().map(|at| random.next() / lengths[*at]);
                let sum = DVector::from_iterator(unknowns.len(), sum);
                let moment: Moment = unknowns.iter().copied().zip(sum.iter().copied()).collect();
                match (jointly.of(&sum).sd(), covariance.sds(&[moment])[0]) {
                    (Some(one), Some(other)) => {
                        told.set(told.get() + 1);
                        assert!((one - other).abs() < 1e-6 * other, "{one} {other}");
                    }
                    (one, other) => {
                        open.set(open.get() + 1);
                        assert_eq!(one, other);
                    }
                }
            }
        }
    });
    assert!(told.get() > 50, "{told:?} told, {open:?} open");
}

fn of_poses(each: Vec<Six>) -> Residuals {
    Residuals {
        kinds: [true; 2],
        each,
    }
}

/// Bins of one track, a second apart, of so many samples each.
fn row_of_bins(count: usize, samples: usize) -> Bins {
    Bins {
        bins: (0..count)
            .map(|bin| Bin {
                track: TrackIndex(0),
                kinds: [true; 2],
                time_s: bin as f64,
                acted_s: bin as f64,
                samples,
            })
            .collect(),
        of_samples: (0..count * samples)
            .map(|sample| sample / samples)
            .collect(),
        flight_s: 4.0,
    }
}

#[test]
fn the_likelihood_is_that_of_contrasts() {
    const BINS: usize = 5;
    let mut random = Random(3);
    let mut column = || -> Vec<Six> { (0..BINS).map(|_| random.six()).collect() };
    let absorbed = [column(), column(), column(), column()];
    let residual = column();
    let bins = row_of_bins(BINS, 1);
    let cosines = Cosines::new(&bins, 0);
    let basis = DMatrix::from_fn(BINS, BINS, |bin, frequency| {
        let norm = if frequency == 0 { 1.0_f64 } else { 2.0 } / BINS as f64;
        let turn = (bin as f64 + 0.5) * frequency as f64 / BINS as f64;
        norm.sqrt() * (std::f64::consts::PI * turn).cos()
    });
    // A process of which the cosines are independent.
    let kernel = |size: f64, white: f64| {
        let variances = DVector::from_fn(BINS, |frequency, _| size / (1 + frequency) as f64);
        &basis * DMatrix::from_diagonal(&variances.add_scalar(white)) * basis.transpose()
    };
    // Contrasts: an orthonormal basis of what the absorbed columns are not.
    let dense = |column: &Vec<Six>| DVector::from_fn(6 * BINS, |at, _| column[at / 6][at % 6]);
    let columns: Vec<DVector<f64>> = absorbed.iter().map(dense).collect();
    let a = DMatrix::from_columns(&columns);
    let hat = &a * (a.transpose() * &a).try_inverse().unwrap() * a.transpose();
    let eigen = (DMatrix::identity(6 * BINS, 6 * BINS) - hat).symmetric_eigen();
    let kept = (0..6 * BINS).filter(|at| eigen.eigenvalues[*at] > 0.5);
    let kept: Vec<_> = kept
        .map(|at| eigen.eigenvectors.column(at).into_owned())
        .collect();
    assert_eq!(kept.len(), 6 * BINS - 4);
    let contrasts = DMatrix::from_columns(&kept);
    let seen = contrasts.transpose() * dense(&residual);

    let both = |kinds: [(f64, f64); 2]| {
        let kernels = kinds.map(|(size, white)| kernel(size, white));
        let grams = [0, 1].map(|kind| {
            let all = absorbed.iter().chain([&residual]).map(Vec::as_slice);
            let all: Vec<&[Six]> = all.collect();
            let variances = cosines.variances(kernels[kind].as_slice());
            Columns::new(&cosines, &all, kind)
                .gram(variances.into_iter())
                .unwrap()
        });
        let whole = DMatrix::from_fn(6 * BINS, 6 * BINS, |i, j| {
            if i % 6 == j % 6 {
                kernels[(i % 6) / 3][(i / 6, j / 6)]
            } else {
                0.0
            }
        });
        let covariance = contrasts.transpose() * whole * &contrasts;
        let factor = covariance.cholesky().unwrap();
        let exact = -0.5 * (factor.determinant().ln() + seen.dot(&factor.solve(&seen)));
        (log_likelihood([&grams[0], &grams[1]]), exact)
    };
    // Up to a constant.
    let (first, exact_first) = both([(1.0, 0.1), (3.0, 0.5)]);
    let (second, exact_second) = both([(4.0, 1.0), (0.3, 0.2)]);
    let error = (first - second) - (exact_first - exact_second);
    assert!(
        error.abs() < 1e-8,
        "{first} {second}, {exact_first} {exact_second}"
    );
}

/// A constant and a slope on every axis, orthonormal: the directions that a flight's own fit
/// absorbs.
fn constants_and_slopes(bins: &Bins) -> Vec<Vec<Six>> {
    let count = bins.count() as f64;
    let middle = 0.5 * (count - 1.0);
    let slope = (0..bins.count())
        .map(|bin| (bin as f64 - middle).powi(2))
        .sum::<f64>()
        .sqrt();
    let column = |axis: usize, value: &dyn Fn(f64) -> f64| -> Vec<Six> {
        (0..bins.count())
            .map(|bin| std::array::from_fn(|i| if i == axis { value(bin as f64) } else { 0.0 }))
            .collect()
    };
    (0..6)
        .flat_map(|axis| {
            [
                column(axis, &|_| count.sqrt().recip()),
                column(axis, &|bin| (bin - middle) / slope),
            ]
        })
        .collect()
}

/// Equal weights of all residuals in all bins: the sum on which a slow wander acts most.
fn alike(bins: &Bins) -> super::trace::Trace {
    super::trace::Trace {
        sums: vec![[1.0; 6]; bins.count()],
        squares: [3.0 * bins.count() as f64; 2],
    }
}

#[test]
fn white_noise_is_seen_as_such() {
    const SAMPLES: usize = 40;
    let bins = row_of_bins(8, SAMPLES);
    let mut random = Random(5);
    let residuals: Vec<Six> = (0..8 * SAMPLES).map(|_| random.six()).collect();
    let noise = Noise::of(&bins, &[of_poses(residuals)], &constants_and_slopes(&bins));
    for white in noise.white {
        assert!((white - 1.0).abs() < 0.1, "{white}");
    }
    // Variance of a contrast between neighbouring bins.
    let mut trace = alike(&bins);
    for (bin, six) in trace.sums.iter_mut().enumerate() {
        *six = [if bin % 2 == 0 { 1.0 } else { -1.0 } * SAMPLES as f64; 6];
    }
    let count = (8 * SAMPLES) as f64;
    trace.squares = [3.0 * count; 2];
    let ratio = noise.variance(&trace) / (6.0 * count);
    assert!((0.9..1.5).contains(&ratio), "{ratio}");
}

/// A wander like a random walk, of which the fit has absorbed line and constant. If that is not
/// accounted for, the remaining residuals look small.
#[test]
fn what_the_fit_absorbs_of_a_slow_wander_counts() {
    const SAMPLES: usize = 5;
    let bins = row_of_bins(12, SAMPLES);
    let absorbed = constants_and_slopes(&bins);
    let (mut known, mut unknown, mut truth) = (0.0, 0.0, 0.0);
    for seed in 1..=20 {
        let mut random = Random(seed * 977);
        let mut at = [0.0; 6];
        let mut walk: Vec<Six> = (0..bins.of_samples.len())
            .map(|_| {
                at.iter_mut().for_each(|at| *at += random.next());
                let noise = random.six();
                std::array::from_fn(|axis| at[axis] + 0.1 * noise[axis])
            })
            .collect();
        for axis in 0..6 {
            let count = walk.len() as f64;
            let mean = walk.iter().map(|six| six[axis]).sum::<f64>() / count;
            let place = |sample: usize| sample as f64 - 0.5 * (count - 1.0);
            let moment: f64 = walk
                .iter()
                .enumerate()
                .map(|(at, six)| place(at) * six[axis])
                .sum();
            let slope = moment / (0..walk.len()).map(|at| place(at).powi(2)).sum::<f64>();
            truth += slope * slope / 120.0;
            for (at, six) in walk.iter_mut().enumerate() {
                six[axis] -= mean + slope * place(at);
            }
        }
        // How the slope answers to the residuals.
        let mut trace = alike(&bins);
        let count = bins.of_samples.len();
        let place = |sample: usize| sample as f64 - 0.5 * (count as f64 - 1.0);
        let square: f64 = (0..count).map(|at| place(at).powi(2)).sum();
        trace.sums = vec![[0.0; 6]; bins.count()];
        for sample in 0..count {
            trace.sums[sample / SAMPLES][0] += place(sample) / square;
        }
        trace.squares = [1.0 / square, 0.0];
        let residuals = [of_poses(walk)];
        known += Noise::of(&bins, &residuals, &absorbed).variance(&trace) / 20.0;
        unknown += Noise::of(&bins, &residuals, &[]).variance(&trace) / 20.0;
    }
    let ratio = (known / truth).sqrt();
    assert!((0.7..2.5).contains(&ratio), "{ratio}");
    assert!(unknown < 0.8 * known, "{unknown} {known}");
}

#[test]
fn a_perfect_fit_and_no_samples_to_spare() {
    let bins = row_of_bins(8, 5);
    let trace = alike(&bins);
    let absorbed = constants_and_slopes(&bins);
    let noise = Noise::of(&bins, &[of_poses(vec![[0.0; 6]; 40])], &absorbed);
    assert!(noise.variance(&trace) < 1e-12);
    // As many directions as the bins have: the weights are all there is.
    let bins = row_of_bins(2, 1);
    let noise = Noise::of(
        &bins,
        &[of_poses(vec![[0.3; 6]; 2])],
        &constants_and_slopes(&bins),
    );
    assert_eq!(noise.white, [1.0; 2]);
}
