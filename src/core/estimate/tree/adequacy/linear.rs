//! A motion, linearised: what samples and priors say near it, and the rows that hold it.
//!
//! With residuals `r`, their derivative `J` by the unknowns, acting rows `c = 0` with derivative `C`, a
//! basis `Z` of what those leave free, and derivatives `r_θ` and `c_θ` by a quantity that the scene keeps fixed,
//!
//! ```text
//! r(x + Z z + B y₀ + B y_θ Δ, θ + Δ) = r₀ + J Z z + u Δ,   u = r_θ + J B y_θ
//! C B y₀ = −c,   C B y_θ = −c_θ
//! ```
//!
//! where the columns of `B` span the rows of `C`. At an optimum `uᵀ r` is the slope of the Lagrangian in `θ`,
//! `r_θᵀ r + c_θᵀ λ`, for there `Jᵀ r = −Cᵀ λ`.

use nalgebra::{DMatrix, DVector};

use crate::estimate::tree::part::Part;
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::{RATE_SD_RAD_S, TreeProblem};
use crate::estimate::tree::program::{REGULARISER, TreeProgram};
use crate::estimate::tree::sample::Residual;
use crate::estimate::wander::series::Series;
use crate::math::span::Span;
use crate::optimise::active::ActiveSet;
use crate::optimise::{Program, System};

/// A pivot below which a row depends on others.
const DEPENDENT: f64 = 1e-7;
/// Share of the largest singular value below which a direction of the rows is none, and share of the longest row below which
/// a row is rounding: out of the plane of pins nothing moves, so that a goal there holds nothing.
const SINGULAR: f64 = 1e-10;

/// Residuals and rows of a motion.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub(super) series: Vec<Series>,
    /// `r` of samples, then of priors; in units.
    pub(super) residuals: DVector<f64>,
    /// `J`.
    by: DMatrix<f64>,
    /// `c` and `C` of the rows that act.
    rows: DVector<f64>,
    rows_by: DMatrix<f64>,
    /// Objective and constraints.
    pub(super) system: System,
}

/// How rows hold the motion.
pub(super) struct HeldDirections {
    /// `J Z`.
    pub(super) free: DMatrix<f64>,
    /// `Z`.
    pub(super) basis: DMatrix<f64>,
    /// `B (C B)⁺`.
    along_rows: DMatrix<f64>,
}

impl HeldDirections {
    /// What the motion follows of a change, per unit, so that rows still hold: `B y_θ`.
    pub(super) fn follow(&self, change: &LinearChange) -> DVector<f64> {
        -(&self.along_rows * &change.rows)
    }
}

/// What changes with a quantity.
#[derive(Clone, Debug)]
pub(super) struct LinearChange {
    /// `r_θ`.
    pub(super) residuals: DVector<f64>,
    /// `c_θ`.
    pub(super) rows: DVector<f64>,
}

impl Linear {
    /// At a point, with the rows that act; `None` where something there is no number.
    pub(super) fn new(
        problem: &TreeProblem,
        point: &TreePoint,
        active: &ActiveSet,
    ) -> Option<Self> {
        Self::of(problem, point, active, true)
    }

    /// The same where `J` and `C` are not asked for: they are zero.
    pub(super) fn without_derivatives(
        problem: &TreeProblem,
        point: &TreePoint,
        active: &ActiveSet,
    ) -> Option<Self> {
        Self::of(problem, point, active, false)
    }

