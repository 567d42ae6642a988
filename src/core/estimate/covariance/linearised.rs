//! A solution whose samples err in time, linearised: residuals along the directions that constraints leave free.

use nalgebra::{DMatrix, DVector};

use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::woven;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::likelihood::Restricted;
use crate::estimate::wander::series::SeriesRows;
use crate::math::random::Random;
use crate::math::span::Span;
use crate::optimise::kkt::Kkt;
use crate::optimise::{Program, System};

/// Directions tried beyond the number of unknowns less that of equalities: some rows may be dependent.
const DIRECTIONS_MORE: usize = 2;
/// Greatest number of directions: with more, residuals tell nothing of their errors.
const DIRECTIONS_MOST: usize = 160;
/// A direction of which less than this is orthogonal to the others depends on them.
const DEPENDENT: f64 = 1e-6;
/// How often a direction is corrected for what it moves of constraints.
const REFINEMENTS: usize = 4;
/// Information that every direction has besides.
const LEAST: f64 = 1e-9;

/// Residuals and their derivatives.
pub(in crate::estimate) struct LinearisedSolution {
    /// Along each direction, then the residuals.
    rows: SeriesRows,
    /// Products of the same columns of priors.
    priors: DMatrix<f64>,
    /// Number of the first directions along which the motion may go.
    free: usize,
}

impl LinearisedSolution {
    /// Along directions of the unknowns, a column each, of which the motion may go along the first `free`, of samples at least
    /// so far apart \[s\]. `None` where samples do not err in time and where the parameters make no body.
    pub(in crate::estimate) fn new(
        context: &SolveContext,
        point: &Point,
        directions: &DMatrix<f64>,
        free: usize,
        apart_s: f64,
    ) -> Option<Self> {
        let weave = context.problem.weave.as_ref()?;
        let (series, columns) = woven::rows(context, point, weave, directions, apart_s)?;
        Some(Self {
            rows: SeriesRows::new(&series, &columns),
            priors: products(context, &context.without_samples(point), directions),
            free,
        })
    }

    /// What the motion may follow.
    pub(in crate::estimate) fn restricted(&self) -> Restricted<'_> {
        Restricted {
            rows: &self.rows,
            free: self.free,
            priors: &self.priors,
            least: LEAST,
        }
    }
}

/// Number of unknowns less that of equalities.
pub(in crate::estimate) fn free_count(context: &SolveContext, system: &System) -> usize {
    context.layout.size().saturating_sub(equalities(system))
}

/// Whether there are too many free directions for residuals to tell of their errors.
pub(in crate::estimate) fn is_too_free(context: &SolveContext, system: &System) -> bool {
    free_count(context, system) + DIRECTIONS_MORE > DIRECTIONS_MOST
}

/// Directions that constraints leave free at a solution, orthonormal in typical lengths, a column each; `None` where there are too
/// many.
pub(in crate::estimate) fn free_directions(
    context: &SolveContext,
    system: &System,
    kkt: &Kkt,
) -> Option<DMatrix<f64>> {
    let size = context.layout.size();
    let free = free_count(context, system) + DIRECTIONS_MORE;
    if is_too_free(context, system) {
        return None;
    }
    let scale = context.damping().map(f64::sqrt);
    let mut random = Random::default();
    let columns = (0..free).map(|_| {
        let mut step = DVector::from_fn(size, |at, _| random.signed() * scale[at]);
        kkt.solve(context.structure(), &mut step);
        for _ in 0..REFINEMENTS {
            let mut pulled = DVector::zeros(size);
            kkt.add_pulled(context.structure(), system, &step, &mut pulled);
            kkt.solve(context.structure(), &mut pulled);
            step -= pulled;
        }
        step.component_mul(&scale)
    });
    let columns: Vec<DVector<f64>> = columns.collect();
    let mut basis = Span::of(&columns, size, DEPENDENT).basis();
    for mut column in basis.column_iter_mut() {
        column.component_div_assign(&scale);
    }
    Some(basis)
}

/// `Zᵀ H Z` of directions, with the gradient along them and twice the cost in the last row and column.
pub(super) fn products(
    context: &SolveContext,
    system: &System,
    directions: &DMatrix<f64>,
) -> DMatrix<f64> {
    let pattern = &context.layout.structure.pattern;
    let count = directions.ncols();
    let mut gram = DMatrix::zeros(count + 1, count + 1);
    for (at, direction) in directions.column_iter().enumerate() {
        let mut product = DVector::zeros(direction.len());
        let own = direction.into_owned();
        system.hessian.multiply_add(pattern, &own, &mut product);
        let along = directions.tr_mul(&product);
        gram.view_mut((0, at), (count, 1)).copy_from(&along);
        let slope = own.dot(&system.gradient);
        gram[(at, count)] = slope;
        gram[(count, at)] = slope;
    }
    gram[(count, count)] = 2.0 * system.cost;
    gram
}

/// Number of equalities.
fn equalities(system: &System) -> usize {
    let bounds = system.blocks.iter().flat_map(|block| &block.bounds);
    bounds.filter(|(lower, upper)| lower == upper).count()
}
