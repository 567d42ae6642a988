//! What shows a whole motion at one glance to viewers: the ways of bodies, of the motion and of the performance,
//! as lines, and events as balls with their names.

use std::path::Path;

use foxglove::messages::{
    LinePrimitive, SceneEntity, SpherePrimitive, TextPrimitive, Timestamp,
    Vector3 as VectorMessage, line_primitive,
};
use nalgebra::Vector3;

use super::drawing::{bytes_of, color, entities, entity, ghost, point, pose_message, timestamp};
use super::error::WriteError;
use crate::math::Pose;
use crate::motion::{Estimate, LinkIndex, PoseSample, Scene};
use crate::sampling::{self, SampledMotion};
use crate::visual::{GHOST_RGBA, Patch, Subject};

/// How thick a way is drawn, in pixels.
const THICKNESS: f64 = 2.0;

/// How high names are, in pixels.
const FONT_SIZE: f64 = 14.0;

/// The ball of an event, as a part of its body's radius.
const BALL: f64 = 0.12;

/// Red, green, blue and opacity of events.
const EVENT_RGBA: [f64; 4] = [0.85, 0.15, 0.20, 0.9];

/// The `foxglove.SceneUpdate` of a motion, from its physical time zero on; surfaces are drawn as far as their
/// patches.
pub(super) fn scene_update(
    path: &Path,
    scene: &Scene,
    estimate: &Estimate,
    motion: &SampledMotion,
    world_frame: &str,
    patches: &[Option<Patch>],
) -> Result<Vec<u8>, WriteError> {
    let at = timestamp(path, motion.zero)?;
    let mut entities = entities(scene, world_frame, at, patches);
    let seen = motion.sketches.iter_enumerated();
    let seen = seen.filter(|(_, samples)| !samples.is_empty());
    entities.extend(seen.map(|(link, _)| ghost(scene, link, at)));
    entities.extend(trails(scene, estimate, motion, world_frame, at));
    Ok(bytes_of(entities))
}

/// The ways of all bodies and the events on them, in the world's frame. A body that does not move, or of which
/// no tracker sees the pose, has no such way.
fn trails(
    scene: &Scene,
    estimate: &Estimate,
    motion: &SampledMotion,
    world_frame: &str,
    at: Timestamp,
) -> Vec<SceneEntity> {
    let mut entities = Vec::new();
    let mut acted = GHOST_RGBA;
    // A line is thinner than a body: as pale it would not be seen.
    acted[3] = 0.7;
    for (link, of) in scene.links.iter_enumerated() {
        let ways = [
            ("way", &motion.estimates[link], Subject::Link(link).rgba()),
            ("acted way", &motion.sketches[link], acted),
        ];
        for (word, samples, rgba) in ways {
            if samples.len() > 1 {
                let id = format!("{word}/{}", of.name);
                let mut entity = entity(at, world_frame, id);
                entity.lines.push(line(samples, rgba));
                entities.push(entity);
            }
        }
    }
    for (index, event) in estimate.events.iter().enumerate() {
        let name = &scene.events[event.event].name;
        let stamp = sampling::stamp(motion.zero, event.time_s);
        let mut entity = entity(at, world_frame, format!("event/{index}/{name}"));
        for (link, of) in scene.links.iter_enumerated() {
            let samples = &motion.estimates[link];
            let here = samples.binary_search_by_key(&stamp, |sample| sample.stamp);
            let (Ok(here), true) = (here, is_of(scene, event.event, link)) else {
                continue;
            };
            let position_m = samples[here].position_m;
            let side_m = 2.0 * BALL * of.shape.radius_m();
            entity.spheres.push(SpherePrimitive {
                pose: Some(pose_message(&at_position(position_m))),
                size: Some(VectorMessage {
                    x: side_m,
                    y: side_m,
                    z: side_m,
                }),
                color: Some(color(EVENT_RGBA)),
            });
            if entity.texts.is_empty() {
                entity.texts.push(TextPrimitive {
                    pose: Some(pose_message(&at_position(position_m))),
                    billboard: true,
                    font_size: FONT_SIZE,
                    scale_invariant: true,
                    color: Some(color(EVENT_RGBA)),
                    text: name.clone(),
                });
            }
        }
        if !entity.spheres.is_empty() {
            entities.push(entity);
        }
    }
    entities
}

/// Whether an event is one of that body.
fn is_of(scene: &Scene, event: usize, link: LinkIndex) -> bool {
    let waypoint = scene.events[event].kind.waypoint();
    waypoint.map_or_else(
        || scene.concerns(event, scene.mechanism_of(link)),
        |of| of == link,
    )
}

fn at_position(position_m: Vector3<f64>) -> Pose {
    Pose::translation(position_m.x, position_m.y, position_m.z)
}

fn line(samples: &[PoseSample], rgba: [f64; 4]) -> LinePrimitive {
    let points = samples.iter().map(|sample| point(&sample.position_m));
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip.into(),
        pose: Some(pose_message(&Pose::identity())),
        thickness: THICKNESS,
        scale_invariant: true,
        points: points.collect(),
        color: Some(color(rgba)),
        ..LinePrimitive::default()
    }
}

#[cfg(test)]
mod tests {
    use foxglove::Decode;
    use foxglove::messages::{Point3, SceneUpdate};

    use super::*;
    use crate::fixture::{estimate, scene, sketch};
    use crate::visual::patches;

    #[test]
    fn bodies_move_with_their_frames_and_the_world_stands_still() {
        let (scene, sketch, estimate) = (scene(), sketch(), estimate());
        let motion = SampledMotion::new(&scene, &sketch, &estimate, None, 240.0).expect("frames");
        let patches = patches(&scene, &motion.estimates);
        let bytes = scene_update(Path::new("x"), &scene, &estimate, &motion, "map", &patches)
            .expect("encode");
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
                ("sketch/pencil", "pencil_sketch"),
                ("way/pencil", "map"),
                ("acted way/pencil", "map"),
                ("event/0/bounce", "map"),
                ("event/1/landing", "map"),
            ]
        );
        let pencil = update.entities[0].cylinders[0];
        assert_eq!(pencil.size.map(|size| size.z), Some(0.19));
        // The slab's upper side is the table.
        let table = update.entities[2].cubes[0];
        let z = table.pose.and_then(|pose| pose.position).map(|p| p.z);
        assert!(z.is_some_and(|z| (z + 0.5e-3).abs() < 1e-12), "{z:?}");
        // The ghost is the body, seen through.
        let ghost = update.entities[4].cylinders[0];
        assert_eq!(ghost.size, pencil.size);
        assert!(ghost.color.is_some_and(|color| color.a < 0.5));
        // Ways pass through every pose, and events are on them.
        for (entity, samples) in [(5, &motion.estimates), (6, &motion.sketches)] {
            let line = &update.entities[entity].lines[0];
            let samples = samples.iter().flatten();
            let points = samples.map(|sample| point(&sample.position_m));
            assert_eq!(line.points, points.collect::<Vec<_>>());
        }
        let bounce = &update.entities[7];
        let at = bounce.spheres[0].pose.and_then(|pose| pose.position);
        let at = at.map(|at| Point3 {
            x: at.x,
            y: at.y,
            z: at.z,
        });
        assert!(
            update.entities[5].lines[0]
                .points
                .iter()
                .any(|on| Some(*on) == at)
        );
        assert_eq!(bounce.texts[0].text, "bounce");
    }
}
