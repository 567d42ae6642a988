//! One judgement for all methods.

use enact::estimate::problem::Problem;
use enact::estimate::schedule::recipe;
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::layout::Layout;
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::optimise::Program;

/// What an answer is worth, by the program's own objective and constraints.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// Sum of squared residuals.
    pub objective: f64,
    /// Largest violation of any constraint, in units.
    pub violation: f64,
}

/// Judges a point of a problem; not finite where the point is not.
pub fn judged(problem: &Problem, layout: &Layout, guess: &Guess, point: &Point) -> Judged {
    let context = SolveContext::new(problem, layout, recipe::epochs_s(guess), point);
    let system = context.evaluated(&Guidance::none(), point);
    Judged {
        objective: 2.0 * system.cost,
        violation: system.violation(),
    }
}
