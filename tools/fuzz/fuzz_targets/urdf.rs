//! Any text as a robot description: an error with a place, or a scene that can be read.
#![no_main]

use enact::config::{scene_from_toml, scene_from_urdf};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(made) = scene_from_urdf(text) {
        let _ = std::hint::black_box(scene_from_toml(&made.toml));
    }
});
