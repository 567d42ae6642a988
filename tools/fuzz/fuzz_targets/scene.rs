//! Any text as a scene: an error with a place, or a scene; never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = enact::config::scene_from_toml(text);
});
