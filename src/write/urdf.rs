//! The scene as URDF, for viewers that draw no scene updates.
//!
//! The root link is the world frame; each body is a link named as its estimate's frame, moved
//! by the frame transforms, each obstacle a fixed one. URDF knows boxes, cylinders and spheres:
//! a cone is drawn as a stack of cylinders, a hull as its bounding box, a rounded box as a sharp
//! one.

use std::fmt::Write;

use nalgebra::{Translation3, Vector3};

use super::topics;
use crate::math::Pose;
use crate::motion::Scene;
use crate::physics::Shape;
use crate::visual::{Form, Primitive, Subject, Visual, bounding_box, cone_slices};
use crate::visual::{primitives, visuals};

/// How many cylinders make a cone.
const CONE_SLICES: usize = 12;

/// The description; surfaces are `surface_side_m` wide.
pub(super) fn robot(scene: &Scene, world_frame: &str, surface_side_m: f64) -> String {
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
    let visuals = visuals(scene, surface_side_m);
    let is_fixed = |of: &&Visual| matches!(of.subject, Subject::Obstacle(_) | Subject::Surface(_));
    for visual in visuals.iter().filter(is_fixed) {
        add_visual(&mut text, visual);
    }
    text.push_str("  </link>\n");
    for visual in &visuals {
        let Subject::Link(link) = visual.subject else {
            continue;
        };
        let link = escaped(&topics::estimate_frame(&scene.links[link].name));
        let _ = writeln!(text, "  <link name=\"{link}\">");
        add_visual(&mut text, visual);
        let _ = write!(
            text,
            "  </link>\n  <joint name=\"{link}_joint\" type=\"floating\">\n    \
             <parent link=\"{world}\"/>\n    <child link=\"{link}\"/>\n  </joint>\n"
        );
    }
    text.push_str("</robot>\n");
    text
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
            for [z_m, length_m, radius_m] in cone_slices(*half_height_m, *radius_m, CONE_SLICES) {
                let pose = pose * Translation3::new(0.0, 0.0, z_m);
                add_geometry(text, &pose, &cylinder(length_m, radius_m), rgba);
            }
        }
        Shape::Hull { points_m } => {
            if let Some((centre_m, sides_m)) = bounding_box(points_m) {
                let pose = pose * Translation3::from(centre_m);
                add_geometry(text, &pose, &cuboid(&sides_m), rgba);
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
    let p = pose.translation.vector;
    // URDF's roll, pitch, yaw are nalgebra's: about fixed x, then y, then z.
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    let _ = writeln!(
        text,
        "    <visual>\n      <origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>\n      \
         <geometry>{geometry}</geometry>\n      \
         <material name=\"{}\"><color rgba=\"{rgba}\"/></material>\n    </visual>",
        p.x,
        p.y,
        p.z,
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
    use crate::motion::fixture::scene;

    #[test]
    fn links_are_the_frames_of_the_estimate() {
        let mut scene = scene();
        scene.name = "a <\"b\"> & c".to_owned();
        let text = robot(&scene, "map <\"1\"> &", 2.0);
        for line in [
            "<robot name=\"a_b_c\">",
            "<link name=\"map &lt;&quot;1&quot;&gt; &amp;\">",
            "<link name=\"pencil_estimate\">",
            "<parent link=\"map &lt;&quot;1&quot;&gt; &amp;\"/>",
            "<cylinder radius=\"0.00375\" length=\"0.19\"/>",
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
        assert_eq!(heights.len(), CONE_SLICES);
        let slice = 2.0 / CONE_SLICES as f64;
        assert!((heights[0] - 0.5 * slice + 0.5).abs() < 1e-12);
        assert!((heights[CONE_SLICES - 1] + 0.5 * slice - 1.5).abs() < 1e-12);
    }
}
