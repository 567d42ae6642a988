//! Columns of the lifted problem's rows, in groups.

use enact::estimate::problem::Problem;
use enact::physics::state::DIMENSION as STATE;

/// A group of columns of the lifted problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// State of a piece.
    Piece(usize),
    /// Time of an event.
    Event(usize),
    /// A parameter.
    Parameter(usize),
}

impl Part {
    /// Columns of it.
    pub fn width(self) -> usize {
        match self {
            Part::Piece(_) => STATE,
            Part::Event(_) | Part::Parameter(_) => 1,
        }
    }
}

/// Columns of a collision's rows, in the program's order.
pub fn of_collision(problem: &Problem, index: usize) -> Vec<Part> {
    let collision = &problem.collisions[index];
    let mut parts = Vec::new();
    for side in &collision.sides {
        parts.extend([Part::Piece(side.before), Part::Piece(side.after)]);
    }
    parts.push(Part::Event(collision.event));
    parts.extend(gravity(problem));
    parts.extend(collision.restitution_parameter.map(Part::Parameter));
    parts.extend(collision.friction_parameter.map(Part::Parameter));
    parts.extend(collision.tangential_parameter.map(Part::Parameter));
    parts.extend(collision.tilts.iter().map(|(_, p)| Part::Parameter(*p)));
    parts
}

/// Columns of a goal's rows, in the program's order.
pub fn of_goal(problem: &Problem, index: usize) -> Vec<Part> {
    let goal = &problem.goals[index];
    let mut parts = vec![Part::Piece(goal.arc)];
    if problem.event_is_free[goal.event] {
        parts.push(Part::Event(goal.event));
    }
    parts.extend(gravity(problem));
    parts
}

/// Free components of gravity.
pub fn gravity(problem: &Problem) -> impl Iterator<Item = Part> + '_ {
    let free = problem.gravity_parameters.iter().flatten();
    free.map(|p| Part::Parameter(*p))
}
