//! Sizes and times of a hand's process that make the residuals of a motion likely.
//!
//! Of a motion that may go along the columns of `J`, linearised, with residuals `r` of covariance `V`, the restricted
//! likelihood is that of all contrasts that the motion cannot follow (Patterson and Thompson, Biometrika 58, 1971):
//!
//! ```text
//! −2 log L = ln |V| + ln |A| + rᵀ P r,   A = Jᵀ V⁻¹ J,   P = V⁻¹ − V⁻¹ J A⁻¹ Jᵀ V⁻¹
//! ```
//!
//! A take tells little of some of the numbers, so that each has a prior about [`Process::EXPECTED`], normal in its
//! logarithm. The best are sought by Newton's method (`search`).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::process::{LogProcess, Process};
use super::series::{SeriesRows, WhitenedProducts};
use crate::motion::Tested;

/// Above this probability of the residuals under noise alone, noise explains them.
const WELL: f64 = 1e-3;
/// Spread of the logarithm of each number of a process about what is expected.
pub(super) const SPREADS: LogProcess = [1.5, 1.0, 1.5, 0.8, 1.5];
/// Samples that are nearer to one another tell little more of a hand \[s\].
pub const APART_S: f64 = 1.0 / 35.0;

/// Errors as they are thought to be.
#[derive(Clone, Copy, Debug)]
pub struct LikelyErrors {
    /// Errors of positions, and of orientations and directions.
    pub processes: [Process; 2],
}

impl LikelyErrors {
    /// Before anything is seen.
    pub const EXPECTED: Self = Self {
        processes: [Process::EXPECTED; 2],
    };

    /// Of these sizes and times.
    pub fn of(processes: [Process; 2]) -> Self {
        Self { processes }
    }

    /// The same with all sizes so many times as great.
    pub fn times(self, factor: f64) -> Self {
        Self::of(self.processes.map(|of| of.times(factor)))
    }
}

/// What is known of a motion whose samples have such errors.
#[derive(Clone, Debug)]
pub struct FittedErrors {
    /// The errors.
    pub errors: LikelyErrors,
    /// `−2 log L`, up to a constant, with what numbers cost that are not as expected.
    pub merit: f64,
    /// `A⁻¹ Jᵀ V⁻¹ r`: minus the step to the motion that is likeliest.
    pub answer: DVector<f64>,
    /// `A`, factorised.
    pub information: Cholesky<f64, Dyn>,
    /// `[u r]ᵀ P [u r]` of the columns after the free ones.
    pub left: DMatrix<f64>,
    /// Whether there are samples of each kind.
    pub shown: [bool; 2],
}

impl FittedErrors {
    /// Variance of the wander of the kinds that are shown, in units, or where nothing strays, of the noise.
    pub fn strayed(&self) -> f64 {
        let kinds = (0..2).filter(|kind| self.shown[*kind]);
        let each = kinds.map(|kind| match &self.errors.processes[kind] {
            process if process.wanders() => process.stray_variance(),
            process => process.noise_sd.powi(2),
        });
        each.sum()
    }

    /// Standard deviation along a direction in which the motion may go.
    pub fn deviation(&self, direction: usize) -> f64 {
        let mut unit = DVector::zeros(self.information.l_dirty().nrows());
        unit[direction] = 1.0;
        self.information.solve(&unit)[direction].max(0.0).sqrt()
    }
}

/// Rows of which some columns are directions in which the motion may go.
#[derive(Clone, Copy, Debug)]
pub struct Restricted<'r> {
    /// The rows.
    pub rows: &'r SeriesRows,
    /// Number of its first columns that are such directions.
    pub free: usize,
    /// Products of the same columns of priors, which are independent and of unit variance.
    pub priors: &'r DMatrix<f64>,
    /// Information that every direction has besides, next to nothing: it holds what nothing tells.
    pub least: f64,
}

