//! Shapes as the primitives that viewers know.

use nalgebra::{Translation3, Vector3};

use super::mesh::{Triangle, mesh};
use crate::math::Pose;
use crate::physics::Shape;

/// A part of a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// How far its centre is from the shape's origin, along the shape's z \[m\].
    pub offset_m: f64,
    /// What it is, about its centre in the shape's axes.
    pub form: Form,
}

/// What viewers can draw.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// A box.
    Cuboid {
        /// Its sides \[m\].
        sides_m: Vector3<f64>,
    },
    /// A ball.
    Sphere {
        /// Its radius \[m\].
        radius_m: f64,
    },
    /// A cylinder about z, or a cone or a part of one.
    Frustum {
        /// Half its length \[m\].
        half_length_m: f64,
        /// Radius of its lower end \[m\].
        radius_m: f64,
        /// Radius of its upper end, as a part of that of the lower one.
        top_scale: f64,
    },
    /// Triangles, counter-clockwise from outside \[m\].
    Triangles(Vec<Triangle>),
}

impl Primitive {
    /// Where its centre is, of a shape at that pose.
    pub fn pose(&self, shape: &Pose) -> Pose {
        if self.offset_m == 0.0 {
            *shape
        } else {
            shape * Translation3::new(0.0, 0.0, self.offset_m)
        }
    }
}

/// What a shape is made of. A rounded box is drawn as its outer sides. A hull whose points span no volume
/// is nothing.
pub fn primitives(shape: &Shape) -> Vec<Primitive> {
    let at = |offset_m, form| Primitive { offset_m, form };
    let cylinder = |half_length_m, radius_m| Form::Frustum {
        half_length_m,
        radius_m,
        top_scale: 1.0,
    };
    match shape {
        Shape::Cuboid { half_extents_m } | Shape::RoundedCuboid { half_extents_m, .. } => {
            let sides_m = 2.0 * half_extents_m;
            vec![at(0.0, Form::Cuboid { sides_m })]
        }
        Shape::Sphere { radius_m } => {
            let radius_m = *radius_m;
            vec![at(0.0, Form::Sphere { radius_m })]
        }
        Shape::Cylinder {
            half_length_m,
            radius_m,
        } => vec![at(0.0, cylinder(*half_length_m, *radius_m))],
        Shape::Capsule {
            half_length_m,
            radius_m,
        } => {
            let (z_m, radius_m) = (*half_length_m, *radius_m);
            let cap = |z_m| at(z_m, Form::Sphere { radius_m });
            vec![at(0.0, cylinder(z_m, radius_m)), cap(-z_m), cap(z_m)]
        }
        Shape::Cone {
            half_height_m,
            radius_m,
        } => {
            let cone = Form::Frustum {
                half_length_m: *half_height_m,
                radius_m: *radius_m,
                top_scale: 0.0,
            };
            // The origin is a quarter of the height above the base.
            vec![at(0.5 * half_height_m, cone)]
        }
        Shape::Hull { .. } | Shape::Compound(_) => {
            vec![at(0.0, Form::Triangles(mesh(shape)))]
        }
    }
}

/// A cone of that half height as a stack of cylinders, for viewers without cones: each with its middle's
/// height over the shape's origin, its length and its radius \[m\].
pub fn cone_slices(half_height_m: f64, radius_m: f64, count: usize) -> Vec<[f64; 3]> {
    let length_m = 2.0 * half_height_m / count as f64;
    let slice = |slice: usize| {
        let middle = (slice as f64 + 0.5) / count as f64;
        // The base is a quarter of the height below the origin.
        let z_m = half_height_m * (2.0 * middle - 0.5);
        [z_m, length_m, radius_m * (1.0 - middle)]
    };
    (0..count).map(slice).collect()
}

