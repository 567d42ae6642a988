//! Shapes: the one door to parry. Axes of cylinders, capsules and cones are z here, y there.
//!
//! A shape's own axes have their origin at its centre of mass, so that the shape of a body of
//! uniform density lies in body axes as it stands.

use nalgebra::{Matrix3, Vector3};
use parry3d::mass_properties::MassProperties;
use parry3d::math::{Pose as ParryPose, Rotation as ParryRotation, Vector as ParryVector};
use parry3d::query;
use parry3d::shape::SharedShape;
use parry3d::transformation::try_convex_hull;
use thiserror::Error;

use super::body::{Body, BodyError};
use crate::math::Pose;

/// How far a hull's centre of mass may be off the origin \[m\].
const CENTRE_TOLERANCE_M: f64 = 1e-9;

/// Products of inertia of a hull, and differences of its moments, that count as none, relative
/// to its largest moment: what six typed digits leave.
const MOMENT_TOLERANCE: f64 = 1e-6;

/// Height over size below which a hull is flat.
const FLAT_RATIO: f64 = 1e-6;

/// A solid, in its own axes, in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box centred at the origin.
    Cuboid {
        /// Half its sides.
        half_extents_m: Vector3<f64>,
    },
    /// A box centred at the origin, its edges and corners rounded.
    RoundedCuboid {
        /// Half its outer sides, as a calliper measures them.
        half_extents_m: Vector3<f64>,
        /// Radius of the rounding, less than the least of them.
        radius_m: f64,
    },
    /// A ball centred at the origin.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A cylinder about z, centred at the origin.
    Cylinder {
        /// Half its length.
        half_length_m: f64,
        /// Radius.
        radius_m: f64,
    },
    /// A capsule about z, centred at the origin.
    Capsule {
        /// Half the length between the centres of its caps.
        half_length_m: f64,
        /// Radius.
        radius_m: f64,
    },
    /// A cone about z, apex up. The origin is its centre of mass: a quarter of the height
    /// above the base.
    Cone {
        /// Half its height.
        half_height_m: f64,
        /// Radius of the base.
        radius_m: f64,
    },
    /// The convex hull of points.
    Hull {
        /// At least four, not in one plane.
        points_m: Vec<Vector3<f64>>,
    },
}

/// Why a shape cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// A length is not positive.
    #[error("{name} is {value_m} m, expected a positive number")]
    Length {
        /// Which one.
        name: &'static str,
        /// As given.
        value_m: f64,
    },
    /// A rounding that leaves no box.
    #[error("the rounding of {radius_m} m leaves no box: half the least side is {half_m} m")]
    Rounding {
        /// Its radius.
        radius_m: f64,
        /// Half the least side.
        half_m: f64,
    },
    /// A point has a coordinate that is not finite.
    #[error("point {index} of the hull is not finite")]
    Point {
        /// Which one.
        index: usize,
    },
    /// Points span no volume.
    #[error("the {count} points of the hull span no volume")]
    Flat {
        /// How many.
        count: usize,
    },
    /// The hull could not be built though its points span a volume.
    #[error("no convex hull of these {count} points: {reason}")]
    Hull {
        /// How many.
        count: usize,
        /// What the geometry library says.
        reason: String,
    },
    /// The origin of a body's axes is not its centre of mass.
    #[error(
        "the hull's centre of mass is at [{}, {}, {}] mm, expected the origin: subtract that from every point",
        .offset_m.x * 1e3, .offset_m.y * 1e3, .offset_m.z * 1e3
    )]
    OffCentre {
        /// Centre of mass in the shape's axes.
        offset_m: Vector3<f64>,
    },
    /// A body's axes are not principal.
    #[error(
        "the axes of the hull are not its principal ones (products of inertia per kg: yz {}, xz {}, xy {} m²): turn its points, or give moments_kg_m2",
        .products_m2.x, .products_m2.y, .products_m2.z
    )]
    NotPrincipal {
        /// Products of inertia over mass: yz, xz, xy.
        products_m2: Vector3<f64>,
    },
    /// A pose between two shapes has a number in it that is not finite.
    #[error("a pose is not finite")]
    Pose,
    /// Mass or density, or the moments that follow, make no body.
    #[error(transparent)]
    Body(#[from] BodyError),
}

