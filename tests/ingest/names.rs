//! Names in files may be anything; what the program prints of them moves no cursor, forges no line and
//! does not turn the direction of writing.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use enact::ingest::Recording;
use enact::report::prints;
use serde_json::Value;

use crate::raw_mcap;

/// Added to every name of a recording: clears the screen, sets the title, forges a line of the account,
/// turns the direction of writing.
const EVIL: &str = "\u{1b}[2J\u{1b}]0;t\u{7}\n  lost: forged\r\u{9b}31m\u{202e}\u{2028}";
const SHOWN: &str = r"\u{1b}[2J\u{1b}]0;t\u{7}\n  lost: forged\r\u{9b}31m\u{202e}\u{2028}";

/// Added to every name of a scene: control characters are refused there, these are not.
const TURNED: &str = "\u{202e}\u{2066}\u{200b}x";
const TURNED_SHOWN: &str = r"\u{202e}\u{2066}\u{200b}x";

fn evil(name: &str) -> String {
    format!("{name}{EVIL}")
}

/// The recording of a pencil in which everything that has a name is called something evil.
fn recording() -> Vec<u8> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let original = Recording::open(&root.join("recordings/pencil_tip.mcap")).expect("a recording");
    let container = original.container();
    let toml = original.scene_toml().expect("a scene");
    let mut toml = String::from_utf8(toml.to_vec()).expect("UTF-8");
    for name in [
        "pencil, tip first",
        "pencil",
        "table",
        "tip",
        "mug floor",
        "bounce",
        "landing",
    ] {
        toml = toml.replace(&format!("\"{name}\""), &format!("\"{name}{TURNED}\""));
    }
    // Keys too.
    toml = toml.replace("tip = [", &format!("\"tip{TURNED}\" = ["));
    let mut parts = vec![
        raw_mcap::attachment(&evil("notes"), b"nothing", false),
        raw_mcap::attachment("scene.toml", toml.as_bytes(), false),
        raw_mcap::schema(900, &evil("Schema"), b""),
        raw_mcap::channel(900, 900, &evil("/other"), &evil("encoding"), b""),
    ];
    for (id, schema) in container.schemas() {
        parts.push(raw_mcap::schema(*id, &schema.name, &schema.data));
    }
    for (id, channel) in container.channels() {
        let topic = channel.topic.replace("pencil", &format!("pencil{TURNED}"));
        let schema = channel.schema_id.unwrap_or(0);
        parts.push(raw_mcap::channel(*id, schema, &topic, "protobuf", b""));
    }
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        parts.push(raw_mcap::message(
            message.channel_id,
            message.log_time,
            message.data,
        ));
    }
    let parts: Vec<&[u8]> = parts.iter().map(Vec::as_slice).collect();
    raw_mcap::file(&parts)
}

/// Runs a command, and checks that all it says only prints.
fn said(arguments: &[&str], folder: &Path) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("enact").expect("enact");
    let command = command
        .args(arguments)
        .env_remove("RUST_LOG")
        .current_dir(folder);
    let Output {
        stdout,
        stderr,
        status,
    } = command.output().expect("run");
    let said = [stdout, stderr].concat();
    let said = String::from_utf8(said).expect("UTF-8");
    for line in said.lines() {
        assert!(line.chars().all(prints), "{arguments:?}: {line:?}");
        assert!(!line.starts_with("  lost: forged"), "{arguments:?}: {said}");
    }
    (status.code(), said)
}

