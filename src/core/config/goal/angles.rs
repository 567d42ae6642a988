//! What is asked of joints.

use crate::config::spanned::Spanned;
use nalgebra::Vector3;

use super::vector::sd;
use super::{DEG, Table};
use crate::config::error::{Fault, fault};
use crate::config::number::index_of;
use crate::config::raw::Text;
use crate::motion::{Condition, Goal, GoalQuantity, GoalSet, GoalTarget, Joint, Moment};
use crate::physics::tree::JointKind;

impl Table<'_> {
    /// The goal on the angles of the joint that is named.
    pub(super) fn of_joint(&mut self, text: &Text) -> Result<Goal, Fault> {
        let raw = self.raw;
        let joints = self.scene.joint_trees().flat_map(|(_, tree)| &tree.joints);
        let joints: Vec<&Joint> = joints.collect();
        let names = joints.iter().map(|joint| joint.name.as_str());
        let joint = joints[index_of("joint", text, names)?];
        let count = match joint.joint.kind {
            JointKind::Pin { .. } => 1,
            JointKind::Universal { .. } => 2,
            _ => {
                let said = format!(
                    "{:?} has no angles, expected a pin or a universal joint; of a ball ask how its child is turned, relative_to its parent",
                    joint.name
                );
                return fault(text.span(), said);
            }
        };
        self.used
            .add(&["angles_deg", "angles_within_deg", "sd_deg"]);
        let [lower, upper] = match (&raw.angles_deg, &raw.angles_within_deg) {
            (Some(exact), None) => {
                let exact = angles("angles_deg", exact.get_ref(), exact, count)?;
                [exact, exact]
            }
            (None, Some(within)) => {
                let [lower, upper] = within.get_ref();
                let lower = angles("angles_within_deg", lower, within, count)?;
                let upper = angles("angles_within_deg", upper, within, count)?;
                if (0..count).any(|axis| lower[axis] > upper[axis]) {
                    let said =
                        "a lower angle is above its upper one, expected the lower corner first";
                    return fault(within.span(), said);
                }
                [lower, upper]
            }
            (Some(_), Some(within)) => {
                return fault(
                    within.span(),
                    "expected one of angles_deg, angles_within_deg",
                );
            }
            (None, None) => {
                return fault(
                    text.span(),
                    "what of the joint? Expected angles_deg or angles_within_deg",
                );
            }
        };
        Ok(Goal {
            event: self.event,
            link: joint.child,
            target: GoalTarget::Condition(Condition {
                quantity: GoalQuantity::Angles { count },
                set: GoalSet::Box { lower, upper },
                moment: Moment::Before,
                sd: sd("sd_deg", &raw.sd_deg, DEG)?,
            }),
        })
    }
}

/// As many finite angles as a joint has \[rad\]; the rest is zero.
fn angles<T>(
    key: &str,
    given_deg: &[f64],
    at: &Spanned<T>,
    count: usize,
) -> Result<Vector3<f64>, Fault> {
    if given_deg.len() != count || given_deg.iter().any(|angle| !angle.is_finite()) {
        let said = format!(
            "{key} has {} numbers, expected {count} finite ones: one for each axis of the joint",
            given_deg.len()
        );
        return fault(at.span(), said);
    }
    Ok(Vector3::from_fn(|axis, _| {
        given_deg.get(axis).copied().unwrap_or(0.0) * DEG
    }))
}
