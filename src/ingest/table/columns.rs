//! What the names of columns mean.

use super::layout::SeenColumn;
use super::units::{AngleUnit, TimeUnit, length_unit};
use crate::motion::LengthUnit;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A time; of several that of the highest rank is read.
    Time { rank: u8, unit: Option<TimeUnit> },
    /// The number of a frame.
    Frame,
    /// A coordinate of a position.
    Position {
        axis: usize,
        unit: Option<LengthUnit>,
    },
    /// A letter by itself, x, y, z or w: a coordinate, or with a w beside it a part of a quaternion.
    Letter {
        axis: usize,
        unit: Option<LengthUnit>,
    },
    /// A part of a quaternion: x, y, z, w; with a name that angles have as well it is one only beside a w.
    Quaternion {
        part: usize,
        is_angle: bool,
        unit: Option<AngleUnit>,
    },
    /// i, j, k or the real part by itself: of a quaternion where all four are there.
    Imaginary(usize),
    /// A coordinate of a position by number, from 0 or from 1.
    Coordinate(usize),
    /// A part of an orientation by number: four are a quaternion, nine a matrix.
    Numbered(usize),
    /// An entry of a matrix of a rotation or of a pose, as it is counted.
    Entry { row: usize, column: usize },
    /// An angle about an axis.
    Angle {
        axis: usize,
        kind: AngleKind,
        unit: Option<AngleUnit>,
    },
    /// The name of the body.
    Body,
    /// Whether the row was seen.
    Seen(SeenKind),
}

/// What a name says of what angles mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AngleKind {
    /// Nothing; a w beside them makes a quaternion of them.
    Untold,
    /// Roll, pitch, yaw.
    Rpy,
    /// A rotation vector.
    Vector,
}

/// How a column says that a row was not seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SeenKind {
    Tracked,
    Lost,
    Residual,
}

impl SeenKind {
    pub(super) fn column(self, column: usize) -> SeenColumn {
        match self {
            Self::Tracked => SeenColumn::Tracked(column),
            Self::Lost => SeenColumn::Lost(column),
            Self::Residual => SeenColumn::Residual(column),
        }
    }
}

impl Meaning {
    /// Whether it is of an orientation.
    pub(super) fn is_turn(&self) -> bool {
        matches!(
            self,
            Self::Quaternion { .. } | Self::Numbered(_) | Self::Angle { .. } | Self::Entry { .. }
        )
    }
}

/// A name taken apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Column {
    pub(super) meaning: Meaning,
    /// What else the name says: whose it is, where several bodies are side by side.
    pub(super) owner: String,
}

const POSITIONS: [&str; 16] = [
    "p",
    "t",
    "pos",
    "position",
    "positions",
    "trans",
    "translation",
    "tvec",
    "loc",
    "location",
    "com",
    "point",
    "centre",
    "center",
    "coord",
    "pose",
];
/// Names of quaternions alone,
const QUATERNIONS: [&str; 4] = ["q", "quat", "quaternion", "o"];
/// and such as angles have too.
const TURNS: [&str; 7] = [
    "orientation",
    "orient",
    "ori",
    "rot",
    "rotation",
    "attitude",
    "att",
];
const ANGLES: [&str; 6] = ["r", "euler", "eul", "ang", "angle", "angles"];
const VECTORS: [&str; 6] = ["rvec", "rotvec", "rodrigues", "helical", "aa", "axisangle"];
/// Positions whose coordinates may be counted.
const COUNTED: [&str; 7] = [
    "pos",
    "position",
    "trans",
    "translation",
    "tvec",
    "loc",
    "location",
];
const MATRICES: [&str; 12] = [
    "r",
    "rot",
    "rotation",
    "m",
    "mat",
    "matrix",
    "t",
    "tf",
    "transform",
    "h",
    "pose",
    "dcm",
];
/// Angles by names of their own, with their axis.
const ROLL_PITCH_YAW: [(&str, usize); 9] = [
    ("roll", 0),
    ("pitch", 1),
    ("yaw", 2),
    ("heading", 2),
    ("azimuth", 2),
    ("elevation", 1),
    ("phi", 0),
    ("theta", 1),
    ("psi", 2),
];
/// What is no pose, though its columns end in x, y, z.
const OTHERS: [&str; 36] = [
    "v",
    "vel",
    "velocity",
    "velocities",
    "speed",
    "a",
    "acc",
    "accel",
    "acceleration",
    "gyro",
    "gyroscope",
    "mag",
    "magnetometer",
    "angular",
    "linear",
    "twist",
    "force",
    "torque",
    "wrench",
    "omega",
    "bias",
    "b",
    "cov",
    "covariance",
    "error",
    "err",
    "std",
    "sd",
    "sigma",
    "stddev",
    "normal",
    "gravity",
    "scale",
    "gaze",
    "rate",
    "size",
];
/// Words that say nothing of whose a column is.
const FILLERS: [&str; 12] = [
    "field", "header", "stamp", "world", "global", "message", "msg", "data", "value", "rigid",
    "body", "w",
];
/// Last words of columns that say that a row was seen.
const SEEN: [&str; 6] = [
    "valid",
    "tracked",
    "btracked",
    "visible",
    "detected",
    "confidence",
];
const BODIES: [&str; 24] = [
    "id",
    "uid",
    "object uid",
    "rigid body id",
    "device id",
    "body",
    "object",
    "name",
    "tracker",
    "device",
    "marker",
    "rigid body",
    "rigid body name",
    "body name",
    "object name",
    "tracker name",
    "subject",
    "segment",
    "child frame id",
    "object id",
    "body id",
    "tracker id",
    "marker id",
    "track id",
];

