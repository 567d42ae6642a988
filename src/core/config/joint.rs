//! Joints: `[[joint]]` tables tie bodies to trees.

mod refused;

pub(super) use refused::{refuse, refuse_dependent};

use std::ops::Range;

use crate::config::spanned::Spanned;
use nalgebra::{Point3, UnitQuaternion, Vector3};

use super::error::{Fault, fault};
use super::event::link_of;
use super::number::{direction, name, not_negative, orientation, unique, vector_from_mm};
use super::raw::{Number, RawJoint, RawScene, Triple};
use crate::math::Pose;
use crate::motion::{Joint, JointTree, LinkIndex, Mechanism, Scene};
use crate::physics::tree::{self, JointKind};

/// Ties the scene's bodies together: those that joints connect become one mechanism.
pub(super) fn join(raw: &RawScene, scene: &mut Scene) -> Result<(), Fault> {
    let mut joints: Vec<(Joint, Range<usize>)> = Vec::new();
    let lasting = |of: &&Spanned<RawJoint>| !of.get_ref().is_for_a_while();
    for spanned in raw.joint.iter().filter(lasting) {
        let joint = joint(spanned, scene)?;
        let taken = joints.iter().map(|(of, _)| of.name.as_str());
        unique("joint", &spanned.get_ref().name, &joint.name, taken)?;
        if let Some((other, _)) = joints.iter().find(|(of, _)| of.child == joint.child) {
            let said = format!(
                "{:?} hangs from {:?} already, expected one joint for each child: bodies form trees, not circles",
                scene.links[joint.child].name, other.name
            );
            return fault(spanned.get_ref().child.span(), said);
        }
        joints.push((joint, spanned.span()));
    }
    let Some(first) = joints.first().map(|(_, span)| span.clone()) else {
        return Ok(());
    };
    let mut mechanisms: Vec<Mechanism> = Vec::new();
    let mut left = joints;
    for link in scene.links.keys() {
        let is_child = |(of, _): &(Joint, Range<usize>)| of.child == link;
        let is_root =
            |(of, _): &(Joint, Range<usize>)| of.child == link && hangs_outside(scene, of);
        let is_base = !left.iter().any(is_child);
        let is_parent = left.iter().any(|(of, _)| of.parent == Some(link));
        let is_free = is_base && (!is_parent || scene.is_held(link));
        if is_free && !mechanisms.iter().any(|of| of.links().any(|l| l == link)) {
            mechanisms.push(Mechanism::Free(link));
        } else if is_base && is_parent || left.iter().any(is_root) {
            let base = is_base.then_some(link);
            mechanisms.push(Mechanism::Tree(taken(scene, base, link, &mut left)));
        }
    }
    if let Some((of, span)) = left.first() {
        let said = format!(
            "{:?} ties bodies to a circle, expected a tree: each child hangs from a parent, and the first from the world, a held body or nothing",
            of.name
        );
        return fault(span.clone(), said);
    }
    for tree in mechanisms.iter().filter_map(Mechanism::tree) {
        let model = tree.model(|link| scene.links[link].body);
        if let Err(error) = model {
            return fault(
                first.clone(),
                format!("the joints allow no motion: {error}"),
            );
        }
    }
    let moving = mechanisms.iter().flat_map(Mechanism::links);
    let has_hand = moving.into_iter().any(|link| scene.is_held(link));
    if has_hand && let Some(settle_s) = &raw.settle_s {
        let said = "joined bodies are not continued beside a held one, expected no settle_s";
        return fault(settle_s.span(), said);
    }
    scene.mechanisms = mechanisms.into();
    for (index, mechanism) in scene.mechanisms.iter_enumerated() {
        for link in mechanism.links() {
            scene.links[link].mechanism = index;
        }
    }
    refused::refuse_neighbours(raw, scene)
}

/// The tree that begins with a link, whose joints are taken out of those left.
fn taken(
    scene: &Scene,
    base: Option<LinkIndex>,
    first: LinkIndex,
    left: &mut Vec<(Joint, Range<usize>)>,
) -> JointTree {
    let mut known = vec![first];
    let mut joints = Vec::new();
    let is_root = |(of, _): &(Joint, Range<usize>)| of.child == first && hangs_outside(scene, of);
    if let Some(at) = left.iter().position(is_root) {
        joints.push(left.remove(at).0);
    }
    let hangs = |of: &Joint, known: &[LinkIndex]| of.parent.is_some_and(|of| known.contains(&of));
    while let Some(at) = left.iter().position(|(of, _)| hangs(of, &known)) {
        let (joint, _) = left.remove(at);
        known.push(joint.child);
        joints.push(joint);
    }
    JointTree { base, joints }
}

/// Whether a joint begins a tree: what it hangs from is no part of that.
fn hangs_outside(scene: &Scene, joint: &Joint) -> bool {
    joint.parent.is_none_or(|parent| scene.is_held(parent))
}

