//! Residuals of a motion, linearised, series by series.

use std::cell::OnceCell;

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, DVector, Dyn, Matrix5, OMatrix, U5};

use super::filter::{Filter, Gain, GainSlopes, Means, SampleInstant, covered, weighed};
use super::process::{LogProcess, Process};
use super::white::WhiteProducts;
use crate::motion::TrackIndex;

/// Median of the size of what is normal, in standard deviations.
const MEDIAN: f64 = 0.6745;

/// Samples of one hand that are of one kind: its places, or how it is turned.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The first of its trackers.
    pub track: TrackIndex,
    /// 0: positions, 1: orientations and directions.
    pub kind: usize,
    /// When its samples were taken, in order.
    pub taken: Vec<SampleInstant>,
    /// The first row of each: it has three.
    pub rows: Vec<usize>,
    /// One unit of its residuals \[m or rad\].
    pub unit: f64,
}

/// Rows of samples, in units, of several columns: derivatives along the directions in which the motion may go, then
/// others.
#[derive(Clone, Debug)]
pub struct SeriesRows {
    series: Vec<RowsOfSeries>,
    /// Number of columns; the residuals are the last.
    count: usize,
}

/// The rows of one series.
#[derive(Clone, Debug)]
struct RowsOfSeries {
    kind: usize,
    unit: f64,
    taken: Vec<SampleInstant>,
    /// Sample by sample, column by column, axis by axis.
    numbers: Vec<f64>,
    /// Products of its columns as they are, where they were asked for.
    plain: OnceCell<DMatrix<f64>>,
}

/// Products of whitened columns, `[J u r]ᵀ V⁻¹ [J u r]`, of samples of one kind.
#[derive(Clone, Debug)]
pub struct WhitenedProducts {
    /// The products.
    pub gram: DMatrix<f64>,
    /// `ln |V|`.
    pub log_variance: f64,
}

/// What changes with each number of the process of one kind.
#[derive(Clone, Debug)]
pub struct NumberSlopes {
    /// Slopes of the function that is asked about.
    pub slopes: LogProcess,
    /// With `W` that whitens, `V_i` the derivative of `V` and `x` what is left, products of all `W V_i V⁻¹ x`,
    pub of_left: Matrix5<f64>,
    /// and those of each with the whitened columns.
    pub across: OMatrix<f64, Dyn, U5>,
}

/// What is left of rows, and how much a function changes with their products.
#[derive(Clone, Debug)]
pub struct AskedSlopes {
    /// Slopes of the function by the products, a symmetric matrix; by `ln |V|` it is one.
    pub by_gram: DMatrix<f64>,
    /// What is left is this sum of the columns.
    pub left: DVector<f64>,
}

/// The three columns of each sample.
fn axes(rows: &mut DMatrix<f64>) -> impl Iterator<Item = DMatrixViewMut<'_, f64>> {
    let count = rows.nrows();
    let samples = rows.as_mut_slice().chunks_exact_mut(3 * count);
    samples.map(move |three| DMatrixViewMut::from_slice(three, count, 3))
}

impl RowsOfSeries {
    /// The same with other samples, or with other columns of them.
    fn with(&self, taken: Vec<SampleInstant>, numbers: Vec<f64>) -> Self {
        Self {
            taken,
            numbers,
            plain: OnceCell::new(),
            ..*self
        }
    }

    /// Variance of each number where nothing strays and all samples are of the same noise.
    fn variance(&self, process: &Process) -> Option<f64> {
        let own = self.taken.first()?.noise_variance;
        let is_alike = self.taken.iter().all(|taken| taken.noise_variance == own);
        (is_alike && !process.wanders()).then(|| process.noise_sd.powi(2) + own)
    }

    /// Products of its columns as they are.
    fn plain(&self, count: usize) -> &DMatrix<f64> {
        self.plain.get_or_init(|| {
            let mut plain = WhiteProducts::new(count);
            for sample in self.numbers.chunks_exact(3 * count) {
                plain.push(sample);
            }
            plain.gram()
        })
    }

    /// Adds its slopes where nothing strays: the noise alone changes.
    fn add_white(
        &self,
        process: &Process,
        variance: f64,
        asked: &AskedSlopes,
        sum: &mut NumberSlopes,
    ) {
        let plain = self.plain(asked.left.len());
        let change = 2.0 * process.noise_sd.powi(2) / variance;
        let square = plain.dot(&asked.by_gram) / variance;
        let rows = (3 * self.taken.len()) as f64;
        let across = plain * &asked.left * (change / variance);
        let noise = Process::NOISE;
        sum.slopes[noise] += change * (rows - square);
        sum.of_left[(noise, noise)] += change * across.dot(&asked.left);
        let mut own = sum.across.column_mut(noise);
        own += across;
    }

