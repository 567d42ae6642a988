//! Goals at rest.

use std::ops::Range;

use crate::config::spanned::Spanned;
use nalgebra::Vector3;

use super::error::{Fault, fault};
use super::event::link_of;
use super::held::check_goal;
use super::number::{direction, positive};
use super::raw::{RawGoal, Text};
use crate::motion::{Link, RestGoal, Scene};
use crate::physics::contact;

/// The event of goals at rest: no event of a scene, but what follows the last.
const REST: &str = "rest";

/// Angle within which a face is up, unless the scene says another \[deg\].
const WITHIN_DEG: f64 = 10.0;

/// Some of a scene's goals.
type Goals<'a> = Vec<&'a Spanned<RawGoal>>;

/// The goals at rest, which have `face_up`, and those at events.
pub(super) fn split(raw: &[Spanned<RawGoal>]) -> [Goals<'_>; 2] {
    let (at_rest, at_events): (Goals, Goals) = raw
        .iter()
        .partition(|spanned| spanned.get_ref().face_up.is_some());
    [at_rest, at_events]
}

/// Goals at rest, each of a body that exists, none twice.
pub(super) fn rest_goals(raw: &[&Spanned<RawGoal>], scene: &Scene) -> Result<Vec<RestGoal>, Fault> {
    let mut goals: Vec<RestGoal> = Vec::new();
    for spanned in raw {
        let raw = spanned.get_ref();
        let Some(face_up) = &raw.face_up else {
            continue;
        };
        let goal = rest_goal(raw, face_up, scene)?;
        if goals.iter().any(|other| other.link == goal.link) {
            let name = &scene.links[goal.link].name;
            return fault(
                spanned.span(),
                format!("a second goal for {name:?} at rest, expected one"),
            );
        }
        goals.push(goal);
    }
    Ok(goals)
}

fn rest_goal(goal: &RawGoal, face_up: &Text, scene: &Scene) -> Result<RestGoal, Fault> {
    if goal.event.get_ref() != REST {
        return fault(
            goal.event.span(),
            "face_up holds when all has come to rest, expected event = \"rest\"",
        );
    }
    let own = ["face_up", "direction", "within_deg", "labels"];
    if let Some((key, span)) = goal.given().find(|(key, _)| !own.contains(key)) {
        return fault(span, format!("{key} does not apply to a goal at rest"));
    }
    if scene.settle_s.is_none() {
        return fault(
            goal.event.span(),
            "nothing comes to rest in this scene, expected settle_s, such as settle_s = 5",
        );
    }
    let Some(body) = &goal.body else {
        return fault(face_up.span(), "missing key `body`: whose face is up");
    };
    let link = link_of(body, scene)?;
    check_goal(body, link, scene)?;
    Ok(RestGoal {
        link,
        name: face_up.get_ref().clone(),
        axis: axis(
            "face_up",
            &scene.links[link],
            face_up.get_ref(),
            face_up.span(),
        )?,
        direction: match &goal.direction {
            Some(given) => direction("direction", given)?,
            None => up(face_up, scene)?,
        },
        within_rad: within_rad(goal)?,
        labels_are_free: labels_are_free(goal.labels.as_ref())?,
    })
}

fn up(face_up: &Text, scene: &Scene) -> Result<Vector3<f64>, Fault> {
    let up = scene.gravity_m_s2.try_normalize(0.0).map(|down| -down);
    up.ok_or_else(|| Fault {
        span: face_up.span(),
        message: "without gravity nothing is up, expected direction beside face_up".into(),
    })
}

/// A body axis such as `+z`, or the normal of one of its faces.
pub(super) fn axis(
    key: &str,
    link: &Link,
    name: &str,
    span: Range<usize>,
) -> Result<Vector3<f64>, Fault> {
    let signed = [("+", 1.0), ("-", -1.0)]
        .into_iter()
        .find_map(|(prefix, sign)| {
            let axis = ["x", "y", "z"];
            let axis = axis
                .iter()
                .position(|axis| name.strip_prefix(prefix) == Some(axis))?;
            Some(link.link_from_given.rotation * Vector3::ith(axis, sign))
        });
    let faces = link
        .features
        .iter()
        .filter_map(|feature| match feature.geometry {
            contact::Feature::Face { normal, .. } => Some((feature.name.as_str(), normal)),
            _ => None,
        });
    let faces: Vec<(&str, Vector3<f64>)> = faces.collect();
    let face = faces.iter().find(|(face, _)| *face == name);
    signed.or(face.map(|(_, normal)| *normal)).ok_or_else(|| {
        let names: Vec<&str> = ["+x", "-x", "+y", "-y", "+z", "-z"]
            .into_iter()
            .chain(faces.iter().map(|(name, _)| *name))
            .collect();
        Fault {
            span,
            message: format!(
                "{key} is {name:?}, expected an axis or a face of {:?}: {}",
                link.name,
                names.join(", ")
            ),
        }
    })
}

fn within_rad(goal: &RawGoal) -> Result<f64, Fault> {
    let Some(number) = &goal.within_deg else {
        return Ok(WITHIN_DEG.to_radians());
    };
    let within_deg = positive("within_deg", number)?;
    if within_deg >= 90.0 {
        return fault(
            number.span(),
            format!("within_deg is {within_deg}, expected less than 90"),
        );
    }
    Ok(within_deg.to_radians())
}

fn labels_are_free(labels: Option<&Text>) -> Result<bool, Fault> {
    match labels.map(|text| (text, text.get_ref().as_str())) {
        None | Some((_, "fixed")) => Ok(false),
        Some((_, "free")) => Ok(true),
        Some((text, other)) => fault(
            text.span(),
            format!("labels are {other:?}, expected \"fixed\" or \"free\""),
        ),
    }
}
