//! The scene as viewers draw it: bodies in the frames of their estimates and, as ghosts, in those of their
//! performances, the static world in the world frame. [`trails`](super::trails) adds a motion.

use std::path::Path;

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, Point3, Pose as PoseMessage, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, Timestamp, TriangleListPrimitive, Vector3 as VectorMessage,
};
use nalgebra::Vector3;

use super::error::WriteError;
use super::topics;
use crate::math::Pose;
use crate::motion::{LinkIndex, Scene, Stamp};
use crate::physics::Shape;
use crate::visual::{Form, GHOST_RGBA, Patch, Subject, primitives, visuals};
use crate::wire::encode;

/// A body in the frame of its performance, beside its estimate.
const GHOST: Color = color(GHOST_RGBA);
/// A body in the frame of its tracker.
#[cfg(feature = "live")]
const LIVE: Color = color([0.30, 0.60, 0.95, 0.35]);

pub(super) const fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}

/// A body as it was acted, in the frame of its performance.
pub(super) fn ghost(scene: &Scene, link: LinkIndex, at: Timestamp) -> SceneEntity {
    let body = &scene.links[link];
    let frame = topics::sketch_frame(&body.name);
    let mut entity = entity(at, &frame, format!("sketch/{}", body.name));
    add_shape(&mut entity, &body.shape, &body.given_from_shape(), GHOST);
    entity
}

pub(super) fn timestamp(path: &Path, at: Stamp) -> Result<Timestamp, WriteError> {
    encode::timestamp(at).map_err(WriteError::encode(path, topics::SCENE))
}

/// The scene without a motion, with every body once more as a ghost in the frame of its performance, and once in
/// that of its tracker.
#[cfg(feature = "live")]
pub(super) fn live_scene_update(
    scene: &Scene,
    world_frame: &str,
    at: Stamp,
    patches: &[Option<Patch>],
) -> Result<Vec<u8>, WriteError> {
    let at = timestamp(Path::new(topics::SCENE), at)?;
    let mut entities = entities(scene, world_frame, at, patches);
    for (link, body) in scene.links.iter_enumerated() {
        entities.push(ghost(scene, link, at));
        let mut live = entity(
            at,
            &topics::live_frame(&body.name),
            format!("live/{}", body.name),
        );
        add_shape(&mut live, &body.shape, &body.given_from_shape(), LIVE);
        entities.push(live);
    }
    Ok(bytes_of(entities))
}

pub(super) fn bytes_of(entities: Vec<SceneEntity>) -> Vec<u8> {
    encode::bytes_of(&SceneUpdate {
        deletions: Vec::new(),
        entities,
    })
}

pub(super) fn entities(
    scene: &Scene,
    world_frame: &str,
    at: Timestamp,
    patches: &[Option<Patch>],
) -> Vec<SceneEntity> {
    let entities = visuals(scene, patches).into_iter().map(|visual| {
        let (frame, id) = names(scene, world_frame, visual.subject);
        let mut entity = entity(at, &frame, id);
        if let Some(shape) = &visual.shape {
            let color = color(visual.subject.rgba());
            add_shape(&mut entity, shape, &visual.frame_from_shape, color);
        }
        entity
    });
    entities.collect()
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

pub(super) fn entity(at: Timestamp, frame: &str, id: String) -> SceneEntity {
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
                points: triangles.iter().flatten().map(point).collect(),
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

pub(super) fn point(at: &Vector3<f64>) -> Point3 {
    Point3 {
        x: at.x,
        y: at.y,
        z: at.z,
    }
}

fn vector(v: &Vector3<f64>) -> VectorMessage {
    VectorMessage {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

pub(super) fn pose_message(pose: &Pose) -> PoseMessage {
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
    use super::*;

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
