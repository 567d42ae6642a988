//! The program's own optimiser over any grid's unknowns: the same weights, rounds and ends.

use enact::estimate::schedule::recipe::{Lead, Recipe};
use enact::optimise;

use super::model::Model;
use super::setting::Place;

/// Where a solve ended.
pub struct End {
    /// All unknowns.
    pub place: Place,
    /// Within tolerances, by its own account.
    pub converged: bool,
    /// Factorisations.
    pub iterations: usize,
}

/// Solves from a place.
pub fn solve(model: &Model, start: Place, recipe: &Recipe) -> End {
    if !start.exists {
        return End {
            place: start,
            converged: false,
            iterations: 0,
        };
    }
    let (context, fits) = model.fits();
    let lead = Lead::new(context, fits, recipe);
    let guidance = |stage| lead.guidance(stage);
    let solution = optimise::solve(model, start, &recipe.schedule, &guidance, &mut ());
    End {
        place: solution.point,
        converged: solution.finished.converged,
        iterations: solution.work.factorisations,
    }
}
