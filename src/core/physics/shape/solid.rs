//! Solids: shapes prepared for distance queries.

use nalgebra::Vector3;
use parry3d::bounding_volume::BoundingSphere;
use parry3d::math::{Pose as ParryPose, Rotation as ParryRotation, Vector as ParryVector};
use parry3d::query;
use parry3d::shape::SharedShape;

use super::error::ShapeError;
use super::hull::{from_parry, hull_of, to_parry};
use super::kind::Shape;
use crate::math::Pose;

/// Distance \[m\] up to which parry computes closest points: larger than any scene.
const FAR_M: f64 = 1e6;

impl Shape {
    /// The shape prepared for many distance queries. Fails where the shape is no solid.
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
            Shape::Compound(compound) => {
                let parts = compound.parts.iter().map(|part| {
                    let own = part.shape.solid()?;
                    let pose = pose_to_parry(&part.compound_from_shape)? * own.shape_from_parry;
                    Ok((pose, own.shape))
                });
                let parts = parts.collect::<Result<Vec<_>, ShapeError>>()?;
                (SharedShape::compound(parts), ParryPose::IDENTITY)
            }
        };
        Ok(Solid {
            shape,
            shape_from_parry,
        })
    }
}

/// A shape prepared for distance queries.
#[derive(Clone)]
pub struct Solid {
    shape: SharedShape,
    shape_from_parry: ParryPose,
}

/// The distance of two things and their closest points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Distance \[m\]; negative is the depth of penetration.
    pub gap_m: f64,
    /// The solid's point nearest to the other, or deepest in it [m, the solid's own axes]; where
    /// there are several, one of them.
    pub point_m: Vector3<f64>,
    /// The other's point nearest to the solid [m, world].
    pub other_point_m: Vector3<f64>,
}

impl Solid {
    /// A ball about the origin; of radius 0, a point.
    pub fn ball(radius_m: f64) -> Self {
        Self {
            shape: SharedShape::ball(radius_m),
            shape_from_parry: ParryPose::IDENTITY,
        }
    }

    /// The solid moved \[m\] in its own axes.
    pub fn moved(self, by_m: &Vector3<f64>) -> Self {
        let ParryPose {
            rotation,
            translation,
        } = self.shape_from_parry;
        Self {
            shape_from_parry: ParryPose::from_parts(translation + to_parry(by_m), rotation),
            ..self
        }
    }

    /// parry's shape and its pose in the solid's own axes, for a simulation that shares
    /// parry's types.
    pub fn parts(&self) -> (&SharedShape, &ParryPose) {
        (&self.shape, &self.shape_from_parry)
    }

    /// Its convex parts, each a solid in the same axes.
    pub fn parts_alone(&self) -> Vec<Solid> {
        let parts = self.convex().into_iter();
        parts
            .map(|(shape_from_parry, shape)| Self {
                shape: shape.clone(),
                shape_from_parry,
            })
            .collect()
    }

    /// The point farthest along a direction, both in the solid's own axes \[m\]; of several one.
    pub fn support_m(&self, along: &Vector3<f64>) -> Vector3<f64> {
        let supports = self.convex().into_iter().map(|(self_from_part, shape)| {
            let local = self_from_part.rotation.inverse() * to_parry(along);
            let support = shape
                .as_support_map()
                .expect("convex shapes have support points")
                .local_support_point(local);
            from_parry(self_from_part * support)
        });
        let farthest = supports.max_by(|a, b| a.dot(along).total_cmp(&b.dot(along)));
        farthest.expect("solids have a part at least")
    }

    /// Its convex solids, each with its pose in the solid's own axes.
    fn convex(&self) -> Vec<(ParryPose, &SharedShape)> {
        match self.shape.as_compound() {
            Some(compound) => {
                let parts = compound.shapes().iter();
                parts
                    .map(|(pose, shape)| (self.shape_from_parry * *pose, shape))
                    .collect()
            }
            None => vec![(self.shape_from_parry, &self.shape)],
        }
    }

