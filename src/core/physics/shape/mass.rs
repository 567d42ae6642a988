//! Volume, centre of mass and moments of inertia.

use nalgebra::{Matrix3, Vector3};

use super::error::ShapeError;
use crate::math::Pose;

/// How mass is distributed, in any axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassDistribution {
    /// Volume.
    pub volume_m3: f64,
    /// Centre of mass.
    pub centre_m: Vector3<f64>,
    /// Tensor of inertia over mass about the centre of mass, along the axes.
    pub tensor_m2: Matrix3<f64>,
}

impl MassDistribution {
    /// Of a solid of uniform density inside triangles that are counter-clockwise from outside: the sum over
    /// the tetrahedra between the origin and each of them. `None` where they enclose no volume.
    pub fn of_triangles(
        triangles: impl IntoIterator<Item = [Vector3<f64>; 3]>,
    ) -> Option<MassDistribution> {
        let mut volume_m3 = 0.0;
        let mut first_m4 = Vector3::zeros();
        let mut second_m5 = Matrix3::zeros();
        for [a, b, c] in triangles {
            let volume = a.dot(&b.cross(&c)) / 6.0;
            let sum = a + b + c;
            volume_m3 += volume;
            first_m4 += sum * (volume / 4.0);
            second_m5 +=
                (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose())
                    * (volume / 20.0);
        }
        if !(volume_m3 > 0.0 && volume_m3.is_finite()) {
            return None;
        }
        let centre_m = first_m4 / volume_m3;
        let second_m2 = second_m5 / volume_m3 - centre_m * centre_m.transpose();
        Some(Self {
            volume_m3,
            centre_m,
            tensor_m2: Matrix3::identity() * second_m2.trace() - second_m2,
        })
    }

    /// Of a shape whose axes are principal ones at its centre of mass.
    pub fn of_uniform(uniform: &UniformMass) -> Self {
        Self {
            volume_m3: uniform.volume_m3,
            centre_m: Vector3::zeros(),
            tensor_m2: Matrix3::from_diagonal(&uniform.moments_per_mass_m2),
        }
    }

    /// The same, placed in other axes.
    pub fn placed(&self, frame_from_own: &Pose) -> Self {
        let turn = frame_from_own.rotation.to_rotation_matrix();
        Self {
            volume_m3: self.volume_m3,
            centre_m: frame_from_own.transform_point(&self.centre_m.into()).coords,
            tensor_m2: turn.matrix() * self.tensor_m2 * turn.matrix().transpose(),
        }
    }

    /// Of several together, each with its mass; a negative mass is that of a cavity, whose volume is taken
    /// away. By the parallel-axis theorem each adds `m (|d|² 1 − d dᵀ)`, with `d` from the common centre of
    /// mass to its own. `None` where no mass is left.
    pub fn joined(parts: &[(f64, Self)]) -> Option<Self> {
        let mass_kg: f64 = parts.iter().map(|(mass_kg, _)| mass_kg).sum();
        let volumes = parts.iter().map(|(m, of)| of.volume_m3 * m.signum());
        let volume_m3: f64 = volumes.sum();
        if !(mass_kg > 0.0 && mass_kg.is_finite() && volume_m3 > 0.0) {
            return None;
        }
        let firsts = parts.iter().map(|(m, of)| of.centre_m * *m);
        let centre_m = firsts.sum::<Vector3<f64>>() / mass_kg;
        let tensors = parts.iter().map(|(m, of)| {
            let d = of.centre_m - centre_m;
            (of.tensor_m2 + Matrix3::identity() * d.norm_squared() - d * d.transpose()) * *m
        });
        Some(Self {
            volume_m3,
            centre_m,
            tensor_m2: tensors.sum::<Matrix3<f64>>() / mass_kg,
        })
    }

    /// As the moments about these very axes. Fails where they are not principal ones at the centre of mass, to
    /// the error of coordinates typed with six digits.
    pub fn about_its_axes(&self) -> Result<UniformMass, ShapeError> {
        if self.centre_m.norm() > CENTRE_TOLERANCE_M {
            return Err(ShapeError::OffCentre {
                offset_m: self.centre_m,
            });
        }
        let mut moments = self.tensor_m2.diagonal();
        let none = MOMENT_TOLERANCE * moments.max();
        let products_m2 = -Vector3::new(
            self.tensor_m2[(1, 2)],
            self.tensor_m2[(0, 2)],
            self.tensor_m2[(0, 1)],
        );
        if products_m2.amax() > none {
            return Err(ShapeError::NotPrincipal { products_m2 });
        }
        equalise(&mut moments, none);
        Ok(UniformMass {
            volume_m3: self.volume_m3,
            moments_per_mass_m2: moments,
        })
    }
}

/// Greatest distance of a centre of mass from the origin that counts as none \[m\].
const CENTRE_TOLERANCE_M: f64 = 1e-9;

/// Products of inertia, and differences of moments, that count as zero, relative to the largest moment: the
/// error of coordinates typed with six digits.
pub const MOMENT_TOLERANCE: f64 = 1e-6;

/// Makes moments equal that differ by less: those of a regular prism are equal only to the digits of the
/// typed coordinates.
pub fn equalise(moments: &mut Vector3<f64>, none: f64) {
    if moments.max() - moments.min() <= none {
        moments.fill(moments.mean());
    }
    for axis in 0..3 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        if (moments[i] - moments[j]).abs() <= none {
            let mean = 0.5 * (moments[i] + moments[j]);
            moments[i] = mean;
            moments[j] = mean;
        }
    }
}

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
