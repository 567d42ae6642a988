//! The contacts of one collision.

use super::error::ContactSetError;
use super::law::MOST_CONTACTS;
use crate::physics::contact::{Contact, ContactError, Feature};

/// How far from its own point a face is held to another \[m\].
const FACE_M: f64 = 0.05;

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

    /// Contacts with friction, whose coefficient may be zero: one, or three of points of A with one face, on which A
    /// lands flat. Others are refused.
    pub fn with_friction(contacts: &[Contact]) -> Result<Self, ContactSetError> {
        let contacts = Self::frictionless(contacts)?;
        if contacts.count > 1 && !contacts.is_flat() {
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

    /// A face of A on a face of B, at three points of it about its own.
    pub fn face_on_face(
        a: &Feature,
        b: &Feature,
    ) -> Result<Option<[Contact; MOST_CONTACTS]>, ContactError> {
        let (Feature::Face { point_m, normal }, Feature::Face { .. }) = (*a, *b) else {
            return Ok(None);
        };
        let [first, second] = Feature::tangents(&normal).map(|tangent| tangent * FACE_M);
        let points = [first, second - first, -first - second];
        let [x, y, z] = points.map(|off_m| Contact::new(Feature::corner(point_m + off_m), *b));
        Ok(Some([x?, y?, z?]))
    }

    /// Whether three points of A are on one face.
    pub fn is_flat(&self) -> bool {
        let contacts = self.as_slice();
        let is_on_it = |contact: &Contact| {
            matches!(contact.a(), Feature::Point { .. })
                && matches!(contact.b(), Feature::Face { .. })
                && contact.b() == contacts[0].b()
        };
        contacts.len() == MOST_CONTACTS && contacts.iter().all(is_on_it)
    }

    /// Whether a face lands flat and friction acts on it as a whole.
    pub fn is_landing(&self) -> bool {
        self.has_friction && self.count > 1
    }

    /// Whether friction is part of it.
    pub fn has_friction(&self) -> bool {
        self.has_friction
    }

    /// Fails where nothing that sticks springs back: at several contacts at once, and without friction.
    pub fn check_spring_back(&self) -> Result<(), ContactSetError> {
        match self.count {
            1 if self.has_friction => Ok(()),
            count => Err(ContactSetError::SpringBack { count }),
        }
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
