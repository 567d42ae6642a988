//! The scene as URDF, for viewers that draw no scene updates, and for all who compute with robots.
//!
//! The root link is the world frame, with obstacles and surfaces. Each body is a link named as its
//! estimate's frame, which is the one in which the scene gives it; its inertia is said at its centre of mass
//! along its principal axes. Bodies that fly are joined to the
//! world by floating joints, which frame transforms move, and so are bodies as they were acted, once more. URDF knows no universal joint and no ball: a
//! joint of the scene is a series of hinges with links between them that have neither mass nor shape
//! ([`skeleton`](super::skeleton)), and a body hangs fixed on the last of them, for a hinge's link must be at
//! its axis.
//!
//! URDF knows boxes, cylinders and spheres: a cone is drawn as a stack of cylinders, a hull as a
//! stack of boxes (who reads URDF from a recording finds no files of meshes), a rounded box as a sharp one, a compound as its parts. It
//! has no word for springs, and for a hinge with one limit alone: that is without.

use std::fmt::Write;

use nalgebra::{Translation3, Vector3};

use super::skeleton::{Hanging, Skeleton, SkeletonHinge};
use super::topics;
use crate::math::{Pose, euler};
use crate::motion::{Link, LinkIndex, Scene};
use crate::physics::Shape;
use crate::visual::{
    Form, GHOST_RGBA, Patch, Primitive, Subject, Visual, cone_slices, hull_slices, mesh,
};
use crate::visual::{primitives, visuals};

/// How many cylinders make a cone, and boxes a hull.
const SLICES: usize = 12;

/// URDF demands a greatest rate where there are limits \[rad/s\]: one that says nothing.
const GREATEST_RATE_RAD_S: f64 = 1e6;

/// The description; surfaces are drawn as far as their patches. What is in `acted` is there once more as it was
/// acted: a link without mass in the frame of its performance.
pub(super) fn robot(
    scene: &Scene,
    world_frame: &str,
    patches: &[Option<Patch>],
    acted: &[LinkIndex],
) -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    let world = escaped(world_frame);
    // Viewers make paths of this name: words only.
    let name: String = scene
        .name
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join("_");
    let _ = writeln!(text, "<robot name=\"{name}\">");
    let _ = writeln!(text, "  <link name=\"{world}\">");
    let visuals = visuals(scene, patches);
    let is_fixed = |of: &&Visual| matches!(of.subject, Subject::Obstacle(_) | Subject::Surface(_));
    for visual in visuals.iter().filter(is_fixed) {
        add_visual(&mut text, visual);
    }
    text.push_str("  </link>\n");
    for body in &Skeleton::new(scene, world_frame).bodies {
        let (parent, pose) = match &body.hanging {
            Some(hanging) => (
                add_hinges(&mut text, hanging),
                Some(hanging.last_from_body()),
            ),
            None => (world_frame, None),
        };
        let _ = writeln!(text, "  <link name=\"{}\">", escaped(&body.frame));
        add_inertia(&mut text, &scene.links[body.link]);
        let is_its = |of: &&Visual| of.subject == Subject::Link(body.link);
        for visual in visuals.iter().filter(is_its) {
            add_visual(&mut text, visual);
        }
        text.push_str("  </link>\n");
        let kind = if pose.is_some() { "fixed" } else { "floating" };
        open_joint(&mut text, &body.joint, kind, [parent, &body.frame]);
        if let Some(pose) = &pose {
            let _ = writeln!(text, "    {}", origin(pose));
        }
        text.push_str("  </joint>\n");
    }
    for link in acted {
        add_ghost(&mut text, &scene.links[*link], world_frame);
    }
    text.push_str("</robot>\n");
    text
}

/// A body as it was acted, which moves freely in the world.
fn add_ghost(text: &mut String, link: &Link, world_frame: &str) {
    let frame = topics::sketch_frame(&link.name);
    let rgba = GHOST_RGBA.map(|part| part.to_string()).join(" ");
    let _ = writeln!(text, "  <link name=\"{}\">", escaped(&frame));
    add_shape(text, &link.shape, &link.given_from_shape(), &rgba);
    text.push_str("  </link>\n");
    let joint = format!("{frame}_joint");
    open_joint(text, &joint, "floating", [world_frame, &frame]);
    text.push_str("  </joint>\n");
}

