//! Kinds of shapes, and their mass properties at uniform density.

use nalgebra::Vector3;
use parry3d::mass_properties::MassProperties;
use parry3d::math::Vector as ParryVector;

use super::error::ShapeError;
use super::hull::{check_hull, from_parry, hull_mass, to_parry};
use super::mass::{MassDistribution, UniformMass, rounded_mass};
use crate::math::Pose;
use crate::physics::body::Body;
use crate::physics::contact::Feature;

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
    /// Several convex solids that move as one.
    Compound(Compound),
}

impl Shape {
    /// Fails where the shape is no solid: lengths must be positive and finite, hulls not flat.
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
            Shape::Compound(compound) => compound.check(),
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
            Shape::Compound(compound) => compound.radius_m(),
        }
    }

    /// Volume and moments at uniform density.
    ///
    /// Fails where the shape is no solid, and where its axes cannot be body axes: a hull or a compound whose
    /// centre of mass is not the origin or whose axes are not principal.
    pub fn uniform_mass(&self) -> Result<UniformMass, ShapeError> {
        self.check()?;
        match self {
            Shape::Hull { points_m } => hull_mass(points_m)?.about_its_axes(),
            Shape::Compound(compound) => compound.mass()?.about_its_axes(),
            _ => self.symmetric_mass(),
        }
    }

    /// How mass is distributed in it at uniform density, in its own axes. The volume that parts of a compound
    /// have in common counts as often as they are.
    ///
    /// Fails where the shape is no solid.
    pub fn mass(&self) -> Result<MassDistribution, ShapeError> {
        self.check()?;
        match self {
            Shape::Hull { points_m } => hull_mass(points_m),
            Shape::Compound(compound) => compound.mass(),
            _ => Ok(MassDistribution::of_uniform(&self.symmetric_mass()?)),
        }
    }

    /// Of the kinds that are symmetric about their axes.
    fn symmetric_mass(&self) -> Result<UniformMass, ShapeError> {
        let (properties, shape_from_parry) = match self {
            Shape::Cuboid { half_extents_m } => (
                MassProperties::from_cuboid(1.0, to_parry(half_extents_m)),
                ShapeAxes::Same,
            ),
            Shape::RoundedCuboid {
                half_extents_m,
                radius_m,
            } => return Ok(rounded_mass(half_extents_m, *radius_m)),
            Shape::Sphere { radius_m } => {
                (MassProperties::from_ball(1.0, *radius_m), ShapeAxes::Same)
            }
            Shape::Cylinder {
                half_length_m,
                radius_m,
            } => (
                MassProperties::from_cylinder(1.0, *half_length_m, *radius_m),
                ShapeAxes::YToZ,
            ),
            Shape::Capsule {
                half_length_m,
                radius_m,
            } => {
                let end = ParryVector::new(0.0, *half_length_m, 0.0);
                (
                    MassProperties::from_capsule(1.0, -end, end, *radius_m),
                    ShapeAxes::YToZ,
                )
            }
            Shape::Cone {
                half_height_m,
                radius_m,
            } => (
                MassProperties::from_cone(1.0, *half_height_m, *radius_m),
                ShapeAxes::YToZ,
            ),
            Shape::Hull { .. } | Shape::Compound(_) => return self.mass()?.about_its_axes(),
        };
        let principal = properties.principal_inertia();
        let moments = match shape_from_parry {
            ShapeAxes::Same => from_parry(principal),
            // The moment about y in parry is that about z here; the two transverse ones are equal.
            ShapeAxes::YToZ => Vector3::new(principal.x, principal.x, principal.y),
        };
        Ok(UniformMass {
            volume_m3: properties.mass(),
            moments_per_mass_m2: moments / properties.mass(),
        })
    }

    /// The body of this shape at uniform density with the given mass \[kg\]. Fails where
    /// [`Shape::uniform_mass`] fails, or the mass is not positive.
    pub fn body_of_mass_kg(&self, mass_kg: f64) -> Result<Body, ShapeError> {
        let uniform = self.uniform_mass()?;
        Ok(Body::new(mass_kg, uniform.moments_per_mass_m2 * mass_kg)?)
    }

    /// The body of this shape with the given uniform density [kg/m³]. Fails as
    /// [`Shape::body_of_mass_kg`] does.
    pub fn body_of_density_kg_m3(&self, density_kg_m3: f64) -> Result<Body, ShapeError> {
        self.body_of_mass_kg(self.uniform_mass()?.volume_m3 * density_kg_m3)
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

/// Several convex solids in one frame. It need not be convex, and its parts may overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct Compound {
    /// At least one, none of them a compound.
    pub parts: Vec<Part>,
    /// By what it may touch others, each with its name, in its own axes. The features of its parts are not
    /// among them by themselves: some are inside others.
    pub features: Vec<(String, Feature)>,
}

/// A part of a compound.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its shape.
    pub shape: Shape,
    /// Where that is in the compound's axes.
    pub compound_from_shape: Pose,
}

impl Compound {
    /// Fails where it has no part, or a part is no solid or a compound itself.
    pub(super) fn check(&self) -> Result<(), ShapeError> {
        if self.parts.is_empty() {
            return Err(ShapeError::NoPart);
        }
        for part in &self.parts {
            if matches!(part.shape, Shape::Compound(_)) {
                return Err(ShapeError::Nested);
            }
            part.shape.check()?;
        }
        Ok(())
    }

    fn radius_m(&self) -> f64 {
        let radii = self.parts.iter().map(|part| match &part.shape {
            Shape::Hull { points_m } => {
                let placed =
                    |p: &Vector3<f64>| part.compound_from_shape.transform_point(&(*p).into());
                let distances = points_m.iter().map(|p| placed(p).coords.norm());
                distances.fold(0.0, f64::max)
            }
            other => part.compound_from_shape.translation.vector.norm() + other.radius_m(),
        });
        radii.fold(0.0, f64::max)
    }

    fn mass(&self) -> Result<MassDistribution, ShapeError> {
        let parts = self.parts.iter().map(|part| {
            let own = part.shape.mass()?;
            Ok((own.volume_m3, own.placed(&part.compound_from_shape)))
        });
        let parts = parts.collect::<Result<Vec<_>, ShapeError>>()?;
        MassDistribution::joined(&parts).ok_or(ShapeError::NoPart)
    }

    /// The same in other axes.
    pub fn placed(&self, frame_from_compound: &Pose) -> Self {
        let parts = self.parts.iter().map(|part| Part {
            shape: part.shape.clone(),
            compound_from_shape: frame_from_compound * part.compound_from_shape,
        });
        let features = self.features.iter();
        let features = features.map(|(name, of)| (name.clone(), of.placed(frame_from_compound)));
        Self {
            parts: parts.collect(),
            features: features.collect(),
        }
    }
}

enum ShapeAxes {
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
