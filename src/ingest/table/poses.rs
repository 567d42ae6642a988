//! What is said of a table, and what is read of it.

use super::axes::Preset;
use super::layout::QuaternionOrder;
use super::missing::UnseenRows;
use super::turn::Turn;
use super::units::{AngleUnit, TimeUnit};
use crate::motion::{LengthUnit, PoseSample, Stamp};

/// A button that makes marks: a column of a table, or a button of a captured session.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkColumn {
    /// Its name.
    pub name: String,
    /// The value above which it is down; by default half of its greatest.
    pub level: Option<f64>,
}

/// Words in names of buttons.
const BUTTONS: [&str; 9] = [
    "trigger", "button", "grip", "squeeze", "thumb", "trackpad", "touchpad", "pinch", "press",
];

impl MarkColumn {
    /// Whether a column has its name.
    pub(super) fn is_named(&self, column: &str) -> bool {
        let column = column.trim_matches(['#', '"', ' ']);
        column.eq_ignore_ascii_case(&self.name)
    }

    /// Whether a column is a button's, by its name.
    pub(super) fn may_be(column: &str) -> bool {
        let column = column.to_ascii_lowercase();
        BUTTONS.iter().any(|word| column.contains(word))
    }
}

/// What a user says of a table; what is not said is read off its head, or guessed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableOptions {
    /// Names of the columns, in order, parted by commas, in place of those in the file.
    pub columns: Option<String>,
    /// Unit of the times.
    pub time_unit: Option<TimeUnit>,
    /// Unit of the positions.
    pub length_unit: Option<LengthUnit>,
    /// Unit of angles.
    pub angle_unit: Option<AngleUnit>,
    /// Rows are so many a second, whatever their times say; frames are, where times count frames.
    pub rate_hz: Option<f64>,
    /// Order of the quaternion's numbers, where names do not say it.
    pub quaternion: Option<QuaternionOrder>,
    /// What three angles mean.
    pub turn: Option<&'static Turn>,
    /// What is usual where it comes from.
    pub preset: Option<&'static Preset>,
    /// Buttons that are marks where they go down.
    pub mark_columns: Vec<MarkColumn>,
}

/// What a table holds.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTable {
    /// What wrote it, in words.
    pub kind: String,
    /// The preset by which its axes were turned.
    pub preset: &'static Preset,
    /// The unit of its positions.
    pub length: LengthUnit,
    /// Its bodies, in the order of their columns or first rows.
    pub bodies: Vec<BodyPoses>,
    /// Marks of its head, with the names of events.
    pub marks: Vec<(String, Stamp)>,
    /// When a button was pressed: the next event, in order.
    pub presses: Vec<Stamp>,
    /// The time of its first row where it counts frames or rows: several files have one zero.
    pub zero: Option<Stamp>,
    /// What was guessed, and what was not read.
    pub notes: Vec<String>,
    /// What speaks against how it was read.
    pub against: Vec<String>,
    /// What is lost.
    pub lost: Vec<String>,
}

/// The samples of a body, in file order: metres, z up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyPoses {
    /// Its name in the file, if it has one there.
    pub name: Option<String>,
    /// Its readings.
    pub samples: Vec<PoseSample>,
    /// Rows in which it has no pose.
    pub unseen: UnseenRows,
    /// What is to be known of its rows.
    pub notes: Vec<String>,
    /// What speaks against them.
    pub against: Vec<String>,
}
