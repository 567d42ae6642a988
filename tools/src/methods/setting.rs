//! A problem on a grid, and a value of its unknowns.

use enact::estimate::problem::Problem;
use enact::estimate::unknowns::layout::Layout;
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::physics::flow;
use enact::physics::state::StateTangent;

use super::columns::Columns;
use super::split::{Grid, Split, split};

/// A problem on a grid.
pub struct Setting {
    /// Which.
    pub grid: Grid,
    /// As given.
    pub problem: Problem,
    /// Its pieces.
    pub split: Split,
    /// Where the pieces' unknowns would sit if all were free.
    pub lifted: Layout,
    /// Where the grid's unknowns sit.
    pub columns: Columns,
    /// Epochs of the given guess \[s\].
    pub guess: Guess,
}

impl Setting {
    /// Of a problem and where to start.
    pub fn new(problem: &Problem, guess: &Guess, grid: Grid) -> Self {
        let split = split(problem, guess, grid);
        let lifted = Layout::new(&split.problem);
        Self {
            columns: Columns::new(&split, &lifted, grid),
            grid,
            problem: problem.clone(),
            split,
            lifted,
            guess: guess.clone(),
        }
    }

    /// The point as one of the given problem: of every arc the piece with the most samples.
    pub fn whole(&self, place: &Place) -> Point {
        let gravity = self.problem.gravity(&place.lifted.parameters);
        let arcs = self.problem.arcs.iter().enumerate().map(|(arc, of)| {
            let pieces = (0..self.split.arc_of.len()).filter(|p| self.split.arc_of[*p] == arc);
            let samples = |piece: &usize| self.split.problem.arcs[*piece].sample_count();
            let piece = pieces.max_by_key(samples).expect("every arc has a piece");
            let past_s = self.guess.arcs[arc].epoch_s - self.split.epochs_s[piece];
            let body = &self.problem.bodies[of.mechanism];
            flow::advance(body, &gravity, &place.lifted.arcs[piece], past_s)
        });
        Point {
            arcs: arcs.collect(),
            ..place.lifted.clone()
        }
    }
}

/// A value of a grid's unknowns and of all that follows from them.
#[derive(Clone, Debug)]
pub struct Place {
    /// All unknowns of the lifted problem.
    pub lifted: Point,
    /// Velocity gaps of every collision and body, in units.
    pub gaps: Vec<[StateTangent; 2]>,
    /// Whether there is such a motion.
    pub exists: bool,
}
