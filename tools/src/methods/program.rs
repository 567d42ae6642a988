//! The program as a method, whole or with a part of it left out.

use enact::estimate::problem::Problem;
use enact::estimate::schedule::events;
use enact::estimate::schedule::recipe::{self, Lead, Recipe};
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::layout::Layout;
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::optimise::finish::Tolerances;
use enact::optimise::{self, Schedule};
use enact::physics::Body;
use enact::physics::body::Symmetry;
use nalgebra::Vector3;

/// Moments are nudged by this, relative, so that they are three different ones: far more than what
/// the program takes for rounding (2e-15), far less than what shows in an objective.
const NUDGE: f64 = 1e-13;
/// A part of the program's recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The descent with all constraints as a penalty.
    Sweep,
    /// The rounds of multipliers before the finish.
    Multipliers,
    /// The pull of events to where they begin, in the sweep.
    Pull,
    /// The hinge that keeps contacts approaching, in the sweep.
    Hinge,
}

/// The program's answer.
pub fn own(problem: &Problem, layout: &Layout, guess: &Guess, recipe: &Recipe) -> (Point, bool) {
    let solution = recipe::solve(problem, layout, guess, recipe, &mut ());
    (solution.point, solution.finished.converged)
}

/// As [`recipe::solve`], but contacts may recede in the sweep.
pub fn without_hinge(
    problem: &Problem,
    layout: &Layout,
    guess: &Guess,
    recipe: &Recipe,
) -> (Point, bool) {
    let mut start = Point::new(problem, guess);
    let context = SolveContext::new(problem, layout, recipe::epochs_s(guess), &start);
    events::align(&context, &mut start);
    let lead = Lead::new(&context, &start, recipe);
    let guidance = |stage| Guidance {
        approach_limits_m_s: Vec::new(),
        ..lead.guidance(stage)
    };
    let solution = optimise::solve(&context, start, &recipe.schedule, &guidance, &mut ());
    (solution.point, solution.finished.converged)
}

/// A recipe with a part left out.
pub fn without(part: Part, mut recipe: Recipe) -> Recipe {
    match part {
        Part::Sweep => recipe.schedule.sweep_weights.clear(),
        Part::Multipliers => recipe.schedule.multiplier_rounds = (0, 0),
        Part::Pull => recipe.event_sd_s = f64::INFINITY,
        Part::Hinge => {}
    }
    recipe
}

/// The program's recipe with those tolerances.
pub fn ending_at(tolerances: &Tolerances) -> Recipe {
    let usual = Schedule::default();
    Recipe::of(Schedule {
        tolerances: *tolerances,
        // Without a finish there is nothing to try again.
        retries: if tolerances.steps > 0 {
            usual.retries
        } else {
            0
        },
        ..usual
    })
}

/// The body with moments that differ by rounding, so that its turn is computed as the general one.
pub fn with_three_moments(body: &Body) -> Body {
    let signs = match body.symmetry() {
        Symmetry::Spherical => Vector3::new(-1.0, 0.0, 1.0),
        Symmetry::Axial { axis } => Vector3::from_fn(|i, _| match (i + 3 - axis) % 3 {
            0 => 0.0,
            1 => -1.0,
            _ => 1.0,
        }),
        Symmetry::Asymmetric => Vector3::zeros(),
    };
    let moments = body.moments_kg_m2();
    let nudged = moments + moments.component_mul(&signs) * NUDGE;
    Body::new(body.mass_kg(), nudged).expect("nearly the moments of a body")
}