/// Hinges with their links; the name of the last of these, or of the parent where there are none.
fn add_hinges<'s>(text: &mut String, hanging: &'s Hanging) -> &'s str {
    let mut parent = hanging.parent.as_str();
    let mut pose = hanging.parent_from_joint();
    for hinge in &hanging.hinges {
        let _ = writeln!(text, "  <link name=\"{}\"/>", escaped(&hinge.frame));
        add_hinge(text, hanging, hinge, parent, &pose);
        (parent, pose) = (&hinge.frame, Pose::identity());
    }
    parent
}

fn add_hinge(
    text: &mut String,
    hanging: &Hanging,
    hinge: &SkeletonHinge,
    parent: &str,
    pose: &Pose,
) {
    let kind = match hinge.limits_rad {
        Some(_) => "revolute",
        None => "continuous",
    };
    open_joint(text, &hinge.name, kind, [parent, &hinge.frame]);
    let axis = hinge.axis;
    let _ = writeln!(
        text,
        "    {}\n    <axis xyz=\"{} {} {}\"/>",
        origin(pose),
        axis.x,
        axis.y,
        axis.z
    );
    if let Some([least, greatest]) = hinge.limits_rad {
        // Nothing drives it.
        let _ = writeln!(
            text,
            "    <limit lower=\"{least}\" upper=\"{greatest}\" effort=\"0\" velocity=\"{GREATEST_RATE_RAD_S}\"/>"
        );
    }
    let damping_n_m_s = hanging.joint.joint.damping_n_m_s;
    if damping_n_m_s > 0.0 {
        let _ = writeln!(text, "    <dynamics damping=\"{damping_n_m_s}\"/>");
    }
    text.push_str("  </joint>\n");
}

fn open_joint(text: &mut String, name: &str, kind: &str, [parent, child]: [&str; 2]) {
    let [name, parent, child] = [name, parent, child].map(escaped);
    let _ = writeln!(
        text,
        "  <joint name=\"{name}\" type=\"{kind}\">\n    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>"
    );
}

/// Mass and principal moments. What is held moves as its hand does: it has none.
fn add_inertia(text: &mut String, link: &Link) {
    if link.held.is_some() {
        return;
    }
    let (mass_kg, moments) = (link.body.mass_kg(), link.body.moments_kg_m2());
    let given_from_link = link.link_from_given.inverse();
    let place = match given_from_link == Pose::identity() {
        true => String::new(),
        false => format!("      {}\n", origin(&given_from_link)),
    };
    let _ = writeln!(
        text,
        "    <inertial>\n{place}      <mass value=\"{mass_kg}\"/>\n      \
         <inertia ixx=\"{}\" ixy=\"0\" ixz=\"0\" iyy=\"{}\" iyz=\"0\" izz=\"{}\"/>\n    </inertial>",
        moments.x, moments.y, moments.z
    );
}

/// Where a frame is.
fn origin(pose: &Pose) -> String {
    let p = pose.translation.vector;
    let [roll, pitch, yaw] = euler::roll_pitch_yaw(&pose.rotation);
    format!(
        "<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>",
        p.x, p.y, p.z
    )
}

fn add_visual(text: &mut String, visual: &Visual) {
    if let Some(shape) = &visual.shape {
        let rgba = visual.subject.rgba().map(|part| part.to_string());
        add_shape(text, shape, &visual.frame_from_shape, &rgba.join(" "));
    }
}

fn add_shape(text: &mut String, shape: &Shape, pose: &Pose, rgba: &str) {
    match shape {
        Shape::Cone {
            half_height_m,
            radius_m,
        } => {
            for [z_m, length_m, radius_m] in cone_slices(*half_height_m, *radius_m, SLICES) {
                let pose = pose * Translation3::new(0.0, 0.0, z_m);
                add_geometry(text, &pose, &cylinder(length_m, radius_m), rgba);
            }
        }
        Shape::Hull { .. } => {
            for [middle_m, sides_m] in hull_slices(&mesh(shape), SLICES) {
                let pose = pose * Translation3::from(middle_m);
                add_geometry(text, &pose, &cuboid(&sides_m), rgba);
            }
        }
        Shape::Compound(compound) => {
            for part in &compound.parts {
                let pose = pose * part.compound_from_shape;
                add_shape(text, &part.shape, &pose, rgba);
            }
        }
        _ => {
            for primitive in primitives(shape) {
                if let Some(geometry) = geometry(&primitive) {
                    add_geometry(text, &primitive.pose(pose), &geometry, rgba);
                }
            }
        }
    }
}