    fn of(
        problem: &TreeProblem,
        point: &TreePoint,
        active: &ActiveSet,
        has_derivatives: bool,
    ) -> Option<Self> {
        let program = TreeProgram::new(problem, point.clone());
        let size = problem.unknown_count();
        let mut system = System::new(program.structure());
        let mut series: Vec<Series> = Vec::new();
        let (mut values, mut derivatives) = (Vec::new(), Vec::new());
        let mut each = |node: usize, residual: &Residual| {
            let residual = residual.in_units();
            let sample = residual.sample;
            let kind = sample.kind();
            let is_of = |of: &Series| (of.track, of.kind) == (sample.track, kind);
            let at = series.iter().position(is_of).unwrap_or_else(|| {
                series.push(Series {
                    track: sample.track,
                    kind,
                    taken: Vec::new(),
                    rows: Vec::new(),
                    unit: sample.unit,
                });
                series.len() - 1
            });
            series[at].taken.push(sample.instant());
            series[at].rows.push(values.len());
            for axis in 0..3 {
                let mut row = DVector::zeros(size);
                for (column, by) in residual.by.row(axis).iter().enumerate() {
                    row[problem.unknown_of(node, column)] = *by;
                }
                values.push(residual.value[axis]);
                derivatives.push(row);
            }
        };
        let whole = Part::whole();
        program.evaluate_each(&whole, point, has_derivatives, &mut system, &mut each);
        for (value, by) in priors(problem, point) {
            let mut row = DVector::zeros(size);
            for (unknown, by) in by {
                row[unknown] = by;
            }
            values.push(value);
            derivatives.push(row);
        }
        let (weights, off) = active.weights_and_violations(&system, program.information().1);
        let acting: Vec<usize> = (0..off.len()).filter(|row| weights[*row] > 0.0).collect();
        let mut rows_by = DMatrix::zeros(acting.len(), size);
        for column in 0..size {
            let mut unit = DVector::zeros(size);
            unit[column] = 1.0;
            let mut along = Vec::new();
            system.along(program.structure(), &unit, &mut along);
            for (row, of) in acting.iter().enumerate() {
                rows_by[(row, column)] = along[*of];
            }
        }
        let by = DMatrix::from_fn(derivatives.len(), size, |row, column| {
            derivatives[row][column]
        });
        let linear = Self {
            series,
            residuals: DVector::from_vec(values),
            by,
            rows: DVector::from_iterator(acting.len(), acting.iter().map(|row| off[*row])),
            rows_by,
            system,
        };
        linear.is_finite().then_some(linear)
    }

    fn is_finite(&self) -> bool {
        let numbers = self.residuals.iter().chain(&self.by).chain(&self.rows);
        let mut numbers = numbers.chain(&self.rows_by);
        self.system.cost.is_finite() && numbers.all(|number| number.is_finite())
    }

    /// `c`.
    #[cfg(test)]
    pub(super) fn rows(&self) -> &DVector<f64> {
        &self.rows
    }

    /// Number of rows of samples.
    pub(super) fn sample_rows(&self) -> usize {
        3 * self.series.iter().map(|of| of.rows.len()).sum::<usize>()
    }

    /// Root mean square distance \[m\] and angle \[rad\] of all samples.
    pub(super) fn rms(&self) -> [f64; 2] {
        rms(&self.series, |of| {
            let rows = of.rows.iter();
            rows.map(|row| self.residuals.rows(*row, 3).norm_squared())
                .sum()
        })
    }

    /// What holds the motion.
    pub(super) fn held(&self) -> HeldDirections {
        let size = self.by.ncols();
        let mut rows: Vec<DVector<f64>> =
            self.rows_by.row_iter().map(|row| row.transpose()).collect();
        let longest = rows.iter().map(|row| row.norm()).fold(0.0, f64::max);
        rows.retain(|row| row.norm() > SINGULAR * longest);
        let span = Span::of(&rows, size, DEPENDENT);
        let basis = span.beyond(DMatrix::identity(size, size)).transpose();
        let across = span.basis();
        let along_rows = if span.rank() == 0 {
            DMatrix::zeros(size, self.rows_by.nrows())
        } else {
            let held = (&self.rows_by * &across).svd(true, true);
            let least = SINGULAR * held.singular_values.max();
            let inverse = held.pseudo_inverse(least);
            across * inverse.expect("it was asked for both factors")
        };
        HeldDirections {
            free: &self.by * &basis,
            basis,
            along_rows,
        }
    }

    /// `u` of a quantity.
    pub(super) fn total(&self, held: &HeldDirections, change: &LinearChange) -> DVector<f64> {
        &change.residuals + &self.by * held.follow(change)
    }