impl Restricted<'_> {
    /// Whether there are enough residuals beyond what the motion may follow, of each number of a process three.
    pub fn is_told(&self) -> bool {
        3 * self.rows.samples() >= self.free + 3 * Process::COUNT
    }

    /// What follows of errors of these sizes and times; `None` where a number is none.
    pub fn at(&self, errors: &LikelyErrors) -> Option<FittedErrors> {
        let processes = &errors.processes;
        let [positions, orientations] =
            [0, 1].map(|kind| self.rows.products(kind, &processes[kind]));
        self.with(processes, [&positions, &orientations])
    }

    /// The likeliest errors, from where they are thought to be: as samples tell them that are at least so far apart \[s\]. They
    /// are sought by the columns that the likelihood is of, the free ones and the residuals.
    pub fn likely(&self, from: &LikelyErrors, apart_s: f64) -> Option<LikelyErrors> {
        let last = self.rows.count() - 1;
        let kept: Vec<usize> = (0..self.free).chain([last]).collect();
        let (rows, priors) = self.select(&kept);
        let narrow = Restricted {
            rows: &rows.thinned(apart_s),
            priors: &priors,
            ..*self
        };
        let likeliest = match from.processes == LikelyErrors::EXPECTED.processes {
            true => {
                let found = narrow.first().into_iter();
                let found = found.filter_map(|start| narrow.search(&start));
                found.min_by(|a, b| a.merit.total_cmp(&b.merit))
            }
            false => narrow.search(from),
        };
        Some(likeliest?.errors)
    }

    /// Some of the columns: their rows, and products of priors.
    pub(super) fn select(&self, kept: &[usize]) -> (SeriesRows, DMatrix<f64>) {
        let priors = self.priors.select_columns(kept).select_rows(kept);
        (self.rows.select(kept), priors)
    }

    /// What follows of the likeliest errors, as samples tell them that are not nearer to one another than a hand moves.
    pub fn fitted(&self, from: &LikelyErrors) -> Option<FittedErrors> {
        self.at(&self.likely(from, APART_S)?)
    }

    /// The likeliest errors as all samples tell them, from where they are thought to be.
    pub fn likeliest(&self, from: &LikelyErrors) -> Option<FittedErrors> {
        self.at(&self.likely(from, 0.0)?)
    }

    /// The likeliest noise where nothing strays, from that which makes all that is left.
    pub fn likeliest_noise(&self) -> Option<FittedErrors> {
        let processes = [0, 1].map(|kind| {
            let left = self.rows.residual_rms(kind);
            Process {
                noise_sd: match left > 0.0 {
                    true => left,
                    false => Process::EXPECTED.noise_sd,
                },
                ..Process::EXPECTED.without_wander()
            }
        });
        self.likeliest(&LikelyErrors::of(processes))
    }

    /// What follows of errors with such logarithms; `None` where that is no number.
    pub(super) fn valued(&self, logs: &[LogProcess; 2]) -> Option<FittedErrors> {
        let errors = LikelyErrors::of(logs.map(|of| Process::of_logs(&of)));
        self.at(&errors).filter(|of| of.merit.is_finite())
    }

    /// What follows of errors with such products.
    pub(super) fn with(
        &self,
        processes: &[Process; 2],
        products: [&WhitenedProducts; 2],
    ) -> Option<FittedErrors> {
        let [positions, orientations] = products;
        let gram = &positions.gram + &orientations.gram + self.priors;
        let others = gram.ncols() - self.free;
        let mut free = gram.view((0, 0), (self.free, self.free)).into_owned();
        for at in 0..self.free {
            free[(at, at)] += self.least;
        }
        let across = gram.view((0, self.free), (self.free, others));
        let information = free.cholesky()?;
        let left = gram.view((self.free, self.free), (others, others))
            - across.tr_mul(&information.solve(&across));
        let log_variance = positions.log_variance + orientations.log_variance;
        let misfit = left[(others - 1, others - 1)];
        Some(FittedErrors {
            errors: LikelyErrors::of(*processes),
            merit: log_variance + information.ln_determinant() + misfit + penalty(processes),
            answer: information.solve(&across.column(others - 1)),
            information,
            left,
            shown: [0, 1].map(|kind| self.rows.shows(kind)),
        })
    }
}

/// Residuals taken for noise alone.
#[derive(Clone, Debug)]
pub struct NoiseAlone {
    /// What follows of it.
    pub fitted: FittedErrors,
    /// Against noise and a wander, by the ratio of their likelihoods.
    pub test: Tested,
}

