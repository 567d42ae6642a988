//! Checks of numbers, names, vectors and poses; errors point to their place in the text.

use std::collections::BTreeSet;

use crate::config::spanned::Spanned;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::error::{Fault, fault};
use super::raw::{Number, Quadruple, Text, Triple};
use crate::math::Pose;

/// Greatest deviation of the norm of a quaternion from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Longest name [characters].
const NAME_LENGTH: usize = 64;

/// A finite number.
pub(super) fn finite(what: &str, number: &Number) -> Result<f64, Fault> {
    let value = *number.get_ref();
    if value.is_finite() {
        Ok(value)
    } else {
        fault(
            number.span(),
            format!("{what} is {value}, expected a finite number"),
        )
    }
}

/// A finite number above zero.
pub(super) fn positive(what: &str, number: &Number) -> Result<f64, Fault> {
    let value = finite(what, number)?;
    if value > 0.0 {
        Ok(value)
    } else {
        fault(
            number.span(),
            format!("{what} is {value}, expected a positive number"),
        )
    }
}

/// A finite number, zero or more.
pub(super) fn not_negative(what: &str, number: &Number) -> Result<f64, Fault> {
    let value = finite(what, number)?;
    if value >= 0.0 {
        Ok(value)
    } else {
        fault(
            number.span(),
            format!("{what} is {value}, expected zero or more"),
        )
    }
}

/// Three finite numbers.
pub(super) fn vector(what: &str, triple: &Triple) -> Result<Vector3<f64>, Fault> {
    let value = Vector3::from(*triple.get_ref());
    if value.iter().all(|x| x.is_finite()) {
        Ok(value)
    } else {
        fault(
            triple.span(),
            format!(
                "{what} is [{}, {}, {}], expected three finite numbers",
                value.x, value.y, value.z
            ),
        )
    }
}

/// Three finite numbers, from millimetres to metres.
pub(super) fn vector_from_mm(what: &str, triple: &Triple) -> Result<Vector3<f64>, Fault> {
    Ok(vector(what, triple)? / 1e3)
}

/// A unit vector from one of any length but zero.
pub(super) fn direction(what: &str, triple: &Triple) -> Result<Vector3<f64>, Fault> {
    let value = vector(what, triple)?;
    // Scaled by its largest component first, so that no square under- or overflows.
    let largest = value.amax();
    if largest > 0.0 {
        return Ok((value / largest).normalize());
    }
    fault(
        triple.span(),
        format!("{what} is zero, expected a direction"),
    )
}

/// A unit quaternion `[w, x, y, z]`, world from body.
pub(super) fn orientation(what: &str, wxyz: &Quadruple) -> Result<UnitQuaternion<f64>, Fault> {
    let [w, x, y, z] = *wxyz.get_ref();
    let quaternion = Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    // Not `> UNIT_TOLERANCE`: a norm that is NaN is no unit either.
    if (norm - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(Unit::new_normalize(quaternion))
    } else {
        fault(
            wxyz.span(),
            format!(
                "{what} has norm {norm}, expected a unit quaternion [w, x, y, z] within {UNIT_TOLERANCE}"
            ),
        )
    }
}

/// An orientation as a unit quaternion, or as angles about x, then y, then z of the axes in which it is given
/// (roll, pitch, yaw); `None` where neither is given.
pub(super) fn orientation_in_either(
    what: &str,
    wxyz: Option<&Quadruple>,
    rpy_deg: Option<&Triple>,
) -> Result<Option<UnitQuaternion<f64>>, Fault> {
    match (wxyz, rpy_deg) {
        (None, None) => Ok(None),
        (Some(wxyz), None) => orientation(what, wxyz).map(Some),
        (None, Some(angles)) => {
            let angles_deg = vector("rpy_deg", angles)?;
            let [roll, pitch, yaw]: [f64; 3] = angles_deg.map(f64::to_radians).into();
            Ok(Some(UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
        }
        (Some(_), Some(angles)) => fault(
            angles.span(),
            format!("{what} is given twice, expected one of orientation_wxyz, rpy_deg"),
        ),
    }
}

/// A pose from its parts; a part that is left out is the identity.
pub(super) fn pose(
    what: &str,
    position_mm: Option<&Triple>,
    orientation: (Option<&Quadruple>, Option<&Triple>),
) -> Result<Pose, Fault> {
    let position_m = match position_mm {
        Some(position) => vector_from_mm(&format!("position of {what}"), position)?,
        None => Vector3::zeros(),
    };
    let (wxyz, rpy_deg) = orientation;
    let rotation = orientation_in_either(&format!("orientation of {what}"), wxyz, rpy_deg)?;
    let rotation = rotation.unwrap_or_else(UnitQuaternion::identity);
    Ok(Pose::from_parts(position_m.into(), rotation))
}

/// A name that is valid in reports and topics.
pub(super) fn name(what: &str, text: &Text) -> Result<String, Fault> {
    let name = text.get_ref();
    let complaint = if name.trim().is_empty() {
        "is empty"
    } else if name.trim() != name {
        "begins or ends with a space"
    } else if name.chars().any(char::is_control) {
        "has a control character in it"
    } else if name.chars().count() > NAME_LENGTH {
        "has more than 64 characters"
    } else {
        return Ok(name.clone());
    };
    fault(
        text.span(),
        format!("the name of the {what} {complaint}, expected a short plain name"),
    )
}

/// A topic: begins with a slash, no spaces.
pub(super) fn topic(what: &str, text: &Text) -> Result<String, Fault> {
    let topic = text.get_ref();
    let plain = !topic.chars().any(|c| c.is_whitespace() || c.is_control());
    if !topic.is_empty() && plain {
        Ok(topic.clone())
    } else {
        fault(
            text.span(),
            format!("{what} is {topic:?}, expected a topic without spaces, such as \"/marks\""),
        )
    }
}

/// Index of a name among the defined ones.
pub(super) fn index_of<'a>(
    what: &str,
    text: &Text,
    defined: impl IntoIterator<Item = &'a str>,
) -> Result<usize, Fault> {
    let wanted = text.get_ref();
    let mut others = Vec::new();
    for (index, name) in defined.into_iter().enumerate() {
        if name == wanted {
            return Ok(index);
        }
        others.push(name);
    }
    let defined = others;
    let expected = match defined.as_slice() {
        [] => format!("but no {what} is defined"),
        [one] => format!("expected {one:?}"),
        many => format!("expected one of {}", quoted(many)),
    };
    fault(
        text.span(),
        format!("unknown {what} {wanted:?}, {expected}"),
    )
}

/// Names that are taken, of many: [`unique`] looks through all of them.
#[derive(Default)]
pub(super) struct Taken(BTreeSet<String>);

impl Taken {
    /// Takes a name. Refuses the second of two equal ones.
    pub(super) fn take<T>(
        &mut self,
        what: &str,
        text: &Spanned<T>,
        name: &str,
    ) -> Result<(), Fault> {
        let is_new = self.0.insert(name.to_owned());
        let before = if is_new { None } else { Some(name) };
        unique(what, text, name, before)
    }
}

/// Refuses the second of two equal names.
pub(super) fn unique<'a, T>(
    what: &str,
    text: &Spanned<T>,
    name: &str,
    before: impl IntoIterator<Item = &'a str>,
) -> Result<(), Fault> {
    if before.into_iter().any(|other| other == name) {
        return fault(
            text.span(),
            format!("a second {what} {name:?}, expected a name of its own"),
        );
    }
    Ok(())
}

/// Names in quotes, with commas.
pub(super) fn quoted(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
    quoted.join(", ")
}
