//! The covariance of an estimate by dense algebra that shares nothing with the library's.

use enact::estimate::adequacy;
use enact::estimate::covariance::Covariance;
use enact::estimate::schedule::recipe::{self, Recipe};
use enact::estimate::solve;
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::point::Point;
use enact::motion::Sketch;
use enact::optimise::{Program, System};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::case::{Case, Posed};

/// Errors of all unknowns and what they should be.
pub struct Uncertainty {
    /// Estimate less truth, in the order of the layout.
    pub error: DVector<f64>,
    /// Orthonormal directions that the constraints leave free (unknowns scaled by `scale`).
    pub free: DMatrix<f64>,
    /// Length of every unknown, so that metres and radians compare.
    pub scale: DVector<f64>,
    /// Covariance of all unknowns by `Z (Zᵀ H Z)⁻¹ Zᵀ`.
    pub exact: DMatrix<f64>,
    /// The same as the library has it.
    pub library: DMatrix<f64>,
    /// White noise as the library sees it, of positions and of orientations, in squared units.
    pub white: [f64; 2],
    /// Standard deviations that the library reports, of all unknowns.
    pub sds: Vec<Option<f64>>,
}

impl Uncertainty {
    /// Where the program's solver ends. `None` where the library has no covariance.
    pub fn of(case: &Case, posed: &Posed, offset_s: f64) -> Option<Self> {
        let (problem, layout) = (&posed.problem, &posed.layout);
        let recipe = Recipe::default();
        let solve::Best {
            guess: best,
            solution,
            ..
        } = solve::best(problem, layout, &posed.guesses, &recipe, &mut ());
        let guess = &posed.guesses[best];
        let (point, system) = (&solution.point, &solution.system);
        let context = SolveContext::new(problem, layout, recipe::epochs_s(guess), point);
        let multipliers = &solution.multipliers;
        let in_time = adequacy::in_time(&context, &solution)?;
        let covariance = Covariance::new(&context, point, system, multipliers, Some(&in_time))?;
        let all: Vec<usize> = (0..layout.size()).collect();
        let library = covariance.of(&all);
        let Exact { free, scale, exact } = Exact::of(&context, system)?;
        Some(Self {
            error: error(case, posed, point, &context.epochs_s, offset_s),
            exact,
            free,
            scale,
            library,
            white: in_time.noise_sds().map(|sd| sd * sd),
            sds: covariance.sds(&all.iter().map(|at| vec![(*at, 1.0)]).collect::<Vec<_>>()),
        })
    }

    /// Number of independent unknowns.
    pub fn rank(&self) -> usize {
        self.free.ncols()
    }

    /// Normalised error squared in the free directions, under one of the covariances: its
    /// expectation is the rank.
    pub fn normalised_square(&self, covariance: &DMatrix<f64>) -> f64 {
        let unscale = DMatrix::from_diagonal(&self.scale.map(f64::recip));
        let to_free = self.free.transpose() * unscale;
        let error = &to_free * &self.error;
        let covariance = &to_free * covariance * to_free.transpose();
        let solved = covariance.cholesky().map(|c| c.solve(&error));
        solved.map_or(f64::NAN, |solved| error.dot(&solved))
    }
}

/// The covariance of all unknowns at the truth: no unbiased estimate has a smaller one where
/// residuals are weighed by their white noise (Cramér–Rao).
pub fn bound(case: &Case, posed: &Posed, sketch: &Sketch) -> Option<DMatrix<f64>> {
    let (problem, layout) = (&posed.problem, &posed.layout);
    let guess = case.true_guess(posed, sketch);
    let point = Point::new(problem, &guess);
    let context = SolveContext::new(problem, layout, recipe::epochs_s(&guess), &point);
    let system = context.evaluated(&Guidance::none(), &point);
    Some(Exact::of(&context, &system)?.exact)
}

/// See [`Uncertainty`].
struct Exact {
    free: DMatrix<f64>,
    scale: DVector<f64>,
    exact: DMatrix<f64>,
}

impl Exact {
    fn of(context: &SolveContext, system: &System) -> Option<Self> {
        let (hessian, jacobian) = (hessian(context, system), jacobian(context, system));
        let scale = hessian
            .diagonal()
            .map(|h| if h > 0.0 { h.sqrt().recip() } else { 1e-3 });
        let free = null_space(&(&jacobian * DMatrix::from_diagonal(&scale)));
        let directions = DMatrix::from_diagonal(&scale) * &free;
        let inner = (directions.transpose() * hessian * &directions).try_inverse()?;
        Some(Self {
            exact: &directions * inner * directions.transpose(),
            free,
            scale,
        })
    }
}

fn error(
    case: &Case,
    posed: &Posed,
    point: &Point,
    epochs_s: &[f64],
    offset_s: f64,
) -> DVector<f64> {
    let layout = &posed.layout;
    let mut error = DVector::zeros(layout.size());
    for (arc, at) in layout.arcs.iter().enumerate() {
        let truth = case.true_state(arc, epochs_s[arc], offset_s);
        error
            .rows_mut(*at, 12)
            .copy_from(&point.arcs[arc].minus(&truth));
    }
    for (event, at) in layout.events.iter().enumerate() {
        if let Some(at) = at {
            let true_s = case.performance.truth.event_times_s[event] + offset_s;
            error[*at] = point.event_times_s[event] - true_s;
        }
    }
    error
}

fn hessian(context: &SolveContext, system: &System) -> DMatrix<f64> {
    let size = context.layout.size();
    DMatrix::from_fn(size, size, |row, column| {
        let (row, column) = (row.max(column), row.min(column));
        system
            .hessian
            .get(&context.layout.structure.pattern, row, column)
    })
}

/// Of the rows whose bounds act: equalities, and inequalities that hold with equality.
fn jacobian(context: &SolveContext, system: &System) -> DMatrix<f64> {
    let mut rows: Vec<DVector<f64>> = Vec::new();
    for (index, block) in system.blocks.iter().enumerate() {
        let pattern = &context.layout.structure.blocks[index];
        for row in 0..block.values.len() {
            let (lower, upper) = block.bounds[row];
            let value = block.values[row];
            if value > lower + 1e-9 && value < upper - 1e-9 {
                continue;
            }
            let mut dense = DVector::zeros(context.layout.size());
            let derivatives = block.derivatives(pattern, row);
            for (at, derivative) in pattern.unknowns(row).iter().zip(derivatives) {
                dense[*at] += derivative;
            }
            rows.push(dense);
        }
    }
    DMatrix::from_fn(rows.len(), context.layout.size(), |row, column| {
        rows[row][column]
    })
}

/// Orthonormal basis of what a matrix maps to zero; its rows are independent.
fn null_space(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    // Rows of one size, or a small row would look like a zero one.
    let mut rows = matrix.clone();
    for mut row in rows.row_iter_mut() {
        let norm = row.norm();
        if norm > 0.0 {
            row /= norm;
        }
    }
    let rank = rows.nrows();
    let eigen = SymmetricEigen::new(rows.transpose() * rows);
    let mut order: Vec<usize> = (0..matrix.ncols()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let free = matrix.ncols() - rank;
    let columns: Vec<_> = order[..free]
        .iter()
        .map(|index| eigen.eigenvectors.column(*index).into_owned())
        .collect();
    DMatrix::from_columns(&columns)
}
