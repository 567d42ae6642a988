//! Newton steps on the Karush–Kuhn–Tucker (KKT) conditions `∇f + Jᵀ ν = 0, c = 0` of the active
//! rows.
//!
//! The linearised conditions
//!
//! ```text
//! [H  Jᵀ] [d]   [−g]
//! [J  0 ] [ν] = [−c]
//! ```
//!
//! are solved by the method of multipliers on the quadratic model (Nocedal and Wright, *Numerical
//! Optimization*, chapter 17): with `W = w·1`, repeat
//!
//! ```text
//! (H + Jᵀ W J) d = −(g + Jᵀ ν + Jᵀ W c),   ν ← ν + W (c + J d)
//! ```
//!
//! One factorisation of `H + Jᵀ W J` serves all repetitions; it keeps the envelope and is positive
//! definite where the solution is unique. Each repetition reduces the error by the ratio of `H` to
//! `Jᵀ W J`.

use nalgebra::DVector;

use super::active::ActiveSet;
use super::envelope::{Envelope, Pattern};
use super::program::Program;
use super::system::{Curvature, Structure, System};

/// Damping of the factorised matrix, as a share of `1 + Hᵢᵢ`: so small that it only keeps
/// undetermined unknowns in place.
pub const DAMPING: f64 = 1e-9;
/// Repetitions end where the linearised constraints hold to this share of the violation (the
/// constraints' curvature leaves more than that after the step),
const EXACT: f64 = 1e-5;
/// or to rounding, in units.
const ROUNDING: f64 = 1e-14;
/// Greatest number of repetitions.
const REFINEMENTS: usize = 8;

/// A solution of the linearised optimality conditions.
pub struct KktStep {
    /// The step `d`, a tangent.
    pub delta: DVector<f64>,
    /// The multipliers `ν` after it, row by row; zero for rows that are not active.
    pub multipliers: Vec<f64>,
}

/// Where a step begins: gradient of the cost, multipliers, and signed distances of the rows from their active bounds.
struct StepStart<'a> {
    gradient: DVector<f64>,
    multipliers: Vec<f64>,
    violations: &'a [f64],
}

/// The factorised `H + Jᵀ W J` of a system, for steps and for covariances.
pub struct Kkt {
    matrix: Envelope,
    /// Curvature of active rows in closed form, added to `H`.
    curvature: Vec<Curvature>,
    /// Shifts of pivots, added to `H`.
    shifts: Vec<Curvature>,
    /// Weight of every row, zero where it is not active.
    weights: Vec<f64>,
    /// Signed distance of every row from its active bound.
    violations: Vec<f64>,
    multipliers: Vec<f64>,
    /// Damping, added to the diagonal.
    damping: Vec<f64>,
}

impl Kkt {
    /// Factorises with the active set that `multipliers` imply ([`ActiveSet::of`]). `None` where
    /// the matrix is not positive definite: an unknown is undetermined beyond the damping.
    pub fn new<P: Program>(program: &P, system: &System, multipliers: &[f64]) -> Option<Self> {
        let active = ActiveSet::of(system, multipliers, program.information().1);
        Self::with(program, system, None, multipliers, &active)
    }

    /// Factorises with a given active set; `curved` is the system's Hessian with curvature added
    /// ([`Program::add_curvature`]), for none the system's own. `None` as for [`Kkt::new`].
    pub fn with<P: Program>(
        program: &P,
        system: &System,
        curved: Option<&Envelope>,
        multipliers: &[f64],
        active: &ActiveSet,
    ) -> Option<Self> {
        let structure = program.structure();
        let weighed = active.weights_and_violations(system, program.information().1);
        let damping = vec![DAMPING; structure.size()];
        let multipliers = multipliers.to_vec();
        Self::weighed(
            structure,
            system,
            curved,
            multipliers,
            weighed.0,
            weighed.1,
            damping,
        )
    }

    /// Factorises with given weights and violations of the rows, and with `damping` as a share of
    /// `1 + Hᵢᵢ` on the diagonal. `None` as for [`Kkt::new`].
    pub fn weighed(
        structure: &Structure,
        system: &System,
        curved: Option<&Envelope>,
        multipliers: Vec<f64>,
        weights: Vec<f64>,
        violations: Vec<f64>,
        mut damping: Vec<f64>,
    ) -> Option<Self> {
        let pattern = &structure.pattern;
        let pull = |row: usize| {
            if weights[row] > 0.0 {
                multipliers[row]
            } else {
                0.0
            }
        };
        let curvature = system.curvature(structure, pull);
        let mut matrix = curved.unwrap_or(&system.hessian).clone();
        for of in &curvature {
            matrix.add(pattern, of.row, of.column, of.value);
        }
        for (row, damping) in damping.iter_mut().enumerate() {
            *damping *= 1.0 + system.hessian.get(pattern, row, row);
            matrix.add(pattern, row, row, *damping);
        }
        system.add_square(structure, &weights, &mut matrix);
        let shifts = if curvature.iter().all(Curvature::is_convex) {
            matrix.factorise(pattern).ok()?;
            Vec::new()
        } else {
            factorise_curved(&mut matrix, pattern)?
        };
        Some(Self {
            matrix,
            curvature,
            shifts,
            weights,
            violations,
            multipliers,
            damping,
        })
    }

    /// The step to the optimum of the quadratic model at `system`, with the Hessian of the
    /// factorisation.
    pub fn step(
        &self,
        structure: &Structure,
        system: &System,
        curved: Option<&Envelope>,
    ) -> KktStep {
        let start = StepStart {
            gradient: system.gradient.clone(),
            multipliers: self.multipliers.clone(),
            violations: &self.violations,
        };
        self.stepped(structure, system, curved, start)
    }

