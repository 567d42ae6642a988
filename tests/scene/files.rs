//! Scene files as people and editors meet them: the reference and the schema are those of the types that read
//! them, objects and meshes become scenes, and `scene check` says what one means.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use boon::{Compiler, SchemaIndex, Schemas};
use enact::config::{Coefficient, MATERIALS, PRESETS, scene_from_toml};
use enact::motion::LinkIndex;
use serde_json::{Value, json};

mod defaults;
mod presets;

fn enact(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.current_dir(folder).env_remove("RUST_LOG");
    command
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn stdout(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = enact(folder).args(arguments).output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// The schema that the program writes.
struct Schema(Schemas, SchemaIndex);

impl Schema {
    fn of_program() -> Self {
        let text = stdout(root(), &["scene", "schema"], 0);
        let schema: Value = serde_json::from_str(&text).expect("JSON");
        let mut compiler = Compiler::new();
        compiler
            .add_resource("scene.json", schema)
            .expect("a resource");
        let mut schemas = Schemas::new();
        let index = compiler
            .compile("scene.json", &mut schemas)
            .expect("a valid schema");
        Self(schemas, index)
    }

    fn accepts(&self, toml: &str) -> Result<(), String> {
        let value: toml::Value = toml::from_str(toml).expect("TOML");
        let value = json_of(&value);
        let result = self.0.validate(&value, self.1);
        result.map_err(|error| format!("{error:#}"))
    }
}

/// TOML as JSON; an infinite bound is a number there as any other.
fn json_of(value: &toml::Value) -> Value {
    match value {
        toml::Value::String(text) => json!(text),
        toml::Value::Integer(number) => json!(number),
        toml::Value::Float(number) => json!(number.clamp(-1e300, 1e300)),
        toml::Value::Boolean(is) => json!(is),
        toml::Value::Datetime(at) => json!(at.to_string()),
        toml::Value::Array(all) => all.iter().map(json_of).collect(),
        toml::Value::Table(table) => {
            let all = table
                .iter()
                .map(|(key, value)| (key.clone(), json_of(value)));
            Value::Object(all.collect())
        }
    }
}

fn scenes() -> Vec<(PathBuf, String)> {
    let files = fs::read_dir(root().join("config")).expect("config/");
    let files = files.map(|file| file.expect("a file").path());
    let scenes: Vec<(PathBuf, String)> = files
        .filter(|path| path.extension().is_some_and(|of| of == "toml"))
        .map(|path| {
            let text = fs::read_to_string(&path).expect("a text");
            (path, text)
        })
        .collect();
    assert!(scenes.len() >= 10);
    scenes
}

#[test]
fn the_reference_is_that_of_the_types() {
    let kept = fs::read_to_string(root().join("docs/scene.md")).expect("docs/scene.md");
    let made = stdout(root(), &["scene", "reference"], 0);
    assert!(
        kept == made,
        "docs/scene.md is stale: cargo run -- scene reference > docs/scene.md"
    );
}

/// A scene that lacks what an example gives.
fn around(example: &str) -> String {
    let first = example
        .lines()
        .find(|line| line.starts_with('['))
        .unwrap_or_default();
    let begins = |with: &str| first.starts_with(with);
    if example.starts_with("name =") {
        return example.to_owned();
    }
    let mut text = "name = \"example\"\n".to_owned();
    if !begins("[timing]") {
        text += "[timing]\nstamps = \"tempo\"\n";
    }
    if !begins("[[event]]") && !begins("[[body]]") {
        text += "[[event]]\nname = \"bounce\"\nkind = \"collision\"\nbody = \"pencil\"\nfeature = \"tip\"\n\
                 surface = \"table\"\nrestitution = 0.6\n[[event]]\nname = \"landing\"\nkind = \"end\"\n";
    }
    if !begins("[[body]]") {
        text += "[[body]]\nname = \"pencil\"\nmass_g = 6\n\
                 shape = { kind = \"cylinder\", length_mm = 190, radius_mm = 3.75, position_mm = [0, 0, 95] }\n\
                 features_mm = { tip = [0, 0, 0] }\n";
    }
    // A table of a body comes right after it.
    let rest = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    text + example + rest
}

#[test]
fn every_example_of_the_reference_is_read_and_valid() {
    let schema = Schema::of_program();
    let text = fs::read_to_string(root().join("docs/scene.md")).expect("docs/scene.md");
    let blocks = text.split("```toml\n").skip(1);
    let examples: Vec<&str> = blocks
        .filter_map(|block| block.split("```").next())
        .collect();
    assert!(examples.len() >= 15, "{}", examples.len());
    for example in examples {
        let scene = around(example);
        if let Err(error) = scene_from_toml(&scene) {
            panic!("{error}\n{scene}");
        }
        if let Err(error) = schema.accepts(&scene) {
            panic!("{error}\n{scene}");
        }
    }
}

#[test]
fn every_scene_is_valid_and_checked() {
    let schema = Schema::of_program();
    for (path, text) in scenes() {
        if let Err(error) = schema.accepts(&text) {
            panic!("{}: {error}", path.display());
        }
        let path = path.display().to_string();
        let said = stdout(root(), &["scene", "check", &path], 0);
        assert!(said.contains("  expected  /"), "{said}");
    }
}

#[test]
fn what_the_reader_refuses_by_its_types_the_schema_refuses_too() {
    let schema = Schema::of_program();
    let (_, plain) = scenes()
        .into_iter()
        .find(|(path, _)| path.ends_with("pencil_tip.toml"))
        .expect("a scene");
    for (from, to) in [
        ("settle_s = 3", "settle = 3"),
        ("stamps = \"tempo\"", "stamps = \"tempi\""),
        ("stamps = \"tempo\"", ""),
        ("mass_g = 6.0", "mass_g = \"6\""),
        ("mass_g = 6.0", "mass_lb = 6"),
        ("point_mm = [0, 0, 0]", "point_mm = [0, 0]"),
        ("point_mm = [0, 0, 0]\n", ""),
        (
            "kind = \"cylinder\", length_mm = 190",
            "kind = \"cilinder\", length_mm = 190",
        ),
        ("kind = \"collision\"", "kind = \"bounce\""),
        ("[[goal]]", "[[aim]]"),
        (
            "orientation_wxyz = [0.944, 0.016, 0.032, 0.328]",
            "orientation_wxyz = 1",
        ),
    ] {
        let text = plain.replace(from, to);
        assert_ne!(text, plain, "{from}");
        assert!(scene_from_toml(&text).is_err(), "{to}");
        assert!(schema.accepts(&text).is_err(), "{to}");
    }
}

#[test]
fn every_object_becomes_a_scene_that_is_checked() {
    let (folder, schema) = (folder(), Schema::of_program());
    let listed = stdout(folder.path(), &["scene", "objects"], 0);
    assert_eq!(PRESETS.len(), 16);
    for preset in PRESETS {
        assert!(listed.contains(preset.name) && listed.contains(preset.source));
        for lands in [None, Some("+z")] {
            let file = format!("{}{}.toml", preset.name, lands.unwrap_or_default());
            let mut arguments = vec!["scene", "new", preset.name, "-o", &file, "--bounces", "2"];
            arguments.extend(lands.into_iter().flat_map(|up| ["--lands", up]));
            let said = stdout(folder.path(), &arguments, 0);
            assert!(said.contains(" g, centre of mass at ["), "{said}");
            let text = fs::read_to_string(folder.path().join(&file)).expect("a scene");
            assert!(schema.accepts(&text).is_ok(), "{text}");
            let scene = scene_from_toml(&text).expect("a scene");
            assert_eq!(scene.rest_goals.len(), usize::from(lands.is_some()));
            let link = &scene.links[LinkIndex(0)];
            assert!(
                (2e-3..0.7).contains(&link.body.mass_kg()),
                "{}",
                link.body.mass_kg()
            );
            assert!(!link.features.is_empty());
            // Where the parts that may touch are, the solid is too.
            let height_m = |normal: nalgebra::Vector3<f64>| {
                let solid = link.solid();
                let pose = enact::math::Pose::identity();
                solid
                    .lowest(&pose, &nalgebra::Vector3::zeros(), &normal)
                    .expect("a solid")
                    .gap_m
            };
            for axis in 0..3 {
                let normal = nalgebra::Vector3::ith(axis, 1.0);
                let size_m = -height_m(normal) - height_m(-normal);
                assert!(
                    (2e-3..0.7).contains(&size_m),
                    "{} {axis}: {size_m} m",
                    preset.name
                );
            }
            let said = stdout(folder.path(), &["scene", "check", &file], 0);
            assert!(said.contains("  mark 2    bounce 2: "), "{said}");
            assert!(
                said.contains(&format!("/tracker/{}/pose", preset.name)),
                "{said}"
            );
        }
    }
}

/// Every material makes a scene that bounces or rubs in the middle of what its source says, and names it: how it bounces is free
/// within that, how it rubs has its deviation.
#[test]
fn materials_are_as_their_sources_say() {
    let (folder, schema) = (folder(), Schema::of_program());
    let listed = stdout(folder.path(), &["scene", "materials"], 0);
    let docs = fs::read_to_string(root().join("docs/scene_shapes.md")).expect("the page");
    for material in MATERIALS {
        let (of, [least, most]) = material.states();
        assert!(listed.contains(material.name) && listed.contains(material.source));
        let row = docs
            .lines()
            .find(|line| line.starts_with(&format!("| `{}`", material.name)));
        let row = row.expect("a row in the page");
        assert!(
            row.contains(&least.to_string()) && row.contains(&most.to_string()),
            "{row}"
        );
        let file = format!("{}.toml", material.name);
        let new = [
            "scene",
            "new",
            "ball",
            "--material",
            material.name,
            "-o",
            &file,
        ];
        let said = stdout(folder.path(), &new, 0);
        assert!(said.contains(material.source), "{said}");
        let text = fs::read_to_string(folder.path().join(&file)).expect("a scene");
        assert!(
            text.contains(material.source) && schema.accepts(&text).is_ok(),
            "{text}"
        );
        for key in ["\nrestitution = ", "\nfriction = "] {
            assert_eq!(text.matches(key).count(), 1, "{text}");
        }
        let scene = scene_from_toml(&text).expect("a scene");
        let middle = (least + most) / 2.0;
        for law in &scene.contact_laws {
            let stated = match of {
                Coefficient::Restitution => law.restitution,
                Coefficient::Friction => law.friction,
            };
            assert!((stated - middle).abs() <= 5.01e-4, "{law:?}");
        }
        assert!(!scene.contact_laws.is_empty());
        let bounds: Vec<[f64; 2]> = scene
            .parameters
            .iter()
            .map(|of| [of.lower, of.upper])
            .collect();
        let bounces = of == Coefficient::Restitution;
        match bounces && least < most {
            true => assert_eq!(bounds, [[least, most]]),
            false => assert!(bounds.is_empty()),
        }
        assert_eq!(text.contains("\nfriction_sd = 0."), !bounces, "{text}");
        // A ball of that name bounces so: its size and mass are that ball's.
        let link = scene.links.iter().next().expect("a ball");
        let (radius_mm, mass_g) = match material.name {
            "table-tennis-ball" | "table-tennis-table" => (20.0, 2.7),
            "football" => (110.0, 430.0),
            "basketball" => (122.0, 610.0),
            "baseball" => (36.9, 145.0),
            _ => (33.5, 57.7),
        };
        assert!(
            (link.shape.radius_m() * 1e3 - radius_mm).abs() < 1e-9,
            "{}",
            material.name
        );
        assert!(
            (link.body.mass_kg() * 1e3 - mass_g).abs() < 1e-9,
            "{}",
            material.name
        );
    }
    let other = enact(folder.path())
        .args([
            "scene",
            "new",
            "mug",
            "--material",
            "football",
            "-o",
            "x.toml",
        ])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&other.stderr);
    assert!(
        other.status.code() == Some(1) && said.contains("expected `scene new football`"),
        "{said}"
    );
    let output = enact(folder.path())
        .args([
            "scene",
            "new",
            "ball",
            "--material",
            "tenis-ball",
            "-o",
            "x.toml",
        ])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(1) && said.contains("did you mean tennis-ball?"),
        "{said}"
    );
}

