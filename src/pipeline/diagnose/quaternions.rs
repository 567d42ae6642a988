//! Orders of quaternions: `w, x, y, z` or `x, y, z, w`, world from body or body from world.

use super::facts::Facts;
use crate::motion::{GoalTarget, QuaternionSlip, Remedy};

/// Other orders in streams and goals.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let has_pose = facts
        .scene
        .goals
        .iter()
        .any(|goal| matches!(goal.target, GoalTarget::Pose { .. }));
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
