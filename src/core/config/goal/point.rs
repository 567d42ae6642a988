//! The point of a body that a goal is about, and from where it is seen.

use std::ops::Range;

use nalgebra::Point3;

use super::Table;
use crate::config::error::{Fault, fault};
use crate::config::event::{feature_of, link_of};
use crate::config::held::check_goal;
use crate::config::number::vector;
use crate::motion::{BodyPoint, LinkIndex, Touching};
use crate::physics::contact::Feature;

impl Table<'_> {
    /// The point of the body that is meant.
    pub(super) fn point(&self, link: LinkIndex) -> Result<BodyPoint, Fault> {
        let raw = self.raw;
        if let Some(contact) = raw.contact.as_ref().filter(|contact| *contact.get_ref()) {
            if let Some(point) = &raw.point_mm {
                return fault(point.span(), "expected one of contact, point_mm");
            }
            return Ok(BodyPoint::Contact(self.contact(link, contact.span())?));
        }
        match (&raw.point_mm, &raw.feature) {
            (None, None) => Ok(BodyPoint::Centre),
            (Some(point), None) => {
                let point_m = vector("point_mm", point)? * super::MM;
                let point_m = self.link_from_given(Some(link)) * Point3::from(point_m);
                Ok(BodyPoint::Fixed(point_m.coords))
            }
            (Some(_), Some(feature)) => fault(feature.span(), "expected one of point_mm, feature"),
            (None, Some(text)) => {
                let link = &self.scene.links[link];
                let feature = &link.features[feature_of(link, text)?];
                match feature.geometry {
                    Feature::Point { point_m, .. } => Ok(BodyPoint::Fixed(point_m)),
                    Feature::Rim { centre_m, .. } => Ok(BodyPoint::Fixed(centre_m)),
                    Feature::Line { .. } | Feature::Face { .. } => fault(
                        text.span(),
                        format!(
                            "{:?} is no one point, expected a corner, or point_mm",
                            feature.name
                        ),
                    ),
                }
            }
        }
    }

    /// Which of the collision's contacts is meant.
    fn contact(&self, link: LinkIndex, span: Range<usize>) -> Result<usize, Fault> {
        let event = &self.scene.events[self.event];
        let collision = event.kind.collision();
        let Some(collision) = collision.filter(|of| of.links().any(|other| other == link)) else {
            return fault(
                span,
                format!(
                    "{:?} touches nothing at {:?}, expected a collision of it",
                    self.scene.links[link].name, event.name
                ),
            );
        };
        let touching = &collision.contacts;
        let Some(text) = &self.raw.feature else {
            return if touching.len() == 1 {
                Ok(0)
            } else {
                fault(
                    span,
                    format!(
                        "{} features touch at {:?}, expected feature to say which",
                        touching.len(),
                        event.name
                    ),
                )
            };
        };
        let feature = feature_of(&self.scene.links[link], text)?;
        let is_it = |touching: &Touching| {
            let own = if collision.link == link {
                touching.feature
            } else {
                touching.other
            };
            own == Some(feature)
        };
        touching.iter().position(is_it).ok_or_else(|| Fault {
            span: text.span(),
            message: format!(
                "{:?} does not touch at {:?}, expected a feature that the event names",
                text.get_ref(),
                event.name
            ),
        })
    }

    /// The body in whose axes positions, orientations and directions are given.
    pub(super) fn seen_from(&self, link: LinkIndex) -> Result<Option<LinkIndex>, Fault> {
        let Some(text) = &self.raw.relative_to else {
            return Ok(None);
        };
        let other = link_of(text, self.scene)?;
        check_goal(text, other, self.scene)?;
        if other == link {
            return fault(
                text.span(),
                "a body is not seen from itself, expected another",
            );
        }
        Ok(Some(other))
    }
}
