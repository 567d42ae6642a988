//! What takes together do not determine: directions of the joint information that tell less than a typical change of the
//! parameters, priors included.

use nalgebra::{DMatrix, DVector};

use super::parameter::JointParameter;

/// Least information of a direction that is determined, per squared length.
const LEAST: f64 = 1.0;
/// Parameters with a smaller part in a direction are not named.
const NAMED: f64 = 0.1;

/// A combination of parameters that is not determined.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakDirection {
    /// The parameters that change together, by their index, and by how much, in lengths; the greatest first.
    pub parts: Vec<(usize, f64)>,
    /// Standard deviation along it, in lengths; infinite where nothing tells of it.
    pub sd: f64,
}

/// The directions of an information matrix that are weak, as columns, and in words.
pub(super) fn weak(
    parameters: &[JointParameter],
    information: &DMatrix<f64>,
) -> (DMatrix<f64>, Vec<WeakDirection>) {
    let count = parameters.len();
    let eigen = information.clone().symmetric_eigen();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let weak = order.iter().filter(|at| eigen.eigenvalues[**at] < LEAST);
    let columns: Vec<DVector<f64>> = weak
        .clone()
        .map(|at| eigen.eigenvectors.column(*at).into_owned())
        .collect();
    let words = weak.zip(&columns).map(|(at, column)| {
        let mut parts: Vec<(usize, f64)> = column.iter().copied().enumerate().collect();
        parts.retain(|(_, part)| part.abs() > NAMED);
        parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let sign = parts.first().map_or(1.0, |(_, part)| part.signum());
        parts.iter_mut().for_each(|(_, part)| *part *= sign);
        let told = eigen.eigenvalues[*at].max(0.0);
        WeakDirection {
            parts,
            sd: told.sqrt().recip(),
        }
    });
    let words = words.collect();
    match columns.is_empty() {
        true => (DMatrix::zeros(count, 0), words),
        false => (DMatrix::from_columns(&columns), words),
    }
}

/// `1 − V Vᵀ` of directions.
pub(super) fn without(directions: &DMatrix<f64>) -> DMatrix<f64> {
    let count = directions.nrows();
    DMatrix::identity(count, count) - directions * directions.transpose()
}
