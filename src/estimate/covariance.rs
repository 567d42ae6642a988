//! How certain the estimate is: the inverse of the Hessian on the constraints' tangent space.
//!
//! With residuals that are independent and of one unit, the covariance of the unknowns is
//! `Z (Zᵀ H Z)⁻¹ Zᵀ`, `Z` spanning the directions the constraints leave free; it is the limit
//! of `(H + w JᵀJ)⁻¹` for large `w`, and the finish has that matrix factorised. It is scaled
//! by the mean square residual, so that the unit of the weights does not matter.

use nalgebra::{DMatrix, DVector};

use super::finish::{DAMPING, Kkt};
use super::system::{Frame, System};

/// Share of an unknown's information that may come from the damping before it counts as
/// undetermined.
const DAMPING_SHARE_MAX: f64 = 0.1;

/// Covariances at an optimum.
pub struct Covariance<'a> {
    frame: &'a Frame<'a>,
    system: &'a System,
    kkt: Kkt,
    /// Mean square residual per degree of freedom.
    pub variance_factor: f64,
}

impl<'a> Covariance<'a> {
    /// `None` where the matrix cannot be factorised.
    pub fn new(frame: &'a Frame<'a>, system: &'a System, multipliers: &[f64]) -> Option<Self> {
        let kkt = Kkt::new(frame, system, multipliers)?;
        let problem = frame.problem;
        let tempo_rows = if problem.times_are_unknown() {
            problem.nodes_acted_s.len().saturating_sub(2)
        } else {
            0
        };
        let priors = problem
            .parameters
            .iter()
            .filter(|free| free.prior_sd.is_some())
            .count();
        let residuals = 6 * problem.sample_count() + tempo_rows + priors;
        let freedom = (residuals + kkt.acting_rows()) as f64 - frame.layout.size() as f64;
        let variance_factor = if freedom >= 1.0 {
            2.0 * system.cost / freedom
        } else {
            1.0
        };
        Some(Self {
            frame,
            system,
            kkt,
            variance_factor,
        })
    }

    /// Covariance of the unknowns `at`, in their units.
    pub fn of(&self, at: &[usize]) -> DMatrix<f64> {
        let mut result = DMatrix::zeros(at.len(), at.len());
        for (column, unknown) in at.iter().enumerate() {
            let mut x = DVector::zeros(self.frame.layout.size());
            x[*unknown] = 1.0;
            self.kkt.solve(self.frame, &mut x);
            for (row, other) in at.iter().enumerate() {
                result[(row, column)] = self.variance_factor * x[*other];
            }
        }
        result
    }

    /// Standard deviation of one unknown; `None` where the performance does not determine it.
    pub fn sd(&self, at: usize) -> Option<f64> {
        let mut x = DVector::zeros(self.frame.layout.size());
        x[at] = 1.0;
        self.kkt.solve(self.frame, &mut x);
        let damping = DAMPING * (1.0 + self.system.hessian.get(&self.frame.layout.pattern, at, at));
        let determined = x[at] * damping < DAMPING_SHARE_MAX;
        determined.then(|| (self.variance_factor * x[at]).max(0.0).sqrt())
    }
}
