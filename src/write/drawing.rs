//! The scene as viewers draw it: bodies in the frames of their estimates, the static world in
//! the world frame.

use std::path::Path;

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, Point3, Pose as PoseMessage, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, Timestamp, TriangleListPrimitive, Vector3 as VectorMessage,
};
use nalgebra::Vector3;

use super::error::WriteError;
use super::topics;
use crate::math::Pose;
use crate::motion::{Scene, Stamp};
use crate::physics::Shape;
#[cfg(any(test, feature = "live"))]
use crate::visual::GHOST_RGBA;
use crate::visual::{Form, Subject, primitives, visuals};
use crate::wire::encode;

/// A body in the frame of its performance, beside its estimate.
#[cfg(any(test, feature = "live"))]
const GHOST: Color = color(GHOST_RGBA);
/// A body in the frame of its tracker.
#[cfg(feature = "live")]
const LIVE: Color = color([0.30, 0.60, 0.95, 0.35]);

const fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}

/// The `foxglove.SceneUpdate` of the scene; surfaces are drawn `surface_side_m` wide.
pub(super) fn scene_update(
    path: &Path,
    scene: &Scene,
    world_frame: &str,
    at: Stamp,
    surface_side_m: f64,
) -> Result<Vec<u8>, WriteError> {
    let entities = entities(path, scene, world_frame, at, surface_side_m)?;
    Ok(bytes_of(entities))
}

/// The same with every body once more as a ghost in the frame of its performance, and once in
/// that of its tracker.
#[cfg(feature = "live")]
pub(super) fn live_scene_update(
    scene: &Scene,
    world_frame: &str,
    at: Stamp,
    surface_side_m: f64,
) -> Result<Vec<u8>, WriteError> {
    let path = Path::new(topics::SCENE);
    let mut entities = entities(path, scene, world_frame, at, surface_side_m)?;
    let at = encode::timestamp(at).map_err(WriteError::encode(path, topics::SCENE))?;
    for body in &scene.links {
        let sketch = (topics::sketch_frame(&body.name), "sketch", GHOST);
        let live = (topics::live_frame(&body.name), "live", LIVE);
        for (frame, word, color) in [sketch, live] {
            let mut entity = entity(at, &frame, format!("{word}/{}", body.name));
            add_shape(&mut entity, &body.shape, &body.given_from_shape(), color);
            entities.push(entity);
        }
    }
    Ok(bytes_of(entities))
}

fn bytes_of(entities: Vec<SceneEntity>) -> Vec<u8> {
    encode::bytes_of(&SceneUpdate {
        deletions: Vec::new(),
        entities,
    })
}

fn entities(
    path: &Path,
    scene: &Scene,
    world_frame: &str,
    at: Stamp,
    surface_side_m: f64,
) -> Result<Vec<SceneEntity>, WriteError> {
    let at = encode::timestamp(at).map_err(WriteError::encode(path, topics::SCENE))?;
    let entities = visuals(scene, surface_side_m).into_iter().map(|visual| {
        let (frame, id) = names(scene, world_frame, visual.subject);
        let mut entity = entity(at, &frame, id);
        if let Some(shape) = &visual.shape {
            let color = color(visual.subject.rgba());
            add_shape(&mut entity, shape, &visual.frame_from_shape, color);
        }
        entity
    });
    Ok(entities.collect())
}

/// The frame in which something is drawn, and its entity's id.
pub(super) fn names(scene: &Scene, world_frame: &str, subject: Subject) -> (String, String) {
    let world = world_frame.to_owned();
    match subject {
        Subject::Link(index) => {
            let name = &scene.links[index].name;
            (topics::estimate_frame(name), format!("body/{name}"))
        }
        Subject::Obstacle(index) => (world, format!("obstacle/{}", scene.obstacles[index].name)),
        Subject::Surface(index) => (world, format!("surface/{}", scene.surfaces[index].name)),
        Subject::Goal(index) => {
            let goal = &scene.goals[index];
            let (event, body) = (&scene.events[goal.event], &scene.links[goal.link]);
            (world, format!("goal/{index}/{}/{}", event.name, body.name))
        }
    }
}

fn entity(at: Timestamp, frame: &str, id: String) -> SceneEntity {
    SceneEntity {
        timestamp: Some(at),
        frame_id: frame.to_owned(),
        id,
        frame_locked: true,
        ..SceneEntity::default()
    }
}

