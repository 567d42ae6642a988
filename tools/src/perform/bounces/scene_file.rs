//! Scene files of cubes that bounce.

use enact::motion::{LinkIndex, Scene, Timing, TrackIndex};
use enact::physics::{Shape, contact};
use nalgebra::Vector3;

/// The scene file of such a motion: one cube, planes, and bounces on them.
///
/// # Panics
/// If there is something else in the scene.
pub fn scene_toml(scene: &Scene) -> String {
    let cube = &scene.links[LinkIndex(0)];
    let half_m = match cube.shape {
        Shape::Cuboid { half_extents_m } => half_extents_m.x,
        _ => panic!("a scene file is written of cubes alone"),
    };
    let stamps = match scene.timing {
        Timing::Known => "physical",
        Timing::Unknown { .. } => "tempo",
        Timing::Edited => panic!("a scene file is written of motions with marks alone"),
    };
    let mount = &scene.tracks[TrackIndex(0)].link_from_tracker;
    let q = mount.rotation;
    let mut text = format!(
        "name = {:?}\ngravity_m_s2 = {}\n[timing]\nstamps = {stamps:?}\n[[body]]\nname = \"cube\"\n\
         shape = {{ kind = \"cuboid\", size_mm = {} }}\nmass_kg = {:?}\nmoments_kg_m2 = {}\n\
         drag_quadratic_per_m = {:?}\n\
         tracker = {{ position_mm = {}, orientation_wxyz = [{:?}, {:?}, {:?}, {:?}] }}\n\
         [body.features_mm]\n",
        scene.name,
        list(&scene.gravity_m_s2),
        list(&Vector3::repeat(2e3 * half_m)),
        cube.body.mass_kg(),
        list(&cube.body.moments_kg_m2()),
        cube.body.drag().quadratic_per_m,
        list(&(mount.translation.vector * 1e3)),
        q.w,
        q.i,
        q.j,
        q.k,
    );
    for feature in &cube.features {
        if let contact::Feature::Point { point_m, .. } = feature.geometry {
            text += &format!("{} = {}\n", feature.name, list(&(point_m * 1e3)));
        }
    }
    for surface in &scene.surfaces {
        let (point_m, normal) = surface.plane().expect("surfaces are planes");
        text += &format!(
            "[[surface]]\nname = {:?}\npoint_mm = {}\nnormal = {}\n",
            surface.name,
            list(&(point_m * 1e3)),
            list(&normal),
        );
    }
    for event in &scene.events {
        text += &format!(
            "[[event]]\nname = {:?}\nkind = {:?}\n",
            event.name,
            event.kind.as_str()
        );
        if event.kind.waypoint().is_some() {
            text += "body = \"cube\"\n";
        }
        if let Some(collision) = event.kind.collision()
            && let Some(feature) = collision.contacts[0].feature
        {
            let law = scene.law_of(collision);
            let (restitution, friction) = (law.restitution, law.friction);
            text += &format!(
                "body = \"cube\"\nfeature = {:?}\nsurface = \"table\"\nrestitution = {restitution:?}\n\
                 friction = {friction:?}\n",
                cube.features[feature].name,
            );
        }
    }
    text
}

/// Three numbers of a scene file.
fn list(of: &Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", of.x, of.y, of.z)
}
