//! Methods of estimation, all on the program's own problem, from the same arc fits, through the same
//! stages, judged alike.
//!
//! [`split`] says where a method holds states, [`touch`] lets it begin, [`simulate`] what follows from them, [`columns`] where
//! the unknowns sit, [`chain`], [`objective`] and [`join`] how derivatives reach them, [`model`] puts
//! it together ([`setting`]); [`parts`] and [`rows`] are how the program's rows are read;
//! [`descent`], [`finish`] and [`stages`] are the program's recipe over any of these grids,
//! [`evolution`] samples. A [`task`] is what one is asked, and what it answers.
#![allow(dead_code, reason = "no part and no test uses all of it")]

pub mod chain;
pub mod columns;
pub mod descent;
pub mod evolution;
pub mod finish;
pub mod join;
pub mod model;
pub mod objective;
pub mod parts;
pub mod rows;
pub mod setting;
pub mod simulate;
pub mod split;
pub mod stages;
pub mod task;
pub mod touch;

pub use split::Grid;
pub use task::{Answer, Method, Task};

use enact::estimate::layout::Layout;
use enact::estimate::point::Point;
use enact::estimate::problem::Problem;
use enact::estimate::recipe;
use enact::estimate::system::{Frame, Guidance, System};
use enact::motion::Guess;

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
    let frame = Frame::new(problem, layout, recipe::epochs_s(guess), point);
    let mut system = System::new(&frame);
    system.evaluate(&frame, &Guidance::none(problem), point);
    Judged {
        objective: 2.0 * system.cost,
        violation: system.violation(),
    }
}
