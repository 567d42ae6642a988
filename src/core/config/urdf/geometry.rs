//! Solids of links: of their collisions, or of what is drawn where there are none.

use std::ops::Range;

use super::element::Element;
use crate::config::error::Fault;
use nalgebra::Vector3;

use crate::math::Pose;

/// A solid about the origin of its own frame.
#[derive(Clone, Debug)]
pub(super) enum UrdfPrimitive {
    Cuboid {
        half_extents_m: Vector3<f64>,
    },
    Sphere {
        radius_m: f64,
    },
    /// About z.
    Cylinder {
        half_length_m: f64,
        radius_m: f64,
    },
    /// About z; the length is that between the centres of its caps.
    Capsule {
        half_length_m: f64,
        radius_m: f64,
    },
}

/// A solid at its place in the link's frame.
#[derive(Clone, Debug)]
pub(super) struct UrdfPlaced {
    pub(super) primitive: UrdfPrimitive,
    pub(super) link_from_solid: Pose,
}

/// What a link's `<collision>` or `<visual>` elements are.
#[derive(Debug, Default)]
pub(super) struct UrdfSolids {
    pub(super) placed: Vec<UrdfPlaced>,
    /// The meshes.
    pub(super) meshes: Vec<Range<usize>>,
}

/// Both.
#[derive(Debug, Default)]
pub(super) struct Geometries {
    pub(super) collision: UrdfSolids,
    pub(super) visual: UrdfSolids,
}

/// Reads a `<collision>` or a `<visual>`.
pub(super) fn geometry(element: &mut Element, solids: &mut UrdfSolids) -> Result<(), Fault> {
    element.only(&["name"]);
    let (mut origin, mut read) = (None, None);
    let mut mesh = None;
    element.children(|child| {
        match child.tag() {
            "origin" => {
                child.once(&origin)?;
                origin = Some(child.pose()?);
            }
            "geometry" => {
                child.once(&read)?;
                child.only(&[]);
                let mut known = None;
                child.children(|of| match of.tag() {
                    "mesh" => {
                        mesh = Some(of.span());
                        Ok(true)
                    }
                    _ => {
                        let found = primitive(of)?;
                        let is_known = found.is_some();
                        known = found.or(known.take());
                        Ok(is_known)
                    }
                })?;
                read = Some(known);
            }
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    solids.meshes.extend(mesh);
    solids
        .placed
        .extend(read.flatten().map(|primitive| UrdfPlaced {
            primitive,
            link_from_solid: origin.unwrap_or_else(Pose::identity),
        }));
    Ok(())
}

/// `None` of what scenes do not know.
fn primitive(element: &mut Element) -> Result<Option<UrdfPrimitive>, Fault> {
    let shape = match element.tag() {
        "box" => {
            let size = element.only(&["size"]).vector_if("size")?;
            match size.filter(|size| size.min() > 0.0) {
                Some(size) => UrdfPrimitive::Cuboid {
                    half_extents_m: size / 2.0,
                },
                None => return element.fault("<box> has no size, expected three positive numbers"),
            }
        }
        "sphere" => UrdfPrimitive::Sphere {
            radius_m: element.only(&["radius"]).positive("radius")?,
        },
        round @ ("cylinder" | "capsule") => {
            element.only(&["radius", "length"]);
            let radius_m = element.positive("radius")?;
            let half_length_m = element.positive("length")? / 2.0;
            match round {
                "cylinder" => UrdfPrimitive::Cylinder {
                    half_length_m,
                    radius_m,
                },
                _ => UrdfPrimitive::Capsule {
                    half_length_m,
                    radius_m,
                },
            }
        }
        _ => return Ok(None),
    };
    Ok(Some(shape))
}
