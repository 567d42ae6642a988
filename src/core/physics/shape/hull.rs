//! Convex hulls of points.

use nalgebra::Vector3;
use parry3d::math::Vector as ParryVector;
use parry3d::transformation::try_convex_hull;

use super::error::ShapeError;
use super::mass::MassDistribution;

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

/// How mass is distributed in the hull of points. parry's sum is exact too, but the principal frame it returns
/// does not reproduce the tensor for rotated boxes.
pub(super) fn hull_mass(points_m: &[Vector3<f64>]) -> Result<MassDistribution, ShapeError> {
    let triangles = hull_triangles(points_m)?;
    MassDistribution::of_triangles(triangles).ok_or(ShapeError::Flat {
        count: points_m.len(),
    })
}

pub(super) fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

pub(super) fn from_parry(v: ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}
