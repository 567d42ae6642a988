//! What scene files may have, from the types that read them: a JSON schema, and a page for people.

use std::collections::BTreeSet;
use std::fmt::Write;

use schemars::schema_for;
use serde_json::{Map, Value, json};

use super::raw::RawScene;
use super::solid::KINDS;

/// Words that texts may be, beside the kinds of shapes: table, key, words.
const WORDS: &[(&str, &str, &[&str])] = &[
    ("timing", "stamps", &["tempo", "physical", "edited"]),
    (
        "event",
        "kind",
        &["start", "collision", "change", "waypoint", "end"],
    ),
    (
        "phase",
        "motion",
        &["slide", "roll", "rest", "held", "tumble"],
    ),
    ("event", "time", &["fixed", "free"]),
    ("joint", "kind", &["pin", "universal", "ball", "fixed"]),
    (
        "body.track",
        "sees",
        &["pose", "point", "orientation", "direction"],
    ),
    ("goal", "axes", &["world", "body"]),
    ("goal", "labels", &["fixed", "free"]),
    (
        "capture.tracker",
        "stamps",
        &["sample", "device", "sequence", "receipt"],
    ),
];

/// The JSON schema of scene files, draft 2020-12.
pub fn scene_schema() -> Value {
    let mut schema = schema_for!(RawScene).to_value();
    schema["title"] = json!("a scene of enact");
    let kinds: Vec<&str> = KINDS.iter().map(|(kind, _)| *kind).collect();
    let shapes = [("shape", "kind", kinds.as_slice())];
    for (table, key, words) in shapes.iter().chain(WORDS) {
        if let Some(property) = schema.pointer_mut(&format!("/$defs/{table}/properties/{key}")) {
            property["enum"] = json!(words);
            // Keys that may be left out are; TOML has no null.
            property["type"] = json!("string");
        }
    }
    without_null(&mut schema);
    schema
}

/// Takes `null` out of the types of keys that may be left out: TOML has none.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if let Some(Value::Array(types)) = map.get_mut("type") {
                types.retain(|of| of != "null");
                if let [only] = &types[..] {
                    let only = only.clone();
                    map.insert("type".into(), only);
                }
            }
            if let Some(Value::Array(any)) = map.get_mut("anyOf") {
                any.retain(|of| of["type"] != "null");
                if let [Value::Object(only)] = &any[..] {
                    let only = only.clone();
                    map.remove("anyOf");
                    map.extend(only);
                }
            }
            map.values_mut().for_each(without_null);
        }
        Value::Array(all) => all.iter_mut().for_each(without_null),
        _ => {}
    }
}

