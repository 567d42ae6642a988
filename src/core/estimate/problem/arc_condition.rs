//! A condition of the scene as the solver has it: on which arcs, as which rows.

use nalgebra::Vector3;

use super::influence::Influence;
use crate::motion::{Condition, Goal, GoalSet, Scene};
use crate::physics::contact::Feature;

/// A condition on arcs at an event.
#[derive(Clone, Debug)]
pub struct ArcCondition {
    /// Event at which it holds.
    pub event: usize,
    /// What must hold.
    pub condition: Condition,
    /// Arcs of the body and, where the quantity depends on it, of another; none of a time.
    pub arcs: Vec<usize>,
    /// Where the point it is about touches.
    pub touched: Option<Touched>,
    /// How its set becomes rows.
    pub rows: Rows,
    /// Parameters that act on it.
    pub acting: Vec<ActingParameter>,
}

/// The contact whose place is meant.
#[derive(Clone, Copy, Debug)]
pub struct Touched {
    /// Index into [`Problem::collisions`](super::Problem::collisions).
    pub collision: usize,
    /// Which of its contacts.
    pub contact: usize,
    /// The side of the collision that the body is.
    pub side: usize,
}

/// Sine of the angle to an axis below which the normal of a face is along it.
const ALONG: f64 = 1e-9;

/// The rows of a condition.
#[derive(Clone, Debug, PartialEq)]
pub enum Rows {
    /// One for each of these numbers, which a box bounds.
    Axes(Vec<usize>),
    /// Equality along two tangents of the face that is touched: the contact holds it on the face.
    OnFace([Vector3<f64>; 2]),
    /// One for the way into a half-space, or for the distance from a ball's centre.
    Single,
}

/// A parameter with what it does to a condition's bodies or to what they touch.
#[derive(Clone, Debug, PartialEq)]
pub struct ActingParameter {
    /// Index into [`Problem::parameters`](super::Problem::parameters).
    pub parameter: usize,
    /// Its influences, each on one of the condition's arcs, or on the surface (`None`).
    pub on: Vec<(Option<usize>, Influence)>,
}

impl Rows {
    /// Those of a goal's condition. What touches a face is asked nothing across it, since the contact's own row already holds
    /// it there.
    pub fn of(scene: &Scene, goal: &Goal, condition: &Condition) -> Self {
        let GoalSet::Box { lower, upper } = &condition.set else {
            return Self::Single;
        };
        let is_bounded = |axis: &usize| lower[*axis].is_finite() || upper[*axis].is_finite();
        let axes = (0..condition.quantity.dimension()).filter(is_bounded);
        match scene.face_touched(goal, condition) {
            Some((_, normal)) if condition.set.is_point(3) => {
                Self::OnFace(Feature::tangents(&normal))
            }
            Some((_, normal)) => {
                let is_across =
                    |axis: &usize| normal.cross(&Vector3::ith(*axis, 1.0)).norm() > ALONG;
                Self::Axes(axes.filter(is_across).collect())
            }
            None => Self::Axes(axes.collect()),
        }
    }

    /// Their number.
    pub fn count(&self) -> usize {
        match self {
            Rows::Axes(axes) => axes.len(),
            Rows::OnFace(_) => 2,
            Rows::Single => 1,
        }
    }
}

impl ArcCondition {
    /// Whether it is a wish with a weight.
    pub fn is_soft(&self) -> bool {
        self.condition.sd.is_some()
    }

    /// The events whose times it depends on.
    pub fn events(&self) -> impl Iterator<Item = usize> {
        [self.event]
            .into_iter()
            .chain(self.condition.quantity.since())
    }
}
