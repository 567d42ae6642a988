//! Tests that cannot run where they are: said, and recorded for whoever counts.

use std::path::{Path, PathBuf};

/// Where skips are recorded, one file each: `skips` in cargo's target folder.
fn folder() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    root.join(target).join("skips")
}

/// Says that a test, or the rest of it, does not run here, and why. `.ci/run` lists what is
/// recorded and fails where `.ci/skips.allowed` does not have its name.
pub fn skip(name: &str, why: &str) {
    eprintln!("skipped: {name}: {why}");
    let folder = folder();
    std::fs::create_dir_all(&folder).expect("a folder for skips");
    std::fs::write(folder.join(name), format!("{why}\n")).expect("a record of the skip");
}
