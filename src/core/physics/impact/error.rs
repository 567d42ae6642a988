//! Reasons why contact sets and impacts are refused.

use thiserror::Error;

use crate::physics::contact::Degenerate;

/// Why contacts are refused as a [`ContactSet`](super::ContactSet).
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ContactSetError {
    /// None, or too many.
    #[error("{count} contacts at once, expected one, two or three")]
    Count {
        /// How many.
        count: usize,
    },
    /// Friction at more than one contact.
    #[error(
        "friction at {count} contacts at once is not supported: leave it out, use one contact, or a face that lands flat on one of the world's"
    )]
    FrictionAtSeveral {
        /// How many contacts.
        count: usize,
    },
    /// Tangential restitution where nothing sticks by itself.
    #[error(
        "tangential restitution is for one contact with friction, not for {count} without friction or at once: leave it out"
    )]
    SpringBack {
        /// How many contacts.
        count: usize,
    },
    /// A tilted normal where B's feature is no face and has no normal of its own.
    #[error(
        "the normal of contact {contact} cannot be tilted: what it touches is a {kind}, only a face has a normal of its own"
    )]
    Tilt {
        /// Index of the contact.
        contact: usize,
        /// Kind of B's feature.
        kind: &'static str,
    },
}

/// Why an impact is undetermined in given poses.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ImpactError {
    /// A contact is degenerate in these poses.
    #[error("contact {contact}: {reason}")]
    Degenerate {
        /// Index of the contact.
        contact: usize,
        /// Why it is degenerate.
        reason: Degenerate,
    },
    /// The contacts' normal speeds are linearly dependent: three points in a line, or one point
    /// twice.
    #[error(
        "the {count} contacts depend on each other (points in a line, or one twice): their impulses are not determined"
    )]
    Dependent {
        /// How many contacts.
        count: usize,
    },
    /// Poses are so far off that a contact's response to impulses cannot be computed: not numbers, or
    /// arms beyond all measure.
    #[error(
        "the contact's response to an impulse is no positive definite matrix: expected finite poses"
    )]
    NoResponse,
}
