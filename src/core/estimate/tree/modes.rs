//! Lower optima along what sketch and goals tell weakly: how fast a chain spins about its length hardly shows, and the valley
//! that such a direction is has more than one deepest place.
//!
//! With `H` the Hessian on the directions `Z` that acting rows leave free, rates at the start have the covariance
//!
//! ```text
//! C = Z (Zᵀ H Z)⁻¹ Zᵀ,      C_uu = Σ σ² w wᵀ
//! ```
//!
//! Where a deviation `σ` is large, the start is moved along `w`, everything else with it as `C` says, and the optimum near there is
//! looked for; and so on beyond it while optima get lower.

use nalgebra::DVector;

use super::curvature::dense;
use super::optimum::{Solved, approached, finished};
use super::part::Part;
use super::program::TreeProgram;
use crate::motion::Observer;
use crate::optimise::{Program, Schedule, Work};

/// Deviation of rates at the start from which on a direction is weak [rad/s],
const WEAK_RAD_S: f64 = 3.0;
/// how many are walked along at most, the weakest first,
const DIRECTIONS: usize = 3;
/// by how much at a time [rad/s],
const STEP_RAD_S: f64 = 4.0;
/// and how often to each side.
const STEPS: usize = 4;
/// An optimum is lower whose cost is less by such a share.
const LOWER: f64 = 1e-5;

/// The lowest of the optima along the weak directions of one, that one if none is lower; of motions on one interval whose stamps are
/// physical times.
pub(super) fn walked(mut least: Solved, work: &mut Work, observer: &mut dyn Observer) -> Solved {
    let is_one = least.problem.nodes_s.len() == 1 && least.problem.tempo.is_none();
    if !is_one || !least.solution.finished.converged {
        return least;
    }
    for direction in weak(&least) {
        for side in [STEP_RAD_S, -STEP_RAD_S] {
            for _ in 0..STEPS {
                let Some(lower) = beyond(&least, &(&direction * side), work, observer) else {
                    break;
                };
                least = lower;
            }
        }
    }
    least.solution.work = *work;
    least
}

/// Weak directions by the unknowns, the weakest first, along which rates change by one [rad/s] in all.
fn weak(solved: &Solved) -> Vec<DVector<f64>> {
    let (problem, point) = (&solved.problem, &solved.solution.point);
    let program = TreeProgram::new(problem, point.clone());
    let free = program.free_directions(&solved.solution.system);
    let information = dense(&program.structure.pattern, &solved.solution.system.hessian);
    let Some(inverse) = free.tr_mul(&(information * &free)).cholesky() else {
        return Vec::new();
    };
    let covariance = &free * inverse.solve(&free.transpose());
    let freedoms = problem.forest.freedoms();
    let is_turn = |at: &usize| !problem.forest.is_translation(*at);
    let rates: Vec<usize> = (0..freedoms)
        .filter(is_turn)
        .map(|at| freedoms + at)
        .collect();
    let by_rates = covariance.select_columns(&rates);
    let eigen = by_rates.select_rows(&rates).symmetric_eigen();
    let mut all: Vec<(f64, DVector<f64>)> = (0..rates.len())
        .map(|at| {
            let (variance, turn) = (eigen.eigenvalues[at], eigen.eigenvectors.column(at));
            (variance, &by_rates * turn / variance)
        })
        .filter(|(variance, _)| *variance > WEAK_RAD_S * WEAK_RAD_S)
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.truncate(DIRECTIONS);
    all.into_iter().map(|(_, direction)| direction).collect()
}

/// The optimum near where a step leads from another, where it is lower.
fn beyond(
    from: &Solved,
    step: &DVector<f64>,
    work: &mut Work,
    observer: &mut dyn Observer,
) -> Option<Solved> {
    if observer.should_stop() {
        return None;
    }
    let mut problem = from.problem.clone();
    let program = TreeProgram::new(&from.problem, from.solution.point.clone());
    let mut moved = from.solution.point.clone();
    program.retract(&from.solution.point, step, &mut moved);
    let point = approached(&program, moved, work, observer);
    let enough = from.cost() * (1.0 - LOWER);
    if !(program.evaluated(&Part::whole(), &point).cost < enough) {
        return None;
    }
    problem.fit_to(&point);
    let at_once = Schedule::default().from_the_last();
    let solved = finished(&problem, &point, &at_once, work, observer);
    (solved.solution.finished.converged && solved.cost() < enough).then_some(solved)
}