    /// How unknowns and multipliers follow, to first order, where an active row is to be greater by one unit.
    pub fn response(
        &self,
        structure: &Structure,
        system: &System,
        curved: Option<&Envelope>,
        row: usize,
    ) -> KktStep {
        let mut asked = vec![0.0; self.violations.len()];
        asked[row] = -1.0;
        let start = StepStart {
            gradient: DVector::zeros(structure.size()),
            multipliers: vec![0.0; asked.len()],
            violations: &asked,
        };
        self.stepped(structure, system, curved, start)
    }

    fn stepped(
        &self,
        structure: &Structure,
        system: &System,
        curved: Option<&Envelope>,
        start: StepStart,
    ) -> KktStep {
        let hessian = curved.unwrap_or(&system.hessian);
        let (weights, violations) = (&self.weights, start.violations);
        let mut multipliers = start.multipliers;
        let mut delta = DVector::zeros(structure.size());
        let mut residual = DVector::zeros(structure.size());
        let mut rows = vec![0.0; multipliers.len()];
        let largest = violations
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        for refinement in 0..REFINEMENTS {
            // Minus the gradient of the model's augmented Lagrangian at `delta`.
            residual.copy_from(&start.gradient);
            if refinement > 0 {
                hessian.multiply_add(&structure.pattern, &delta, &mut residual);
                for of in self.curvature.iter().chain(&self.shifts) {
                    of.multiply_add(&delta, &mut residual);
                }
            }
            let pull = |row: usize| {
                if weights[row] > 0.0 {
                    multipliers[row] + weights[row] * (violations[row] + rows[row])
                } else {
                    0.0
                }
            };
            system.add_pull(structure, pull, &mut residual);
            residual.neg_mut();
            self.matrix.solve(&structure.pattern, &mut residual);
            delta += &residual;
            system.along(structure, &delta, &mut rows);
            let mut worst: f64 = 0.0;
            for (row, multiplier) in multipliers.iter_mut().enumerate() {
                let error = if weights[row] > 0.0 {
                    violations[row] + rows[row]
                } else {
                    0.0
                };
                *multiplier += weights[row] * error;
                worst = worst.max(error.abs());
            }
            if worst <= (EXACT * largest).max(ROUNDING) {
                break;
            }
        }
        for (multiplier, weight) in multipliers.iter_mut().zip(weights) {
            if *weight == 0.0 {
                *multiplier = 0.0;
            }
        }
        KktStep { delta, multipliers }
    }

    /// The second-order correction of a step that led to `trial` ([`System::correction`]).
    pub fn correction(
        &self,
        structure: &Structure,
        system: &System,
        trial: &System,
        delta: &DVector<f64>,
    ) -> DVector<f64> {
        system.correction(structure, trial, delta, &self.weights, &self.matrix)
    }

    /// The part of `xᵀ (H + Jᵀ W J) x` from damping and shifts.
    pub fn damped(&self, x: &DVector<f64>) -> f64 {
        let damping = x.iter().zip(&self.damping).map(|(x, d)| d * x * x);
        damping.sum::<f64>() + square(&self.shifts, x)
    }

    /// The part from the curvature of rows in closed form.
    pub fn curved(&self, x: &DVector<f64>) -> f64 {
        square(&self.curvature, x)
    }

    /// Adds `Cᵀ W C d`, what the rows of a system, weighed as here, take off a direction `d` that does not hold them.
    pub fn add_pulled(
        &self,
        structure: &Structure,
        system: &System,
        direction: &DVector<f64>,
        to: &mut DVector<f64>,
    ) {
        let mut rows = Vec::new();
        system.along(structure, direction, &mut rows);
        system.add_pull(structure, |row| self.weight(row) * rows[row], to);
    }

    /// Weight of a row in the factorised matrix; zero where it is not active.
    pub fn weight(&self, row: usize) -> f64 {
        self.weights[row]
    }

    /// Solves `(H + Jᵀ W J) x = b` in place.
    pub fn solve(&self, structure: &Structure, b: &mut DVector<f64>) {
        self.matrix.solve(&structure.pattern, b);
    }
}

/// `xᵀ K x`.
fn square(curvature: &[Curvature], x: &DVector<f64>) -> f64 {
    let each = curvature.iter().map(|of| {
        let once = of.value * x[of.row] * x[of.column];
        if of.row == of.column {
            once
        } else {
            2.0 * once
        }
    });
    each.sum()
}

/// Factorises a matrix that contains curvature of rows that is not convex; without it, Gauss and
/// Newton's model is there to turn to, and the better one (twenty bounces of a small die end in a
/// tenth of the factorisations). With large weights it is positive definite where the
/// Hessian is on the null space of the weighted rows (Nocedal and Wright, theorem 17.5); where
/// curvature prevents that, pivots that are negative change their sign. Returns those shifts of the
/// diagonal; `None` where an entry is not a number.
fn factorise_curved(matrix: &mut Envelope, pattern: &Pattern) -> Option<Vec<Curvature>> {
    let mut shifts = Vec::new();
    let repaired = matrix.factorise_repaired(pattern, |row, pivot| {
        let value = -2.0 * pivot;
        shifts.push(Curvature {
            row,
            column: row,
            value,
        });
        Some(value)
    });
    repaired.is_ok().then_some(shifts)
}
