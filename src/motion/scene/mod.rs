//! The scene: what moves, the static world, expected events, goals, free parameters, weights.
//!
//! Plain validated data in SI units. `config` makes it from TOML; the stages do not check it again.

mod contact_law;
mod contacts;
mod estimated;
mod event;
mod freedom;
mod goal;
mod link;
mod parameter;
mod quantity;
mod rest;
mod untold;
mod whole;
mod world;

pub use contact_law::ContactLaw;
pub use contacts::CollisionError;
pub use event::{Collision, Event, EventKind, EventTime, Partner, Touching};
pub use goal::{Goal, GoalTarget};
pub use link::{Feature, FreeBody, Held, Link, Mechanism, Track};
pub use parameter::{Cone, FreeParameter};
pub use quantity::Quantity;
pub use rest::RestGoal;
pub use untold::{Combination, Together, Untold};
pub use whole::{Scene, Timing, VelocityGaps, Weights};
pub use world::{Against, Obstacle, Surface};
