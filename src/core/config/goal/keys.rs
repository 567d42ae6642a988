//! Which keys a goal has, and what each is about.

use std::ops::Range;

use crate::config::spanned::Spanned;

use crate::config::error::{Fault, fault};
use crate::config::raw::RawGoal;

/// Keys that say nothing alone, with what they need.
const NEEDS: &[(&str, &str)] = &[
    ("within_mm", "position_mm, about which it is a ball"),
    ("angles_deg", "joint, whose angles they are"),
    ("angles_within_deg", "joint, whose angles they are"),
    ("sd_mm", "a position, of which it is the weight"),
    (
        "point_mm",
        "a position or a velocity, of which it is the point",
    ),
    (
        "feature",
        "a position or a velocity, of which it is the point",
    ),
    ("contact", "a position, which is that of the contact"),
    (
        "normal",
        "position_mm, velocity_m_s or spin_rad_s, where its half-space begins",
    ),
    (
        "relative_to",
        "a position, an orientation or an axis, which is seen from there",
    ),
    ("direction", "axis, which points there, or face_up at rest"),
    ("within_deg", "orientation_wxyz or axis, or face_up at rest"),
    (
        "sd_deg",
        "orientation_wxyz or axis, of which it is the weight",
    ),
    (
        "within_m_s",
        "velocity_m_s or at_rest, about which it is a ball",
    ),
    ("sd_m_s", "a velocity or at_rest, of which it is the weight"),
    (
        "within_rad_s",
        "spin_rad_s or at_rest, about which it is a ball",
    ),
    ("sd_rad_s", "a spin or at_rest, of which it is the weight"),
    ("axes", "a spin, which is in them"),
    (
        "after",
        "a velocity, a spin or at_rest: poses are the same before and after",
    ),
    ("since", "a time, which is counted from there"),
    ("sd_ms", "a time, of which it is the weight"),
    ("labels", "face_up, which it is about"),
];

/// What a goal may be about.
pub(super) const ABOUT: &str = "position_mm, position_within_mm, orientation_wxyz, rpy_deg, axis, velocity_m_s, \
     velocity_within_m_s, spin_rad_s, spin_within_rad_s, at_rest, time_ms, time_within_ms, \
     angles_deg or angles_within_deg of a joint, or face_up at rest";

impl RawGoal {
    /// The keys that are given, but for `event` and `body`, with their places.
    pub(in crate::config) fn given(&self) -> impl Iterator<Item = (&'static str, Range<usize>)> {
        fn at<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
            value.as_ref().map(Spanned::span)
        }
        let all = [
            ("after", at(&self.after)),
            ("angles_deg", at(&self.angles_deg)),
            ("angles_within_deg", at(&self.angles_within_deg)),
            ("position_mm", at(&self.position_mm)),
            ("position_within_mm", at(&self.position_within_mm)),
            ("within_mm", at(&self.within_mm)),
            ("sd_mm", at(&self.sd_mm)),
            ("point_mm", at(&self.point_mm)),
            ("feature", at(&self.feature)),
            ("contact", at(&self.contact)),
            ("normal", at(&self.normal)),
            ("relative_to", at(&self.relative_to)),
            ("orientation_wxyz", at(&self.orientation_wxyz)),
            ("rpy_deg", at(&self.rpy_deg)),
            ("axis", at(&self.axis)),
            ("direction", at(&self.direction)),
            ("within_deg", at(&self.within_deg)),
            ("sd_deg", at(&self.sd_deg)),
            ("velocity_m_s", at(&self.velocity_m_s)),
            ("velocity_within_m_s", at(&self.velocity_within_m_s)),
            ("within_m_s", at(&self.within_m_s)),
            ("sd_m_s", at(&self.sd_m_s)),
            ("spin_rad_s", at(&self.spin_rad_s)),
            ("spin_within_rad_s", at(&self.spin_within_rad_s)),
            ("within_rad_s", at(&self.within_rad_s)),
            ("sd_rad_s", at(&self.sd_rad_s)),
            ("axes", at(&self.axes)),
            ("at_rest", at(&self.at_rest)),
            ("time_ms", at(&self.time_ms)),
            ("time_within_ms", at(&self.time_within_ms)),
            ("since", at(&self.since)),
            ("sd_ms", at(&self.sd_ms)),
            ("face_up", at(&self.face_up)),
            ("labels", at(&self.labels)),
        ];
        all.into_iter().filter_map(|(key, span)| Some((key, span?)))
    }
}

/// The keys of a goal that something was made of.
#[derive(Default)]
pub(super) struct Used(Vec<&'static str>);

impl Used {
    /// Something was made of a key, if it is given.
    pub(super) fn add(&mut self, keys: &[&'static str]) {
        self.0.extend(keys);
    }

    /// Refuses the first key of which nothing was made.
    pub(super) fn check(&self, goal: &RawGoal) -> Result<(), Fault> {
        let mut given = goal.given();
        let Some((key, span)) = given.find(|(key, _)| !self.0.contains(key)) else {
            return Ok(());
        };
        let needs = NEEDS.iter().find(|(other, _)| *other == key);
        let needs = needs.map_or("to be left out", |(_, needs)| needs);
        fault(span, format!("{key} needs {needs}"))
    }
}
