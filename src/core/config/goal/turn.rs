//! Orientations, and directions of axes.

use crate::config::spanned::Spanned;

use super::vector::sd;
use super::{DEG, Table, target};
use crate::config::error::{Fault, fault};
use crate::config::number::{direction, orientation_in_either, positive};
use crate::config::raw::{RawAxis, Triple};
use crate::config::rest::axis;
use crate::motion::{Condition, GoalQuantity, GoalSet, GoalTarget, LinkIndex, Moment};

impl Table<'_> {
    /// An orientation, exactly or within an angle.
    pub(super) fn turn(
        &mut self,
        link: LinkIndex,
        seen_from: Option<LinkIndex>,
    ) -> Result<Option<Condition>, Fault> {
        let raw = self.raw;
        let what = "orientation of the goal";
        let (wxyz, rpy_deg) = (raw.orientation_wxyz.as_ref(), raw.rpy_deg.as_ref());
        let Some(turn) = orientation_in_either(what, wxyz, rpy_deg)? else {
            return Ok(None);
        };
        if let Some(axis) = &raw.axis {
            return fault(
                axis.span(),
                "expected one of orientation_wxyz, axis: each in a goal of its own",
            );
        }
        let keys = [
            "orientation_wxyz",
            "rpy_deg",
            "relative_to",
            "within_deg",
            "sd_deg",
        ];
        self.used.add(&keys);
        Ok(Some(Condition {
            quantity: GoalQuantity::Turn {
                from: self.link_from_given(seen_from).rotation
                    * turn
                    * self.link_from_given(Some(link)).rotation.inverse(),
                seen_from,
            },
            set: GoalSet::about_zero(self.angle()?),
            moment: Moment::Before,
            sd: sd("sd_deg", &raw.sd_deg, DEG)?,
        }))
    }

    /// An axis of the body along a direction, exactly or within a cone.
    pub(super) fn direction(
        &mut self,
        link: LinkIndex,
        seen_from: Option<LinkIndex>,
    ) -> Result<Option<GoalTarget>, Fault> {
        let raw = self.raw;
        let Some(given) = &raw.axis else {
            return Ok(None);
        };
        let axis = match given.get_ref() {
            RawAxis::Name(name) => axis("axis", &self.scene.links[link], name, given.span())?,
            RawAxis::Vector(numbers) => {
                let triple: Triple = Spanned::new(given.span(), *numbers);
                self.link_from_given(Some(link)).rotation * direction("axis", &triple)?
            }
        };
        let towards = match (&raw.direction, seen_from) {
            (Some(triple), _) => {
                self.link_from_given(seen_from).rotation * direction("direction", triple)?
            }
            (None, None) => {
                let up = self.scene.gravity_m_s2.try_normalize(0.0).map(|down| -down);
                up.ok_or_else(|| Fault {
                    span: given.span(),
                    message: "without gravity nothing is up, expected direction beside axis".into(),
                })?
            }
            (None, Some(_)) => {
                return fault(
                    given.span(),
                    "an axis seen from another body needs a direction in its axes",
                );
            }
        };
        let keys = ["axis", "direction", "relative_to", "within_deg", "sd_deg"];
        self.used.add(&keys);
        let quantity = GoalQuantity::Direction {
            axis,
            towards,
            seen_from,
        };
        let set = GoalSet::about_zero(self.angle()?);
        Ok(Some(target(quantity, set, sd("sd_deg", &raw.sd_deg, DEG)?)))
    }

    fn angle(&self) -> Result<Option<f64>, Fault> {
        let Some(number) = &self.raw.within_deg else {
            return Ok(None);
        };
        let within_deg = positive("within_deg", number)?;
        if within_deg >= 180.0 {
            return fault(
                number.span(),
                format!("within_deg is {within_deg}, expected less than 180"),
            );
        }
        Ok(Some(within_deg * DEG))
    }
}
