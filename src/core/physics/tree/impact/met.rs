//! The contacts of an impact of trees in given poses.

use nalgebra::{DVector, Vector3};

use crate::physics::contact::Touch;

/// A link that takes part in an impact.
#[derive(Clone, Copy, Debug)]
pub(in crate::physics::tree) struct Side {
    /// Its place among the links of the forest.
    pub place: usize,
    /// One of A, minus one of B.
    pub sign: f64,
    /// Where it is touched [m, link].
    pub point_m: Vector3<f64>,
}

/// One of the contacts in given poses.
pub(super) struct Met {
    pub(super) touch: Touch,
    pub(super) sides: Vec<Side>,
    /// The tilted normal [world],
    pub(super) normal: Vector3<f64>,
    /// and its derivatives by the tilts; none where it cannot be tilted.
    pub(super) normal_by_tilt: Option<[Vector3<f64>; 2]>,
    /// Velocity of A's contact point against B's before [m/s, world].
    pub(super) velocity_m_s: Vector3<f64>,
}

impl Met {
    /// Speed along the untilted normal [m/s].
    pub(super) fn speed_m_s(&self) -> f64 {
        self.touch.normal.dot(&self.velocity_m_s)
    }
}

/// Rows of each contact.
pub(super) fn thirds(rows: &DVector<f64>) -> Vec<Vector3<f64>> {
    let all = rows.as_slice().chunks_exact(3);
    all.map(Vector3::from_column_slice).collect()
}

/// Rows of all contacts one below the other.
pub(super) fn stacked(rows: impl IntoIterator<Item = Vector3<f64>>) -> DVector<f64> {
    let rows: Vec<f64> = rows
        .into_iter()
        .flat_map(|row| [row.x, row.y, row.z])
        .collect();
    DVector::from_vec(rows)
}
