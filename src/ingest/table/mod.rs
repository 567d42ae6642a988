//! Tables of poses, as trackers' programs export them, become samples.
//!
//! [`read_table`] takes the text of a file: lines of numbers under a head that names the columns, in any
//! order and with any separator. `text` parts it into cells, `head` finds the columns of each body in the
//! heads of programs (`vendor`) and of everybody else (`columns`), `time` and `axes` make SI units, integer
//! nanoseconds and a world whose z axis is up. What is guessed is said in [`PoseTable::notes`].
//! `docs/import.md` describes it for who uses it.

mod axes;
mod columns;
mod head;
mod layout;
mod read;
mod stamp;
mod text;
mod time;
mod units;
mod vendor;

pub use axes::{PRESETS, Preset};
pub use layout::{QuaternionOrder, Turn};
pub use read::{BodyPoses, PoseTable, TableOptions, read_table};
pub use stamp::nanoseconds;
pub use units::{TimeUnit, length_unit};

#[cfg(test)]
mod tests;
