//! The quadratic model of a composite step.

use nalgebra::{DMatrix, DVector, SVD};

use crate::optimise::envelope::Envelope;
use crate::optimise::program::Program;
use crate::optimise::system::System;

/// Normal steps may be so many radii long.
const NORMAL: f64 = 4.0;
/// Price of a violation, per greatest multiplier.
const PRICE: f64 = 2.0;

/// A row that acts.
pub(super) struct Row {
    /// Its place among all rows.
    pub(super) number: usize,
    /// The bound at which it acts: −1 the lower one, 1 the upper one, 0 both.
    pub(super) side: f64,
    is_violated: bool,
}

/// The quadratic model of cost and acting rows at a point, in scaled unknowns.
pub(super) struct Model {
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    pub(super) rows: Vec<Row>,
    jacobian: DMatrix<f64>,
    off: DVector<f64>,
    /// `C⁺`.
    pub(super) inverse: DMatrix<f64>,
    /// `Z`, orthonormal.
    free: DMatrix<f64>,
}

/// A step of a model.
pub(super) struct ModelStep {
    pub(super) delta: DVector<f64>,
    /// `ν` of the rows that act,
    pub(super) multipliers: DVector<f64>,
    /// and `μ`.
    pub(super) price: f64,
    /// Decrease of the model's merit.
    pub(super) predicted: f64,
    /// Whether its tangential part is as long as the radius.
    pub(super) is_at_border: bool,
}

impl Model {
    /// The model at a point, in unknowns of these lengths; `None` where numbers are not finite, of which no
    /// decomposition ends.
    pub(super) fn new<P: Program>(
        program: &P,
        system: &System,
        hessian: &Envelope,
        scale: &DVector<f64>,
        held: &[bool],
    ) -> Option<Self> {
        /// Least singular value of independent rows, of the greatest.
        const RANK: f64 = 1e-10;
        let structure = program.structure();
        let size = structure.size();
        let hessian = DMatrix::from_fn(size, size, |row, column| {
            let (row, column) = (row.max(column), row.min(column));
            scale[row] * scale[column] * hessian.get(&structure.pattern, row, column)
        });
        let (mut rows, mut off, mut entries) = (Vec::new(), Vec::new(), Vec::new());
        let mut number = 0;
        for (pattern, block) in structure.blocks.iter().zip(&system.blocks) {
            for row in 0..block.values.len() {
                if block.acts(row) || held[number] {
                    let ((lower, upper), value) = (block.bounds[row], block.values[row]);
                    let side = match lower == upper {
                        true => 0.0,
                        false if value - lower < upper - value => -1.0,
                        false => 1.0,
                    };
                    let mut whole = DVector::zeros(size);
                    let derivatives = block.derivatives(pattern, row);
                    for (at, entry) in pattern.unknowns(row).iter().zip(derivatives) {
                        whole[*at] = entry * scale[*at];
                    }
                    entries.push(whole.transpose());
                    rows.push(Row {
                        number,
                        side,
                        is_violated: block.acts(row),
                    });
                    off.push(value - if side < 0.0 { lower } else { upper });
                }
                number += 1;
            }
        }
        let jacobian = if entries.is_empty() {
            DMatrix::zeros(0, size)
        } else {
            DMatrix::from_rows(&entries)
        };
        let gradient = system.gradient.component_mul(scale);
        let mut numbers = hessian.iter().chain(&jacobian).chain(&gradient);
        if !numbers.all(|number| number.is_finite()) {
            return None;
        }
        let mut inverse = DMatrix::zeros(size, rows.len());
        let mut left = DMatrix::identity(size, size);
        if !rows.is_empty() {
            let SVD {
                u: Some(u),
                v_t: Some(v_t),
                singular_values,
            } = jacobian.clone().svd(true, true)
            else {
                unreachable!("both are asked for");
            };
            let least = RANK * singular_values.max();
            for (at, value) in singular_values.iter().enumerate() {
                if *value > least {
                    let row = v_t.row(at).transpose();
                    inverse.ger(value.recip(), &row, &u.column(at), 1.0);
                    left.ger(-1.0, &row, &row, 1.0);
                }
            }
        }
        // A projection: eigenvalues are zero and one.
        let eigen = left.symmetric_eigen();
        let free = (0..size).filter(|at| eigen.eigenvalues[*at] > 0.5);
        let free: Vec<_> = free.map(|at| eigen.eigenvectors.column(at)).collect();
        let free = match free.as_slice() {
            [] => DMatrix::zeros(size, 0),
            columns => DMatrix::from_columns(columns),
        };
        Some(Self {
            hessian,
            gradient,
            rows,
            jacobian,
            off: off.into(),
            inverse,
            free,
        })
    }

    /// Violations elsewhere of the rows that act here.
    pub(super) fn acting(&self, system: &System) -> DVector<f64> {
        let blocks = system.blocks.iter();
        let all = blocks.flat_map(|block| (0..block.values.len()).map(|row| block.violation(row)));
        let all: Vec<f64> = all.collect();
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| all[row.number]))
    }

    pub(super) fn step(&self, radius: f64) -> ModelStep {
        let mut delta = -(&self.inverse * &self.off);
        let length = delta.norm();
        if length > NORMAL * radius {
            delta *= NORMAL * radius / length;
        }
        let pull = self.free.tr_mul(&(&self.gradient + &self.hessian * &delta));
        let reduced = self.free.tr_mul(&(&self.hessian * &self.free));
        let (along, is_at_border) = within(reduced, &pull, radius);
        delta += &self.free * along;
        let curved = &self.hessian * &delta;
        let multipliers = -self.inverse.tr_mul(&(&self.gradient + &curved));
        let price = PRICE * multipliers.amax();
        let left = &self.off + &self.jacobian * &delta;
        let sum = |of: &DVector<f64>| -> f64 {
            let rows = of.iter().zip(&self.rows).filter(|(_, row)| row.is_violated);
            rows.map(|(off, _)| off.abs()).sum()
        };
        let of_cost = -(self.gradient.dot(&delta) + 0.5 * curved.dot(&delta));
        ModelStep {
            predicted: of_cost + price * (sum(&self.off) - sum(&left)),
            price,
            multipliers,
            delta,
            is_at_border,
        }
    }
}

/// The least of `½ zᵀHz + gᵀz` within a radius, and whether it is at the border:
/// `z = −(H + σ)⁻¹ g` with the least `σ ≥ 0` that is short enough.
pub(super) fn within(
    hessian: DMatrix<f64>,
    gradient: &DVector<f64>,
    radius: f64,
) -> (DVector<f64>, bool) {
    /// Halvings of the interval of `σ`.
    const HALVINGS: usize = 60;
    if gradient.is_empty() {
        return (gradient.clone(), false);
    }
    let eigen = hessian.symmetric_eigen();
    let pull = eigen.eigenvectors.tr_mul(gradient);
    let least = eigen.eigenvalues.min();
    let at = |shift: f64| {
        let parts = pull.zip_map(&eigen.eigenvalues, |pull, value| {
            let held = value + shift;
            if pull == 0.0 { 0.0 } else { -pull / held }
        });
        let length = parts.norm();
        (parts, length)
    };
    let whole = at(0.0);
    if least > 0.0 && whole.1 <= radius {
        return (&eigen.eigenvectors * whole.0, false);
    }
    let (mut low, mut high) = ((-least).max(0.0), (-least).max(0.0) + pull.norm() / radius);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if at(middle).1 > radius {
            low = middle;
        } else {
            high = middle;
        }
    }
    (&eigen.eigenvectors * at(high).0, true)
}
