//! Volume and moments of inertia at uniform density.

use nalgebra::Vector3;

/// Mass properties of a shape at uniform density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformMass {
    /// Volume.
    pub volume_m3: f64,
    /// Principal moments over mass, about the shape's axes.
    pub moments_per_mass_m2: Vector3<f64>,
}

/// Mass properties of a rounded box: the sum of the core, the slabs on its faces, the quarter
/// cylinders on its edges and the octants of a ball at its corners (parry leaves the rounding out).
pub(super) fn rounded_mass(half_extents_m: &Vector3<f64>, radius_m: f64) -> UniformMass {
    use std::f64::consts::PI;
    let (core, r) = (half_extents_m.add_scalar(-radius_m), radius_m);
    let ball_m3 = 4.0 / 3.0 * PI * r.powi(3);
    let mut volume_m3 = 8.0 * core.product() + ball_m3;
    // ∫x² dV along each axis.
    let mut second_m5 = Vector3::zeros();
    for axis in 0..3 {
        let (a, b, c) = (core[axis], core[(axis + 1) % 3], core[(axis + 2) % 3]);
        volume_m3 += 8.0 * r * b * c + 2.0 * PI * a * r * r;
        // Volume of the parts that have the core's extent along this axis, the core included.
        let along_m3 = 8.0 * a * (b * c + r * (b + c)) + 2.0 * PI * a * r * r;
        let slabs = 8.0 / 3.0 * b * c * ((a + r).powi(3) - a.powi(3));
        // ∫(a + |s|)² over a disc, and over a ball.
        let disc = PI * r * r * a * a + 8.0 / 3.0 * a * r.powi(3) + PI / 4.0 * r.powi(4);
        let ball = ball_m3 * a * a + PI * a * r.powi(4) + 4.0 / 15.0 * PI * r.powi(5);
        second_m5[axis] = along_m3 * a * a / 3.0 + slabs + 2.0 * (b + c) * disc + ball;
    }
    let moments_m5 = second_m5.map(|own| second_m5.sum() - own);
    UniformMass {
        volume_m3,
        moments_per_mass_m2: moments_m5 / volume_m3,
    }
}
