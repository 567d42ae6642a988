//! A contact whose features lie elsewhere than the scene says: on a body, whose centre of mass is
//! elsewhere, or in the world.

use nalgebra::{SMatrix, Vector3};

use super::error::ContactError;
use super::feature::Feature;
use super::pair::Contact;
use crate::math::so3;

impl Contact {
    /// The contact with A's feature shifted by `shifts_m[0]` and B's by `shifts_m[1]` [m, each in its
    /// body's axes]; its tilt axes stay.
    ///
    /// Fails where a sharp line comes to lie on its body's centre of mass.
    pub fn with_shifts(&self, shifts_m: [Vector3<f64>; 2]) -> Result<Self, ContactError> {
        let [a, b] = [self.a(), self.b()];
        let mut shifted = Self::new(a.shifted(&shifts_m[0]), b.shifted(&shifts_m[1]))?;
        shifted.tangents = self.tangents;
        Ok(shifted)
    }

    /// The contact with B's face raised by `height_m` along its normal `n` and turned about its own
    /// point by `Exp(t0 a0 + t1 a1)`, with [`Contact::tilt_axes`] `a`, which turn with it. `None`
    /// where B's feature is no face, or the height or a tilt is no number.
    ///
    /// Beside it, the motion of the face by height and tilts, a column each: its displacement [m, B's
    /// axes], then its rotation [rad, B's axes] about its own point. With no height and no tilt these
    /// are `n`, `a0` and `a1`.
    pub fn with_surface(
        &self,
        height_m: f64,
        tilt_rad: [f64; 2],
    ) -> Option<(Self, SMatrix<f64, 6, 3>)> {
        let (axes, Feature::Face { point_m, normal }) = (self.tilt_axes()?, self.b()) else {
            return None;
        };
        let tilt = axes[0] * tilt_rad[0] + axes[1] * tilt_rad[1];
        let (turn, left) = so3::exp_and_left_jacobian(&tilt);
        let face = Feature::face(point_m + normal * height_m, turn * normal);
        let mut moved = Self::new(*self.a(), face).ok()?;
        moved.tangents = Some(axes.map(|axis| turn * axis));
        let mut motion = SMatrix::<f64, 6, 3>::zeros();
        motion.fixed_view_mut::<3, 1>(0, 0).copy_from(normal);
        for (column, axis) in axes.iter().enumerate() {
            let rotation: Vector3<f64> = left * axis;
            motion
                .fixed_view_mut::<3, 1>(3, 1 + column)
                .copy_from(&rotation);
        }
        Some((moved, motion))
    }
}