fn add_shape(entity: &mut SceneEntity, shape: &Shape, pose: &Pose, color: Color) {
    for primitive in primitives(shape) {
        let pose = primitive.pose(pose);
        match primitive.form {
            Form::Cuboid { sides_m } => entity.cubes.push(cube(&pose, &sides_m, color)),
            Form::Sphere { radius_m } => entity.spheres.push(sphere(&pose, radius_m, color)),
            Form::Frustum {
                half_length_m,
                radius_m,
                top_scale,
            } => {
                let frustum = cylinder(&pose, half_length_m, radius_m, top_scale, color);
                entity.cylinders.push(frustum);
            }
            Form::Triangles(triangles) => entity.triangles.push(TriangleListPrimitive {
                pose: Some(pose_message(&pose)),
                points: triangles
                    .iter()
                    .flatten()
                    .map(|point| Point3 {
                        x: point.x,
                        y: point.y,
                        z: point.z,
                    })
                    .collect(),
                color: Some(color),
                ..TriangleListPrimitive::default()
            }),
        }
    }
}

fn cube(pose: &Pose, size_m: &Vector3<f64>, color: Color) -> CubePrimitive {
    CubePrimitive {
        pose: Some(pose_message(pose)),
        size: Some(vector(size_m)),
        color: Some(color),
    }
}

fn sphere(pose: &Pose, radius_m: f64, color: Color) -> SpherePrimitive {
    SpherePrimitive {
        pose: Some(pose_message(pose)),
        size: Some(vector(&Vector3::repeat(2.0 * radius_m))),
        color: Some(color),
    }
}

fn cylinder(
    pose: &Pose,
    half_length_m: f64,
    radius_m: f64,
    top_scale: f64,
    color: Color,
) -> CylinderPrimitive {
    let diameter_m = 2.0 * radius_m;
    CylinderPrimitive {
        pose: Some(pose_message(pose)),
        size: Some(vector(&Vector3::new(
            diameter_m,
            diameter_m,
            2.0 * half_length_m,
        ))),
        bottom_scale: 1.0,
        top_scale,
        color: Some(color),
    }
}

fn vector(v: &Vector3<f64>) -> VectorMessage {
    VectorMessage {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

fn pose_message(pose: &Pose) -> PoseMessage {
    let q = pose.rotation.quaternion();
    PoseMessage {
        position: Some(vector(&pose.translation.vector)),
        orientation: Some(Quaternion {
            x: q.i,
            y: q.j,
            z: q.k,
            w: q.w,
        }),
    }
}

#[cfg(test)]
mod tests {
    use foxglove::Decode;

    use super::*;
    use crate::motion::fixture::scene;

    #[test]
    fn bodies_move_with_their_frames_and_the_world_stands_still() {
        let scene = scene();
        let bytes = scene_update(Path::new("x"), &scene, "map", Stamp(5), 2.0).expect("encode");
        let update = SceneUpdate::decode(&bytes[..]).expect("decode");
        let found: Vec<_> = update
            .entities
            .iter()
            .map(|entity| (entity.id.as_str(), entity.frame_id.as_str()))
            .collect();
        assert_eq!(
            found,
            [
                ("body/pencil", "pencil_estimate"),
                ("obstacle/mug floor", "map"),
                ("surface/table", "map"),
                ("goal/0/landing/pencil", "map"),
            ]
        );
        let pencil = update.entities[0].cylinders[0];
        assert_eq!(pencil.size.map(|size| size.z), Some(0.19));
        // The slab's upper side is the table.
        let table = update.entities[2].cubes[0];
        let z = table.pose.and_then(|pose| pose.position).map(|p| p.z);
        assert_eq!(z, Some(-0.5e-3));
    }

    #[test]
    fn every_shape_is_drawn_where_it_is() {
        let points_m = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
            .map(|p| Vector3::from(p).map(f64::from))
            .to_vec();
        let shapes = [
            (Shape::Sphere { radius_m: 0.1 }, [0, 1, 0, 0]),
            (
                Shape::Cuboid {
                    half_extents_m: Vector3::repeat(0.1),
                },
                [1, 0, 0, 0],
            ),
            (
                Shape::Capsule {
                    half_length_m: 0.2,
                    radius_m: 0.1,
                },
                [0, 2, 1, 0],
            ),
            (
                Shape::Cone {
                    half_height_m: 0.2,
                    radius_m: 0.1,
                },
                [0, 0, 1, 0],
            ),
            (Shape::Hull { points_m }, [0, 0, 0, 1]),
        ];
        for (shape, counts) in shapes {
            let mut entity = SceneEntity::default();
            add_shape(&mut entity, &shape, &Pose::identity(), GHOST);
            let found = [
                entity.cubes.len(),
                entity.spheres.len(),
                entity.cylinders.len(),
                entity.triangles.len(),
            ];
            assert_eq!(found, counts, "{shape:?}");
            if let Some(triangles) = entity.triangles.first() {
                assert_eq!(triangles.points.len(), 4 * 3);
            }
        }
    }
}
