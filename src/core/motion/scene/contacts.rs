//! The contacts of a collision, as far as a scene names what touches.

use thiserror::Error;

use super::event::{Partner, Touching};
use super::quantity::Quantity;
use super::whole::Scene;
use crate::motion::index::ContactLawIndex;
use crate::physics::contact::{Contact, ContactError};
use crate::physics::impact::{ContactSet, ContactSetError};

/// Why the collision of a scene is refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CollisionError {
    /// Two features are no supported pair.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The contacts together are not supported.
    #[error(transparent)]
    ContactSet(#[from] ContactSetError),
}

impl Scene {
    /// The contacts of a collision; `None` where the scene leaves a feature open, or where the
    /// event is no collision.
    ///
    /// Fails where two features are no supported pair, or their impact is not supported.
    pub fn contact_set(&self, event: usize) -> Result<Option<ContactSet>, CollisionError> {
        match self.events[event].kind.collision() {
            Some(collision) => self.contact_set_of(event, &collision.contacts),
            None => Ok(None),
        }
    }

    /// [`Scene::contact_set`] with the given contacts in place of the collision's.
    pub fn contact_set_of(
        &self,
        event: usize,
        touchings: &[Touching],
    ) -> Result<Option<ContactSet>, CollisionError> {
        let Some(collision) = self.events[event].kind.collision() else {
            return Ok(None);
        };
        let mut contacts = Vec::new();
        for touching in touchings {
            let (Some(feature), Some(other)) = (touching.feature, touching.other) else {
                return Ok(None);
            };
            let feature = self.links[collision.link].features[feature].geometry;
            let other = match collision.partner {
                Partner::World => self.surfaces[other].geometry,
                Partner::Link(link) => self.links[link].features[other].geometry,
            };
            // Only where a scene names it: of what is left open one feature is sought.
            let is_named = collision.contacts == touchings && touchings.len() == 1;
            match ContactSet::face_on_face(&feature, &other)? {
                Some(flat) if is_named => contacts.extend(flat),
                _ => contacts.push(Contact::new(feature, other)?),
            }
        }
        let law = collision.law;
        let is_tilted = collision.tilt_rad != [0.0; 2]
            || (0..2).any(|tangent| self.frees(Quantity::Tilt { event, tangent }));
        let set = if self.has_friction(law) {
            let count = contacts.len();
            let joined = self.joint_tree(self.mechanism_of(collision.link));
            if count > 1 && (collision.partner != Partner::World || joined.is_some()) {
                return Err(ContactSetError::FrictionAtSeveral { count }.into());
            }
            ContactSet::with_friction(&contacts)?
        } else {
            ContactSet::frictionless(&contacts)?
        };
        if self.springs_back(law) {
            set.check_spring_back()?;
        }
        if is_tilted {
            set.check_tilt()?;
        }
        Ok(Some(set))
    }

    /// Whether tangential restitution is part of a law, or may become so.
    pub fn springs_back(&self, law: ContactLawIndex) -> bool {
        self.contact_laws[law].tangential_restitution > 0.0
            || self.frees(Quantity::TangentialRestitution { law })
    }

    /// Whether friction is part of a law, or may become so.
    pub fn has_friction(&self, law: ContactLawIndex) -> bool {
        self.contact_laws[law].friction > 0.0 || self.frees(Quantity::Friction { law })
    }
}