/// Units by the endings of keys, the longer endings first.
const UNITS: &[(&str, &str)] = &[
    ("_per_sqrt_s", "1/√s"),
    ("_kg_m3", "kg/m³"),
    ("_kg_m2", "kg m²"),
    ("_n_m_s", "N m s"),
    ("_n_m", "N m"),
    ("_rad_s", "rad/s"),
    ("_per_s", "1/s"),
    ("_per_m", "1/m"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_percent", "%"),
    ("_wxyz", "w, x, y, z"),
    ("_deg", "°"),
    ("_mm", "mm"),
    ("_ms", "ms"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_g", "g"),
    ("_s", "s"),
];

/// The reference as Markdown: every table with its keys, their types, units and defaults.
pub fn scene_reference() -> String {
    let schema = scene_schema();
    let mut text = String::from(
        "# Scene files\n\n\
         This page is made from the types that read scene files: `enact scene reference > docs/scene.md`. The same for \
         editors is a JSON schema: `enact scene schema > scene.schema.json`, and `#:schema ./scene.schema.json` in the \
         first line of a scene. `enact scene new` makes a scene, `enact scene check` says what one means.\n\n\
         A scene is a TOML file. Units are in the names of keys; every mistake is answered with line, column and what \
         was expected. Shapes, frames, masses, meshes and presets are explained in [scene_shapes.md](scene_shapes.md), \
         goals in [goals.md](goals.md), what trackers see in [tracks.md](tracks.md), joints in [joints.md](joints.md), \
         bodies in the hand in [held.md](held.md).\n",
    );
    let mut known = BTreeSet::new();
    add_table(&mut text, "The whole file", &schema, &schema, &mut known);
    text
}

/// Appends a table, and below it the tables that its keys have.
fn add_table(
    text: &mut String,
    title: &str,
    table: &Value,
    schema: &Value,
    known: &mut BTreeSet<String>,
) {
    let _ = write!(text, "\n## {title}\n\n{}\n", words(table, "description"));
    text.push_str("\n| key | is | unit | default | |\n|---|---|---|---|---|\n");
    let empty = Map::new();
    let properties = table["properties"].as_object().unwrap_or(&empty);
    let required = table["required"].as_array();
    let is_required = |key: &str| required.is_some_and(|of| of.iter().any(|name| name == key));
    let mut below = Vec::new();
    for (key, property) in properties {
        let description = words(property, "description").replace('\n', " ");
        let (what, default) = match description.split_once("Default: ") {
            Some((what, default)) => (what.trim().to_owned(), default.trim_end_matches('.')),
            None => (
                description.clone(),
                if is_required(key) { "**needed**" } else { "" },
            ),
        };
        let unit = UNITS.iter().find(|(ending, _)| key.ends_with(ending));
        let unit = unit.map_or("", |(_, unit)| unit);
        let (of, kind) = kind(property);
        let kind = kind.replace('|', "\\|");
        let _ = writeln!(
            text,
            "| `{key}` | {kind} | {unit} | {} | {} |",
            default.replace('|', "\\|"),
            what.replace('|', "\\|")
        );
        below.extend(of.map(|(name, is_list)| (key.clone(), name, is_list)));
    }
    for (key, name, is_list) in below {
        if !known.insert(name.clone()) {
            continue;
        }
        let Some(of) = schema.pointer(&format!("/$defs/{name}")) else {
            continue;
        };
        let is_table = of["properties"].is_object();
        if is_table {
            let title = match (is_list, name.as_str()) {
                (true, _) => format!("`[[{name}]]`"),
                (false, "shape" | "tracker") => format!("`{key} = {{ … }}`"),
                (false, _) => format!("`[{name}]`"),
            };
            add_table(text, &title, of, schema, known);
        }
    }
}

fn words(of: &Value, key: &str) -> String {
    of[key].as_str().unwrap_or_default().to_owned()
}

/// What a key is, and the definition of the table or list of tables that it may be.
fn kind(property: &Value) -> (Option<(String, bool)>, String) {
    let name = |of: &Value| {
        let path = of["$ref"].as_str()?;
        path.strip_prefix("#/$defs/").map(str::to_owned)
    };
    if let Some(name) = name(property) {
        return match name.as_str() {
            "RawCount" => (None, "number, or two".into()),
            "RawAxis" => (None, "text, or 3 numbers".into()),
            _ => (Some((name, false)), "table".into()),
        };
    }
    if let Some(words) = property["enum"].as_array() {
        let words: Vec<String> = words.iter().map(Value::to_string).collect();
        return (None, words.join(" "));
    }
    match property["type"].as_str() {
        Some("number" | "integer") => (None, "number".into()),
        Some("string") => (None, "text".into()),
        Some("boolean") => (None, "true, false".into()),
        Some("object") => (None, "table of 3 numbers each".into()),
        Some("array") => {
            let items = &property["items"];
            if let Some(name) = name(items) {
                return (Some((name, true)), "tables".into());
            }
            let each = match items["type"].as_str() {
                Some("array") => self::kind(items).1,
                Some("string") => "texts".into(),
                _ => "numbers".into(),
            };
            let said = match property["minItems"].as_u64() {
                Some(count) => format!("{count} × {each}").replace("× numbers", "numbers"),
                None => format!("list of {each}").replace("list of numbers", "numbers"),
            };
            (None, said)
        }
        _ => (None, String::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::scene_from_toml;

    /// Each list of words is the one that the reader names where it refuses another.
    #[test]
    fn words_are_those_of_the_reader() {
        let scene = |line: &str| {
            let body = "[[body]]\nname = \"b\"\nshape = { kind = \"sphere\", radius_mm = 9 }\nmass_g = 1\nrestitution = 1\n";
            let plain = format!("name = \"x\"\n[timing]\nstamps = \"tempo\"\n{body}");
            match line {
                "timing.stamps" => plain.replace("tempo", "?"),
                "event.kind" => plain + "[[event]]\nname = \"e\"\nkind = \"?\"",
                "event.time" => plain + "[[event]]\nname = \"e\"\nkind = \"end\"\ntime = \"?\"",
                "phase.motion" => {
                    plain
                        + "[[surface]]\nname = \"t\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n[[phase]]\nname = \"p\"\nbody = \"b\"\nsurface = \"t\"\nfrom = \"e\"\nuntil = \"e\"\nmotion = \"?\""
                }
                "joint.kind" => plain + "[[joint]]\nname = \"j\"\nkind = \"?\"\nchild = \"b\"",
                "body.track.sees" => plain + "[[body.track]]\nsees = \"?\"",
                "goal.axes" => {
                    plain
                        + "[[event]]\nname = \"e\"\nkind = \"end\"\n[[goal]]\nevent = \"e\"\nbody = \"b\"\nspin_rad_s = [0, 0, 1]\naxes = \"?\""
                }
                "goal.labels" => {
                    plain.replace("[timing]", "settle_s = 1\n[timing]")
                        + "[[goal]]\nevent = \"rest\"\nbody = \"b\"\nface_up = \"+z\"\nlabels = \"?\""
                }
                "capture.tracker.stamps" => {
                    plain + "[[capture.tracker]]\nbody = \"b\"\nstamps = \"?\""
                }
                "shape.kind" => plain.replace("sphere", "?"),
                other => panic!("no example of {other}"),
            }
        };
        let kinds: Vec<&str> = KINDS.iter().map(|(kind, _)| *kind).collect();
        for (table, key, words) in WORDS.iter().chain(&[("shape", "kind", &kinds[..])]) {
            let text = scene(&format!("{table}.{key}"));
            let said = scene_from_toml(&text).expect_err("a wrong word").message;
            let mut said: Vec<&str> = said
                .split(|c: char| !c.is_alphanumeric() && c != '_')
                .collect();
            said.retain(|word| !word.is_empty());
            for word in *words {
                assert!(said.contains(word), "{table}.{key} lacks {word}: {said:?}");
            }
        }
    }
}
