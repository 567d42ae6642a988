//! The scene as URDF, for viewers that draw no scene updates.
//!
//! The root link is the world frame; each body is a link named as its estimate's frame, moved
//! by the frame transforms, each obstacle a fixed one. URDF knows boxes, cylinders and spheres:
//! a cone is drawn as a stack of cylinders, a hull as its bounding box, a rounded box as a sharp
//! one.

use std::fmt::Write;

use nalgebra::{Translation3, Vector3};

use super::drawing::world_from_slab;
use super::topics;
use crate::math::Pose;
use crate::motion::{Scene, Surface};
use crate::physics::Shape;

/// How many cylinders make a cone.
const CONE_SLICES: usize = 12;

const BODY_RGBA: &str = "0.95 0.65 0.2 1";
const OBSTACLE_RGBA: &str = "0.45 0.55 0.65 0.5";
const SURFACE_RGBA: &str = "0.75 0.75 0.75 0.5";

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
    for obstacle in &scene.obstacles {
        add_shape(
            &mut text,
            &obstacle.shape,
            &obstacle.world_from_shape,
            OBSTACLE_RGBA,
        );
    }
    for plane in scene.surfaces.iter().filter_map(Surface::plane) {
        let half_extents_m = Vector3::new(0.5 * surface_side_m, 0.5 * surface_side_m, 5e-4);
        let slab = Shape::Cuboid { half_extents_m };
        add_shape(&mut text, &slab, &world_from_slab(plane), SURFACE_RGBA);
    }
    text.push_str("  </link>\n");
    for body in &scene.bodies {
        let link = escaped(&topics::estimate_frame(&body.name));
        let _ = writeln!(text, "  <link name=\"{link}\">");
        add_shape(&mut text, &body.shape, &Pose::identity(), BODY_RGBA);
        let _ = write!(
            text,
            "  </link>\n  <joint name=\"{link}_joint\" type=\"floating\">\n    \
             <parent link=\"{world}\"/>\n    <child link=\"{link}\"/>\n  </joint>\n"
        );
    }
    text.push_str("</robot>\n");
    text
}

fn add_shape(text: &mut String, shape: &Shape, pose: &Pose, rgba: &str) {
    let along_z = |z: f64| pose * Translation3::new(0.0, 0.0, z);
    match shape {
        Shape::Cuboid { half_extents_m } | Shape::RoundedCuboid { half_extents_m, .. } => {
            add_box(text, pose, &(2.0 * half_extents_m), rgba);
        }
        Shape::Sphere { radius_m } => add_sphere(text, pose, *radius_m, rgba),
        Shape::Cylinder {
            half_length_m,
            radius_m,
        } => add_cylinder(text, pose, 2.0 * half_length_m, *radius_m, rgba),
        Shape::Capsule {
            half_length_m,
            radius_m,
        } => {
            add_cylinder(text, pose, 2.0 * half_length_m, *radius_m, rgba);
            for z in [-*half_length_m, *half_length_m] {
                add_sphere(text, &along_z(z), *radius_m, rgba);
            }
        }
        Shape::Cone {
            half_height_m,
            radius_m,
        } => {
            let slice_m = 2.0 * half_height_m / CONE_SLICES as f64;
            for slice in 0..CONE_SLICES {
                let middle = (slice as f64 + 0.5) / CONE_SLICES as f64;
                // The base is a quarter of the height below the origin.
                let z = half_height_m * (2.0 * middle - 0.5);
                add_cylinder(text, &along_z(z), slice_m, radius_m * (1.0 - middle), rgba);
            }
        }
        Shape::Hull { points_m } => {
            let Some(first) = points_m.first() else {
                return;
            };
            let (lower, upper) = points_m
                .iter()
                .fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
            let centre = pose * Translation3::from(0.5 * (lower + upper));
            add_box(text, &centre, &(upper - lower), rgba);
        }
    }
}

fn add_box(text: &mut String, pose: &Pose, size_m: &Vector3<f64>, rgba: &str) {
    let (x, y, z) = (size_m.x, size_m.y, size_m.z);
    add_visual(text, pose, &format!("<box size=\"{x} {y} {z}\"/>"), rgba);
}

fn add_sphere(text: &mut String, pose: &Pose, radius_m: f64, rgba: &str) {
    add_visual(
        text,
        pose,
        &format!("<sphere radius=\"{radius_m}\"/>"),
        rgba,
    );
}

fn add_cylinder(text: &mut String, pose: &Pose, length_m: f64, radius_m: f64, rgba: &str) {
    let geometry = format!("<cylinder radius=\"{radius_m}\" length=\"{length_m}\"/>");
    add_visual(text, pose, &geometry, rgba);
}

fn add_visual(text: &mut String, pose: &Pose, geometry: &str, rgba: &str) {
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
        add_shape(&mut text, &cone, &Pose::identity(), BODY_RGBA);
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