/// What follows from a shape at uniform density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformMass {
    /// Volume.
    pub volume_m3: f64,
    /// Principal moments over mass, about the shape's axes.
    pub moments_per_mass_m2: Vector3<f64>,
}

impl Shape {
    /// Whether the shape is a solid: lengths positive and finite, hulls not flat.
    pub fn check(&self) -> Result<(), ShapeError> {
        match self {
            Shape::Cuboid { half_extents_m } => check_sides(half_extents_m),
            Shape::RoundedCuboid {
                half_extents_m,
                radius_m,
            } => {
                check_sides(half_extents_m)?;
                positive("radius", *radius_m)?;
                let half_m = half_extents_m.min();
                if !(*radius_m < half_m) {
                    let radius_m = *radius_m;
                    return Err(ShapeError::Rounding { radius_m, half_m });
                }
                Ok(())
            }
            Shape::Sphere { radius_m } => positive("radius", *radius_m),
            Shape::Cylinder {
                half_length_m,
                radius_m,
            }
            | Shape::Capsule {
                half_length_m,
                radius_m,
            } => {
                positive("length", 2.0 * half_length_m)?;
                positive("radius", *radius_m)
            }
            Shape::Cone {
                half_height_m,
                radius_m,
            } => {
                positive("height", 2.0 * half_height_m)?;
                positive("radius", *radius_m)
            }
            Shape::Hull { points_m } => check_hull(points_m),
        }
    }

    /// Radius of the least ball about the origin that holds the shape \[m\].
    pub fn radius_m(&self) -> f64 {
        match self {
            Shape::Cuboid { half_extents_m } => half_extents_m.norm(),
            Shape::RoundedCuboid {
                half_extents_m,
                radius_m,
            } => half_extents_m.add_scalar(-radius_m).norm() + radius_m,
            Shape::Sphere { radius_m } => *radius_m,
            Shape::Cylinder {
                half_length_m,
                radius_m,
            } => half_length_m.hypot(*radius_m),
            Shape::Capsule {
                half_length_m,
                radius_m,
            } => half_length_m + radius_m,
            Shape::Cone {
                half_height_m,
                radius_m,
            } => (1.5 * half_height_m).max(radius_m.hypot(0.5 * half_height_m)),
            Shape::Hull { points_m } => points_m.iter().map(|p| p.norm()).fold(0.0, f64::max),
        }
    }

    /// Volume and moments at uniform density.
    ///
    /// Fails where the shape is no solid, and where its axes cannot be body axes: a hull whose
    /// centre of mass is off the origin or whose principal axes are not its own.
    pub fn uniform_mass(&self) -> Result<UniformMass, ShapeError> {
        self.check()?;
        let (properties, shape_from_parry) = match self {
            Shape::Cuboid { half_extents_m } => (
                MassProperties::from_cuboid(1.0, to_parry(half_extents_m)),
                Axes::Same,
            ),
            Shape::RoundedCuboid {
                half_extents_m,
                radius_m,
            } => return Ok(rounded_mass(half_extents_m, *radius_m)),
            Shape::Sphere { radius_m } => (MassProperties::from_ball(1.0, *radius_m), Axes::Same),
            Shape::Cylinder {
                half_length_m,
                radius_m,
            } => (
                MassProperties::from_cylinder(1.0, *half_length_m, *radius_m),
                Axes::YToZ,
            ),
            Shape::Capsule {
                half_length_m,
                radius_m,
            } => {
                let end = ParryVector::new(0.0, *half_length_m, 0.0);
                (
                    MassProperties::from_capsule(1.0, -end, end, *radius_m),
                    Axes::YToZ,
                )
            }
            Shape::Cone {
                half_height_m,
                radius_m,
            } => (
                MassProperties::from_cone(1.0, *half_height_m, *radius_m),
                Axes::YToZ,
            ),
            Shape::Hull { points_m } => return hull_mass(points_m),
        };
        let principal = properties.principal_inertia();
        let moments = match shape_from_parry {
            Axes::Same => from_parry(principal),
            // About y there is about z here; the two transverse ones are equal.
            Axes::YToZ => Vector3::new(principal.x, principal.x, principal.y),
        };
        Ok(UniformMass {
            volume_m3: properties.mass(),
            moments_per_mass_m2: moments / properties.mass(),
        })
    }

