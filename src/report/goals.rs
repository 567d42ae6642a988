//! How far the motion is from the scene's goals at events.

use serde::{Deserialize, Serialize};

use super::read::unknown;
use crate::motion::{
    BodyPoint, Condition, Estimate, Goal, GoalQuantity, GoalTarget, GoalUnit, Moment, Scene,
};

/// How far the motion is from one goal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GoalLine {
    /// Name of the event at which it is asked.
    pub event: String,
    /// Name of the body; none of a time.
    pub body: Option<String>,
    /// What is asked, in words.
    pub what: String,
    /// Whether it is met.
    pub is_met: bool,
    /// Whether it is at its bound, or beyond: it may then act on the motion.
    pub binds: bool,
    /// Distance from the set of what meets it: negative inside, as far as its boundary.
    #[serde(default = "unknown")]
    pub distance: f64,
    /// Standard deviation of that distance, its weight; none of a hard goal.
    pub sd: Option<f64>,
    /// Unit of both.
    pub unit: String,
}

/// The goals at events, in the scene's order, measured at the exported motion.
pub(super) fn goal_lines(scene: &Scene, estimate: &Estimate) -> Vec<GoalLine> {
    let scene = &scene.as_estimated(estimate);
    let attained = scene.goals_attained(estimate).into_iter();
    let lines = attained.map(|found| {
        let goal = &scene.goals[found.goal];
        let condition = match &goal.target {
            GoalTarget::Condition(condition) => Some(condition),
            _ => None,
        };
        let is_time = condition.is_some_and(|of| of.quantity.unit() == GoalUnit::Second);
        GoalLine {
            event: scene.events[goal.event].name.clone(),
            body: (!is_time).then(|| scene.links[goal.link].name.clone()),
            what: words(scene, goal),
            is_met: found.is_met(),
            binds: found.binds(),
            distance: found.distance,
            sd: condition.and_then(|condition| condition.sd),
            unit: found.unit.as_str().to_owned(),
        }
    });
    lines.collect()
}

/// What a goal asks for.
fn words(scene: &Scene, goal: &Goal) -> String {
    match &goal.target {
        GoalTarget::Pose { .. } => "pose".into(),
        GoalTarget::PositionWithin { .. } => "position of the centre of mass".into(),
        GoalTarget::Condition(condition) => of_condition(scene, condition),
    }
}

fn of_condition(scene: &Scene, condition: &Condition) -> String {
    let of = |point: &BodyPoint| match point {
        BodyPoint::Centre => "the centre of mass".to_owned(),
        BodyPoint::Contact(_) => "the contact".to_owned(),
        BodyPoint::Fixed(at_m) => {
            let [x, y, z] = (at_m * 1e3).into();
            format!("the point at {x:.1}, {y:.1}, {z:.1} mm")
        }
    };
    let mut words = match &condition.quantity {
        GoalQuantity::Position { point, .. } => format!("position of {}", of(point)),
        GoalQuantity::Turn { .. } => "orientation".into(),
        GoalQuantity::Direction { axis, .. } => {
            format!(
                "direction of the axis {:.2}, {:.2}, {:.2}",
                axis.x, axis.y, axis.z
            )
        }
        GoalQuantity::Velocity { point } => format!("velocity of {}", of(point)),
        GoalQuantity::Spin { .. } => "spin".into(),
        GoalQuantity::Angles { .. } => "angles of its joint".into(),
        GoalQuantity::Time { since } => {
            let since = since.map_or("the first sample", |event| &scene.events[event].name);
            format!("time since {since}")
        }
    };
    if let Some(other) = condition.quantity.seen_from() {
        words += &format!(" relative to {}", scene.links[other].name);
    }
    if condition.moment == Moment::After {
        words += " after it";
    }
    words
}