    /// The step of Gauss and Newton in the unknowns, and in a quantity with this change; `information` holds what nothing
    /// tells. `None` where nothing tells the quantity.
    pub(super) fn step(
        &self,
        change: &LinearChange,
        information: f64,
    ) -> Option<(DVector<f64>, f64)> {
        let held = self.held();
        let to_rows = -&held.along_rows * &self.rows;
        let residuals = &self.residuals + &self.by * &to_rows;
        let total = self.total(&held, change);
        let free = held.free.ncols();
        let mut columns = held.free.clone().insert_column(free, 0.0);
        columns.set_column(free, &total);
        let mut normal = columns.tr_mul(&columns);
        for at in 0..free {
            normal[(at, at)] += REGULARISER * information;
        }
        let answer = -normal.cholesky()?.solve(&columns.tr_mul(&residuals));
        let by = answer[free];
        let step = to_rows + &held.basis * answer.rows(0, free) + held.follow(change) * by;
        Some((step, by))
    }

    /// Half the squares of all residuals, and by how much rows do not hold, in units.
    pub(super) fn merit(&self) -> (f64, f64) {
        (0.5 * self.residuals.norm_squared(), self.rows.lp_norm(1))
    }

    /// The change of a quantity from two motions that differ in it alone, by so much.
    pub(super) fn change(before: &Self, after: &Self, by: f64) -> LinearChange {
        LinearChange {
            residuals: (&after.residuals - &before.residuals) / by,
            rows: (&after.rows - &before.rows) / by,
        }
    }
}

/// Root mean squares over the samples of series with sums of squares in their units \[m, rad\]; zero where none are seen.
pub(super) fn rms(series: &[Series], squares: impl Fn(&Series) -> f64) -> [f64; 2] {
    [0, 1].map(|kind| {
        let of_kind = || series.iter().filter(|of| of.kind == kind);
        let sum: f64 = of_kind().map(|of| squares(of) * of.unit * of.unit).sum();
        let samples: usize = of_kind().map(|of| of.rows.len()).sum();
        (sum / samples.max(1) as f64).sqrt()
    })
}

/// A prior: its residual, and the derivatives by unknowns, in units.
type Prior = (f64, Vec<(usize, f64)>);

/// Freedoms that turn.
fn turning(problem: &TreeProblem) -> impl Iterator<Item = usize> + '_ {
    let freedoms = 0..problem.forest.freedoms();
    freedoms.filter(|at| !problem.forest.is_translation(*at))
}

/// What holds rates of the start, times of events at their marks, an unknown tempo, and parameters.
fn priors(problem: &TreeProblem, point: &TreePoint) -> Vec<Prior> {
    let freedoms = problem.forest.freedoms();
    let rates = turning(problem).map(|at| {
        let rate = point.nodes[0].rates[at];
        let per_unit = 1.0 / RATE_SD_RAD_S;
        (rate * per_unit, vec![(freedoms + at, per_unit)])
    });
    let line = &point.time_line(problem);
    let times = problem.events.iter().zip(&point.event_times_s).enumerate();
    let times = times.filter_map(|(index, (event, time_s))| {
        let mark = event.mark?;
        let sd_s = mark.counted_sd_s();
        let (acted_s, by) = line.acted_by(problem, index, *time_s);
        let by = by.into_iter().map(|(at, by)| (at, by / sd_s));
        Some(((acted_s - mark.acted_s) / sd_s, by.collect()))
    });
    let tempo = problem.tempo.iter().flat_map(|tempo| {
        let pairs = point.log_paces.windows(2).enumerate();
        pairs.map(|(piece, pair)| {
            let per_unit = 1.0 / tempo.change_sd(piece);
            let ends = [(piece, -per_unit), (piece + 1, per_unit)];
            let by = ends.map(|(piece, by)| (problem.unknown_of_pace(piece), by));
            ((pair[1] - pair[0]) * per_unit, by.to_vec())
        })
    });
    let parameters = problem.parameters.iter().zip(&point.parameters).enumerate();
    let parameters = parameters.filter_map(|(index, (free, value))| {
        let sd = free.prior_sd?;
        let by = vec![(problem.unknown_of_parameter(index), 1.0 / sd)];
        Some(((value - free.initial) / sd, by))
    });
    rates.chain(times).chain(tempo).chain(parameters).collect()
}
