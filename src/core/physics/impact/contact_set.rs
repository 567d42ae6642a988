//! The contacts of one collision.

use super::error::ContactSetError;
use super::law::MOST_CONTACTS;
use crate::physics::contact::Contact;

/// One to three contacts at which a body A meets a body B or the static world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSet {
    contacts: [Contact; MOST_CONTACTS],
    count: usize,
    has_friction: bool,
}

impl ContactSet {
    /// One to three contacts without friction.
    pub fn frictionless(contacts: &[Contact]) -> Result<Self, ContactSetError> {
        let count = contacts.len();
        let Some(first) = contacts.first().filter(|_| count <= MOST_CONTACTS) else {
            return Err(ContactSetError::Count { count });
        };
        let mut all = [*first; MOST_CONTACTS];
        all[..count].copy_from_slice(contacts);
        Ok(Self {
            contacts: all,
            count,
            has_friction: false,
        })
    }

    /// One contact with friction, whose coefficient may be zero. Several contacts are refused.
    pub fn with_friction(contacts: &[Contact]) -> Result<Self, ContactSetError> {
        let contacts = Self::frictionless(contacts)?;
        if contacts.count > 1 {
            return Err(ContactSetError::FrictionAtSeveral {
                count: contacts.count,
            });
        }
        Ok(Self {
            has_friction: true,
            ..contacts
        })
    }

    /// Its contacts.
    pub fn as_slice(&self) -> &[Contact] {
        &self.contacts[..self.count]
    }

    /// Whether friction is part of it.
    pub fn has_friction(&self) -> bool {
        self.has_friction
    }

    /// Fails where a normal cannot be tilted: each contact must touch a face of B.
    pub fn check_tilt(&self) -> Result<(), ContactSetError> {
        for (contact, pair) in self.as_slice().iter().enumerate() {
            if pair.tilt_axes().is_none() {
                let kind = pair.b().kind();
                return Err(ContactSetError::Tilt { contact, kind });
            }
        }
        Ok(())
    }
}
