//! What must hold of the motion of trees at events.

use nalgebra::Vector3;

use super::event::StampedEvent;
use crate::estimate::problem::arc_condition::Rows;
use crate::estimate::problem::unit;
use crate::motion::{BodyPoint, Condition, Goal, LinkIndex, Partner, Scene, Sketch};

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
    /// The link's place in the forest, and that of the link in whose axes it is seen or which it touches.
    pub places: [usize; 2],
    /// Where the point that it is about touches.
    pub touched: Option<TouchedContact>,
    /// Point of the link that it is about [m, link axes].
    pub point_m: Vector3<f64>,
    /// What must hold.
    pub condition: Condition,
    /// How its set becomes rows.
    pub rows: Rows,
}

/// The contact whose place is meant.
#[derive(Clone, Copy, Debug)]
pub struct TouchedContact {
    /// Which of those of its event.
    pub contact: usize,
    /// The side of it that the link is.
    pub side: usize,
    /// The link on the other side; `None` where that stands still.
    pub other: Option<LinkIndex>,
}

impl TouchedContact {
    /// That of a condition; `None` where it is about no contact.
    fn of(scene: &Scene, goal: &Goal, condition: &Condition) -> Option<Self> {
        let Some(BodyPoint::Contact(contact)) = condition.quantity.point() else {
            return None;
        };
        let collision = scene.events[goal.event].kind.collision()?;
        let side = collision.links().position(|link| link == goal.link)?;
        let other = match collision.partner {
            Partner::World => None,
            Partner::Link(other) => Some([other, collision.link][side]),
        };
        Some(Self {
            contact,
            side,
            other,
        })
    }
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
            let touched = TouchedContact::of(scene, goal, &condition);
            let touches = touched.and_then(|touched| touched.other);
            let other = condition.quantity.seen_from().or(touches);
            let other = other.map_or(place, |link| scene.place_of(link));
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
                touched,
                point_m: point_m(&condition),
                rows: Rows::of(scene, goal, &condition),
                condition,
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
            None => self.rows.count(),
        }
    }

    /// One unit of its rows, in the unit of its quantity.
    pub fn unit(&self) -> f64 {
        unit::of(self.condition.quantity.unit())
    }
}
