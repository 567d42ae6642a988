//! Where in the rows of a table the poses are.

use super::units::TimeUnit;
use crate::motion::LengthUnit;

/// An error at a line of the text, from 1; 0 for the whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) line: usize,
    pub(super) message: String,
}

/// A [`Fault`] as an error.
pub(super) fn fault<T>(line: usize, message: impl Into<String>) -> Result<T, Fault> {
    Err(Fault {
        line,
        message: message.into(),
    })
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
}

/// What three angles mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// A rotation vector: axis times angle (Vicon: helical).
    Vector,
    /// Turns about the body's own x, then y, then z axis: `R = Rx·Ry·Rz`.
    EulerXyz,
}

/// Unit of angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AngleUnit {
    Radian,
    Degree,
}

/// Columns of an orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Orientation {
    /// Of x, y, z and w.
    Quaternion([usize; 4]),
    /// Of three angles.
    Angles([usize; 3], AngleUnit),
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

/// Columns of a body's poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct BodyColumns {
    /// Its name, if the table has one.
    pub(super) name: Option<String>,
    pub(super) position: [usize; 3],
    pub(super) orientation: Orientation,
}

/// What a table's head says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
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
    /// Whether the order of quaternions is said by the names of their columns; otherwise it is among what to know.
    pub(super) is_order_named: bool,
    /// What to know.
    pub(super) notes: Vec<String>,
    /// Whether the table ends at a row that begins without a number.
    pub(super) is_section: bool,
}
