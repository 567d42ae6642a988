//! The scene: what moves, the static world, expected events, goals, free parameters, weights.
//!
//! Plain validated data in SI units. `config` makes it from TOML; the stages do not check it again.

mod attained;
mod axes;
mod condition;
mod contact_law;
mod contacts;
mod contradiction;
mod estimated;
mod event;
mod flown;
mod freedom;
mod goal;
mod goal_set;
mod group;
mod joint;
mod link;
mod parameter;
mod phase;
mod phases;
mod pressed;
mod quantity;
mod reach;
mod rest;
mod sticking;
mod tree_touch;
mod trees;
mod until;
mod untold;
mod weights;
mod whole;
mod world;

pub use attained::GoalEstimate;
pub use axes::Axes;
pub use condition::{BodyPoint, Condition, GoalQuantity, GoalUnit, Moment};
pub use contact_law::ContactLaw;
pub use contacts::CollisionError;
pub use event::{Collision, Event, EventKind, EventTime, Partner, Touching};
pub use goal::{Goal, GoalTarget};
pub use goal_set::GoalSet;
pub use group::Group;
pub use joint::{Joint, JointEnd, JointTree};
pub use link::{Feature, FreeBody, Held, Link, Mechanism, Sees, Track};
pub use parameter::{Cone, FreeParameter};
pub use phase::{AtPivot, InHand, OnSurface, StuckTo, SupportPhase, SupportedBy};
pub use quantity::Quantity;
pub use rest::RestGoal;
pub use sticking::StuckPair;
pub use tree_touch::TreeTouch;
pub use untold::{Combination, Together, Untold};
pub use weights::{Performer, Weighing, Weights};
pub use whole::{Scene, Timing, VelocityGaps};
pub use world::{Against, Obstacle, Surface};
