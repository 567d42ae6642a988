//! Bodies and joints as TOML.

use std::fmt::Write;
use std::ops::Range;

use nalgebra::{UnitQuaternion, Vector3};

use super::geometry::UrdfPrimitive;
use super::mechanism::{UrdfBody, UrdfHinge, UrdfMechanism};
use super::robot::Robot;
use super::solid::UrdfShape;
use crate::math::Pose;

/// Parts of a number below this are rounding \[m\] and nothing is lost by zero.
const ROUNDING: f64 = 1e-15;

/// The text of a scene.
#[derive(Debug, Default)]
pub(super) struct SceneText {
    pub(super) toml: String,
    /// Where tables begin in it, and what of the description they were made of.
    tables: Vec<(usize, Range<usize>)>,
}

impl SceneText {
    /// Writes a mechanism.
    pub(super) fn new(robot: &Robot, made: &UrdfMechanism) -> Self {
        let mut text = Self::default();
        text.begin(robot.span.clone());
        let _ = write!(
            text.toml,
            "# The mechanism of a URDF file. Bodies have their axes in their centres of mass, along principal axes; a\n\
             # tracker of each is where the link's own frame is. A body that no tracker sees has `tracked = false` in place of\n\
             # `tracker`; `docs/tracks.md` says what else trackers may see, `docs/goals.md` what may be asked.\n\n\
             name = {}\n\n[timing]\nstamps = \"physical\"\n",
            quoted(robot.name.get_ref())
        );
        for body in &made.bodies {
            text.begin(body.name.span());
            text.body(body);
        }
        for hinge in &made.hinges {
            text.begin(hinge.name.span());
            text.hinge(hinge, made);
        }
        text.toml += "\n[[event]]\nname = \"start\"\nkind = \"start\"\n\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
        text
    }

    /// What of the description a line of the scene, from 1, was made of.
    pub(super) fn origin(&self, line: usize) -> Range<usize> {
        let before = self.toml.split_inclusive('\n').take(line.saturating_sub(1));
        let start: usize = before.map(str::len).sum();
        let table = self.tables.iter().rev().find(|(at, _)| *at <= start);
        table.map_or(0..0, |(_, span)| span.clone())
    }

    fn begin(&mut self, span: Range<usize>) {
        self.tables.push((self.toml.len(), span));
    }

    fn body(&mut self, body: &UrdfBody) {
        let solid = &body.solid;
        let body_from_link = solid.link_from_body.inverse();
        let moments = solid.moments_kg_m2;
        let _ = write!(
            self.toml,
            "\n[[body]]\nname = {}\nshape = {{ {} }}\nmass_kg = {:?}\nmoments_kg_m2 = [{:?}, {:?}, {:?}]\n\
             tracker = {{ position_mm = {}, orientation_wxyz = {} }}\n",
            quoted(body.name.get_ref()),
            shape(&solid.shape),
            solid.mass_kg,
            moments.x,
            moments.y,
            moments.z,
            millimetres(&body_from_link.translation.vector),
            wxyz(&body_from_link.rotation),
        );
        if body.points.is_empty() {
            return;
        }
        let point = |(name, at_m): &(String, Vector3<f64>)| {
            let at_m = body_from_link * nalgebra::Point3::from(*at_m);
            format!("{} = {}", quoted(name), millimetres(&at_m.coords))
        };
        let points: Vec<String> = body.points.iter().map(point).collect();
        let _ = writeln!(self.toml, "features_mm = {{ {} }}", points.join(", "));
    }