/// A primitive in URDF's words; `None` of one that it does not know.
fn geometry(primitive: &Primitive) -> Option<String> {
    match &primitive.form {
        Form::Cuboid { sides_m } => Some(cuboid(sides_m)),
        Form::Sphere { radius_m } => Some(format!("<sphere radius=\"{radius_m}\"/>")),
        Form::Frustum {
            half_length_m,
            radius_m,
            ..
        } => Some(cylinder(2.0 * half_length_m, *radius_m)),
        Form::Triangles(_) => None,
    }
}

fn cuboid(sides_m: &Vector3<f64>) -> String {
    let (x, y, z) = (sides_m.x, sides_m.y, sides_m.z);
    format!("<box size=\"{x} {y} {z}\"/>")
}

fn cylinder(length_m: f64, radius_m: f64) -> String {
    format!("<cylinder radius=\"{radius_m}\" length=\"{length_m}\"/>")
}

fn add_geometry(text: &mut String, pose: &Pose, geometry: &str, rgba: &str) {
    let _ = writeln!(
        text,
        "    <visual>\n      {}\n      <geometry>{geometry}</geometry>\n      \
         <material name=\"{}\"><color rgba=\"{rgba}\"/></material>\n    </visual>",
        origin(pose),
        rgba.replace(' ', "_"),
    );
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::scene;
    use crate::motion::LinkIndex;

    #[test]
    fn a_body_that_is_given_elsewhere_has_its_mass_and_shape_where_they_are() {
        let mut scene = scene();
        let plain = robot(&scene, "map", &[], &[]);
        assert!(plain.contains("<inertial>\n      <mass"), "{plain}");
        // Given from 95 mm below its centre of mass.
        scene.links[LinkIndex(0)].link_from_given = Pose::translation(0.0, 0.0, -0.095);
        let text = robot(&scene, "map", &[], &[]);
        let of = |tag: &str| {
            let at = text
                .find("<link name=\"pencil_estimate\">")
                .expect("the pencil");
            let from = at + text[at..].find(tag).expect("what it has");
            text[from..]
                .lines()
                .nth(1)
                .expect("an origin")
                .replace("-0 ", "0 ")
        };
        for tag in ["<inertial>", "<visual>"] {
            assert!(
                of(tag).contains("<origin xyz=\"0 0 0.095\" rpy="),
                "{}",
                of(tag)
            );
        }
    }

    #[test]
    fn links_are_the_frames_of_the_estimate() {
        let mut scene = scene();
        scene.name = "a <\"b\"> & c".to_owned();
        let text = robot(&scene, "map <\"1\"> &", &[], &[LinkIndex(0)]);
        for line in [
            "<robot name=\"a_b_c\">",
            "<link name=\"map &lt;&quot;1&quot;&gt; &amp;\">",
            "<link name=\"pencil_estimate\">",
            "<parent link=\"map &lt;&quot;1&quot;&gt; &amp;\"/>",
            "<cylinder radius=\"0.00375\" length=\"0.19\"/>",
            "<link name=\"pencil_sketch\">",
            "<joint name=\"pencil_sketch_joint\" type=\"floating\">",
            "<color rgba=\"0.95 0.65 0.2 0.35\"/>",
        ] {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
    }

    #[test]
    fn a_cone_reaches_from_its_base_to_its_apex() {
        let mut text = String::new();
        let cone = Shape::Cone {
            half_height_m: 1.0,
            radius_m: 1.0,
        };
        add_shape(&mut text, &cone, &Pose::identity(), "1 1 1 1");
        let heights: Vec<f64> = text
            .split("xyz=\"0 0 ")
            .skip(1)
            .map(|rest| {
                rest[..rest.find('"').expect("quote")]
                    .parse()
                    .expect("number")
            })
            .collect();
        assert_eq!(heights.len(), SLICES);
        let slice = 2.0 / SLICES as f64;
        assert!((heights[0] - 0.5 * slice + 0.5).abs() < 1e-12);
        assert!((heights[SLICES - 1] + 0.5 * slice - 1.5).abs() < 1e-12);
    }
}
