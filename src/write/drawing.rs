//! The scene as viewers draw it: bodies in the frames of their estimates, the static world in
//! the world frame.

use std::path::Path;

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, Point3, Pose as PoseMessage, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, Timestamp, TriangleListPrimitive, Vector3 as VectorMessage,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::error::WriteError;
use super::topics;
use crate::math::Pose;
use crate::motion::{GoalTarget, Scene, Stamp};
use crate::physics::Shape;
use crate::physics::shape::hull_triangles;
use crate::wire::encode;

const BODY: Color = color(0.95, 0.65, 0.20, 1.0);
#[cfg(feature = "live")]
const GHOST: Color = color(0.95, 0.65, 0.20, 0.35);
#[cfg(feature = "live")]
const LIVE: Color = color(0.30, 0.60, 0.95, 0.35);
const OBSTACLE: Color = color(0.45, 0.55, 0.65, 0.5);
const SURFACE: Color = color(0.75, 0.75, 0.75, 0.5);
const GOAL: Color = color(0.25, 0.80, 0.35, 0.3);

/// How thick a surface is drawn \[m\]; it lies below the plane.
const SURFACE_THICKNESS_M: f64 = 1e-3;

const fn color(r: f64, g: f64, b: f64, a: f64) -> Color {
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
    for body in &scene.bodies {
        let sketch = (topics::sketch_frame(&body.name), "sketch", GHOST);
        let live = (topics::live_frame(&body.name), "live", LIVE);
        for (frame, word, color) in [sketch, live] {
            let mut entity = entity(at, &frame, format!("{word}/{}", body.name));
            add_shape(&mut entity, &body.shape, &Pose::identity(), color);
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
    let mut entities = Vec::new();
    for body in &scene.bodies {
        let frame = topics::estimate_frame(&body.name);
        let mut entity = entity(at, &frame, format!("body/{}", body.name));
        add_shape(&mut entity, &body.shape, &Pose::identity(), BODY);
        entities.push(entity);
    }
    for obstacle in &scene.obstacles {
        let mut entity = entity(at, world_frame, format!("obstacle/{}", obstacle.name));
        add_shape(
            &mut entity,
            &obstacle.shape,
            &obstacle.world_from_shape,
            OBSTACLE,
        );
        entities.push(entity);
    }
    for surface in &scene.surfaces {
        let Some(plane) = surface.plane() else {
            continue;
        };
        let mut entity = entity(at, world_frame, format!("surface/{}", surface.name));
        let slab = Vector3::new(surface_side_m, surface_side_m, SURFACE_THICKNESS_M);
        entity
            .cubes
            .push(cube(&world_from_slab(plane), &slab, SURFACE));
        entities.push(entity);
    }
    for (index, goal) in scene.goals.iter().enumerate() {
        let (event, body) = (&scene.events[goal.event], &scene.bodies[goal.body]);
        let id = format!("goal/{index}/{}/{}", event.name, body.name);
        let mut entity = entity(at, world_frame, id);
        match &goal.target {
            GoalTarget::Pose { world_from_body } => {
                add_shape(&mut entity, &body.shape, world_from_body, GOAL);
            }
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                let size = upper_m - lower_m;
                if size.iter().all(|side| side.is_finite()) {
                    let centre = Translation3::from(0.5 * (upper_m + lower_m));
                    let pose = Pose::from_parts(centre, UnitQuaternion::identity());
                    // A side of no length would not be seen.
                    entity
                        .cubes
                        .push(cube(&pose, &size.map(|s| s.max(SURFACE_THICKNESS_M)), GOAL));
                }
            }
        }
        entities.push(entity);
    }
    Ok(entities)
}

/// Pose of a slab whose upper side is the plane of that point and normal.
pub(super) fn world_from_slab((point_m, normal): (Vector3<f64>, Vector3<f64>)) -> Pose {
    let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &normal).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    });
    let centre_m = point_m - 0.5 * SURFACE_THICKNESS_M * normal;
    Pose::from_parts(centre_m.into(), rotation)
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
    match shape {
        // Viewers know no rounded boxes: its outer sides are drawn.
        Shape::Cuboid { half_extents_m } | Shape::RoundedCuboid { half_extents_m, .. } => {
            entity
                .cubes
                .push(cube(pose, &(2.0 * half_extents_m), color));
        }
        Shape::Sphere { radius_m } => entity.spheres.push(sphere(pose, *radius_m, color)),
        Shape::Cylinder {
            half_length_m,
            radius_m,
        } => entity
            .cylinders
            .push(cylinder(pose, *half_length_m, *radius_m, 1.0, color)),
        Shape::Capsule {
            half_length_m,
            radius_m,
        } => {
            entity
                .cylinders
                .push(cylinder(pose, *half_length_m, *radius_m, 1.0, color));
            for z in [-*half_length_m, *half_length_m] {
                let cap = pose * Translation3::new(0.0, 0.0, z);
                entity.spheres.push(sphere(&cap, *radius_m, color));
            }
        }
        Shape::Cone {
            half_height_m,
            radius_m,
        } => {
            // The origin is a quarter of the height above the base.
            let middle = pose * Translation3::new(0.0, 0.0, 0.5 * half_height_m);
            entity
                .cylinders
                .push(cylinder(&middle, *half_height_m, *radius_m, 0.0, color));
        }
        Shape::Hull { points_m } => entity.triangles.push(TriangleListPrimitive {
            pose: Some(pose_message(pose)),
            points: hull_triangles(points_m)
                .unwrap_or_default()
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
        assert_eq!(z, Some(-0.5 * SURFACE_THICKNESS_M));
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
            add_shape(&mut entity, &shape, &Pose::identity(), BODY);
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