    /// The body that this shape makes at uniform density with that mass \[kg\].
    pub fn body_of_mass_kg(&self, mass_kg: f64) -> Result<Body, ShapeError> {
        let uniform = self.uniform_mass()?;
        Ok(Body::new(mass_kg, uniform.moments_per_mass_m2 * mass_kg)?)
    }

    /// The body that this shape makes of a material of that density [kg/m³].
    pub fn body_of_density_kg_m3(&self, density_kg_m3: f64) -> Result<Body, ShapeError> {
        self.body_of_mass_kg(self.uniform_mass()?.volume_m3 * density_kg_m3)
    }

    /// The shape made ready for many distance queries.
    pub fn solid(&self) -> Result<Solid, ShapeError> {
        self.check()?;
        let along_z = |offset_m: f64| {
            ParryPose::from_parts(
                ParryVector::new(0.0, 0.0, offset_m),
                ParryRotation::from_rotation_x(std::f64::consts::FRAC_PI_2),
            )
        };
        let (shape, shape_from_parry) = match self {
            Shape::Cuboid { half_extents_m: h } => {
                (SharedShape::cuboid(h.x, h.y, h.z), ParryPose::IDENTITY)
            }
            Shape::RoundedCuboid {
                half_extents_m,
                radius_m,
            } => {
                let core = half_extents_m.add_scalar(-radius_m);
                (
                    SharedShape::round_cuboid(core.x, core.y, core.z, *radius_m),
                    ParryPose::IDENTITY,
                )
            }
            Shape::Sphere { radius_m } => (SharedShape::ball(*radius_m), ParryPose::IDENTITY),
            Shape::Cylinder {
                half_length_m,
                radius_m,
            } => (
                SharedShape::cylinder(*half_length_m, *radius_m),
                along_z(0.0),
            ),
            Shape::Capsule {
                half_length_m,
                radius_m,
            } => (
                SharedShape::capsule_z(*half_length_m, *radius_m),
                ParryPose::IDENTITY,
            ),
            Shape::Cone {
                half_height_m,
                radius_m,
            } => (
                SharedShape::cone(*half_height_m, *radius_m),
                along_z(0.5 * half_height_m),
            ),
            Shape::Hull { points_m } => (
                hull_of(points_m).and_then(|(points, triangles)| {
                    SharedShape::convex_mesh(points, &triangles).ok_or(ShapeError::Hull {
                        count: points_m.len(),
                        reason: "its surface is not closed".into(),
                    })
                })?,
                ParryPose::IDENTITY,
            ),
        };
        Ok(Solid {
            shape,
            shape_from_parry,
        })
    }

    /// Distance between two placed shapes \[m\]; negative is the depth of penetration.
    ///
    /// Builds both solids: for many queries build them once, by [`Shape::solid`].
    pub fn distance_m(
        &self,
        world_from_self: &Pose,
        other: &Shape,
        world_from_other: &Pose,
    ) -> Result<f64, ShapeError> {
        self.solid()?
            .distance_m(world_from_self, &other.solid()?, world_from_other)
    }
}