/// One joint, as its table says.
pub(super) fn joint(spanned: &Spanned<RawJoint>, scene: &Scene) -> Result<Joint, Fault> {
    let raw = spanned.get_ref();
    let name = name("joint", &raw.name)?;
    let child = link_of(&raw.child, scene)?;
    let parent = raw.parent.as_ref().map(|text| link_of(text, scene));
    let parent = parent.transpose()?;
    if parent == Some(child) {
        return fault(
            raw.child.span(),
            "a body hangs from itself, expected another",
        );
    }
    if scene.is_held(child) {
        let said = format!(
            "{:?} is held and goes where it was tracked, expected it as the parent of what hangs from it",
            scene.links[child].name
        );
        return fault(raw.child.span(), said);
    }
    let kind = kind(spanned)?;
    // In link axes; where no place is given, in the centre of mass.
    let placed = |of: Option<LinkIndex>, key: &str, triple: &Option<Triple>, turn| {
        let link_from_given =
            of.map_or_else(Pose::identity, |link| scene.links[link].link_from_given);
        let at_m = match triple {
            Some(triple) => {
                let at_m = vector_from_mm(key, triple)?;
                (link_from_given * Point3::from(at_m)).coords
            }
            None => Vector3::zeros(),
        };
        Ok(Pose::from_parts(
            at_m.into(),
            link_from_given.rotation * turn,
        ))
    };
    let turned = match &raw.child_orientation_wxyz {
        Some(wxyz) => orientation("child_orientation_wxyz", wxyz)?,
        None => UnitQuaternion::identity(),
    };
    let number = |key: &str, number: &Option<Number>| match number {
        Some(number) => not_negative(key, number),
        None => Ok(0.0),
    };
    let along = UnitQuaternion::identity();
    let mut made = tree::Joint::new(
        kind,
        placed(parent, "parent_at_mm", &raw.parent_at_mm, along)?,
        placed(
            Some(child),
            "child_at_mm",
            &raw.child_at_mm,
            turned.inverse(),
        )?,
    );
    made.damping_n_m_s = number("damping_n_m_s", &raw.damping_n_m_s)?;
    made.stiffness_n_m = number("stiffness_n_m", &raw.stiffness_n_m)?;
    if let Some(limits) = &raw.limits_deg {
        made.limits_rad = limits_rad(limits, &kind)?;
    }
    let is_stiff = made.damping_n_m_s > 0.0 || made.stiffness_n_m > 0.0;
    if is_stiff && kind == JointKind::Fixed {
        let said = "a fixed joint has neither damping nor stiffness, expected another kind";
        return fault(raw.kind.span(), said);
    }
    Ok(Joint {
        name,
        parent,
        child,
        joint: made,
    })
}

/// Least and greatest angles, a pair for each axis.
fn limits_rad(limits: &Spanned<Vec<[f64; 2]>>, kind: &JointKind) -> Result<[[f64; 2]; 2], Fault> {
    let axes = match kind {
        JointKind::Pin { .. } => 1,
        JointKind::Universal { .. } => 2,
        _ => {
            let said = "limits are of angles, expected them of a pin or a universal joint alone";
            return fault(limits.span(), said);
        }
    };
    let given = limits.get_ref();
    if given.len() != axes {
        let said = format!(
            "limits_deg has {} pairs, expected {axes}: the least and the greatest angle about each axis",
            given.len()
        );
        return fault(limits.span(), said);
    }
    let mut limits_rad = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
    for (to, [least, greatest]) in limits_rad.iter_mut().zip(given) {
        if !(least < greatest) {
            let said =
                format!("limits_deg has [{least}, {greatest}], expected the least angle first");
            return fault(limits.span(), said);
        }
        *to = [least.to_radians(), greatest.to_radians()];
    }
    Ok(limits_rad)
}

fn kind(spanned: &Spanned<RawJoint>) -> Result<JointKind, Fault> {
    let raw = spanned.get_ref();
    let said = raw.kind.get_ref().as_str();
    let kind = match (said, &raw.axis, &raw.axes) {
        ("pin", Some(axis), None) => JointKind::Pin {
            axis: direction("axis", axis)?,
        },
        ("universal", None, Some(axes)) => {
            let axis = |of: usize| {
                let spanned = Spanned::new(axes.span(), axes.get_ref()[of]);
                direction("an axis", &spanned)
            };
            JointKind::Universal {
                axes: [axis(0)?, axis(1)?],
            }
        }
        ("ball", None, None) => JointKind::Ball,
        ("fixed", None, None) => JointKind::Fixed,
        ("pin", ..) => return fault(spanned.span(), "a pin needs axis, and no axes"),
        ("universal", ..) => {
            return fault(
                spanned.span(),
                "a universal joint needs axes, two of them, and no axis",
            );
        }
        ("ball" | "fixed", ..) => {
            let said = format!("a {said} joint has no axis, expected neither axis nor axes");
            return fault(spanned.span(), said);
        }
        (other, ..) => {
            let said = format!(
                "kind is {other:?}, expected \"pin\", \"universal\", \"ball\" or \"fixed\""
            );
            return fault(raw.kind.span(), said);
        }
    };
    Ok(kind)
}
