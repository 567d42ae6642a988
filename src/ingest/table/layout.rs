//! Where in the rows of a table the poses are.

use super::turn::Turn;
use super::units::{AngleUnit, TimeUnit};
use crate::motion::LengthUnit;

/// An error at a line of the text, from 1; 0 for the whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TableFault {
    pub(super) line: usize,
    pub(super) message: String,
}

/// A [`TableFault`] as an error.
pub(super) fn fault<T>(line: usize, message: impl Into<String>) -> Result<T, TableFault> {
    Err(TableFault {
        line,
        message: message.into(),
    })
}

/// A cell as part of a message, and no more of it than one reads.
pub(super) fn shown(cell: &str) -> String {
    const SHOWN: usize = 40;
    match cell.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{:?}…", &cell[..end]),
        None => format!("{cell:?}"),
    }
}

/// Order of a quaternion's four numbers where the names of their columns do not say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionOrder {
    /// Scalar last.
    Xyzw,
    /// Scalar first.
    Wxyz,
}

impl QuaternionOrder {
    /// In words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Xyzw => "x, y, z, w",
            Self::Wxyz => "w, x, y, z",
        }
    }

    /// The columns of x, y, z and w, where four follow each other in this order.
    pub(super) fn columns(self, [a, b, c, d]: [usize; 4]) -> [usize; 4] {
        match self {
            Self::Wxyz => [b, c, d, a],
            Self::Xyzw => [a, b, c, d],
        }
    }
}

/// Columns of three angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Angles {
    /// About x, y and z.
    pub(super) columns: [usize; 3],
    /// Their unit, where it is stated.
    pub(super) unit: Option<AngleUnit>,
    /// What they mean, where it is stated or follows from their names.
    pub(super) turn: Option<&'static Turn>,
}

/// Columns of an orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Orientation {
    /// Of x, y, z and w.
    Quaternion([usize; 4]),
    /// Of three angles.
    Angles(Angles),
    /// Of a matrix, row by row.
    Matrix([usize; 9]),
    /// None: a point is all that is seen.
    Unseen,
}

/// The note that points are taken, and why.
pub(super) fn points_are_taken(why: &str) -> String {
    format!("{why}: points are taken, as a track with sees = \"point\" does")
}

impl Orientation {
    /// The order in which the columns of a quaternion stand, in words.
    pub(super) fn order(&self) -> Option<String> {
        let Self::Quaternion(parts) = self else {
            return None;
        };
        let mut parts: Vec<(usize, &str)> =
            parts.iter().copied().zip(["x", "y", "z", "w"]).collect();
        parts.sort();
        let letters: Vec<&str> = parts.iter().map(|(_, letter)| *letter).collect();
        Some(letters.join(", "))
    }
}

/// Columns of the time of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TimeColumns {
    /// A number in a unit, where that is stated.
    One(usize, Option<TimeUnit>),
    /// Whole seconds, and the nanoseconds past them.
    Two(usize, usize),
    /// None: the row's place counts.
    Row,
}

impl TimeColumns {
    /// The column that is not a time where a row has none.
    pub(super) fn first(self) -> Option<usize> {
        match self {
            Self::One(column, _) | Self::Two(column, _) => Some(column),
            Self::Row => None,
        }
    }
}

/// A column that says whether a row's pose was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SeenColumn {
    /// Zero or `false` where it was not.
    Tracked(usize),
    /// Anything else where it was not.
    Lost(usize),
    /// A residual, below zero where it was not.
    Residual(usize),
}

/// Columns of a body's poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct BodyColumns {
    /// Its name, if the table has one.
    pub(super) name: Option<String>,
    pub(super) position: [usize; 3],
    pub(super) orientation: Orientation,
    /// What says whether it was seen.
    pub(super) seen: Vec<SeenColumn>,
}

/// A mark that a table has in its head.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeadMark {
    pub(super) name: String,
    /// The number of its frame, from 1,
    pub(super) frame: String,
    /// and its time \[s\].
    pub(super) time: String,
}

/// What a table's head says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TableLayout {
    /// What wrote it, in words.
    pub(super) kind: String,
    pub(super) time: TimeColumns,
    pub(super) bodies: Vec<BodyColumns>,
    /// The column that names the body of a row, if several are in turn.
    pub(super) body_name: Option<usize>,
    /// Unit of positions, where it is stated.
    pub(super) length: Option<LengthUnit>,
    /// Rows a second, where it is stated.
    pub(super) rate_hz: Option<f64>,
    /// The preset that is usual for what wrote it.
    pub(super) preset: Option<&'static str>,
    /// Names of the columns that are not read.
    pub(super) unread: Vec<String>,
    /// Names of other columns that may be times.
    pub(super) other_times: Vec<String>,
    /// Whether the order of quaternions is said by the names of their columns; otherwise it is among what to know.
    pub(super) is_order_named: bool,
    /// What to know.
    pub(super) notes: Vec<String>,
    /// What speaks against reading it so.
    pub(super) against: Vec<String>,
    /// Whether the table ends at a row that begins without a number.
    pub(super) is_section: bool,
    /// Whether lines may end where all further cells are empty.
    pub(super) is_ragged: bool,
    /// Whether a position of zeros is not seen, by the rules of the format.
    pub(super) is_zero_unseen: bool,
    /// Marks of the head.
    pub(super) marks: Vec<HeadMark>,
}

impl TableLayout {
    /// A layout of which nothing is known but where time and bodies are.
    pub(super) fn plain(
        kind: impl Into<String>,
        time: TimeColumns,
        bodies: Vec<BodyColumns>,
    ) -> Self {
        Self {
            kind: kind.into(),
            time,
            bodies,
            body_name: None,
            length: None,
            rate_hz: None,
            preset: None,
            unread: Vec::new(),
            other_times: Vec::new(),
            is_order_named: false,
            notes: Vec::new(),
            against: Vec::new(),
            is_section: false,
            is_ragged: false,
            is_zero_unseen: false,
            marks: Vec::new(),
        }
    }
}
