//! What lies how at rest, and what it took.

use nalgebra::UnitQuaternion;

/// The result of a scene's goals at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Rest {
    /// One per goal, in the order of `Scene::rest_goals`.
    pub goals: Vec<Lie>,
    /// The search for a motion near the performance.
    pub work: RestWork,
    /// Turns of the links' labels from those that were acted, goal by goal; `None` where they are
    /// as acted.
    pub labels: Vec<Option<UnitQuaternion<f64>>>,
}

/// The work of a search for a motion that comes to rest as asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestWork {
    /// Continuations that were simulated.
    pub continuations: usize,
    /// Motions near the performance that were estimated anew.
    pub motions: usize,
    /// Objective of the motion that fits best, wherever it comes to rest.
    pub best_objective: f64,
}

impl Lie {
    /// Whether the goal is met: it lies still, and the axis is within the goal's angle.
    pub fn is_met(&self) -> bool {
        self.is_still && self.is_shown
    }
}

impl Rest {
    /// Whether every goal is met.
    pub fn is_reached(&self) -> bool {
        self.goals.iter().all(Lie::is_met)
    }
}

/// How a link lies at the end of its simulated motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Lie {
    /// Angle between the goal's axis and its direction \[rad\].
    pub angle_rad: f64,
    /// The axis that points most nearly in that direction: the goal's, a declared face's, `±x`,
    /// `±y` or `±z`.
    pub shown: String,
    /// Whether it lies still.
    pub is_still: bool,
    /// Whether the axis is within the goal's angle.
    pub is_shown: bool,
}