#[test]
fn a_box_has_the_sides_and_the_mass_that_are_said() {
    let folder = folder();
    let arguments = [
        "scene",
        "new",
        "book",
        "-o",
        "cube.toml",
        "--size-mm",
        "105,105,105",
        "--mass-g",
        "370",
    ];
    stdout(folder.path(), &arguments, 0);
    let text = fs::read_to_string(folder.path().join("cube.toml")).expect("a scene");
    let scene = scene_from_toml(&text).expect("it is read");
    let body = &scene.links.iter().next().expect("a body").body;
    let expected = 0.37 * 0.105 * 0.105 / 6.0;
    let off = body.moments_kg_m2().map(|of| of / expected - 1.0);
    assert!(
        (body.mass_kg() - 0.37).abs() < 1e-12 && off.amax() < 1e-9,
        "{off}"
    );
    // A hollow one on its bottom.
    let arguments = [
        "scene",
        "new",
        "box",
        "-o",
        "low.toml",
        "--size-mm",
        "40,30,20",
    ];
    stdout(folder.path(), &arguments, 0);
    let text = fs::read_to_string(folder.path().join("low.toml")).expect("a scene");
    assert!(text.contains("position_mm = [0, 0, 10]"), "{text}");
    let scene = scene_from_toml(&text).expect("it is read");
    let radius_m = scene.links.iter().next().expect("a body").radius_m();
    let half_m = nalgebra::Vector3::<f64>::new(0.02, 0.015, 0.01).norm();
    assert!((radius_m - half_m).abs() < 1e-9, "{radius_m} {half_m}");
}

