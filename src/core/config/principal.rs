//! Principal axes: those nearest to axes that are given.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

/// Products of inertia, and differences of moments, that count as zero where a tensor is given, relative to
/// the largest moment: what rounding leaves.
pub(super) const ROUNDING: f64 = 1e-12;

/// Most sweeps of the eigenvalue iteration; three suffice.
const SWEEPS: usize = 1000;

/// Principal moments of a tensor, and axes along which they are.
///
/// Right-handed, and as near to the axes of `near` as principal axes are: the very same where the
/// tensor is diagonal along them. Where two moments are equal the third's axis is reached by the
/// shortest turn. Products and differences below `equal`, relative to the largest moment, are none. `None` where the tensor has no eigenvalues, as one that is not finite.
pub(super) fn principal(
    tensor: &Matrix3<f64>,
    near: &UnitQuaternion<f64>,
    equal: f64,
) -> Option<(UnitQuaternion<f64>, Vector3<f64>)> {
    let near_rotation = near.to_rotation_matrix();
    let along = |turn: &Rotation3<f64>| turn.matrix().transpose() * tensor * turn.matrix();
    let seen = along(&near_rotation);
    let size = seen.amax();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let products = Vector3::new(seen[(1, 2)], seen[(0, 2)], seen[(0, 1)]);
    if products.amax() <= equal * size {
        return Some((*near, seen.diagonal()));
    }
    let eigen = SymmetricEigen::try_new(seen / size, f64::EPSILON, SWEEPS)?;
    let moments = eigen.eigenvalues;
    let gap = |axis: usize| (moments[(axis + 1) % 3] - moments[(axis + 2) % 3]).abs();
    let turn = match (0..3).find(|axis| gap(*axis) <= equal) {
        Some(alone) => shortest(eigen.eigenvectors.column(alone).into_owned()),
        None => nearest(&eigen.eigenvectors),
    };
    let turn = near * UnitQuaternion::from_rotation_matrix(&turn);
    Some((turn, along(&turn.to_rotation_matrix()).diagonal()))
}

/// The shortest turn that lays one of the axes, either way round, along a direction.
fn shortest(direction: Vector3<f64>) -> Rotation3<f64> {
    let axis = direction.iamax();
    let from = Vector3::from_fn(|of, _| if of == axis { 1.0 } else { 0.0 });
    let to = direction * direction[axis].signum();
    // They are at most 55° apart.
    Rotation3::rotation_between(&from, &to).unwrap_or_else(Rotation3::identity)
}

/// The columns in the order, and with the signs, that make the turn by them least.
fn nearest(vectors: &Matrix3<f64>) -> Rotation3<f64> {
    const ORDERS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    // Of orders that are equally near the first.
    const TIE: f64 = 1e-9;
    let signed = |order: &[usize; 3]| {
        let columns = [0, 1, 2].map(|axis| {
            let column = vectors.column(order[axis]).into_owned();
            column * if column[axis] < 0.0 { -1.0 } else { 1.0 }
        });
        let mut turn = Matrix3::from_columns(&columns);
        if turn.determinant() < 0.0 {
            let least = turn.diagonal().imin();
            turn.column_mut(least).neg_mut();
        }
        turn
    };
    let mut best = signed(&ORDERS[0]);
    for order in &ORDERS[1..] {
        let turn = signed(order);
        if turn.trace() > best.trace() + TIE {
            best = turn;
        }
    }
    Rotation3::from_matrix_unchecked(best)
}
