//! A condition of the scene as the solver has it: on which arcs, as which rows.

use nalgebra::Vector3;

use super::influence::Influence;
use crate::motion::Condition;

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
