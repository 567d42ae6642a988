//! What must hold of the motion of trees at events.

use nalgebra::Vector3;

use super::event::StampedEvent;
use crate::estimate::problem::unit;
use crate::motion::{BodyPoint, Condition, GoalSet, Scene, Sketch};

/// A condition at an event.
#[derive(Clone, Debug)]
pub struct TreeGoal {
    /// Index into `Scene::goals`.
    pub goal: usize,
    /// Which of its conditions.
    pub part: usize,
    /// Index into `Scene::events`.
    pub event: usize,
    /// Stamp of its event \[s\].
    pub acted_s: f64,
    /// Of a time the event since which it is counted.
    pub since: Option<StampedEvent>,
    /// The link's place in the forest, and that of the link in whose axes it is seen.
    pub places: [usize; 2],
    /// Point of the link that it is about [m, link axes].
    pub point_m: Vector3<f64>,
    /// What must hold.
    pub condition: Condition,
    /// The numbers of the quantity that a box bounds; none where the set has one row.
    pub axes: Vec<usize>,
}

/// The goals of all links, in order of time.
pub(super) fn goals(scene: &Scene, sketch: &Sketch, span_s: [f64; 2]) -> Vec<TreeGoal> {
    let mut all = Vec::new();
    for (index, goal) in scene.goals.iter().enumerate() {
        let acted_s = |event: usize| sketch.marks_s[event].clamp(span_s[0], span_s[1]);
        for (part, condition) in goal.target.conditions().into_iter().enumerate() {
            // Of a time the link says nothing.
            let place = match condition.quantity.is_time() {
                true => 0,
                false => scene.place_of(goal.link),
            };
            let seen_from = condition.quantity.seen_from();
            let other = seen_from.map_or(place, |link| scene.place_of(link));
            let axes = match &condition.set {
                GoalSet::Box { lower, upper } => (0..condition.quantity.dimension())
                    .filter(|axis| lower[*axis].is_finite() || upper[*axis].is_finite())
                    .collect(),
                _ => Vec::new(),
            };
            all.push(TreeGoal {
                goal: index,
                part,
                event: goal.event,
                acted_s: acted_s(goal.event),
                since: condition.quantity.since().map(|event| StampedEvent {
                    event,
                    acted_s: acted_s(event),
                }),
                places: [place, other],
                point_m: point_m(&condition),
                condition,
                axes,
            });
        }
    }
    all.sort_by(|a, b| a.acted_s.total_cmp(&b.acted_s));
    all
}

/// The point of the link that a condition is about [m, link axes].
fn point_m(condition: &Condition) -> Vector3<f64> {
    match condition.quantity.point() {
        Some(BodyPoint::Fixed(point_m)) => point_m,
        _ => Vector3::zeros(),
    }
}

impl TreeGoal {
    /// The same of another scene that differs in values of quantities.
    pub(super) fn set_from(&mut self, other: &Scene) {
        let mut conditions = other.goals[self.goal].target.conditions();
        self.condition = conditions.swap_remove(self.part);
        self.point_m = point_m(&self.condition);
    }

    /// Number of its rows that must hold: none of one that weighs.
    pub fn row_count(&self) -> usize {
        match self.condition.sd {
            Some(_) => 0,
            None => self.axes.len().max(1),
        }
    }

    /// One unit of its rows, in the unit of its quantity.
    pub fn unit(&self) -> f64 {
        unit::of(self.condition.quantity.unit())
    }
}
