//! What is tied to the world for a while, or held still.

use crate::config::error::{Fault, fault};
use crate::config::joint::joint;
use crate::config::raw::{RawJoint, RawPhase};
use crate::config::spanned::Spanned;
use crate::motion::{AtPivot, Joint, Scene};
use crate::physics::support::{Pivot, PivotAxes};
use crate::physics::tree::JointKind;
use nalgebra::Vector3;

/// A joint that is there for a part of the time.
pub(super) fn tied(spanned: &Spanned<RawJoint>, scene: &Scene) -> Result<(Joint, AtPivot), Fault> {
    let raw = spanned.get_ref();
    let of = joint(spanned, scene)?;
    if let Some(parent) = &raw.parent {
        return fault(
            parent.span(),
            "from and until are of a joint to the world, of one to a held body, or of a fixed one from which on two bodies are one: expected no parent, one that is held, or kind = \"fixed\"",
        );
    }
    let made = &of.joint;
    let (axes, axis) = match made.kind {
        JointKind::Pin { axis } => {
            let axis = axis.normalize();
            let of_body = made.link_from_joint.rotation * axis;
            let of_world = made.parent_from_joint.rotation * axis;
            (PivotAxes::One(of_body), Some(of_world))
        }
        JointKind::Ball => (PivotAxes::All, None),
        _ => {
            return fault(
                raw.kind.span(),
                "from and until are of a pin or a ball joint, expected one of these; what is held still is a [[phase]] with motion = \"rest\" and no surface",
            );
        }
    };
    let stiffness = raw.stiffness_n_m.as_ref().map(Spanned::span);
    if let Some(span) = stiffness.or(raw.limits_deg.as_ref().map(Spanned::span)) {
        return fault(
            span,
            "a joint with from or until has neither a spring nor limits, expected damping_n_m_s at most",
        );
    }
    let at = AtPivot {
        pivot: Pivot {
            at_m: made.link_from_joint.translation.vector,
            axes,
            damping_n_m_s: made.damping_n_m_s,
        },
        place_m: Some(made.parent_from_joint.translation.vector),
        axis,
    };
    Ok((of, at))
}

/// A phase without a surface: the body is held still where it is.
pub(super) fn still(spanned: &Spanned<RawPhase>) -> Result<AtPivot, Fault> {
    let raw = spanned.get_ref();
    let needs = |what: &str| {
        format!(
            "missing key `surface`: without one a body is held still by something, expected {what}"
        )
    };
    if raw.motion.get_ref() != "rest" {
        return fault(raw.motion.span(), needs("motion = \"rest\""));
    }
    if let Some(feature) = &raw.feature {
        return fault(feature.span(), needs("no feature"));
    }
    if let Some(friction) = &raw.friction {
        return fault(friction.span(), needs("no friction"));
    }
    Ok(AtPivot {
        pivot: Pivot {
            at_m: Vector3::zeros(),
            axes: PivotAxes::None,
            damping_n_m_s: 0.0,
        },
        place_m: None,
        axis: None,
    })
}