impl NoiseAlone {
    /// Beside the likeliest errors with a wander; `None` where too few residuals are beyond what the motion may follow.
    pub fn of(of: &Restricted, wandering: &FittedErrors) -> Option<Self> {
        if !of.is_told() {
            return None;
        }
        let fitted = of.likeliest_noise()?;
        let kinds = (0..2).filter(|kind| of.rows.shows(*kind)).count();
        let freedom = (Process::COUNT - 1) * kinds;
        let statistic = (fitted.merit - wandering.merit).max(0.0);
        let law = ChiSquared::new(freedom as f64).ok()?;
        Some(Self {
            fitted,
            test: Tested {
                statistic,
                freedom,
                probability: law.sf(statistic),
            },
        })
    }

    /// Whether that explains them.
    pub fn explains(&self) -> bool {
        self.test.probability >= WELL
    }
}

/// What numbers cost that are not as expected; those of a part that is not there cost nothing.
fn penalty(processes: &[Process; 2]) -> f64 {
    let expected = Process::EXPECTED.logs();
    let of = |process: &Process| -> f64 {
        let logs = process.logs();
        let numbers = logs.iter().zip(&expected).zip(&SPREADS).enumerate();
        let there = numbers.filter(|(number, _)| process.has(*number));
        there
            .map(|(_, ((log, mean), spread))| ((log - mean) / spread).powi(2))
            .sum()
    };
    processes.iter().map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::wander::filter::{Filter, Means, SampleInstant};
    use crate::estimate::wander::search::{GAIN, NumberOf, STEP};
    use crate::estimate::wander::series::{AskedSlopes, NumberSlopes, Series};
    use crate::estimate::wander::wrong;
    use crate::math::random::Random;
    use crate::motion::TrackIndex;

    const TRUE: Process = Process {
        smooth_sd: 2.0,
        smooth_s: 0.6,
        rough_sd: 0.05,
        rough_s: 0.15,
        noise_sd: 0.1,
    };

    /// Samples of the process about a parabola, with columns of it.
    fn drawn(random: &mut Random, samples: usize) -> (Vec<Series>, DMatrix<f64>) {
        let taken = (0..samples).map(|at| SampleInstant {
            time_s: 0.02 * at as f64,
            noise_variance: 0.0,
        });
        let taken: Vec<SampleInstant> = taken.collect();
        let mut columns = DMatrix::zeros(3 * samples, 10);
        for axis in 0..3 {
            for (row, taken) in taken.iter().enumerate() {
                for power in 0..3 {
                    columns[(3 * row + axis, 3 * power + axis)] = taken.time_s.powi(power as i32);
                }
            }
            // `r = L e`: what the filter takes off is put back on.
            let (mut filter, mut means) = (Filter::new(&TRUE), Means::new(2));
            for (row, taken) in taken.iter().enumerate() {
                let gain = filter.next(taken);
                // `e = offset + slope r`.
                let (mut zero, mut one) = ([0.0, 0.0], [1.0, 1.0]);
                means.clone().whiten(&gain, &mut zero);
                means.clone().whiten(&gain, &mut one);
                let value = (random.normal() - zero[0]) / (one[0] - zero[0]);
                let mut both = [value, 0.0];
                means.whiten(&gain, &mut both);
                columns[(3 * row + axis, 9)] = value;
            }
        }
        let series = Series {
            track: TrackIndex(0),
            kind: 0,
            taken,
            rows: (0..samples).map(|row| 3 * row).collect(),
            unit: 1.0,
        };
        (vec![series], columns)
    }

    /// Of a motion that is a parabola.
    fn about_parabola<'r>(rows: &'r SeriesRows, priors: &'r DMatrix<f64>) -> Restricted<'r> {
        Restricted {
            rows,
            free: 9,
            priors,
            least: 1e-9,
        }
    }

    /// Of hands that are drawn, the sizes come back, on average over their logarithms.
    #[test]
    fn the_likeliest_errors_are_about_those_that_were_drawn() {
        let mut random = Random::default();
        let mut off = [0.0; 3];
        let count = 20;
        for _ in 0..count {
            let (series, columns) = drawn(&mut random, 120);
            let rows = SeriesRows::new(&series, &columns);
            let priors = DMatrix::zeros(10, 10);
            let of = about_parabola(&rows, &priors);
            let fitted = of.likeliest(&LikelyErrors::EXPECTED).expect("a likelihood");
            let found = fitted.errors.processes[0].logs();
            for (off, at) in off.iter_mut().zip([0, 1, 4]) {
                *off += (found[at] - TRUE.logs()[at]) / f64::from(count);
            }
            // No sample shows the other kind, of which what is expected stays.
            assert_eq!(
                fitted.errors.processes[1],
                Process::of_logs(&Process::EXPECTED.logs())
            );
        }
        assert!(off[0].abs() < 0.3 && off[1].abs() < 0.3, "{off:?}");
        assert!(off[2].abs() < 0.15, "{off:?}");
    }

    #[test]
    fn slopes_are_those_of_the_merit() {
        let mut random = Random::default();
        let (series, columns) = drawn(&mut random, 40);
        let rows = SeriesRows::new(&series, &columns);
        let priors = DMatrix::zeros(10, 10);
        let of = about_parabola(&rows, &priors);
        let logs = [Process::EXPECTED.logs(); 2];
        let merit = |number: usize, by: f64| {
            let mut there = logs;
            there[0][number] += by;
            of.valued(&there).expect("a likelihood").merit
        };
        let here = of.valued(&logs).expect("a likelihood");
        let numbers: Vec<NumberOf> = (0..Process::COUNT)
            .map(|number| NumberOf { kind: 0, number })
            .collect();
        let slopes = of.slopes(&logs, &here, &numbers);
        for number in 0..Process::COUNT {
            let expected = (merit(number, 1e-4) - merit(number, -1e-4)) / 2e-4;
            let off = (slopes.merit[number] - expected).abs();
            assert!(off < 1e-2 + 1e-3 * expected.abs(), "{number}: {off}");
        }
    }

    /// Against `rᵀ P V_i P V_j P r` of whole matrices.
    #[test]
    fn the_average_information_is_that_of_whole_matrices() {
        let mut random = Random::default();
        let (series, columns) = drawn(&mut random, 30);
        let rows = SeriesRows::new(&series, &columns);
        let priors = DMatrix::zeros(10, 10);
        let of = about_parabola(&rows, &priors);
        let logs = [Process::EXPECTED.logs(); 2];
        let numbers: Vec<NumberOf> = (0..Process::COUNT)
            .map(|number| NumberOf { kind: 0, number })
            .collect();
        let here = of.valued(&logs).expect("a likelihood");
        let given = of.slopes(&logs, &here, &numbers).information;
        let covariance = |logs: &LogProcess| {
            let process = Process::of_logs(logs);
            DMatrix::from_fn(90, 90, |row, column| {
                let apart = (row / 3).abs_diff(column / 3);
                let noise = if apart == 0 {
                    process.noise_sd.powi(2)
                } else {
                    0.0
                };
                match row % 3 == column % 3 {
                    true => process.covariance(0.02 * apart as f64) + noise,
                    false => 0.0,
                }
            })
        };
        let inverse = covariance(&logs[0]).try_inverse().expect("a covariance");
        let free = columns.columns(0, 9).into_owned();
        let whole = free.tr_mul(&(&inverse * &free));
        let whole = whole.try_inverse().expect("it is told");
        let projection = &inverse - &inverse * &free * whole * free.tr_mul(&inverse);
        let left = &projection * columns.column(9);
        let changes: Vec<DVector<f64>> = (0..Process::COUNT)
            .map(|number| {
                let beside = |by: f64| {
                    let mut there = logs[0];
                    there[number] += by;
                    covariance(&there)
                };
                (beside(1e-5) - beside(-1e-5)) / 2e-5 * &left
            })
            .collect();
        for (row, one) in changes.iter().enumerate() {
            for (column, other) in changes.iter().enumerate() {
                let prior = match row == column {
                    true => 2.0 / SPREADS[row].powi(2),
                    false => 0.0,
                };
                let stated = one.dot(&(&projection * other)) + prior;
                let off = (given[(row, column)] - stated).abs();
                assert!(off < 1e-3 * (1.0 + stated.abs()), "{row} {column}: {off}");
            }
        }
    }

    /// Where nothing strays and all noise is alike, products are not whitened: against those that are.
    #[test]
    fn noise_alone_is_what_a_wander_of_nothing_is() {
        let mut random = Random::default();
        let (series, columns) = drawn(&mut random, 40);
        let rows = SeriesRows::new(&series, &columns);
        let still = Process::EXPECTED.without_wander();
        let hardly = |sd: f64| Process {
            smooth_sd: sd,
            rough_sd: sd,
            ..still
        };
        let [alone, near] = [still, hardly(1e-9)].map(|process| rows.products(0, &process));
        let off = (&alone.gram - &near.gram).amax() / near.gram.amax();
        assert!(off < 1e-9, "{off}");
        assert!((alone.log_variance - near.log_variance).abs() < 1e-9);
        let asked = AskedSlopes {
            by_gram: DMatrix::from_fn(10, 10, |a, b| 1.0 + (a * b) as f64),
            left: DVector::from_fn(10, |at, _| at as f64 - 3.0),
        };
        // Differences are between processes whose sizes are not less than the least.
        let [alone, near] =
            [still, hardly(1e-5)].map(|process| rows.slopes(0, &process, &asked, STEP));
        // The one slope is exact, the other by differences of gains.
        let noise = Process::NOISE;
        let numbers = |of: &NumberSlopes| {
            let across = of.across.column(noise).amax();
            [of.slopes[noise], of.of_left[(noise, noise)], across]
        };
        for (alone, near) in numbers(&alone).into_iter().zip(numbers(&near)) {
            let off = (alone - near).abs() / near.abs();
            assert!(off < 1e-3, "{off}");
        }
    }

    /// Where it ends no number of the process makes it less.
    #[test]
    fn nothing_near_by_is_likelier() {
        let mut random = Random::default();
        let (series, columns) = drawn(&mut random, 60);
        let rows = SeriesRows::new(&series, &columns);
        let priors = DMatrix::zeros(10, 10);
        let of = about_parabola(&rows, &priors);
        let best = of.likeliest(&LikelyErrors::EXPECTED).expect("a likelihood");
        for number in 0..Process::COUNT {
            for by in [-0.05, 0.05] {
                let mut logs = best.errors.processes[0].logs();
                logs[number] += by;
                let there = [Process::of_logs(&logs), best.errors.processes[1]];
                let there = of.at(&LikelyErrors::of(there)).expect("a likelihood").merit;
                assert!(
                    there > best.merit - GAIN,
                    "{number} {by}: {}",
                    there - best.merit
                );
            }
        }
    }

    /// Looks at slopes alone, as long as there is time.
    struct Patient(bool);

    impl wrong::Looker for Patient {
        fn should_stop(&mut self) -> bool {
            self.0
        }

        fn tried(
            &mut self,
            near: wrong::WrongQuantity,
            _: &FittedErrors,
        ) -> Option<wrong::WrongQuantity> {
            Some(near)
        }
    }

    /// A step that is kept fixed wrongly is told, and no other: of samples of noise, and of those of a hand.
    #[test]
    fn a_wrong_quantity_is_told_and_a_right_one_is_not() {
        let mut random = Random::default();
        for by in [0.0, 3.0] {
            let (series, mut columns) = drawn(&mut random, 120);
            columns = columns.insert_column(9, 0.0);
            for row in 180..360 {
                columns[(row, 9)] = f64::from(u8::from(row % 3 == 2));
                columns[(row, 10)] += by * columns[(row, 9)];
            }
            let rows = SeriesRows::new(&series, &columns);
            let priors = DMatrix::zeros(11, 11);
            let of = about_parabola(&rows, &priors);
            let narrow = of.fitted(&LikelyErrors::EXPECTED).expect("a likelihood");
            let kept = [wrong::KeptQuantity {
                typical: 1.0,
                explains_least: 0.0,
                room: [f64::NEG_INFINITY, f64::INFINITY],
                tried_from: None,
            }];
            let mut looker = Patient(false);
            let judged = wrong::judge(&of, &narrow, &kept, APART_S, &mut looker).expect("time");
            assert!(judged.shows[0].is_finite());
            let changes: Vec<f64> = judged.wrong.iter().map(|of| of.change).collect();
            match by > 0.0 {
                true => assert!(
                    changes.len() == 1 && (changes[0] + by).abs() < 0.5,
                    "{changes:?}"
                ),
                false => assert!(changes.is_empty(), "{changes:?}"),
            }
            let stopped = wrong::judge(&of, &narrow, &kept, APART_S, &mut Patient(true));
            assert!(stopped.is_none() || by == 0.0);
        }
    }
}
