//! Tables of poses, as trackers' programs export them, become samples.
//!
//! [`read_table`] takes the text of a file: lines of numbers under a head that names the columns, in any
//! order and with any separator. `text` parts it into cells, `formats` finds the columns of each body in the
//! heads of programs and in rows without names, `head` in everybody else's by what `columns` knows of names.
//! `time`, `turn` and `axes` make integer nanoseconds, quaternions and a world whose z axis is up, `missing` knows what
//! says that nothing was seen, `buttons` when buttons went down, `order` looks at the rows before anybody sorts them. What is assumed is said by `said`,
//! in [`PoseTable::notes`], and what speaks against it in [`PoseTable::against`]. `docs/import.md` describes it for who
//! uses it.

mod axes;
mod buttons;
mod columns;
mod encoding;
mod formats;
mod head;
mod layout;
mod missing;
mod order;
mod poses;
mod read;
mod said;
mod sample;
mod stamp;
mod text;
mod time;
mod turn;
mod units;

pub use axes::{PRESETS, Preset};
pub use encoding::{TableText, table_text};
pub use layout::QuaternionOrder;
pub use missing::{HeldPoses, UnseenRows, held_poses, rounded_m};
pub use poses::{BodyPoses, MarkColumn, PoseTable, TableOptions};
pub use read::read_table;
pub use stamp::nanoseconds;
pub use turn::{TURNS, Turn};
pub use units::{AngleUnit, TimeUnit, length_name, length_unit};

#[cfg(test)]
mod tests;
