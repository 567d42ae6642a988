//! Trees of rigid bodies: bodies joined by joints, without circles.

mod air;
mod articulated;
mod centre;
mod change;
mod error;
mod field;
mod flow;
mod forest;
mod hand;
mod impact;
mod jacobian;
mod joint;
mod kinematics;
mod link_state;
mod model;
mod points;
mod pushed;
mod snapshot;
mod spatial;
mod stages;
mod state;
pub mod tableau;
mod tangent;

pub use error::TreeError;
pub use flow::Flow;
pub use forest::Forest;
pub use forest::flow::ForestFlow;
pub use forest::snapshot::ForestSnapshot;
pub use hand::{Carrier, Hand};
pub use impact::derivative::TreeImpactDerivative;
pub use impact::{LinkContact, TreeImpact};
pub use joint::{Joint, JointKind};
pub use kinematics::Root;
pub use model::{Link, Tree};
pub use snapshot::Snapshot;
pub use spatial::{Force, Inertia, Motion};
pub use state::TreeState;

#[cfg(test)]
mod tests;
