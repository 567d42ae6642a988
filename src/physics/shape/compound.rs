//! Compounds: convex solids that move as one.

use super::error::ShapeError;
use super::kind::Shape;
use super::mass::MassDistribution;
use crate::math::Pose;
use crate::physics::contact::Feature;

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

    pub(super) fn radius_m(&self) -> f64 {
        let radii = self.parts.iter().map(|part| match &part.shape {
            Shape::Hull { points_m } => {
                let placed = |p: &nalgebra::Vector3<f64>| {
                    part.compound_from_shape.transform_point(&(*p).into())
                };
                let distances = points_m.iter().map(|p| placed(p).coords.norm());
                distances.fold(0.0, f64::max)
            }
            other => part.compound_from_shape.translation.vector.norm() + other.radius_m(),
        });
        radii.fold(0.0, f64::max)
    }

    pub(super) fn mass(&self) -> Result<MassDistribution, ShapeError> {
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