#[test]
fn a_scene_is_never_replaced_and_an_unknown_object_is_answered_with_the_nearest() {
    let folder = folder();
    stdout(folder.path(), &["scene", "new", "die"], 0);
    let refused = |arguments: &[&str], code: i32, message: &str| {
        let output = enact(folder.path())
            .args(arguments)
            .output()
            .expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(message), "{arguments:?}: {said}");
    };
    let before = fs::read(folder.path().join("die.toml")).expect("a scene");
    let first = String::from_utf8_lossy(&before);
    let first = first.lines().next().expect("a line");
    assert!(
        first.starts_with("# Made by enact ") && first.ends_with(": enact scene new die"),
        "{first}"
    );
    refused(&["scene", "new", "die"], 1, "is there already");
    assert_eq!(
        fs::read(folder.path().join("die.toml")).expect("a scene"),
        before
    );
    refused(&["scene", "new", "pencli"], 1, "did you mean pencil?");
    refused(&["scene", "new", "die", "--unit", "mm"], 1, "is of a mesh");
    let sized =
        |object: &'static str| ["scene", "new", object, "-o", "x.toml", "--size-mm", "1,2,3"];
    refused(
        &sized("ball"),
        1,
        "expected a size for die, box, book, phone only",
    );
    refused(&sized("book"), 1, "expected the mass in grams too");
    refused(
        &["scene", "new", "die", "--mass-g", "-1"],
        2,
        "expected a positive number",
    );
    refused(
        &["scene", "new", "die", "--tracker-mm", "1,2"],
        2,
        "three numbers",
    );
    refused(
        &["scene", "new", "die", "-o", "x.toml", "--lands", "up"],
        1,
        "face_up is \"up\"",
    );
    refused(
        &["scene", "new", "die", "-o", "x.toml", "--bounces", "101"],
        1,
        "100 at most",
    );
    refused(
        &["scene", "new", "none.obj", "--mass-g", "5"],
        1,
        "does not say its unit",
    );
    refused(
        &["scene", "new", "none.stl", "--unit", "mm", "--mass-g", "5"],
        1,
        "cannot read",
    );
    assert!(!folder.path().join("x.toml").exists());
}

