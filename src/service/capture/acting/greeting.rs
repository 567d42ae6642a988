//! What a page is told once it is let in, and as long as it is there.

use serde::Serialize;
use serde_json::{Value, json};

use super::super::event::Status;
use super::super::history::TakeLine;
use crate::ingest::live::{StreamTopic, Token};
use crate::motion::{PoseSample, Scene, Stamp};
use crate::service::provenance::scene_provenance;
use crate::write::export::{ExportedBody, Key, glb};
use crate::write::show::tracker_mount;

/// Takes that a page is told of.
const TAKES: usize = 5;

/// How far tables are drawn about the origin \[m\].
const REACH_M: f64 = 0.35;

/// A stream that a page may be the tracker of.
#[derive(Clone, Debug, Serialize)]
struct ActedStream {
    /// Its topic.
    topic: String,
    /// The body that the tracker is mounted on: the name of its node in the scene's glTF.
    body: String,
    /// Where the tracker is in the body's frame \[m\].
    position_m: [f64; 3],
    /// The turn of the tracker in the body's frame.
    quaternion_xyzw: [f64; 4],
    /// Names of the body's features that may be a tip: its corners.
    features: Vec<String>,
}

/// What does not change while the daemon runs.
#[derive(Clone, Debug)]
pub(super) struct Greeting(Value);

impl Greeting {
    pub(super) fn new(scene: &Scene, topics: &[StreamTopic], events: &[String]) -> Self {
        let streams: Vec<ActedStream> = topics
            .iter()
            .map(|of| {
                let mount = tracker_mount(scene, of.track);
                let link = scene.link_seen_by(of.track);
                // What is round touches elsewhere, wherever it is turned.
                let tips = link.features.iter().filter(|of| {
                    let (_, radius_m) = of.geometry.skeleton_m(&of.geometry.place_m());
                    of.geometry.kind() == "point" && radius_m == 0.0
                });
                ActedStream {
                    topic: of.topic.clone(),
                    body: link.name.clone(),
                    position_m: mount.position_m.into(),
                    quaternion_xyzw: mount.quaternion_xyzw,
                    features: tips.map(|of| of.name.clone()).collect(),
                }
            })
            .collect();
        let surfaces: Vec<&str> = scene.surfaces.iter().map(|of| of.name.as_str()).collect();
        Self(json!({
            "what": "paired",
            "scene": scene.name,
            "streams": streams,
            "events": events,
            "surfaces": surfaces,
        }))
    }

    /// The first message to a page, with the key by which it comes back.
    pub(super) fn text(&self, key: &Token) -> String {
        let mut said = self.0.clone();
        said["key"] = key.text().into();
        said.to_string()
    }
}

/// How everything stands.
pub(super) fn state_text(status: &Status, troubles: &[String], takes: &[TakeLine]) -> String {
    json!({
        "what": "state",
        "take": status.take,
        "messages": status.messages,
        "marks": status.counts.marks.received,
        "troubles": troubles,
        "takes": &takes[..takes.len().min(TAKES)],
    })
    .to_string()
}

/// What went wrong, in words.
pub(super) fn refusal_text(why: &str) -> String {
    json!({ "what": "refused", "why": why }).to_string()
}

/// The scene as binary glTF, each body at the origin. A table is drawn as far as bodies go: here, to [`REACH_M`].
pub(super) fn scene_glb(scene: &Scene) -> Vec<u8> {
    let key = |[at_s, x_m, y_m]: [f64; 3]| Key {
        sample: PoseSample::new(
            Stamp(0).after(at_s),
            [x_m, y_m, 0.0].into(),
            [0.0, 0.0, 0.0, 1.0],
        ),
        event: None,
        is_exact: true,
    };
    let places = [[0.0; 3], [1.0, -REACH_M, -REACH_M], [2.0, REACH_M, REACH_M]];
    let body = |link| ExportedBody {
        link,
        keys: places.map(key).into(),
        acted: Vec::new(),
    };
    let bodies: Vec<ExportedBody> = scene.links.keys().map(body).collect();
    let provenance = scene_provenance(scene, "");
    glb(scene, &bodies, Stamp(0), 1.0, &provenance)
}
