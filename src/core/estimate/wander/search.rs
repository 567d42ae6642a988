//! The search for the likeliest errors.
//!
//! It is Newton's method on `−2 log L` by the logarithms of the numbers of a process, with the average information in place of
//! second derivatives (Gilmour, Thompson and Cullis, Biometrics 51, 1995). With `V_i` the derivatives of `V`,
//!
//! ```text
//! ∂_i = tr (P V_i) − rᵀ P V_i P r,   ∂_i ∂_j ≈ rᵀ P V_i P V_j P r
//! ```
//!
//! What the last steps tell of slopes is added, as Broyden, Fletcher, Goldfarb and Shanno do: where errors are less than any
//! hand's, average information is too small.

use nalgebra::{DMatrix, DVector};

use super::likelihood::{FittedErrors, LikelyErrors, Restricted, SPREADS};
use super::process::{LogProcess, Process};
use super::series::AskedSlopes;

/// Greatest number of steps.
const STEPS: usize = 30;
/// Step of the differences of gains.
pub(super) const STEP: f64 = 1e-4;
/// The longest step in any logarithm.
const LONGEST: f64 = 1.5;
/// How many of the last steps tell how slopes change.
const LAST: usize = 3;
/// Greatest number of times that a step is made shorter, and by how much each time.
const SHORTENINGS: usize = 8;
const SHORTER: f64 = 0.3;
/// Steps end where the next one promises less than this of `−2 log L`.
pub(super) const GAIN: f64 = 0.02;

/// A number of the process of one kind of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NumberOf {
    pub(super) kind: usize,
    pub(super) number: usize,
}

/// How the merit changes with logarithms of numbers.
pub(super) struct MeritSlopes {
    pub(super) merit: DVector<f64>,
    /// The mean of its second derivatives and of those that are expected, without what is expected to be nothing, and those of
    /// what numbers cost: with the derivatives `V_i` of `V`, `rᵀ P V_i P V_j P r`.
    pub(super) information: DMatrix<f64>,
}

/// By how much slopes changed with a step.
struct SlopeChange {
    step: DVector<f64>,
    change: DVector<f64>,
}

impl MeritSlopes {
    /// The step to where the merit is least, as average information tells it and how slopes changed with the last steps; `None`
    /// where that promises nothing.
    fn step(&self, numbers: &[NumberOf], changes: &[SlopeChange]) -> Option<DVector<f64>> {
        let mut inverse = self.information.clone().cholesky()?.inverse();
        for last in &changes[changes.len().saturating_sub(LAST)..] {
            update(&mut inverse, last);
        }
        let mut step = -(inverse * &self.merit);
        for kind in 0..2 {
            let of_kind = || numbers.iter().map(move |of| of.kind == kind);
            let own = step.iter().zip(of_kind()).filter(|(_, is_own)| *is_own);
            let longest = own.fold(LONGEST, |longest, (by, _)| longest.max(by.abs()));
            for (by, _) in step.iter_mut().zip(of_kind()).filter(|(_, is_own)| *is_own) {
                *by *= LONGEST / longest;
            }
        }
        (-0.5 * step.dot(&self.merit) > GAIN).then_some(step)
    }
}