/// The words of a name in lower case, and the unit in brackets.
fn words(name: &str) -> (Vec<String>, Option<String>) {
    let name = name.trim().trim_matches(['#', '%', '"', '\'']).trim();
    let is_index = |at: usize| name[at + 1..].starts_with(|of: char| of.is_ascii_digit());
    let bracket = name.find(['[', '(']).filter(|at| !is_index(*at));
    let (name, mut unit) = match bracket {
        Some(at) => {
            let unit = name[at + 1..].trim_end_matches([']', ')', ' ']);
            (&name[..at], Some(unit.to_lowercase()))
        }
        None => (name, None),
    };
    if unit.is_none() && name.contains(['°', 'º']) {
        unit = Some("°".to_owned());
    }
    let mut words: Vec<String> = vec![String::new()];
    let mut was_lower = false;
    for character in name.chars().filter(|of| *of != 'º') {
        let begins = was_lower && character.is_uppercase();
        if !character.is_alphanumeric() || begins {
            words.push(String::new());
        }
        if let Some(last) = words.last_mut().filter(|_| character.is_alphanumeric()) {
            last.extend(character.to_lowercase());
        }
        was_lower = character.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    (words, unit.filter(|unit| !unit.is_empty()))
}

/// What a column with a name holds, if poses need it.
pub(super) fn column(name: &str) -> Option<Column> {
    let (mut words, mut unit) = words(name);
    let is_unit = |word: &str| {
        TimeUnit::of(word).is_some() || length_unit(word).is_some() || AngleUnit::of(word).is_some()
    };
    if unit.is_none() && words.len() > 1 && words.last().is_some_and(|word| is_unit(word)) {
        unit = words.pop();
    }
    let unit = unit.as_deref();
    let plain = |meaning: Meaning| {
        let owner = String::new();
        Some(Column { meaning, owner })
    };
    let joined = words.join(" ");
    if BODIES.contains(&joined.as_str()) {
        return plain(Meaning::Body);
    }
    if let Some(meaning) = time(&words, unit) {
        return plain(meaning);
    }
    // OpenVR's `bPoseIsValid`: a truth value.
    if let [first, _, ..] = &words[..]
        && first == "b"
        && words
            .last()
            .is_some_and(|word| SEEN.contains(&word.as_str()))
    {
        words.remove(0);
    }
    if words.iter().any(|word| OTHERS.contains(&word.as_str())) {
        return None;
    }
    let of_seen = |kind: SeenKind| Column {
        meaning: Meaning::Seen(kind),
        owner: owner(&words[..words.len().saturating_sub(1)]),
    };
    match words.last()?.as_str() {
        word if SEEN.contains(&word) => return Some(of_seen(SeenKind::Tracked)),
        "lost" | "occluded" | "missing" => return Some(of_seen(SeenKind::Lost)),
        "residual" => return Some(of_seen(SeenKind::Residual)),
        _ => {}
    }
    // The axis is said by the last word, or by the first.
    let (last, before) = words.split_last()?;
    let found = part(last, before, unit).or_else(|| {
        let (first, after) = words.split_first()?;
        part(first, after, unit)
    });
    let (meaning, owner) = found?;
    Some(Column { meaning, owner })
}

/// What a column with a name holds, whosever it is.
pub(super) fn meaning(name: &str) -> Option<Meaning> {
    column(name).map(|column| column.meaning)
}

/// Whether a name that is not read looks as if it were of an orientation.
pub(super) fn looks_turned(name: &str) -> bool {
    if column(name)
        .is_some_and(|of| of.meaning.is_turn() || matches!(of.meaning, Meaning::Imaginary(_)))
    {
        return true;
    }
    let (words, _) = words(name);
    // Letters by themselves are numbers of parts here.
    let is_other = words
        .iter()
        .any(|word| word.len() > 1 && OTHERS.contains(&word.as_str()));
    let is_turn = |word: &String| {
        let known = QUATERNIONS[..3]
            .iter()
            .chain(&TURNS)
            .chain(&ANGLES[1..])
            .chain(&VECTORS);
        let mut known = known.chain(ROLL_PITCH_YAW.iter().map(|(name, _)| name));
        let word = word.trim_end_matches(|of: char| of.is_ascii_digit());
        known.any(|known| *known == word)
    };
    !is_other
        && (words.iter().any(is_turn) || words == ["w"] || words.iter().any(|word| word == "axis"))
}

fn time(words: &[String], unit: Option<&str>) -> Option<Meaning> {
    let last = words.last()?.as_str();
    let is_alone = words.len() == 1;
    let rank = match last {
        "stamp" => Some(4),
        "timestamp" | "timestamps" => Some(3),
        "time" | "times" | "clock" | "datetime" => Some(2),
        "t" => Some(1),
        // `time_ms` is taken apart before; `millis` is a name of its own.
        "sec" | "secs" | "seconds" | "nsec" | "nsecs" | "nanosec" | "nanosecs" | "nanoseconds"
        | "millis" | "milliseconds" | "micros" | "microseconds" | "nanos" | "ticks" | "tick"
        | "filetime"
            if is_alone =>
        {
            Some(1)
        }
        "elapsed" => Some(1),
        _ => None,
    };
    if let Some(rank) = rank {
        let unit = unit.or((rank == 1).then_some(last));
        let unit = unit.and_then(TimeUnit::of);
        return Some(Meaning::Time { rank, unit });
    }
    let is_frame = matches!(last, "frame" | "frames")
        || matches!(
            words.join(" ").as_str(),
            "frame number"
                | "frame no"
                | "frame num"
                | "frame idx"
                | "frame index"
                | "index"
                | "field"
        );
    is_frame.then_some(Meaning::Frame)
}

/// Whose a column is, by the words that say nothing else.
fn owner(words: &[String]) -> String {
    let said = |word: &&String| {
        let word = word.as_str();
        let known = [
            &POSITIONS[..],
            &QUATERNIONS,
            &TURNS,
            &ANGLES,
            &VECTORS,
            &FILLERS,
        ];
        !known.iter().any(|known| known.contains(&word))
    };
    let left: Vec<&str> = words.iter().filter(said).map(String::as_str).collect();
    left.join("_")
}

/// What a word that ends in a letter or digits stands for, among the others of its name.
fn part(word: &str, others: &[String], unit: Option<&str>) -> Option<(Meaning, String)> {
    let angle_unit = unit.and_then(AngleUnit::of);
    let length = unit.and_then(length_unit);
    if let Some((_, axis)) = ROLL_PITCH_YAW.iter().find(|(name, _)| *name == word) {
        let (axis, kind) = (*axis, AngleKind::Rpy);
        let unit = angle_unit;
        return Some((Meaning::Angle { axis, kind, unit }, owner(others)));
    }
    if let Some(found) = counted(word, others) {
        return Some(found);
    }
    let with = |meaning: Meaning| Some((meaning, owner(others)));
    let is_named = |of: &str| others.iter().any(|word| word == of);
    let imaginary = match word {
        "i" | "qi" => Some(0),
        "j" | "qj" => Some(1),
        "k" | "qk" => Some(2),
        "real" | "scalar" | "qr" | "qs" | "qreal" => Some(3),
        "r" if QUATERNIONS.iter().any(|of| is_named(of)) => Some(3),
        _ => None,
    };
    if let Some(part) = imaginary {
        let is_quaternion = word.starts_with('q') || QUATERNIONS.iter().any(|of| is_named(of));
        let unit = angle_unit;
        let is_angle = false;
        return with(match is_quaternion {
            true => Meaning::Quaternion {
                part,
                is_angle,
                unit,
            },
            false => Meaning::Imaginary(part),
        });
    }
    let letter = word.chars().next_back()?;
    let axis = "xyzw".find(letter)?;
    // `qx`, `pos_x`, `field.pose.position.x`, `p_RS_R_x`, `x`.
    let stem = &word[..word.len() - letter.len_utf8()];
    let is_of = |known: &[&str]| match stem {
        "" => known.iter().any(|of| is_named(of)),
        stem => known.contains(&stem),
    };
    let unit = angle_unit;
    let is_loose = is_of(&TURNS);
    if is_of(&QUATERNIONS) || is_loose {
        return with(Meaning::Quaternion {
            part: axis,
            is_angle: is_loose,
            unit,
        });
    }
    if is_of(&VECTORS) {
        let kind = AngleKind::Vector;
        return with(Meaning::Angle { axis, kind, unit });
    }
    let is_euler = is_of(&ANGLES[1..]);
    if !is_euler && axis < 3 && is_of(&POSITIONS) {
        return with(Meaning::Position { axis, unit: length });
    }
    // `r` alone: it stands in names of frames, too.
    let is_r = stem == "r" || stem.is_empty() && others.iter().eq(["r"].iter());
    if is_euler || is_r {
        let kind = AngleKind::Untold;
        return with(Meaning::Angle { axis, kind, unit });
    }
    stem.is_empty()
        .then_some(Meaning::Letter { axis, unit: length })
        .and_then(with)
}

/// A part by number: `q0`, `Rot[3]`, `R_12`, `m03`, `position_2`.
fn counted(word: &str, others: &[String]) -> Option<(Meaning, String)> {
    let is_digit = |of: char| of.is_ascii_digit();
    let stem = word.trim_end_matches(is_digit);
    let mut digits = word[stem.len()..].to_owned();
    let mut left = others;
    let mut stem = stem;
    if stem.is_empty() {
        // The words before, or `R_1_2`.
        while let Some((last, rest)) = left.split_last() {
            left = rest;
            if last.chars().all(is_digit) {
                digits = format!("{last}{digits}");
            } else {
                stem = last;
                break;
            }
        }
    }
    let digits: Vec<usize> = digits
        .chars()
        .filter_map(|of| of.to_digit(10))
        .map(|of| of as usize)
        .collect();
    let is_turn = QUATERNIONS.contains(&stem) || TURNS.contains(&stem);
    let meaning = match digits[..] {
        [row, column] if MATRICES.contains(&stem) && row <= 4 && column <= 4 => {
            Meaning::Entry { row, column }
        }
        [number] if (is_turn || stem == "dcm") && number <= 9 => Meaning::Numbered(number),
        [number] if COUNTED.contains(&stem) && number <= 3 => Meaning::Coordinate(number),
        _ => return None,
    };
    Some((meaning, owner(left)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_programs_are_understood() {
        let at = |axis, unit| Some(Meaning::Position { axis, unit });
        let letter = |axis, unit| Some(Meaning::Letter { axis, unit });
        let time = |rank, unit| Some(Meaning::Time { rank, unit });
        let quaternion = |part| {
            let (is_angle, unit) = (false, None);
            Some(Meaning::Quaternion {
                part,
                is_angle,
                unit,
            })
        };
        let loose = |part, unit| {
            let is_angle = true;
            Some(Meaning::Quaternion {
                part,
                is_angle,
                unit,
            })
        };
        let angle = |axis, kind, unit| Some(Meaning::Angle { axis, kind, unit });
        let (ns, s) = (Some(TimeUnit::Nanosecond), Some(TimeUnit::Second));
        let deg = Some(AngleUnit::Degree);
        for (name, expected) in [
            ("#timestamp [ns]", time(3, ns)),
            ("# timestamp", time(3, None)),
            ("t", time(1, None)),
            ("t_ms", time(1, Some(TimeUnit::Millisecond))),
            ("Time (Seconds)", time(2, s)),
            ("seconds", time(1, s)),
            ("nsec", time(1, ns)),
            ("ticks", time(1, Some(TimeUnit::Tick))),
            ("time_µs", time(2, Some(TimeUnit::Microsecond))),
            ("field.header.stamp", time(4, None)),
            ("header.stamp.nanosec", time(4, ns)),
            ("/pose/header/stamp/sec", time(4, s)),
            ("rosbagTimestamp", time(3, None)),
            ("Frame", Some(Meaning::Frame)),
            ("frame_number", Some(Meaning::Frame)),
            ("p_RS_R_x [m]", at(0, Some(LengthUnit::Metre))),
            ("field.pose.pose.position.z", at(2, None)),
            ("tx", at(0, None)),
            ("posY", at(1, None)),
            ("x_mm", letter(0, Some(LengthUnit::Millimetre))),
            ("Z (cm)", letter(2, Some(LengthUnit::Centimetre))),
            ("W", letter(3, None)),
            ("q_RS_w []", quaternion(3)),
            ("qx", quaternion(0)),
            ("ow", quaternion(3)),
            ("qi", quaternion(0)),
            ("qr", quaternion(3)),
            ("j", Some(Meaning::Imaginary(1))),
            ("RotationW", loose(3, None)),
            ("RotX (deg)", loose(0, deg)),
            ("field.pose.orientation.y", loose(1, None)),
            ("q3", Some(Meaning::Numbered(3))),
            ("position[1]", Some(Meaning::Coordinate(1))),
            ("quat_r", quaternion(3)),
            ("Rot[8]", Some(Meaning::Numbered(8))),
            ("R12", Some(Meaning::Entry { row: 1, column: 2 })),
            ("m_0_3", Some(Meaning::Entry { row: 0, column: 3 })),
            ("rx [deg]", angle(0, AngleKind::Untold, deg)),
            ("roll", angle(0, AngleKind::Rpy, None)),
            ("Yaw [°]", angle(2, AngleKind::Rpy, deg)),
            ("pitch_deg", angle(1, AngleKind::Rpy, deg)),
            ("rvec_z", angle(2, AngleKind::Vector, None)),
            ("child_frame_id", Some(Meaning::Body)),
            ("rigid body", Some(Meaning::Body)),
            ("marker", Some(Meaning::Body)),
            ("tracking_valid", Some(Meaning::Seen(SeenKind::Tracked))),
            ("Residual", Some(Meaning::Seen(SeenKind::Residual))),
            ("v_RS_R_x [m s^-1]", None),
            ("b_w_RS_S_x [rad s^-1]", None),
            ("angular_velocity.x", None),
            ("field.header.frame_id", None),
            ("field.header.seq", None),
            ("yaw_rate", None),
            ("index_finger", None),
            ("", None),
        ] {
            assert_eq!(meaning(name), expected, "{name}");
        }
    }

    #[test]
    fn names_say_whose_a_column_is() {
        for (name, owner) in [
            ("x", ""),
            ("field.pose.position.x", ""),
            ("cup_x", "cup"),
            ("cup.rotation.w", "cup"),
            ("/vrpn/hand/pose/position/x", "vrpn_hand"),
            ("qx_cup", "cup"),
        ] {
            assert_eq!(
                column(name).map(|of| of.owner).as_deref(),
                Some(owner),
                "{name}"
            );
        }
    }

    #[test]
    fn what_looks_like_an_orientation_is_known() {
        for name in [
            "Rotation A",
            "quat_a",
            "heading",
            "qw",
            "w",
            "k",
            "Euler1",
            "R21",
            "ori_2",
        ] {
            assert!(looks_turned(name), "{name}");
        }
        for name in [
            "x",
            "seq",
            "marker error",
            "angular_velocity",
            "residual",
            "frame_id",
        ] {
            assert!(!looks_turned(name), "{name}");
        }
    }
}
