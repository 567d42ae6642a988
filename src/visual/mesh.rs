//! Surfaces of shapes as triangles.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

use crate::physics::Shape;
use crate::physics::shape::{Part, hull_triangles};

/// Corners in the shape's axes \[m\], counter-clockwise from outside.
pub type Triangle = [Vector3<f64>; 3];

/// Sides of what is round: the mesh is within 0.3 % of the radius.
const SIDES: usize = 48;

/// The closed surface of a shape. Corners of neighbouring triangles are the same numbers. A rounded box is
/// covered as its outer sides; a hull whose points span no volume has no surface. A compound has the closed
/// surfaces of all its parts.
pub fn mesh(shape: &Shape) -> Vec<Triangle> {
    match shape {
        Shape::Cuboid { half_extents_m } | Shape::RoundedCuboid { half_extents_m, .. } => {
            cuboid(half_extents_m)
        }
        Shape::Sphere { radius_m } => revolved(&round(0.0, *radius_m)),
        Shape::Cylinder {
            half_length_m: half_m,
            radius_m,
        } => revolved(&[
            [0.0, -half_m],
            [*radius_m, -half_m],
            [*radius_m, *half_m],
            [0.0, *half_m],
        ]),
        Shape::Capsule {
            half_length_m,
            radius_m,
        } => revolved(&round(*half_length_m, *radius_m)),
        // The origin is a quarter of the height above the base.
        Shape::Cone {
            half_height_m: half_m,
            radius_m,
        } => revolved(&[
            [0.0, -0.5 * half_m],
            [*radius_m, -0.5 * half_m],
            [0.0, 1.5 * half_m],
        ]),
        Shape::Hull { points_m } => hull_triangles(points_m).unwrap_or_default(),
        Shape::Compound(compound) => compound.parts.iter().flat_map(of_part).collect(),
    }
}

/// The surface of a part of a compound, in the compound's axes.
fn of_part(part: &Part) -> Vec<Triangle> {
    let placed = |p: Vector3<f64>| part.compound_from_shape.transform_point(&p.into()).coords;
    let own = mesh(&part.shape).into_iter();
    own.map(|triangle| triangle.map(placed)).collect()
}

fn cuboid(half_extents_m: &Vector3<f64>) -> Vec<Triangle> {
    let corner = |signs: [f64; 3]| half_extents_m.component_mul(&Vector3::from(signs));
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            // Along the next two axes, the other way round on the negative side.
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[u, v]| {
                let mut signs = [side; 3];
                signs[(axis + 1) % 3] = side * u;
                signs[(axis + 2) % 3] = v;
                corner(signs)
            });
            let [a, b, c, d] = corners;
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// Distances from the axis and heights of two half circles, their centres so far below and above the
/// origin \[m\].
fn round(half_length_m: f64, radius_m: f64) -> Vec<[f64; 2]> {
    let steps = SIDES / 4;
    let quarter = |step: usize| {
        let (sin, cos) = (FRAC_PI_2 * step as f64 / steps as f64).sin_cos();
        [radius_m * cos, half_length_m + radius_m * sin]
    };
    let top = [0.0, half_length_m + radius_m];
    let upper: Vec<[f64; 2]> = (0..steps).map(quarter).chain([top]).collect();
    let lower = upper.iter().rev().map(|[r_m, z_m]| [*r_m, -z_m]);
    // Of a ball both meet in one ring.
    let above = usize::from(half_length_m == 0.0);
    lower.chain(upper[above..].iter().copied()).collect()
}

/// The surface that a line from the lower to the upper end of the z axis leaves when it turns about
/// that; its points are distances from the axis and heights \[m\].
fn revolved(profile_m: &[[f64; 2]]) -> Vec<Triangle> {
    let point = |[r_m, z_m]: [f64; 2], side: usize| {
        let (sin, cos) = (TAU * (side % SIDES) as f64 / SIDES as f64).sin_cos();
        Vector3::new(r_m * cos, r_m * sin, z_m)
    };
    let mut triangles = Vec::new();
    for pair in profile_m.windows(2) {
        let [lower, upper] = [pair[0], pair[1]];
        for side in 0..SIDES {
            let [a, b] = [side, side + 1].map(|side| point(lower, side));
            let [d, c] = [side, side + 1].map(|side| point(upper, side));
            // On the axis a side has no width.
            if lower[0] > 0.0 {
                triangles.push([a, b, c]);
            }
            if upper[0] > 0.0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Every edge is passed once in each direction.
    fn is_closed(triangles: &[Triangle]) -> bool {
        let mut passes = BTreeMap::new();
        // Zeros of either sign are one number.
        let key = |p: &Vector3<f64>| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits);
        for [a, b, c] in triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *passes.entry((key(from), key(to))).or_insert(0) += 1;
            }
        }
        let is_met = |(from, to): &(_, _)| passes.get(&(*to, *from)) == Some(&1);
        passes
            .iter()
            .all(|(edge, count)| *count == 1 && is_met(edge))
    }

    #[test]
    fn every_shape_has_a_closed_surface_of_its_volume_and_centre() {
        let points_m = [[1, 0, 0], [-1, 1, 0], [-1, -1, 0], [1, 0, 2]]
            .map(|p| Vector3::from(p).map(f64::from))
            .to_vec();
        let (half_length_m, radius_m) = (0.3, 0.2);
        let shapes = [
            Shape::Cuboid {
                half_extents_m: Vector3::new(0.1, 0.2, 0.3),
            },
            Shape::Sphere { radius_m },
            Shape::Cylinder {
                half_length_m,
                radius_m,
            },
            Shape::Capsule {
                half_length_m,
                radius_m,
            },
            Shape::Cone {
                half_height_m: 0.3,
                radius_m,
            },
            Shape::Hull { points_m },
        ];
        for shape in shapes {
            let triangles = mesh(&shape);
            assert!(is_closed(&triangles), "{shape:?}");
            let volumes = triangles.iter().map(|[a, b, c]| a.dot(&b.cross(c)) / 6.0);
            let volume_m3: f64 = volumes.sum();
            let expected_m3 = match &shape {
                Shape::Hull { .. } => 4.0 / 3.0,
                solid => solid.uniform_mass().expect("a solid").volume_m3,
            };
            let ratio = volume_m3 / expected_m3;
            assert!((0.99..1.0 + 1e-12).contains(&ratio), "{shape:?}: {ratio}");
            if matches!(shape, Shape::Hull { .. }) {
                continue;
            }
            let moments = triangles.iter().map(|[a, b, c]| {
                let volume_m3 = a.dot(&b.cross(c)) / 6.0;
                (a + b + c) * (0.25 * volume_m3)
            });
            let centre_m = moments.sum::<Vector3<f64>>() / volume_m3;
            assert!(centre_m.norm() < 1e-12, "{shape:?}: {centre_m}");
        }
    }
}