impl Restricted<'_> {
    /// Searches among the numbers of the parts that are there, of kinds that are shown.
    pub(super) fn search(&self, from: &LikelyErrors) -> Option<FittedErrors> {
        let kinds = (0..2).filter(|kind| self.rows.shows(*kind));
        let numbers = kinds.flat_map(|kind| {
            let there = (0..Process::COUNT).filter(move |of| from.processes[kind].has(*of));
            there.map(move |number| NumberOf { kind, number })
        });
        let numbers: Vec<NumberOf> = numbers.collect();
        let mut logs = from.processes.map(|process| process.logs());
        let mut here = self.valued(&logs)?;
        let mut slopes = self.slopes(&logs, &here, &numbers);
        let mut changes: Vec<SlopeChange> = Vec::new();
        for _ in 0..STEPS {
            let Some(mut step) = slopes.step(&numbers, &changes) else {
                break;
            };
            let mut moved = None;
            for _ in 0..SHORTENINGS {
                let mut there_logs = logs;
                for (of, by) in numbers.iter().zip(step.iter()) {
                    there_logs[of.kind][of.number] += by;
                }
                let there_logs = there_logs.map(|of| Process::of_logs(&of).logs());
                let there = self.valued(&there_logs);
                if let Some(there) = there.filter(|of| of.merit < here.merit) {
                    moved = Some((there_logs, there));
                    break;
                }
                step *= SHORTER;
            }
            let Some((there_logs, there)) = moved else {
                break;
            };
            (logs, here) = (there_logs, there);
            let next = self.slopes(&logs, &here, &numbers);
            let change = &next.merit - &slopes.merit;
            changes.push(SlopeChange { step, change });
            slopes = next;
        }
        Some(here)
    }

    /// Where searches begin before anything is seen, since the likelihood has several optima: a slow hand with a rough part, as is
    /// expected, and a quick one that is smooth. Sizes are as far from what is expected as the residuals are, and noise is that of
    /// neighbours: taken for too small, it would be told as a rough part that changes from sample to sample.
    pub(super) fn first(&self) -> [LikelyErrors; 2] {
        let slow = Process::EXPECTED;
        let quick = Process {
            smooth_s: slow.rough_s,
            ..slow
        };
        [slow, quick].map(|process| {
            LikelyErrors::of([0, 1].map(|kind| {
                if !self.rows.shows(kind) {
                    return Process::EXPECTED;
                }
                // Of residuals that are nothing it is the least there is.
                let far = self.rows.residual_rms(kind).max(f64::EPSILON);
                let mut logs = process.times(far).logs();
                if let Some(noise_sd) = self.rows.neighbours_sd(kind) {
                    logs[Process::NOISE] = noise_sd.ln();
                }
                Process::of_logs(&logs)
            }))
        })
    }

    /// Slopes of the merit by some numbers, and its average information. With `x = A⁻¹ Jᵀ V⁻¹ r`, it changes by the products as
    ///
    /// ```text
    /// tr (A⁻¹ dG_JJ) + yᵀ dG y,   y = (−x, 1)
    /// ```
    pub(super) fn slopes(
        &self,
        logs: &[LogProcess; 2],
        here: &FittedErrors,
        numbers: &[NumberOf],
    ) -> MeritSlopes {
        let (free, last) = (self.free, self.rows.count() - 1);
        let mut left = DVector::zeros(last + 1);
        left.rows_mut(0, free).copy_from(&-&here.answer);
        left[last] = 1.0;
        let mut by_gram = &left * left.transpose();
        let mut own = by_gram.view_mut((0, 0), (free, free));
        own += here.information.inverse();
        let asked = AskedSlopes { by_gram, left };
        let processes = logs.map(|of| Process::of_logs(&of));
        let of_kinds = [0, 1].map(|kind| {
            let is_shown = self.rows.shows(kind);
            is_shown.then(|| self.rows.slopes(kind, &processes[kind], &asked, STEP))
        });
        let size = numbers.len();
        let (mut merit, mut information) = (DVector::zeros(size), DMatrix::zeros(size, size));
        let mut across = DMatrix::zeros(free, size);
        for (at, of) in numbers.iter().enumerate() {
            let own = of_kinds[of.kind].as_ref().expect("a kind that is shown");
            let (log, spread) = (logs[of.kind][of.number], SPREADS[of.number]);
            let expected = Process::EXPECTED.logs()[of.number];
            merit[at] = own.slopes[of.number] + 2.0 * (log - expected) / spread.powi(2);
            let column = own.across.column(of.number);
            across.column_mut(at).copy_from(&column.rows(0, free));
            for (other, beside) in numbers.iter().enumerate() {
                if of.kind == beside.kind {
                    information[(at, other)] = own.of_left[(of.number, beside.number)];
                }
            }
        }
        information -= across.tr_mul(&here.information.solve(&across));
        for (at, of) in numbers.iter().enumerate() {
            information[(at, at)] += 2.0 / SPREADS[of.number].powi(2);
            // What is the least there is becomes no less.
            if processes[of.kind].is_least(of.number) && merit[at] > 0.0 {
                merit[at] = 0.0;
                information.fill_row(at, 0.0);
                information.fill_column(at, 0.0);
                information[(at, at)] = 1.0;
            }
        }
        MeritSlopes { merit, information }
    }
}

/// The inverse Hessian after a step, along which slopes changed so (Broyden, Fletcher, Goldfarb and Shanno).
fn update(inverse: &mut DMatrix<f64>, last: &SlopeChange) {
    let SlopeChange { step, change } = last;
    let along = step.dot(change);
    if along <= 1e-12 * step.norm() * change.norm() {
        return;
    }
    let size = step.len();
    let per = along.recip();
    let across = DMatrix::identity(size, size) - change * step.transpose() * per;
    *inverse = across.tr_mul(&*inverse) * &across + step * step.transpose() * per;
}