    fn hinge(&mut self, hinge: &UrdfHinge, made: &UrdfMechanism) {
        let joint = &hinge.joint;
        let parent_from_link = match hinge.parent {
            Some(parent) => made.bodies[parent].solid.link_from_body.inverse(),
            None => Pose::identity(),
        };
        let child = &made.bodies[hinge.child];
        let parent_from_child =
            parent_from_link * hinge.parent_from_child * child.solid.link_from_body;
        let parent_at_m = parent_from_link * nalgebra::Point3::from(joint.at_m);
        let child_at_m = parent_from_child.inverse() * parent_at_m;
        let _ = write!(
            self.toml,
            "\n[[joint]]\nname = {}\nkind = \"{}\"\n",
            quoted(hinge.name.get_ref()),
            joint.kind
        );
        let axes = joint.axes.iter();
        let axes: Vec<String> = axes
            .map(|(axis, _)| list((parent_from_link.rotation * axis).as_slice()))
            .collect();
        let _ = match axes.as_slice() {
            [] => Ok(()),
            [axis] => writeln!(self.toml, "axis = {axis}"),
            axes => writeln!(self.toml, "axes = [{}]", axes.join(", ")),
        };
        if let Some(parent) = hinge.parent {
            let name = quoted(made.bodies[parent].name.get_ref());
            let _ = writeln!(self.toml, "parent = {name}");
        }
        let _ = write!(
            self.toml,
            "parent_at_mm = {}\nchild = {}\nchild_at_mm = {}\nchild_orientation_wxyz = {}\n",
            millimetres(&parent_at_m.coords),
            quoted(child.name.get_ref()),
            millimetres(&child_at_m.coords),
            wxyz(&parent_from_child.rotation),
        );
        if joint.damping_n_m_s > 0.0 {
            let _ = writeln!(self.toml, "damping_n_m_s = {:?}", joint.damping_n_m_s);
        }
        let is_limited =
            |(_, limits): &(Vector3<f64>, [f64; 2])| limits.iter().any(|of| of.is_finite());
        if joint.axes.iter().any(is_limited) {
            let limits = joint.axes.iter();
            let limits: Vec<String> = limits
                .map(|(_, limits)| list(&limits.map(f64::to_degrees)))
                .collect();
            let _ = writeln!(self.toml, "limits_deg = [{}]", limits.join(", "));
        }
    }
}

fn shape(shape: &UrdfShape) -> String {
    let round = |kind: &str, half_length_m: f64, radius_m: f64| {
        format!(
            "kind = \"{kind}\", length_mm = {:?}, radius_mm = {:?}",
            2e3 * half_length_m,
            1e3 * radius_m
        )
    };
    match shape {
        UrdfShape::Whole(UrdfPrimitive::Cuboid { half_extents_m }) => {
            let size = millimetres(&(2.0 * half_extents_m));
            format!("kind = \"cuboid\", size_mm = {size}")
        }
        UrdfShape::Whole(UrdfPrimitive::Sphere { radius_m }) => {
            format!("kind = \"sphere\", radius_mm = {:?}", 1e3 * radius_m)
        }
        UrdfShape::Whole(UrdfPrimitive::Cylinder {
            half_length_m,
            radius_m,
        }) => round("cylinder", *half_length_m, *radius_m),
        UrdfShape::Whole(UrdfPrimitive::Capsule {
            half_length_m,
            radius_m,
        }) => round("capsule", *half_length_m, *radius_m),
        UrdfShape::Hull { points_m } => {
            let points: Vec<String> = points_m.iter().map(millimetres).collect();
            format!("kind = \"hull\", points_mm = [{}]", points.join(", "))
        }
    }
}

fn millimetres(at_m: &Vector3<f64>) -> String {
    let clean = at_m.map(|of| if of.abs() < ROUNDING { 0.0 } else { 1e3 * of });
    list(clean.as_slice())
}

fn wxyz(turn: &UnitQuaternion<f64>) -> String {
    // Of the two that are the same turn, the one with a positive w.
    let sign = if turn.w < 0.0 { -1.0 } else { 1.0 };
    list(&[turn.w, turn.i, turn.j, turn.k].map(|of| sign * of))
}

fn list(numbers: &[f64]) -> String {
    let number = |of: &f64| {
        let clean = if of.abs() < ROUNDING { 0.0 } else { *of };
        format!("{clean:?}")
    };
    let numbers: Vec<String> = numbers.iter().map(number).collect();
    format!("[{}]", numbers.join(", "))
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}
