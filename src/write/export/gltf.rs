//! Binary glTF 2.0: a node per body with keys, and what stands still.
//!
//! The file is y-up, as glTF wants it, by one node over all others; below it everything is as it is in the
//! scene, z-up and in metres. A body's node is the frame in which its scene gives it.

use serde_json::json;
use typed_index_collections::TiVec;

use super::super::drawing;
use super::document::Document;
use super::frames::ExportedBody;
use crate::motion::{LinkIndex, PoseSample, Scene, Stamp};
use crate::report::ExportProvenance;
use crate::visual::{GHOST_RGBA, Subject, body_rgba, patches, visuals};

/// The file. Its times begin at a frame: zero is physical time zero, or the last frame before the first
/// key where that is earlier.
pub fn glb(
    scene: &Scene,
    bodies: &[ExportedBody],
    zero: Stamp,
    frame_rate_hz: f64,
    provenance: &ExportProvenance,
) -> Vec<u8> {
    let all = || {
        bodies
            .iter()
            .flat_map(|body| body.keys.iter().chain(&body.acted))
    };
    let first = all().map(|key| key.sample.stamp).min().unwrap_or(zero);
    let frame = (first.seconds_since(zero) * frame_rate_hz).floor().min(0.0);
    let mut file = Document::new(zero, frame.abs() / frame_rate_hz);
    let mut estimates: TiVec<LinkIndex, Vec<PoseSample>> =
        scene.links.iter().map(|_| Vec::new()).collect();
    for body in bodies {
        estimates[body.link] = body.keys.iter().map(|key| key.sample).collect();
    }
    for visual in visuals(scene, &patches(scene, &estimates)) {
        let Some(shape) = &visual.shape else {
            continue;
        };
        let rgba = visual.subject.rgba();
        if let Subject::Link(link) = visual.subject {
            let Some(body) = bodies.iter().find(|body| body.link == link) else {
                continue;
            };
            let name = scene.links[link].name.as_str();
            let geometry = file.geometry(shape, &visual.frame_from_shape);
            let look = format!("body {name}");
            file.moving(name, geometry, (&look, body_rgba(link)), &body.keys);
            if !body.acted.is_empty() {
                let (name, look) = (format!("{name} acted"), ("acted", GHOST_RGBA));
                file.moving(&name, geometry, look, &body.acted);
            }
        } else {
            let (_, name) = drawing::names(scene, "", visual.subject);
            let look = name.split('/').next().unwrap_or_default().to_owned();
            let geometry = file.geometry(shape, &visual.frame_from_shape);
            file.still(&name, geometry, (&look, rgba));
        }
    }
    let mut extras = json!(provenance);
    extras["physical_zero_ns"] = zero.0.into();
    extras["physical_zero_s"] = file.before_s.into();
    extras["frame_rate_hz"] = frame_rate_hz.into();
    let last = all().map(|key| key.sample.stamp).max().unwrap_or(zero);
    let last_s = last.seconds_since(zero) + file.before_s;
    extras["last_frame"] = (last_s * frame_rate_hz).ceil().into();
    file.finish(&scene.name, &provenance.program, extras)
}