    /// Adds its slopes.
    fn add_slopes(
        &self,
        process: &Process,
        asked: &AskedSlopes,
        step: f64,
        sum: &mut NumberSlopes,
    ) {
        let count = asked.left.len();
        let numbers = 3 * count;
        let (gains, log_variance) = self.gains(process);
        let (mut means, mut back) = (Means::new(numbers), GainSlopes::new(numbers));
        let mut white = self.numbers.clone();
        for (gain, numbers) in gains.iter().zip(white.chunks_exact_mut(numbers)) {
            back.push(&means);
            means.whiten(gain, numbers);
        }
        // A column for each axis of each sample.
        let mut rows = DMatrix::zeros(count, 3 * gains.len());
        for (mut three, white) in axes(&mut rows).zip(white.chunks_exact(numbers)) {
            three.tr_copy_from(&DMatrixView::from_slice(white, 3, count));
        }
        let mut by_rows = &asked.by_gram * 2.0 * &rows;
        let mut by_gains: Vec<Gain> = Vec::new();
        let each = gains.iter().zip(white.chunks_exact(numbers));
        let each: Vec<_> = each.zip(axes(&mut by_rows)).collect();
        for ((gain, white), three) in each.into_iter().rev() {
            let by_white = three.transpose();
            by_gains.push(back.pop(gain, white, by_white.as_slice()));
        }
        let samples = self.numbers.chunks_exact(numbers);
        let left = samples.map(|sample| {
            let three = DMatrixView::from_slice(sample, 3, count) * &asked.left;
            [three[0], three[1], three[2]]
        });
        let left: Vec<[f64; 3]> = left.collect();
        let weighed = weighed(&gains, &left);
        let mut changes = OMatrix::<f64, Dyn, U5>::zeros(3 * gains.len());
        for number in (0..Process::COUNT).filter(|of| process.has(*of)) {
            let mut logs = process.logs();
            logs[number] += step;
            let (there, log_variance_there) = self.gains(&Process::of_logs(&logs));
            let each = gains.iter().zip(&there).zip(by_gains.iter().rev());
            let change = each.map(|((here, there), slopes)| here.change(slopes, there));
            sum.slopes[number] += (change.sum::<f64>() + log_variance_there - log_variance) / step;
            let mut means = Means::new(3);
            let covered = covered(&there, &weighed);
            for (at, (gain, (there, here))) in
                gains.iter().zip(covered.iter().zip(&left)).enumerate()
            {
                let mut three = [0, 1, 2].map(|axis| (there[axis] - here[axis]) / step);
                means.whiten(gain, &mut three);
                changes
                    .fixed_view_mut::<3, 1>(3 * at, number)
                    .copy_from_slice(&three);
            }
        }
        sum.of_left += changes.tr_mul(&changes);
        sum.across += rows * changes;
    }

    /// Gains of its samples, and `ln |V|` of their three axes.
    fn gains(&self, process: &Process) -> (Vec<Gain>, f64) {
        let mut filter = Filter::new(process);
        let gains = self.taken.iter().map(|taken| filter.next(taken)).collect();
        (gains, 3.0 * filter.log_variance())
    }
}

impl SeriesRows {
    /// The rows of series in a matrix of all columns.
    pub fn new(series: &[Series], columns: &DMatrix<f64>) -> Self {
        let of_series = series.iter().map(|of| RowsOfSeries {
            kind: of.kind,
            unit: of.unit,
            taken: of.taken.clone(),
            numbers: of
                .rows
                .iter()
                .flat_map(|row| columns.rows(*row, 3).iter().copied().collect::<Vec<_>>())
                .collect(),
            plain: OnceCell::new(),
        });
        Self {
            series: of_series.collect(),
            count: columns.ncols(),
        }
    }

    /// The same with some of the columns.
    pub fn select(&self, kept: &[usize]) -> Self {
        let of_series = self.series.iter().map(|of| {
            let samples = of.numbers.chunks_exact(3 * self.count);
            let kept = samples
                .flat_map(|sample| kept.iter().flat_map(|at| &sample[3 * at..3 * at + 3]))
                .copied();
            of.with(of.taken.clone(), kept.collect())
        });
        Self {
            series: of_series.collect(),
            count: kept.len(),
        }
    }

    /// The same with the samples of one kind.
    pub fn of_kind(&self, kind: usize) -> Self {
        let of_kind = self.series.iter().filter(|of| of.kind == kind);
        Self {
            series: of_kind.cloned().collect(),
            count: self.count,
        }
    }

