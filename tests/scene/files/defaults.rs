//! What the reference says of defaults is what scenes without such a key mean.

use std::collections::BTreeSet;
use std::fs;

use enact::config::{CaptureSettings, capture_from_toml};
use enact::motion::Scene;

use super::root;

/// A scene with a place for a key of each kind of table, `# <table>`, once.
const SCENE: &str = r##"
name = "things"
settle_s = 5
# top
[timing]
stamps = "tempo"
# [timing]
[weights]
# [weights]
[capture]
# [capture]
[[body]]
name = "cube"
mass_g = 100
restitution = 0.5
shape = { kind = "cuboid", size_mm = [40, 50, 60]# shape = { … }
 }
tracker = { # tracker = { … }
 }
# [[body]]
[[body]]
name = "ball"
mass_g = 100
restitution = 0.5
shape = { kind = "sphere", radius_mm = 20 }
[[body.track]]
name = "camera"
# [[body.track]]
[[body]]
name = "rod"
mass_g = 100
restitution = 0.5
shape = { kind = "sphere", radius_mm = 20 }
# held
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
size_mm = [500, 400]
# [[surface]]
[[obstacle]]
name = "box"
position_mm = [300, 0, 50]
shape = { kind = "cuboid", size_mm = [100, 80, 60] }
# [[obstacle]]
[[event]]
name = "bounce"
kind = "collision"
body = "cube"
surface = "table"
[[event]]
name = "again"
kind = "collision"
body = "cube"
surface = "table"
restitution = 0.4
# again
[[event]]
name = "through"
kind = "waypoint"
body = "ball"
[[event]]
name = "landing"
kind = "end"
[[goal]]
event = "bounce"
body = "cube"
spin_rad_s = [1, 2, 3]
# spin
[[goal]]
event = "bounce"
body = "cube"
position_mm = [0, 0, 30]
# place
[[goal]]
event = "bounce"
body = "cube"
axis = "+z"
# axis
[[goal]]
event = "landing"
body = "ball"
velocity_m_s = [0, 0, 0]
# velocity
[[goal]]
event = "rest"
body = "cube"
face_up = "+z"
# rest
"##;

/// Keys with a default that can be written: table, key, its default where the reference says it in words, another
/// value, and where in the scene it is written.
const KEYS: &[(&str, &str, Option<&str>, &str, &str)] = &[
    (
        "The whole file",
        "gravity_m_s2",
        None,
        "[0, 0, -1.6]",
        "top",
    ),
    ("The whole file", "marks_topic", None, "\"/other\"", "top"),
    ("The whole file", "tolerance_mm", Some("0.5"), "2", "top"),
    ("The whole file", "velocity_gaps", None, "\"never\"", "top"),
    ("[[body]]", "friction", None, "0.1", "[[body]]"),
    ("[[body]]", "friction_sd", None, "0.1", "[[body]]"),
    ("[[body]]", "restitution_sd", None, "0.1", "[[body]]"),
    ("[[body]]", "held", None, "true", "held"),
    (
        "[[body]]",
        "topic",
        Some("\"/tracker/cube/pose\""),
        "\"/other\"",
        "[[body]]",
    ),
    ("[[body]]", "tracked", None, "false", "[[body]]"),
    (
        "shape = { … }",
        "orientation_wxyz",
        None,
        "[0, 1, 0, 0]",
        "shape = { … }",
    ),
    (
        "shape = { … }",
        "position_mm",
        None,
        "[1, 2, 3]",
        "shape = { … }",
    ),
    (
        "[[body.track]]",
        "sees",
        None,
        "\"point\"",
        "[[body.track]]",
    ),
    (
        "[[body.track]]",
        "topic",
        Some("\"/tracker/ball/camera\""),
        "\"/other\"",
        "[[body.track]]",
    ),
    (
        "tracker = { … }",
        "orientation_wxyz",
        None,
        "[0, 1, 0, 0]",
        "tracker = { … }",
    ),
    (
        "tracker = { … }",
        "position_mm",
        None,
        "[1, 2, 3]",
        "tracker = { … }",
    ),
    ("[capture]", "chunk_ms", None, "50", "[capture]"),
    ("[capture]", "folder", None, "\"other\"", "[capture]"),
    ("[capture]", "listen", None, "\"0.0.0.0\"", "[capture]"),
    ("[capture]", "pre_roll_s", None, "2", "[capture]"),
    ("[capture]", "sync_ms", None, "500", "[capture]"),
    ("[[event]]", "bumper", None, "true", "again"),
    ("[[event]]", "count", None, "[1, 2]", "again"),
    ("[[goal]]", "after", None, "true", "spin"),
    ("[[goal]]", "at_rest", None, "true", "velocity"),
    ("[[goal]]", "axes", None, "\"body\"", "spin"),
    ("[[goal]]", "contact", None, "true", "place"),
    (
        "[[goal]]",
        "direction",
        Some("[0, 0, 1]"),
        "[1, 0, 0]",
        "axis",
    ),
    ("[[goal]]", "labels", None, "\"free\"", "rest"),
    ("[[goal]]", "within_deg", Some("10"), "20", "rest"),
    (
        "[[obstacle]]",
        "orientation_wxyz",
        None,
        "[0, 1, 0, 0]",
        "[[obstacle]]",
    ),
    (
        "[[surface]]",
        "along",
        Some("[1, 0, 0]"),
        "[0, 1, 0]",
        "[[surface]]",
    ),
    ("[[surface]]", "thickness_mm", None, "20", "[[surface]]"),
    ("[timing]", "tempo_sd_per_sqrt_s", None, "0.4", "[timing]"),
    (
        "[weights]",
        "orientation_deg",
        Some("5.729577951308232"),
        "3",
        "[weights]",
    ),
    ("[weights]", "position_mm", Some("10"), "20", "[weights]"),
];