#[test]
fn names_are_escaped_wherever_they_are_printed() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("a.mcap"), recording()).expect("write");
    let run = |arguments: &[&str]| said(arguments, folder.path());
    let (code, text) = run(&["inspect", "a.mcap"]);
    assert_eq!(code, Some(0), "{text}");
    for name in ["notes", "/other", "Schema", "encoding"] {
        let shown = format!("{name}{SHOWN}");
        assert!(text.contains(&shown), "{name}: {text}");
    }
    for name in ["/tracker/pencil", "pencil, tip first"] {
        let shown = format!("{name}{TURNED_SHOWN}");
        assert!(text.contains(&shown), "{name}: {text}");
    }
    let (code, text) = run(&["replay", "a.mcap", "-o", "estimate.mcap", "-v"]);
    assert_eq!(code, Some(0), "{text}");
    for name in ["pencil, tip first", "bounce", "landing", "pencil"] {
        let shown = format!("{name}{TURNED_SHOWN}");
        assert!(text.contains(&shown), "{name}: {text}");
    }
    let (code, text) = run(&["process", "a.mcap", "-o", "."]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains(TURNED_SHOWN), "{text}");
    let (code, text) = run(&["mark", "a.mcap", "--propose"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains(&format!("bounce{TURNED_SHOWN}")), "{text}");
    for to in ["csv", "glb", "tum"] {
        let output = format!("motion.{to}");
        let (code, text) = run(&["export", "estimate.mcap", "--to", to, "-o", &output]);
        assert_eq!(code, Some(0), "{text}");
        assert!(
            text.contains(&format!("pencil, tip first{TURNED_SHOWN}")),
            "{text}"
        );
    }
    let (code, text) = run(&["sketch", "a.mcap", "-o", "sketch.csv", "--per-flight", "3"]);
    assert_eq!(code, Some(0), "{text}");
    // What the names of files are made of only prints either.
    for entry in std::fs::read_dir(folder.path()).expect("list") {
        let name = entry.expect("an entry").file_name();
        assert!(
            name.to_str().expect("UTF-8").chars().all(prints),
            "{name:?}"
        );
    }
}

#[test]
fn json_is_escaped_and_says_the_name_itself() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("a.mcap"), recording()).expect("write");
    let (code, text) = said(&["inspect", "a.mcap", "--format", "ndjson"], folder.path());
    assert_eq!(code, Some(0), "{text}");
    let inspection: Value = serde_json::from_str(&text).expect("one object");
    assert_eq!(inspection["scene"], format!("pencil, tip first{TURNED}"));
    let topics = inspection["topics"].as_array().expect("topics");
    assert!(topics.iter().any(|topic| topic["topic"] == evil("/other")));
}

#[test]
fn errors_escape_names_too() {
    let folder = tempfile::tempdir().expect("folder");
    // As TOML writes the same.
    let evil_toml = r"\u001b[2J\u001b]0;t\u0007\n  lost: forged\r\u009b31m\u202e\u2028";
    let refused = raw_mcap::SCENE.replace("\"pencil, tip first\"", &format!("\"{evil_toml}\""));
    let unknown = raw_mcap::SCENE.replace("settle_s", &format!("\"settle{evil_toml}\""));
    let absent = raw_mcap::SCENE.replace("\"pencil\"", &format!("\"pencil{TURNED}\""));
    for (toml, shown) in [
        (refused, None),
        (unknown, Some("lost: forged")),
        (absent, Some("/other")),
    ] {
        let bytes = raw_mcap::file(&[
            &raw_mcap::attachment("scene.toml", toml.as_bytes(), false),
            &raw_mcap::channel(3, 0, &evil("/other"), "", b""),
        ]);
        std::fs::write(folder.path().join("a.mcap"), bytes).expect("write");
        for command in [
            &["replay", "a.mcap"][..],
            &["process", "a.mcap", "-o", "."],
            &["process", "a.mcap", "-o", ".", "--format", "ndjson"],
            &["mark", "a.mcap", "--propose"],
            &["inspect", "a.mcap"],
        ] {
            let (code, text) = said(command, folder.path());
            let is_inspected = command[0] == "inspect";
            assert_eq!(code, Some(i32::from(!is_inspected)), "{text}");
            assert!(shown.is_none_or(|shown| text.contains(shown)), "{text}");
        }
    }
}
