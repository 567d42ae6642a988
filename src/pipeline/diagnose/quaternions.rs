//! Orders of quaternions: `w, x, y, z` or `x, y, z, w`, world from body or body from world.

use super::facts::Facts;
use crate::motion::{GoalQuantity, GoalTarget, QuaternionSlip, Remedy};

/// Other orders in streams and goals.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let has_pose = facts.scene.goals.iter().any(|goal| match &goal.target {
        GoalTarget::Pose { .. } => true,
        GoalTarget::Condition(condition) => {
            matches!(condition.quantity, GoalQuantity::Turn { .. })
        }
        GoalTarget::PositionWithin { .. } => false,
    });
    let streams = [
        QuaternionSlip::ScalarFirst,
        QuaternionSlip::ScalarLast,
        QuaternionSlip::Inverse,
    ];
    let goals = [QuaternionSlip::ScalarLast, QuaternionSlip::Inverse];
    let goals = goals.into_iter().filter(|_| has_pose);
    let streams = streams.into_iter().map(Remedy::StreamQuaternions);
    streams.chain(goals.map(Remedy::GoalQuaternions)).collect()
}
