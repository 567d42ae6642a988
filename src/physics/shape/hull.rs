//! Convex hulls of points.

use nalgebra::{Matrix3, Vector3};
use parry3d::math::Vector as ParryVector;
use parry3d::transformation::try_convex_hull;

use super::error::ShapeError;
use super::mass::UniformMass;

/// Greatest distance of a hull's centre of mass from the origin \[m\].
const CENTRE_TOLERANCE_M: f64 = 1e-9;

/// Products of inertia of a hull, and differences of its moments, that count as zero, relative to
/// its largest moment: the error of coordinates typed with six digits.
const MOMENT_TOLERANCE: f64 = 1e-6;

/// Height over size below which a hull is flat.
const FLAT_RATIO: f64 = 1e-6;

/// Fails unless the points are finite and span a volume: takes the farthest from the first, then
/// the farthest from that line, then from that plane. parry accepts three points and gives
/// arbitrary results for a flat set.
pub(super) fn check_hull(points_m: &[Vector3<f64>]) -> Result<(), ShapeError> {
    if let Some(index) = points_m
        .iter()
        .position(|p| !p.iter().all(|x| x.is_finite()))
    {
        return Err(ShapeError::Point { index });
    }
    let flat = ShapeError::Flat {
        count: points_m.len(),
    };
    let Some(first) = points_m.first() else {
        return Err(flat);
    };
    let farthest = |measure: &dyn Fn(&Vector3<f64>) -> f64| {
        points_m
            .iter()
            .map(|p| p - first)
            .max_by(|a, b| measure(a).total_cmp(&measure(b)))
            .unwrap_or_default()
    };
    let longest = farthest(&|d| d.norm());
    let size_m = longest.norm();
    if !(size_m > 0.0 && size_m.is_finite()) {
        return Err(flat);
    }
    let line = longest / size_m;
    let across = farthest(&|d| (d - line * line.dot(d)).norm());
    let normal = line.cross(&across);
    if normal.norm() < FLAT_RATIO * size_m {
        return Err(flat);
    }
    let normal = normal.normalize();
    if farthest(&|d| normal.dot(d).abs()).dot(&normal).abs() < FLAT_RATIO * size_m {
        return Err(flat);
    }
    Ok(())
}

pub(super) fn hull_of(
    points_m: &[Vector3<f64>],
) -> Result<(Vec<ParryVector>, Vec<[u32; 3]>), ShapeError> {
    let points: Vec<_> = points_m.iter().map(to_parry).collect();
    try_convex_hull(&points).map_err(|error| ShapeError::Hull {
        count: points_m.len(),
        reason: error.to_string(),
    })
}

/// The triangles of the hull of points, counter-clockwise from outside, for drawing.
pub fn hull_triangles(points_m: &[Vector3<f64>]) -> Result<Vec<[Vector3<f64>; 3]>, ShapeError> {
    let (points, triangles) = hull_of(points_m)?;
    Ok(triangles
        .into_iter()
        .map(|triangle| triangle.map(|i| from_parry(points[i as usize])))
        .collect())
}

/// Mass properties by summing the tetrahedra between the origin and each triangle. parry's sum is
/// exact too, but the principal frame it returns does not reproduce the tensor for rotated boxes.
pub(super) fn hull_mass(points_m: &[Vector3<f64>]) -> Result<UniformMass, ShapeError> {
    let (points, triangles) = hull_of(points_m)?;
    let mut volume_m3 = 0.0;
    let mut first_m4 = Vector3::zeros();
    let mut second_m5 = Matrix3::zeros();
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|i| from_parry(points[i as usize]));
        let volume = a.dot(&b.cross(&c)) / 6.0;
        let sum = a + b + c;
        volume_m3 += volume;
        first_m4 += sum * (volume / 4.0);
        second_m5 +=
            (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose())
                * (volume / 20.0);
    }
    if !(volume_m3 > 0.0 && volume_m3.is_finite()) {
        return Err(ShapeError::Flat {
            count: points_m.len(),
        });
    }
    let offset_m = first_m4 / volume_m3;
    if offset_m.norm() > CENTRE_TOLERANCE_M {
        return Err(ShapeError::OffCentre { offset_m });
    }
    let second_m2 = second_m5 / volume_m3;
    let tensor_m2 = Matrix3::identity() * second_m2.trace() - second_m2;
    let mut moments = tensor_m2.diagonal();
    let none = MOMENT_TOLERANCE * moments.max();
    let products_m2 = Vector3::new(second_m2[(1, 2)], second_m2[(0, 2)], second_m2[(0, 1)]);
    if products_m2.amax() > none {
        return Err(ShapeError::NotPrincipal { products_m2 });
    }
    // The moments of a regular prism are equal only to the digits of the typed coordinates.
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
    Ok(UniformMass {
        volume_m3,
        moments_per_mass_m2: moments,
    })
}

pub(super) fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

pub(super) fn from_parry(v: ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}
