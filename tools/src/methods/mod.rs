//! Methods of estimation, all on the program's own problem, from the same arc fits, through the same
//! stages, judged alike.
//!
//! [`split`] says where a method holds states, [`touch`] lets it begin, [`simulate`] says what follows
//! from them, [`columns`] where the unknowns sit, [`chain`], [`objective`] and [`join`] how derivatives
//! reach them; [`model`] puts it together ([`setting`]), and reads the program's rows by [`parts`] and
//! [`rows`]. [`stages`] hands it to the program's own optimiser, [`evolution`] samples. A `task` is what one is asked and what it answers, [`judge`] what that is
//! worth.

pub mod chain;
pub mod columns;
pub mod evolution;
pub mod join;
pub mod judge;
pub mod model;
pub mod objective;
pub mod parts;
pub mod program;
pub mod rows;
pub mod setting;
pub mod simulate;
pub mod split;
pub mod stages;
mod task;
pub mod touch;

pub use judge::{Judged, judged};
pub use program::Part;
pub use split::Grid;
pub use task::{Answer, Method, Task};