/// Tables, keys and defaults of the reference.
fn said() -> Vec<(String, String, String)> {
    let text = fs::read_to_string(root().join("docs/scene.md")).expect("the reference");
    let mut table = String::new();
    let mut rows = Vec::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            table = title.trim_matches('`').to_owned();
        }
        let cells: Vec<&str> = line.split(" | ").collect();
        if let ([key, _, _, default, _], true) = (cells.as_slice(), line.starts_with("| `")) {
            let key = key.trim_start_matches("| ").trim_matches('`');
            rows.push((table.clone(), key.to_owned(), (*default).to_owned()));
        }
    }
    assert!(rows.len() > 150, "{}", rows.len());
    rows
}

/// The scene with a line at a place, or why there is none.
fn meant(place: &str, line: &str) -> Result<(Scene, CaptureSettings), String> {
    let at = format!("# {place}\n");
    assert_eq!(SCENE.matches(&at).count(), 1, "{place}");
    let inline = ["shape = { … }", "tracker = { … }"];
    let line = match inline.iter().position(|of| *of == place) {
        Some(0) if !line.is_empty() => format!(", {line}"),
        _ => line.to_owned(),
    };
    let joined = match inline.contains(&place) {
        true => line.clone(),
        false => format!("{line}\n"),
    };
    let mut text = SCENE.replace(&at, &joined);
    // The other places of tables in one line end none.
    for other in inline {
        text = text.replace(&format!("# {other}\n"), "");
    }
    capture_from_toml(&text).map_err(|error| format!("{error}\n{text}"))
}

#[test]
fn a_scene_without_a_key_means_what_the_reference_says_it_does() {
    let said = said();
    let is_literal = |default: &str| {
        let first = default.chars().next();
        let is_number = first.is_some_and(|first| first.is_ascii_digit());
        let is_alone = !default.contains(' ') || default.starts_with('[');
        matches!(default, "true" | "false" | "\"when needed\"")
            || (is_number || matches!(first, Some('[' | '"'))) && is_alone
    };
    let literal = said.iter().filter(|(_, _, default)| is_literal(default));
    let literal: BTreeSet<(&str, &str)> = literal.map(|(a, b, _)| (&a[..], &b[..])).collect();
    let checked: BTreeSet<(&str, &str)> = KEYS.iter().map(|of| (of.0, of.1)).collect();
    let unchecked: Vec<_> = literal.difference(&checked).collect();
    assert!(
        unchecked.is_empty(),
        "defaults that nobody checks: {unchecked:?}"
    );
    for (table, key, in_words, other, place) in KEYS {
        let row = said.iter().find(|(a, b, _)| a == table && b == key);
        let (.., default) = row.unwrap_or_else(|| panic!("{table} {key}"));
        assert_eq!(
            is_literal(default),
            in_words.is_none(),
            "{table} {key}: {default}"
        );
        let default = in_words.unwrap_or(default);
        let without = meant(place, "");
        assert!(without.is_ok(), "{without:?}");
        let with = meant(place, &format!("{key} = {default}"));
        // A run of one collision is one, but is written as a run.
        match *key {
            "count" => assert!(with.is_ok(), "{with:?}"),
            _ => assert_eq!(with, without, "{table} {key}"),
        }
        assert_ne!(
            meant(place, &format!("{key} = {other}")),
            without,
            "{table} {key}"
        );
    }
}