    /// The same with samples that are at least so far apart \[s\].
    pub fn thinned(&self, apart_s: f64) -> Self {
        let of_series = self.series.iter().map(|of| {
            let mut thin = of.with(Vec::new(), Vec::new());
            let samples = of.numbers.chunks_exact(3 * self.count);
            for (taken, sample) in of.taken.iter().zip(samples) {
                let last = thin.taken.last();
                if last.is_none_or(|last| taken.time_s >= last.time_s + apart_s) {
                    thin.taken.push(*taken);
                    thin.numbers.extend(sample);
                }
            }
            thin
        });
        Self {
            series: of_series.collect(),
            count: self.count,
        }
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of samples, each kind by itself.
    pub fn samples(&self) -> usize {
        self.series.iter().map(|of| of.taken.len()).sum()
    }

    /// Whether any sample is of a kind.
    pub fn shows(&self, kind: usize) -> bool {
        let mut series = self.series.iter();
        series.any(|of| of.kind == kind && !of.taken.is_empty())
    }

    /// One unit of residuals of a kind \[m or rad\]; the greatest of several.
    pub fn unit(&self, kind: usize) -> f64 {
        let of_kind = self.series.iter().filter(|of| of.kind == kind);
        of_kind.map(|of| of.unit).fold(0.0, f64::max)
    }

    /// Root mean square of the residuals of a kind, along an axis, in units; zero where none are seen.
    pub fn residual_rms(&self, kind: usize) -> f64 {
        let of_kind = self.series.iter().filter(|of| of.kind == kind);
        let samples = of_kind.flat_map(|of| of.numbers.chunks_exact(3 * self.count));
        let (mut square, mut rows) = (0.0, 0.0_f64);
        for numbers in samples {
            let three = &numbers[3 * (self.count - 1)..];
            square += three.iter().map(|number| number * number).sum::<f64>();
            rows += 3.0;
        }
        (square / rows.max(1.0)).sqrt()
    }

    /// Standard deviation of noise along an axis that second differences of neighbouring residuals of a kind show, by their
    /// median, in units: what is slower hardly is in them, and kinks are few. `None` where no three are neighbours, and where
    /// they are the same.
    pub fn neighbours_sd(&self, kind: usize) -> Option<f64> {
        let of_sample = 3 * self.count;
        let mut differences: Vec<f64> = Vec::new();
        for of in self.series.iter().filter(|of| of.kind == kind) {
            let samples: Vec<&[f64]> = of.numbers.chunks_exact(of_sample).collect();
            for three in samples.windows(3) {
                let second = |at: usize| three[0][at] - 2.0 * three[1][at] + three[2][at];
                differences.extend((of_sample - 3..of_sample).map(|at| second(at).abs()));
            }
        }
        let middle = differences.len() / 2;
        differences.sort_by(f64::total_cmp);
        let median = differences.get(middle).filter(|median| **median > 0.0)?;
        Some(median / (MEDIAN * 6_f64.sqrt()))
    }

    /// Slopes, by the logarithm of each number of such a process, of a function of the products of the samples of one kind and
    /// of their `ln |V|`. Gains and variances change by differences with a step of the logarithms, all else exactly.
    pub fn slopes(
        &self,
        kind: usize,
        process: &Process,
        asked: &AskedSlopes,
        step: f64,
    ) -> NumberSlopes {
        let mut sum = NumberSlopes {
            slopes: [0.0; Process::COUNT],
            of_left: Matrix5::zeros(),
            across: OMatrix::<f64, Dyn, U5>::zeros(self.count),
        };
        for of in self.series.iter().filter(|of| of.kind == kind) {
            match of.variance(process) {
                Some(variance) => of.add_white(process, variance, asked, &mut sum),
                None => of.add_slopes(process, asked, step, &mut sum),
            }
        }
        sum
    }

    /// Products of the samples of one kind, whose errors are such a process.
    pub fn products(&self, kind: usize, process: &Process) -> WhitenedProducts {
        let count = self.count;
        let mut products = WhitenedProducts {
            gram: DMatrix::zeros(count, count),
            log_variance: 0.0,
        };
        for of in self.series.iter().filter(|of| of.kind == kind) {
            if let Some(variance) = of.variance(process) {
                products.gram += of.plain(count) / variance;
                products.log_variance += (3 * of.taken.len()) as f64 * variance.ln();
                continue;
            }
            let (mut filter, mut means) = (Filter::new(process), Means::new(3 * count));
            let mut white = WhiteProducts::new(count);
            let mut numbers = vec![0.0; 3 * count];
            for (taken, sample) in of.taken.iter().zip(of.numbers.chunks_exact(3 * count)) {
                numbers.copy_from_slice(sample);
                means.whiten(&filter.next(taken), &mut numbers);
                white.push(&numbers);
            }
            products.gram += white.gram();
            products.log_variance += 3.0 * filter.log_variance();
        }
        products
    }
}
