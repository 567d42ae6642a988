//! Directions of the start in which the prior says more than sketch and goals do: of the generalised
//! eigenvectors of the information with and without the prior, on what hard goals leave free,
//!
//! ```text
//! Zᵀ J_dᵀ J_d Z v = λ Zᵀ Jᵀ J Z v
//! ```

use nalgebra::{DMatrix, DVector};

use super::part::Part;
use super::point::TreePoint;
use super::problem::{RATE_SD_RAD_S, TreeProblem};
use super::program::TreeProgram;
use crate::optimise::Solution;

/// Directions by the unknowns, of one deviation each, the weakest first: those of which
/// sketch and goals tell less than this share.
pub fn directions(
    problem: &TreeProblem,
    solution: &Solution<TreePoint>,
    told_share: f64,
) -> Vec<DVector<f64>> {
    let program = TreeProgram::new(problem, solution.point.clone());
    let [all, told] = [RATE_SD_RAD_S, f64::INFINITY].map(|rate_sd_rad_s| {
        let part = Part {
            rate_sd_rad_s,
            ..Part::whole()
        };
        program.information_at(&part, &solution.point)
    });
    if !all.iter().chain(&told).all(|number| number.is_finite()) {
        return Vec::new();
    }
    let free = program.free_directions(&solution.system);
    let reduced = |matrix: &DMatrix<f64>| free.tr_mul(&(matrix * &free));
    let count = free.ncols();
    if count == 0 {
        return Vec::new();
    }
    let inverse = reduced(&all).cholesky().and_then(|factor| {
        let identity = DMatrix::identity(count, count);
        factor.l().solve_lower_triangular(&identity)
    });
    let Some(inverse) = inverse else {
        return Vec::new();
    };
    let eigen = (&inverse * reduced(&told) * inverse.transpose()).symmetric_eigen();
    let mut weak: Vec<usize> = (0..count)
        .filter(|at| eigen.eigenvalues[*at] < told_share)
        .collect();
    weak.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let direction = |at: usize| &free * (inverse.transpose() * eigen.eigenvectors.column(at));
    weak.into_iter().map(direction).collect()
}
