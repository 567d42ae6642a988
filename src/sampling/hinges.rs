//! Joints as hinges: each turns about one axis, and more is not known to the formats of robots.
//!
//! A pin is one hinge, a universal joint two, a ball three about x, y and z of the joint's frame
//! ([`euler`]); a fixed joint has none. So the child is turned in its parent by
//! `R = R(a₁, q₁) R(a₂, q₂) …`, with the axes as they are where all angles are zero.

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use crate::math::euler;
use crate::physics::tree::JointKind;

/// Axes of a joint's hinges, in the joint's frame.
pub fn hinge_axes(kind: &JointKind) -> Vec<UnitVector3<f64>> {
    let unit = |axis: &Vector3<f64>| UnitVector3::new_normalize(*axis);
    match kind {
        JointKind::Fixed | JointKind::Free => Vec::new(),
        JointKind::Pin { axis } => vec![unit(axis)],
        JointKind::Universal { axes } => axes.iter().map(unit).collect(),
        JointKind::Ball => vec![Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()],
    }
}

/// Angles of a joint's hinges \[rad\] where the child's side of it is turned so in the parent's: of all that
/// make this rotation those nearest to `before`, one for each hinge.
pub fn hinge_angles(kind: &JointKind, turn: &UnitQuaternion<f64>, before: &[f64]) -> Vec<f64> {
    let axes = hinge_axes(kind);
    let angles = match (&axes[..], before) {
        ([axis], [_]) => vec![2.0 * turn.imag().dot(axis).atan2(turn.w)],
        ([first, second], [_, _]) => vec![
            between(first, second, &(turn * *second)),
            between(second, &(turn.inverse() * *first), first),
        ],
        ([_, _, _], [a, b, c]) => return euler::xyz_near(turn, &[*a, *b, *c]).to_vec(),
        _ => Vec::new(),
    };
    assert_eq!(angles.len(), before.len(), "an angle for each hinge");
    let all = angles.iter().zip(before);
    all.map(|(angle, before)| euler::nearest(*angle, *before))
        .collect()
}

/// The angle about an axis that leads from one direction to another, both as far from the axis \[rad\].
fn between(axis: &UnitVector3<f64>, from: &UnitVector3<f64>, to: &UnitVector3<f64>) -> f64 {
    let sine = axis.cross(from).dot(to);
    let cosine = from.dot(to) - axis.dot(from) * axis.dot(to);
    sine.atan2(cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_make_the_rotation_and_count_on_beyond_whole_turns() {
        let axes = [Vector3::new(1.0, 2.0, -0.5), Vector3::new(0.2, 1.0, 3.0)];
        for kind in [
            JointKind::Fixed,
            JointKind::Pin { axis: axes[0] },
            JointKind::Universal { axes },
            JointKind::Ball,
        ] {
            let axes = hinge_axes(&kind);
            assert_eq!(axes.len(), kind.freedoms());
            for scale in [0.3, 1.0, 3.0, 12.0] {
                let angles = [1.1, -0.3, 0.7].map(|angle| angle * scale);
                let angles = &angles[..axes.len()];
                let turns = axes.iter().zip(angles);
                let turn = turns.fold(UnitQuaternion::identity(), |turn, (axis, angle)| {
                    turn * UnitQuaternion::from_axis_angle(axis, *angle)
                });
                let before: Vec<f64> = angles.iter().map(|angle| angle + 0.1).collect();
                let found = hinge_angles(&kind, &turn, &before);
                for (found, angle) in found.iter().zip(angles) {
                    assert!((found - angle).abs() < 1e-12, "{kind:?} {scale}");
                }
            }
        }
    }
}