/// A tetrahedron with its right angle at [10, 20, 30] cm, open or closed.
fn tetrahedron(is_open: bool) -> String {
    let faces = ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"];
    let faces = &faces[usize::from(is_open)..];
    format!(
        "v 10 20 30\nv 16 20 30\nv 10 24 30\nv 10 20 38\n{}\n",
        faces.join("\n")
    )
}

#[test]
fn a_mesh_becomes_a_body_with_its_centre_and_axes() {
    let folder = folder();
    fs::write(folder.path().join("corner.obj"), tetrahedron(false)).expect("a file");
    let new = ["scene", "new", "corner.obj", "--unit", "cm"];
    let without = enact(folder.path()).args(new).output().expect("it runs");
    assert!(String::from_utf8_lossy(&without.stderr).contains("expected its mass in grams"));
    let mut arguments = new.to_vec();
    arguments.extend([
        "--mass-g",
        "100",
        "--format",
        "ndjson",
        "--tracker-mm",
        "100,200,300",
    ]);
    let said: Value = serde_json::from_str(&stdout(folder.path(), &arguments, 0)).expect("JSON");
    let centre = said["body"]["centre_mm"].as_array().expect("a point");
    for (found, expected) in centre.iter().zip([115.0, 210.0, 320.0]) {
        assert!(
            (found.as_f64().expect("a number") - expected).abs() < 1e-6,
            "{said}"
        );
    }
    let text = fs::read_to_string(folder.path().join("corner.toml")).expect("a scene");
    let scene = scene_from_toml(&text).expect("a scene");
    let link = &scene.links[LinkIndex(0)];
    // The trace of the tensor does not depend on axes: of a right-angled tetrahedron 3/40 m (a² + b² + c²).
    let trace = link.body.moments_kg_m2().sum();
    let expected = 0.1 * 3.0 / 40.0 * (0.06_f64.powi(2) + 0.04_f64.powi(2) + 0.08_f64.powi(2));
    assert!((trace / expected - 1.0).abs() < 1e-9, "{trace} {expected}");
    // The right angle is where the tracker is.
    let corner = link.link_from_given * nalgebra::Point3::new(0.1, 0.2, 0.3);
    let mounted = scene.tracks.first().expect("a track").link_from_tracker;
    assert!((mounted.translation.vector - corner.coords).norm() < 1e-12);
    assert_eq!(link.features.len(), 4);
    let nearest = link
        .features
        .iter()
        .map(|of| (of.geometry.place_m() - corner.coords).norm());
    assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9);
}

