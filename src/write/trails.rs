//! What shows a whole motion at one glance to viewers: the ways of bodies, of the motion and of the performance,
//! as lines, and events as balls with their names.

use foxglove::messages::{
    LinePrimitive, SceneEntity, SpherePrimitive, TextPrimitive, Timestamp, Vector3 as VectorMessage,
    line_primitive,
};
use nalgebra::Vector3;

use super::drawing::{color, entity, point, pose_message};
use crate::math::Pose;
use crate::motion::{Estimate, LinkIndex, PoseSample, Scene};
use crate::sampling::{self, SampledMotion};
use crate::visual::{GHOST_RGBA, Subject};

/// How thick a way is drawn, in pixels.
const THICKNESS: f64 = 2.0;

/// How high names are, in pixels.
const FONT_SIZE: f64 = 14.0;

/// The ball of an event, as a part of its body's radius.
const BALL: f64 = 0.12;

/// Red, green, blue and opacity of events.
const EVENT_RGBA: [f64; 4] = [0.85, 0.15, 0.20, 0.9];

/// The ways of all bodies and the events on them, in the world's frame. A body that does not move, or of which
/// no tracker sees the pose, has no such way.
pub(super) fn trails(
    (scene, estimate): (&Scene, &Estimate),
    motion: &SampledMotion,
    (world_frame, at): (&str, Timestamp),
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