/// A shape made ready for distance queries.
#[derive(Clone)]
pub struct Solid {
    shape: SharedShape,
    shape_from_parry: ParryPose,
}

impl Solid {
    /// Distance between two placed solids \[m\]; negative is the depth of penetration.
    ///
    /// Refuses poses that are not finite: parry's answer for them is 0.
    pub fn distance_m(
        &self,
        world_from_self: &Pose,
        other: &Solid,
        world_from_other: &Pose,
    ) -> Result<f64, ShapeError> {
        let here = pose_to_parry(world_from_self)? * self.shape_from_parry;
        let there = pose_to_parry(world_from_other)? * other.shape_from_parry;
        let distance_m = query::distance(&here, &*self.shape, &there, &*other.shape)
            .expect("convex shapes have distances")
            .distance;
        if distance_m > 0.0 {
            return Ok(distance_m);
        }
        let contact = query::contact(&here, &*self.shape, &there, &*other.shape, 0.0)
            .expect("convex shapes have contacts");
        Ok(contact.map_or(0.0, |contact| contact.dist.min(0.0)))
    }
}

enum Axes {
    Same,
    YToZ,
}

fn positive(name: &'static str, value_m: f64) -> Result<(), ShapeError> {
    if value_m > 0.0 && value_m.is_finite() {
        Ok(())
    } else {
        Err(ShapeError::Length { name, value_m })
    }
}

fn check_sides(half_extents_m: &Vector3<f64>) -> Result<(), ShapeError> {
    for (name, half) in ["x size", "y size", "z size"]
        .into_iter()
        .zip(half_extents_m.iter())
    {
        positive(name, 2.0 * half)?;
    }
    Ok(())
}

/// Sums the core, the slabs on its faces, the quarters of cylinders on its edges and the octants
/// of a ball on its corners (parry leaves the rounding out).
fn rounded_mass(half_extents_m: &Vector3<f64>, radius_m: f64) -> UniformMass {
    use std::f64::consts::PI;
    let (core, r) = (half_extents_m.add_scalar(-radius_m), radius_m);
    let ball_m3 = 4.0 / 3.0 * PI * r.powi(3);
    let mut volume_m3 = 8.0 * core.product() + ball_m3;
    // ∫x² dV along each axis.
    let mut second_m5 = Vector3::zeros();
    for axis in 0..3 {
        let (a, b, c) = (core[axis], core[(axis + 1) % 3], core[(axis + 2) % 3]);
        volume_m3 += 8.0 * r * b * c + 2.0 * PI * a * r * r;
        // What extends along the axis as the core does, beside the core itself.
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

/// Finite points that span a volume: farthest from the first, then from that line, then from
/// that plane. parry accepts three points and answers for a flat set as it happens.
fn check_hull(points_m: &[Vector3<f64>]) -> Result<(), ShapeError> {
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

fn hull_of(points_m: &[Vector3<f64>]) -> Result<(Vec<ParryVector>, Vec<[u32; 3]>), ShapeError> {
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

/// Sums tetrahedra between the origin and each triangle. parry's own sum is exact too, but the
/// frame it diagonalises to does not give the tensor back for boxes that are turned.
fn hull_mass(points_m: &[Vector3<f64>]) -> Result<UniformMass, ShapeError> {
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
    // Typed coordinates leave the moments of a regular prism equal to their digits only.
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

fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

fn from_parry(v: ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

fn pose_to_parry(pose: &Pose) -> Result<ParryPose, ShapeError> {
    let q = pose.rotation.coords;
    let finite = pose.translation.vector.iter().chain(q.iter());
    if !finite.into_iter().all(|x| x.is_finite()) {
        return Err(ShapeError::Pose);
    }
    Ok(ParryPose::from_parts(
        to_parry(&pose.translation.vector),
        ParryRotation::from_xyzw(q.x, q.y, q.z, q.w),
    ))
}

#[cfg(test)]
mod tests;
