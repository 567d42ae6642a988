//! What the names of columns mean.

use super::units::{TimeUnit, length_unit};
use crate::motion::LengthUnit;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A time; of several that of the highest rank is read.
    Time { rank: u8, unit: Option<TimeUnit> },
    /// The number of a frame.
    Frame,
    /// A coordinate.
    Position {
        axis: usize,
        unit: Option<LengthUnit>,
    },
    /// A part of a quaternion by name: x, y, z, w.
    Quaternion(usize),
    /// A part of a quaternion by number.
    Numbered(usize),
    /// An angle, if no w stands beside them.
    Angle { axis: usize, is_degree: bool },
    /// The name of the body.
    Body,
}

/// The words of a name in lower case, and the unit in brackets.
fn words(name: &str) -> (Vec<String>, Option<String>) {
    let name = name.trim().trim_matches(['#', '%', '"', '\'']).trim();
    let (name, bracketed) = match name.find(['[', '(']) {
        Some(at) => {
            let unit = name[at + 1..].trim_end_matches([']', ')', ' ']);
            (&name[..at], Some(unit.to_lowercase()))
        }
        None => (name, None),
    };
    let mut words: Vec<String> = vec![String::new()];
    let mut was_lower = false;
    for character in name.chars() {
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
    (words, bracketed.filter(|unit| !unit.is_empty()))
}

const POSITIONS: [&str; 11] = [
    "",
    "p",
    "t",
    "pos",
    "position",
    "trans",
    "translation",
    "loc",
    "location",
    "com",
    "point",
];
const QUATERNIONS: [&str; 9] = [
    "q",
    "quat",
    "quaternion",
    "orientation",
    "orient",
    "ori",
    "rot",
    "rotation",
    "attitude",
];
/// What a column with a name holds, if poses need it.
pub(super) fn meaning(name: &str) -> Option<Meaning> {
    let (mut words, mut unit) = words(name);
    let is_unit = |word: &str| TimeUnit::of(word).is_some() || length_unit(word).is_some();
    if unit.is_none() && words.len() > 1 && words.last().is_some_and(|word| is_unit(word)) {
        unit = words.pop();
    }
    let unit = unit.as_deref();
    let last = words.last()?.as_str();
    let joined = words.join(" ");
    if [
        "body",
        "object",
        "name",
        "tracker",
        "device",
        "marker",
        "rigid body",
        "child frame id",
    ]
    .contains(&joined.as_str())
    {
        return Some(Meaning::Body);
    }
    let rank = match last {
        "stamp" => Some(4),
        "timestamp" | "timestamps" => Some(3),
        "time" | "times" | "clock" => Some(2),
        "t" => Some(1),
        // `time_ms` is taken apart above; `millis` is a name of its own.
        "secs" | "seconds" | "millis" | "micros" | "nanos" if words.len() == 1 => Some(1),
        _ => None,
    };
    if let Some(rank) = rank {
        let unit = unit.or((rank == 1).then_some(last));
        return Some(Meaning::Time {
            rank,
            unit: unit.and_then(TimeUnit::of),
        });
    }
    if matches!(last, "frame" | "frames")
        || matches!(
            joined.as_str(),
            "frame number" | "frame no" | "frame index" | "index"
        )
    {
        return Some(Meaning::Frame);
    }
    part(&words, unit)
}

/// What one letter of a vector or a quaternion stands for.
fn part(words: &[String], unit: Option<&str>) -> Option<Meaning> {
    let last = words.last()?;
    let letter = last.chars().next_back()?;
    let stem = &last[..last.len() - letter.len_utf8()];
    let before = &words[..words.len() - 1];
    // `qx`, `pos_x`, `field.pose.position.x`, `p_RS_R_x`, `x`.
    let is_of = |known: &[&str]| {
        if !stem.is_empty() {
            return known.contains(&stem);
        }
        match before {
            [] => known.contains(&""),
            before => before.iter().any(|word| known.contains(&word.as_str())),
        }
    };
    if let Some(number) = letter.to_digit(10)
        && (is_of(&QUATERNIONS) && number < 4)
    {
        return Some(Meaning::Numbered(number as usize));
    }
    let axis = "xyzw".find(letter)?;
    if is_of(&QUATERNIONS) {
        return Some(Meaning::Quaternion(axis));
    }
    let is_angle = stem == "r" || stem.is_empty() && before.iter().eq(["r"].iter());
    if is_angle {
        return Some(Meaning::Angle {
            axis,
            is_degree: unit.is_some_and(|unit| unit.starts_with("deg")),
        });
    }
    (axis < 3 && is_of(&POSITIONS)).then_some(Meaning::Position {
        axis,
        unit: unit.and_then(length_unit),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_programs_are_understood() {
        let at = |axis, unit| Some(Meaning::Position { axis, unit });
        let time = |rank, unit| Some(Meaning::Time { rank, unit });
        let (ns, s) = (Some(TimeUnit::Nanosecond), Some(TimeUnit::Second));
        for (name, expected) in [
            ("#timestamp [ns]", time(3, ns)),
            ("# timestamp", time(3, None)),
            ("t", time(1, None)),
            ("t_ms", time(1, Some(TimeUnit::Millisecond))),
            ("Time (Seconds)", time(2, s)),
            ("seconds", time(1, s)),
            ("time_µs", time(2, Some(TimeUnit::Microsecond))),
            ("field.header.stamp", time(4, None)),
            ("header.stamp.nanosec", time(4, ns)),
            ("/pose/header/stamp/sec", time(4, s)),
            ("Frame", Some(Meaning::Frame)),
            ("frame_number", Some(Meaning::Frame)),
            ("p_RS_R_x [m]", at(0, Some(LengthUnit::Metre))),
            ("field.pose.pose.position.z", at(2, None)),
            ("tx", at(0, None)),
            ("posY", at(1, None)),
            ("x_mm", at(0, Some(LengthUnit::Millimetre))),
            ("Z (cm)", at(2, Some(LengthUnit::Centimetre))),
            ("q_RS_w []", Some(Meaning::Quaternion(3))),
            ("qx", Some(Meaning::Quaternion(0))),
            ("RotationW", Some(Meaning::Quaternion(3))),
            ("field.pose.orientation.y", Some(Meaning::Quaternion(1))),
            ("q3", Some(Meaning::Numbered(3))),
            (
                "rx [deg]",
                Some(Meaning::Angle {
                    axis: 0,
                    is_degree: true,
                }),
            ),
            ("child_frame_id", Some(Meaning::Body)),
            ("rigid body", Some(Meaning::Body)),
            ("marker", Some(Meaning::Body)),
            ("v_RS_R_x [m s^-1]", None),
            ("b_w_RS_S_x [rad s^-1]", None),
            ("field.header.frame_id", None),
            ("field.header.seq", None),
            ("angle", None),
            ("index_finger", None),
            ("", None),
        ] {
            assert_eq!(meaning(name), expected, "{name}");
        }
    }
}
