//! The README shows what its first command prints.

use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

const RECORDING: &str = "recordings/pencil_tip.mcap";

/// Lines without what differs from run to run: how long it took.
fn lines(text: &str) -> Vec<String> {
    let timed = |line: &str| match line.split_once(" ms, ") {
        Some((before, after)) if before.trim_start().starts_with("solved") => {
            format!("  solved    in … ms, {after}")
        }
        _ => line.trim_end().to_owned(),
    };
    // Where the time went is said of slow machines.
    let lines = text.lines().filter(|line| !line.starts_with("  took "));
    lines.map(timed).collect()
}

#[test]
fn the_first_screen_is_what_the_first_command_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let command = format!("cargo run --release -- replay {RECORDING}");
    assert!(readme.contains(&command), "the README's first command");
    let (_, after) = readme.split_once("```text\n").expect("a screen");
    let (shown, _) = after.split_once("```").expect("its end");

    let folder = TempDir::new().unwrap();
    let output = folder.path().join("pencil_tip.estimate.mcap");
    let ran = Command::new(env!("CARGO_BIN_EXE_enact"))
        .current_dir(root)
        .args(["replay", RECORDING, "-o"])
        .arg(&output)
        .output()
        .unwrap();
    assert!(ran.status.success(), "{ran:?}");
    let printed = String::from_utf8(ran.stdout).unwrap();
    let beside = "recordings/pencil_tip.estimate.mcap";
    let printed = printed.replace(output.to_str().unwrap(), beside);
    assert_eq!(lines(shown), lines(&printed), "now it prints\n{printed}");
}
