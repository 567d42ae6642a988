//! Which impacts are refused.

use thiserror::Error;

use crate::physics::contact::Degenerate;

/// Why contacts make no meeting.
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
        "friction at {count} contacts at once is not supported: leave it out, or use one contact"
    )]
    FrictionAtSeveral {
        /// How many contacts.
        count: usize,
    },
    /// A tilted normal where the touched feature has none of its own.
    #[error(
        "the normal of contact {contact} cannot be tilted: what it touches is a {kind}, only a face has a normal of its own"
    )]
    Tilt {
        /// Which contact.
        contact: usize,
        /// Kind of B's feature.
        kind: &'static str,
    },
}

/// Why an impact has no answer in the poses at hand.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ImpactError {
    /// A contact is degenerate there.
    #[error("contact {contact}: {reason}")]
    Degenerate {
        /// Which one.
        contact: usize,
        /// Why.
        reason: Degenerate,
    },
    /// The contacts' normal speeds depend on each other: three points in a line, one twice.
    #[error(
        "the {count} contacts depend on each other (points in a line, or one twice): their impulses are not determined"
    )]
    Dependent {
        /// How many contacts.
        count: usize,
    },
}