/// A closed surface as a stack of boxes along its longest side, for viewers without triangles: each with its
/// middle and its sides \[m\], about all of the surface within its layer. None of a surface without triangles.
pub fn hull_slices(surface: &[Triangle], count: usize) -> Vec<[Vector3<f64>; 2]> {
    let corners = surface.iter().flatten();
    let ends = corners.fold(None, |ends: Option<[Vector3<f64>; 2]>, corner| {
        let [lower, upper] = ends.unwrap_or([*corner, *corner]);
        Some([lower.inf(corner), upper.sup(corner)])
    });
    let Some([lower_m, upper_m]) = ends else {
        return Vec::new();
    };
    let axis = (upper_m - lower_m).imax();
    let thick_m = (upper_m[axis] - lower_m[axis]) / count as f64;
    let slices = (0..count).filter_map(|slice| {
        let from_m = lower_m[axis] + slice as f64 * thick_m;
        let layer_m = [from_m, from_m + thick_m];
        let within = surface.iter().flat_map(|of| within(of, axis, layer_m));
        let (lower_m, upper_m) = within.fold((None, None), |(low, high), point| {
            let low = low.map_or(point, |low: Vector3<f64>| low.inf(&point));
            let high = high.map_or(point, |high: Vector3<f64>| high.sup(&point));
            (Some(low), Some(high))
        });
        let (mut lower_m, mut upper_m) = (lower_m?, upper_m?);
        (lower_m[axis], upper_m[axis]) = (layer_m[0], layer_m[1]);
        Some([0.5 * (lower_m + upper_m), upper_m - lower_m])
    });
    slices.collect()
}

/// The corners of a triangle within a layer, and where its sides enter and leave that.
fn within(triangle: &Triangle, axis: usize, layer_m: [f64; 2]) -> Vec<Vector3<f64>> {
    let mut points = Vec::new();
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let (a, b) = (triangle[from], triangle[to]);
        if (layer_m[0]..=layer_m[1]).contains(&a[axis]) {
            points.push(a);
        }
        for end_m in layer_m {
            let part = (end_m - a[axis]) / (b[axis] - a[axis]);
            if part > 0.0 && part < 1.0 {
                points.push(a + (b - a) * part);
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stack_reaches_from_a_cones_base_to_its_apex() {
        let slices = cone_slices(1.0, 1.0, 12);
        let slice_m = 2.0 / 12.0;
        assert_eq!(slices.len(), 12);
        assert!((slices[0][0] - 0.5 * slice_m + 0.5).abs() < 1e-12);
        assert!((slices[11][0] + 0.5 * slice_m - 1.5).abs() < 1e-12);
        assert!(slices.iter().all(|[_, length_m, _]| *length_m == slice_m));
        assert!(slices.is_sorted_by(|a, b| a[2] > b[2]));
    }

    #[test]
    fn a_stack_of_boxes_is_about_a_hull_and_little_larger() {
        let points_m = [[1, 0, 0], [-1, 1, 0], [-1, -1, 0], [0, 0, 6]];
        let points_m = points_m.map(|p| Vector3::from(p).map(f64::from)).to_vec();
        let surface = mesh(&Shape::Hull { points_m });
        let slices = hull_slices(&surface, 12);
        assert_eq!(slices.len(), 12);
        // The lowest is as wide as the base, the highest as narrow as a twelfth of it.
        assert!((slices[0][1] - Vector3::new(2.0, 2.0, 0.5)).norm() < 1e-9);
        assert!((slices[11][1] - Vector3::new(2.0 / 12.0, 2.0 / 12.0, 0.5)).norm() < 1e-9);
        let heights_m: Vec<f64> = slices.iter().map(|[middle_m, _]| middle_m.z).collect();
        assert!((heights_m[0] - 0.25).abs() < 1e-9 && (heights_m[11] - 5.75).abs() < 1e-9);
        // Of one box it would be twice this much.
        let volume_m3: f64 = slices.iter().map(|[_, sides_m]| sides_m.product()).sum();
        assert!((8.0..12.0).contains(&volume_m3), "{volume_m3}");
        assert!(hull_slices(&[], 12).is_empty());
    }
}
