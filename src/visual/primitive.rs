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

/// Centre and sides of the axes' box about points \[m\]; `None` without any.
pub fn bounding_box(points_m: &[Vector3<f64>]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let first = points_m.first()?;
    let (lower, upper) = points_m
        .iter()
        .fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    Some((0.5 * (lower + upper), upper - lower))
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
    fn a_box_reaches_about_all_points() {
        let points_m = [[0.0, 1.0, 2.0], [4.0, -1.0, 2.5]].map(Vector3::from);
        let (centre_m, sides_m) = bounding_box(&points_m).expect("points");
        assert_eq!(centre_m, Vector3::new(2.0, 0.0, 2.25));
        assert_eq!(sides_m, Vector3::new(4.0, 2.0, 0.5));
        assert_eq!(bounding_box(&[]), None);
    }
}
