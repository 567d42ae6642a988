//! Scenes that do not say what touches.

use std::path::Path;

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::ingest::{Recording, Source};
use enact::motion::{Scene, Touching};
use enact::pipeline::Pipeline;

/// A contact of which nothing is said.
pub const OPEN: Touching = Touching {
    feature: None,
    other: None,
};

/// The recordings of this repository.
pub const RECORDINGS: [&str; 5] = [
    "pencil_tip",
    "pencil_eraser",
    "hat_box",
    "hat_box_bent",
    "die",
];

/// The scene with nothing said of what touches.
pub fn opened(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for event in 0..scene.events.len() {
        if scene.events[event].kind.collision().is_some() {
            scene.set_contacts(event, &[OPEN]);
        }
    }
    scene
}

/// A scene file without what touches.
pub fn without_contacts(text: &str) -> String {
    let says = |line: &&str| {
        ["feature =", "surface =", "other_feature ="]
            .iter()
            .all(|key| !line.starts_with(key))
    };
    text.lines().filter(says).collect::<Vec<_>>().join("\n")
}

/// A recording of this repository with its scene file edited, read into a pipeline.
pub fn recorded(name: &str, edit: impl Fn(&str) -> String) -> Result<Pipeline> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let recording = Recording::open(&root.join(format!("recordings/{name}.mcap")))?;
    let text = std::str::from_utf8(recording.scene_toml().context("no scene")?)?;
    let scene = scene_from_toml(&edit(text))?;
    let mut pipeline = Pipeline::new(scene.clone());
    let mut source = recording.source(&scene)?;
    while let Some((_, event)) = source.next()? {
        pipeline.push(event);
    }
    Ok(pipeline)
}
