//! Links of a tree as the files for peers have them (`tools/peers/README.md`, a mechanism file).

use enact::math::Pose;
use enact::physics::tree::{JointKind, Link};
use serde_json::{Value, json};

/// The field `links`.
pub fn links(links: &[Link]) -> Value {
    links.iter().map(link).collect()
}

fn link(link: &Link) -> Value {
    let (kind, axes) = match &link.joint.kind {
        JointKind::Fixed => ("fixed", vec![]),
        JointKind::Pin { axis } => ("pin", vec![axis.as_slice()]),
        JointKind::Universal { axes } => (
            "universal",
            axes.iter().map(|axis| axis.as_slice()).collect(),
        ),
        JointKind::Ball => ("ball", vec![]),
        JointKind::Free => ("free", vec![]),
    };
    json!({
        "parent": link.parent,
        "joint": {
            "kind": kind,
            "axes": axes,
            "parent_from_joint": pose(&link.joint.parent_from_joint),
            "link_from_joint": pose(&link.joint.link_from_joint),
        },
        "mass_kg": link.body.mass_kg(),
        "moments_kg_m2": link.body.moments_kg_m2().as_slice(),
    })
}

fn pose(pose: &Pose) -> Value {
    let q = pose.rotation.coords;
    json!({
        "position_m": pose.translation.vector.as_slice(),
        "orientation_wxyz": [q.w, q.x, q.y, q.z],
    })
}
