//! Any bytes as a recording of the pencil, replayed whole, for a quarter of a second at most: an error, or a file
//! that can be read.
#![no_main]

mod desk;

use std::path::PathBuf;
use std::sync::LazyLock;
use std::time::Duration;

use enact::service::{ReplayJob, inspect, replay};
use enact::wire::container::Container;
use libfuzzer_sys::fuzz_target;

/// The scene, where the recording has none that is valid.
static SCENE: LazyLock<PathBuf> = LazyLock::new(|| {
    let path = std::env::temp_dir().join(format!("enact-fuzz-{}.toml", std::process::id()));
    std::fs::write(&path, include_str!("../../../config/pencil_tip.toml")).expect("write");
    path
});

fuzz_target!(|bytes: &[u8]| {
    let input = desk::file("in.mcap", bytes);
    let _ = std::hint::black_box(inspect(&input, None, None));
    for scene in [None, Some(SCENE.clone())] {
        let output = input.with_file_name("out.mcap");
        let job = ReplayJob {
            input: input.clone(),
            output: Some(output.clone()),
            scene,
            is_free_auto: false,
            is_diagnosing: true,
            rate: None,
            publish: None,
            deadline: Some(Duration::from_millis(250)),
        };
        if replay(&job).is_ok() {
            let written = std::fs::read(&output).expect("written");
            let container = Container::new(written).expect("MCAP");
            assert!(!container.damages().is_loss(), "{:?}", container.damages());
        }
    }
});
