//! Why a tree is refused.

use thiserror::Error;

/// Why a tree of bodies is refused. Links are named by their place in the list.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TreeError {
    /// There is nothing.
    #[error("a tree has at least one link")]
    Empty,
    /// A link's parent comes after it or is itself: such links could form a circle.
    #[error("link {link}: its parent {parent} does not come before it")]
    Order {
        /// Link.
        link: usize,
        /// As given.
        parent: usize,
    },
    /// A free joint that is not the first link's, or hangs from another link.
    #[error("link {link}: only the first link can be free, and then no other hangs from the world")]
    Free {
        /// Link.
        link: usize,
    },
    /// An axis is not a finite vector that has a direction.
    #[error("link {link}: axis {axis} has no direction")]
    Axis {
        /// Link.
        link: usize,
        /// First or second axis: 0 or 1.
        axis: usize,
    },
    /// The two axes of a universal joint are parallel, or nearly so.
    #[error("link {link}: the axes of its universal joint are parallel")]
    ParallelAxes {
        /// Link.
        link: usize,
    },
    /// A mass that moves with a joint is infinite or not positive.
    #[error("link {link}: mass is {mass_kg} kg, expected a positive number")]
    Mass {
        /// Link.
        link: usize,
        /// As given.
        mass_kg: f64,
    },
    /// Something supports a link: what lies or rolls is joined to nothing.
    #[error("link {link}: what something supports is no link of a tree")]
    Support {
        /// Link.
        link: usize,
    },
    /// Damping, stiffness or rest of a joint is negative or not finite, or given where the joint
    /// cannot have one.
    #[error(
        "link {link}: damping and stiffness are zero or more, and a free or fixed joint has none"
    )]
    Passive {
        /// Link.
        link: usize,
    },
    /// A pose is not finite.
    #[error("link {link}: a pose of its joint is not finite")]
    Pose {
        /// Link.
        link: usize,
    },
}