#[test]
fn an_open_mesh_is_refused_and_its_hull_taken_on_demand() {
    let folder = folder();
    fs::write(folder.path().join("open.obj"), tetrahedron(true)).expect("a file");
    let new = [
        "scene", "new", "open.obj", "--unit", "cm", "--mass-g", "100",
    ];
    let output = enact(folder.path()).args(new).output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("3 of its 6 edges"), "{said}");
    let mut arguments = new.to_vec();
    arguments.push("--hull");
    let said = stdout(folder.path(), &arguments, 0);
    assert!(
        said.contains("centre of mass at [115, 210, 320] mm"),
        "{said}"
    );
}

#[test]
fn check_says_what_is_inferred_and_what_is_missing() {
    let folder = folder();
    let scene = |surface: &str| {
        format!(
            "name = \"x\"\n[timing]\nstamps = \"tempo\"\n[[body]]\nname = \"b\"\nmass_g = 5\nrestitution = 0.5\n\
             shape = {{ kind = \"cuboid\", size_mm = [10, 20, 30], position_mm = [5, 10, 15] }}\n{surface}\
             [[event]]\nname = \"bounce\"\nkind = \"collision\"\nbody = \"b\"\ncount = [2, 4]\n\
             [[event]]\nname = \"end\"\nkind = \"end\"\n"
        )
    };
    let table = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    fs::write(folder.path().join("whole.toml"), scene(table)).expect("a file");
    fs::write(folder.path().join("bare.toml"), scene("")).expect("a file");
    let said = stdout(folder.path(), &["scene", "check", "whole.toml"], 0);
    for line in [
        "whole.toml: x, tempo stamps",
        "b: 5 g, centre of mass at [5, 10, 15] mm",
        "expected  /tracker/b/pose  poses of b",
        "/marks",
        "2 to 4 marks from 1 on bounce: some part of b hits some surface, restitution 0.5",
        "end: the motion ends",
        "open: the tracker of \"b\" is taken to be at its origin",
    ] {
        assert!(said.contains(line), "{line:?} is not in:\n{said}");
    }
    let said = stdout(folder.path(), &["scene", "check", "bare.toml"], 3);
    assert!(
        said.contains("missing: nothing can touch at \"bounce 1\", \"bounce 2\""),
        "{said}"
    );
    let text = stdout(
        folder.path(),
        &["scene", "check", "bare.toml", "--format", "ndjson"],
        3,
    );
    let said: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(said["missing"].as_array().map(Vec::len), Some(1));
    assert_eq!(said["events"][0]["marks"], json!([2, 4]));
    fs::write(folder.path().join("wrong.toml"), scene("[[surfaces]]\n")).expect("a file");
    let output = enact(folder.path())
        .args(["scene", "check", "wrong.toml"])
        .output();
    let output = output.expect("it runs");
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("wrong.toml:9:3: unknown key `surfaces`"),
        "{said}"
    );
}