    /// Distance and closest points of two placed solids: of compounds those of the two parts that are nearest,
    /// or deepest in each other. Refuses poses that are not finite.
    ///
    /// parry's iterations leave errors below 1e-6 m between round solids. Where its expanding
    /// polytope finds no depth the gap is 0 and the points are the origins.
    pub fn closest(
        &self,
        world_from_self: &Pose,
        other: &Solid,
        world_from_other: &Pose,
    ) -> Result<Closest, ShapeError> {
        let mut best: Option<Closest> = None;
        self.pairs(world_from_self, other, world_from_other, |here, there| {
            let contact = query::contact(&here.0, &**here.1, &there.0, &**there.1, FAR_M)
                .expect("convex shapes have contacts");
            let found = match contact {
                Some(contact) => Closest {
                    gap_m: contact.dist,
                    point_m: world_from_self
                        .inverse_transform_point(&from_parry(contact.point1).into())
                        .coords,
                    other_point_m: from_parry(contact.point2),
                },
                None => Closest {
                    gap_m: distance_m(here, there),
                    point_m: Vector3::zeros(),
                    other_point_m: world_from_other.translation.vector,
                },
            };
            if best.is_none_or(|best| found.gap_m < best.gap_m) {
                best = Some(found);
            }
            best.map_or(f64::INFINITY, |best| best.gap_m)
        })?;
        Ok(best.expect("solids have a part at least"))
    }

    /// The lowest point over a plane through `plane_point_m` with the given unit normal \[world\],
    /// and its height, negative below the plane. Exact. Refuses poses that are not finite.
    pub fn lowest(
        &self,
        world_from_self: &Pose,
        plane_point_m: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Result<Closest, ShapeError> {
        pose_to_parry(world_from_self)?;
        let down = world_from_self.rotation.inverse_transform_vector(&-normal);
        let point_m = self.support_m(&down);
        let in_world_m = (world_from_self * nalgebra::Point3::from(point_m)).coords;
        let gap_m = normal.dot(&(in_world_m - plane_point_m));
        Ok(Closest {
            gap_m,
            point_m,
            other_point_m: in_world_m - normal * gap_m,
        })
    }

    /// Distance between two placed solids \[m\]; negative is the depth of penetration, of compounds that of
    /// the two parts that are deepest in each other.
    ///
    /// Refuses poses that are not finite: parry's answer for them is 0.
    pub fn distance_m(
        &self,
        world_from_self: &Pose,
        other: &Solid,
        world_from_other: &Pose,
    ) -> Result<f64, ShapeError> {
        let mut least_m = f64::INFINITY;
        self.pairs(world_from_self, other, world_from_other, |here, there| {
            least_m = least_m.min(distance_m(here, there));
            least_m
        })?;
        Ok(least_m)
    }

    /// Looks at pairs of placed convex solids, one of each, until none that is left can be nearer than `look`
    /// says is enough \[m\]: the balls about them are farther apart.
    fn pairs(
        &self,
        world_from_self: &Pose,
        other: &Solid,
        world_from_other: &Pose,
        mut look: impl FnMut(Placed, Placed) -> f64,
    ) -> Result<(), ShapeError> {
        let here = pose_to_parry(world_from_self)?;
        let there = pose_to_parry(world_from_other)?;
        let (own, others) = (self.convex(), other.convex());
        if let ([(a, shape)], [(b, other)]) = (&own[..], &others[..]) {
            look((here * *a, shape), (there * *b, other));
            return Ok(());
        }
        let (own, others) = (with_balls(here, own), with_balls(there, others));
        let mut pairs = Vec::with_capacity(own.len() * others.len());
        for (i, (.., a)) in own.iter().enumerate() {
            for (j, (.., b)) in others.iter().enumerate() {
                let apart_m = (a.center - b.center).length() - a.radius - b.radius;
                pairs.push((apart_m, i, j));
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut enough_m = f64::INFINITY;
        for (apart_m, i, j) in pairs {
            if apart_m > enough_m {
                break;
            }
            let ((a, shape, _), (b, other, _)) = (&own[i], &others[j]);
            enough_m = look((*a, shape), (*b, other));
        }
        Ok(())
    }
}

/// Convex solids placed in the world, with the balls about them.
fn with_balls(
    base: ParryPose,
    parts: Vec<(ParryPose, &SharedShape)>,
) -> Vec<(ParryPose, &SharedShape, BoundingSphere)> {
    let parts = parts.into_iter().map(|(pose, shape)| {
        let pose = base * pose;
        (pose, shape, shape.compute_bounding_sphere(&pose))
    });
    parts.collect()
}

/// A convex solid in the world.
type Placed<'a> = (ParryPose, &'a SharedShape);

/// Distance of two convex solids \[m\]; negative is the depth of penetration.
fn distance_m(here: Placed, there: Placed) -> f64 {
    let distance_m = query::distance(&here.0, &**here.1, &there.0, &**there.1)
        .expect("convex shapes have distances")
        .distance;
    if distance_m > 0.0 {
        return distance_m;
    }
    let contact = query::contact(&here.0, &**here.1, &there.0, &**there.1, 0.0)
        .expect("convex shapes have contacts");
    contact.map_or(0.0, |contact| contact.dist.min(0.0))
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
