//! Orders of quaternions: `w, x, y, z` or `x, y, z, w`, world from body or body from world.

use super::facts::Facts;
use crate::motion::{GoalQuantity, GoalTarget, QuaternionSlip, Remedy, SampleSource};

/// Other orders in streams and goals.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let has_pose = facts.scene.goals.iter().any(|goal| match &goal.target {
        GoalTarget::Pose { .. } => true,
        GoalTarget::Condition(condition) => {
            matches!(condition.quantity, GoalQuantity::Turn { .. })
        }
        GoalTarget::PositionWithin { .. } => false,
    });
    // Of keyframes each number is named.
    let is_stream = facts.source() == SampleSource::Tracker;
    let streams = [
        QuaternionSlip::ScalarFirst,
        QuaternionSlip::ScalarLast,
        QuaternionSlip::Inverse,
    ];
    let goals = [QuaternionSlip::ScalarLast, QuaternionSlip::Inverse];
    let goals = goals.into_iter().filter(|_| has_pose);
    let streams = streams.into_iter().filter(|_| is_stream);
    let streams = streams.map(Remedy::StreamQuaternions);
    streams.chain(goals.map(Remedy::GoalQuaternions)).collect()
}
