//! Turns about axes, one after the other with no mass between, as one joint.

use crate::config::spanned::Spanned;
use nalgebra::Vector3;

use crate::config::error::{Fault, fault};

/// How far axes that meet may miss each other \[m\].
const MISS_M: f64 = 1e-7;

/// Least sine of the angle between the axes of a universal joint.
const LEAST_SINE: f64 = 1e-3;

/// Greatest cosine of the angle between the axes of what is a ball: only axes at right angles reach
/// every orientation.
const RIGHT_ANGLE: f64 = 1e-4;

/// A turn about an axis, in the frame of the link that all hang from, where all angles are zero.
#[derive(Clone, Debug)]
pub(super) struct UrdfTurn {
    pub(super) name: Spanned<String>,
    pub(super) at_m: Vector3<f64>,
    pub(super) axis: Vector3<f64>,
    pub(super) limits_rad: [f64; 2],
    pub(super) damping_n_m_s: f64,
}

/// A joint of a scene, in the frame of the link that it hangs from.
#[derive(Clone, Debug)]
pub(super) struct Merged {
    pub(super) at_m: Vector3<f64>,
    /// One for a pin, two for a universal joint.
    pub(super) axes: Vec<(Vector3<f64>, [f64; 2])>,
    /// `fixed`, `pin`, `universal`, `ball`.
    pub(super) kind: &'static str,
    pub(super) damping_n_m_s: f64,
    /// Whether limits were given that no joint of this kind has.
    pub(super) is_unlimited: bool,
}

/// The turns as one joint; none is a fixed one, which is at `at_m`.
///
/// Where axes meet in a point X, `Exp(ξ₁ θ₁) Exp(ξ₂ θ₂) … M` is a rotation about X: the product of
/// exponentials, with every twist through X.
pub(super) fn merged(turns: &[UrdfTurn], at_m: Vector3<f64>) -> Result<Merged, Fault> {
    let joint = |kind, at_m, axes: &[UrdfTurn]| Merged {
        at_m,
        axes: axes.iter().map(|of| (of.axis, of.limits_rad)).collect(),
        kind,
        damping_n_m_s: 0.0,
        is_unlimited: false,
    };
    match turns {
        [] => Ok(joint("fixed", at_m, &[])),
        [one] => Ok(Merged {
            damping_n_m_s: one.damping_n_m_s,
            ..joint("pin", one.at_m, turns)
        }),
        [first, second] => {
            let at_m = meeting(first, second)?;
            if first.damping_n_m_s != second.damping_n_m_s {
                let said = format!(
                    "{:?} and {:?} become one universal joint, and it has one damping, not {} and {} N m s; expected equal ones, or a link with mass between",
                    first.name.get_ref(),
                    second.name.get_ref(),
                    first.damping_n_m_s,
                    second.damping_n_m_s
                );
                return fault(second.name.span(), said);
            }
            Ok(Merged {
                damping_n_m_s: first.damping_n_m_s,
                ..joint("universal", at_m, turns)
            })
        }
        [first, second, third] => ball(first, second, third).map(|at_m| Merged {
            is_unlimited: turns
                .iter()
                .any(|of| of.limits_rad.iter().any(|of| of.is_finite())),
            ..joint("ball", at_m, &[])
        }),
        [.., last] => {
            let said = format!(
                "{:?} is the {}th joint in a row with no mass between, expected three at most, which make a ball: give a link between an <inertial>",
                last.name.get_ref(),
                turns.len()
            );
            fault(last.name.span(), said)
        }
    }
}

/// Where two axes meet.
fn meeting(first: &UrdfTurn, second: &UrdfTurn) -> Result<Vector3<f64>, Fault> {
    let names = format!("{:?} and {:?}", first.name.get_ref(), second.name.get_ref());
    let across = first.axis.cross(&second.axis);
    let sine = across.norm();
    if sine < LEAST_SINE {
        let said = format!(
            "the axes of {names} are parallel and there is no mass between them, expected an <inertial> of the link between"
        );
        return fault(second.name.span(), said);
    }
    let apart = second.at_m - first.at_m;
    let miss_m = apart.dot(&across).abs() / sine;
    if miss_m > MISS_M {
        let said = format!(
            "the axes of {names} pass each other at {} mm and there is no mass between them: such axes are no universal joint, expected an <inertial> of the link between, or axes that meet",
            miss_m * 1e3
        );
        return fault(second.name.span(), said);
    }
    // The feet of the common perpendicular, and the middle between them.
    let along = |axis: &Vector3<f64>| apart.cross(axis).dot(&across) / sine.powi(2);
    let on_first = first.at_m + first.axis * along(&second.axis);
    let on_second = second.at_m + second.axis * along(&first.axis);
    Ok(0.5 * (on_first + on_second))
}

/// Where three axes meet that reach every orientation.
fn ball(first: &UrdfTurn, second: &UrdfTurn, third: &UrdfTurn) -> Result<Vector3<f64>, Fault> {
    let names = [first, second, third].map(|of| format!("{:?}", of.name.get_ref()));
    let names = names.join(", ");
    let at_m = meeting(first, second)?;
    let miss_m = (at_m - third.at_m).cross(&third.axis).norm();
    if miss_m > MISS_M {
        let said = format!(
            "the axes of {names} do not meet in a point, the third misses it by {} mm, and there is no mass between them: such axes are no ball, expected an <inertial> of a link between",
            miss_m * 1e3
        );
        return fault(third.name.span(), said);
    }
    let cosines = [first.axis.dot(&second.axis), second.axis.dot(&third.axis)];
    if cosines.iter().any(|of| of.abs() > RIGHT_ANGLE) {
        let said = format!(
            "the axes of {names} are not at right angles, one to the next, and there is no mass between them: such axes reach less than a ball does, expected an <inertial> of a link between"
        );
        return fault(third.name.span(), said);
    }
    if [first, second, third]
        .iter()
        .any(|of| of.damping_n_m_s > 0.0)
    {
        let said = format!(
            "{names} become a ball, and damping about three axes is none of a ball: expected no <dynamics damping>, or an <inertial> of a link between"
        );
        return fault(third.name.span(), said);
    }
    Ok(at_m)
}
