//! Lists of the wrong length, of every key that has a list.

use schemars::{JsonSchema, schema_for};
use serde_json::{Map, Value, json};

use crate::config::calibration::Calibration;
use crate::config::raw::RawScene;
use crate::config::{scene_from_toml, sketch_from_toml};

/// A way from the root of a text to a list of a fixed length: with it, as JSON, and the length.
struct Found {
    key: String,
    length: usize,
    /// The text with a list of so many numbers there, alone.
    with: Box<dyn Fn(usize) -> Value>,
}

/// All lists of a fixed length of numbers that a schema has.
fn lists<T: JsonSchema>() -> Vec<Found> {
    let schema = schema_for!(T);
    let root = schema.as_value().clone();
    let mut found = Vec::new();
    walk(
        &root,
        &root,
        &mut Vec::new(),
        &mut found,
        String::new(),
        &wrap_nothing(),
    );
    found
}

type Wrap = std::rc::Rc<dyn Fn(Value) -> Value>;

fn wrap_nothing() -> Wrap {
    std::rc::Rc::new(|value| value)
}

fn walk(
    root: &Value,
    schema: &Value,
    seen: &mut Vec<String>,
    found: &mut Vec<Found>,
    key: String,
    wrap: &Wrap,
) {
    if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
        if seen.iter().any(|of| of == name) {
            return;
        }
        seen.push(name.to_owned());
        let of = root
            .pointer(name.trim_start_matches('#'))
            .expect("it is there");
        walk(root, of, seen, found, key.clone(), wrap);
        seen.pop();
    }
    for choices in ["anyOf", "oneOf", "allOf"] {
        for choice in schema
            .get(choices)
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
        {
            walk(root, choice, seen, found, key.clone(), wrap);
        }
    }
    let named = schema.get("properties").and_then(Value::as_object);
    let any = schema
        .get("additionalProperties")
        .filter(|any| any.is_object());
    let any = any.map(|any| ("x".to_owned(), any));
    let own = named
        .into_iter()
        .flatten()
        .map(|(name, of)| (name.clone(), of));
    for (name, of) in own.chain(any) {
        let (outer, key) = (wrap.clone(), name.clone());
        let inner: Wrap = std::rc::Rc::new(move |value| {
            let mut table = Map::new();
            table.insert(key.clone(), value);
            outer(Value::Object(table))
        });
        walk(root, of, seen, found, name, &inner);
    }
    let Some(items) = schema.get("items") else {
        return;
    };
    if let Some(length) = schema.get("maxItems").and_then(Value::as_u64) {
        let length = usize::try_from(length).expect("small");
        if let Some("number" | "integer") = items.get("type").and_then(Value::as_str) {
            let outer = wrap.clone();
            let with = move |count: usize| outer(json!(vec![1; count]));
            found.push(Found {
                key: key.clone(),
                length,
                with: Box::new(with),
            });
        }
    }
    let repeats = schema.get("minItems").and_then(Value::as_u64).unwrap_or(1);
    let outer = wrap.clone();
    let inner: Wrap = std::rc::Rc::new(move |value| {
        let all: Vec<Value> = (0..repeats.max(1)).map(|_| value.clone()).collect();
        outer(Value::Array(all))
    });
    walk(root, items, seen, found, key, &inner);
}

#[test]
fn lists_with_a_number_too_many_or_too_few_are_refused_whatever_the_key() {
    let scene = scene_from_toml(
        "name = \"x\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"ball\"\nmass_g = 1\nshape = { kind = \"sphere\", radius_mm = 10 }\n",
    );
    let scene = scene.expect("a scene");
    type Read<'a> = Box<dyn Fn(&str) -> String + 'a>;
    let kinds: [(Vec<Found>, Read, usize); 3] = [
        (
            lists::<RawScene>(),
            Box::new(|text| scene_from_toml(text).expect_err("too many").to_string()),
            25,
        ),
        (
            lists::<crate::config::keyframes::RawFile>(),
            Box::new(|text| {
                sketch_from_toml(text, &scene)
                    .expect_err("too many")
                    .to_string()
            }),
            3,
        ),
        (
            lists::<Calibration>(),
            Box::new(|text| {
                Calibration::from_toml(text)
                    .expect_err("too many")
                    .to_string()
            }),
            4,
        ),
    ];
    for (found, read, least) in kinds {
        assert!(found.len() >= least, "{} lists", found.len());
        for of in found {
            for count in [of.length + 1, of.length - 1, of.length + 7] {
                let text = toml::to_string(&(of.with)(count)).expect("a text");
                let said = read(&text);
                let expected = format!("`{}` has {count} numbers, expected {}", of.key, of.length);
                // A choice between lists and something else may say so in its own words.
                assert!(said.contains(&expected), "{text}: {said}");
            }
        }
    }
}

#[test]
fn a_decimal_comma_is_found_where_it_is() {
    let text = "name = \"x\"\ngravity_m_s2 = [0, 0, -9,80665]\n[timing]\nstamps = \"physical\"\n";
    let error = scene_from_toml(text).expect_err("four numbers");
    assert_eq!((error.line, error.column), (2, 26));
    let said = "`gravity_m_s2` has 4 numbers, expected 3: a decimal is written with a point";
    assert!(error.message.contains(said), "{error}");
}
