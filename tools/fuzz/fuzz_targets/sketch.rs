//! Any text as a written sketch, as CSV and as TOML: an error with a place, or rows.
#![no_main]

use std::sync::LazyLock;

use enact::config::{scene_from_toml, sketch_from_csv, sketch_from_toml};
use enact::motion::Scene;
use libfuzzer_sys::fuzz_target;

const BALL: &str = r#"
name = "a ball bounces"
timing = { stamps = "physical" }
[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 50 }
mass_g = 50
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "bounce"
kind = "collision"
body = "ball"
surface = "table"
restitution = 0.8
"#;

static SCENE: LazyLock<Scene> = LazyLock::new(|| scene_from_toml(BALL).expect("a scene"));

fuzz_target!(|text: &str| {
    if let Ok(rows) = sketch_from_csv(text, &SCENE) {
        std::hint::black_box(rows);
    }
    if let Ok(rows) = sketch_from_toml(text, &SCENE) {
        std::hint::black_box(rows);
    }
});
