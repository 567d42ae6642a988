//! The house rules that a machine can check: which room may import which, one door per third
//! party, what the core must not touch, lengths of files, `mod.rs` without code, no files that import
//! each other.
//!
//! Code is looked at as tokens, so that comments, texts and doctests do not count; test code
//! may import what it likes.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

mod circles;
mod dialect;
mod opens;
mod skips;
mod tokens;
mod uses;

use circles::{Importer, circles};
use dialect::Dialect;
use tokens::{Token, is_word, out_of_line_tests, tokens, without_tests};
use uses::uses;

/// Longest file [lines].
const LINES: usize = 800;

/// Each room with the rooms it may import.
const IMPORTS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("optimise", &[]),
    ("physics", &["math"]),
    ("motion", &["physics", "math"]),
    ("segment", &["motion", "physics", "math"]),
    ("initialise", &["motion", "physics", "math"]),
    ("estimate", &["optimise", "motion", "physics", "math"]),
    ("verify", &["motion", "physics", "math"]),
    ("settle", &["motion", "physics", "math"]),
    ("calibrate", &["motion", "physics", "math"]),
    ("jointly", &["motion"]),
    (
        "pipeline",
        &[
            "segment",
            "initialise",
            "estimate",
            "verify",
            "settle",
            "motion",
            "physics",
            "math",
        ],
    ),
    ("wire", &["motion", "math"]),
    ("ingest", &["wire", "motion"]),
    ("report", &["motion"]),
    ("sampling", &["motion", "physics", "math"]),
    ("visual", &["motion", "physics", "math"]),
    (
        "write",
        &[
            "report", "sampling", "visual", "wire", "motion", "physics", "math",
        ],
    ),
    (
        "page",
        &[
            "write", "report", "sampling", "visual", "motion", "physics", "math",
        ],
    ),
    ("config", &["motion", "physics", "math"]),
    (
        "service",
        &[
            "pipeline",
            "calibrate",
            "jointly",
            "ingest",
            "write",
            "page",
            "report",
            "config",
            "motion",
        ],
    ),
    ("cli", &["config", "report", "service"]),
    ("main", &["cli", "service"]),
    ("lib", &[]),
];

/// The rooms that compute and nothing else.
const CORE: &[&str] = &[
    "math",
    "optimise",
    "motion",
    "physics",
    "segment",
    "initialise",
    "estimate",
    "verify",
    "settle",
    "calibrate",
    "jointly",
    "pipeline",
];

/// What the core must not have: files, nets, clocks, threads, printing, logs, and containers
/// whose order changes from run to run.
const NOT_IN_CORE: &[&[&str]] = &[
    &["std", "::", "fs"],
    &["std", "::", "net"],
    &["std", "::", "env"],
    &["std", "::", "process"],
    &["std", "::", "thread"],
    &["thread", "::"],
    &["Instant"],
    &["SystemTime"],
    &["print", "!"],
    &["println", "!"],
    &["eprint", "!"],
    &["eprintln", "!"],
    &["dbg", "!"],
    &["HashMap"],
    &["HashSet"],
    &["tokio"],
    &["iceoryx2"],
    &["clap"],
    &["rayon"],
    &["tracing"],
];

/// Third parties, each with the only places that may name it.
const DOORS: &[(&str, &[&str])] = &[
    ("parry3d", &["src/core/physics/shape/"]),
    ("rapier3d", &["src/core/settle.rs", "src/core/settle/"]),
    ("clarabel", &["src/core/optimise/"]),
    ("cdr", &["src/wire/"]),
    ("lz4", &["src/wire/container/"]),
    ("zstd", &["src/wire/container/"]),
    ("csv", &["src/ingest/table/", "src/ingest/mark_list.rs"]),
    ("mcap", &["src/wire/", "src/ingest/", "src/write/"]),
    ("foxglove", &["src/wire/", "src/ingest/", "src/write/"]),
    ("httparse", &["src/service/capture/"]),
    (
        "iceoryx2",
        &["src/wire/live/", "src/ingest/live/", "src/write/live.rs"],
    ),
    ("base64", &["src/service/capture/viewer/"]),
    (
        "futures_util",
        &["src/service/capture/viewer/", "src/service/capture/acting/"],
    ),
    ("tokio", &["src/service/capture/"]),
    (
        "tokio_tungstenite",
        &[
            "src/service/capture/viewer/",
            "src/service/capture/acting.rs",
            "src/service/capture/acting/",
        ],
    ),
    ("rustix", &["src/service/"]),
    ("roxmltree", &["src/core/config/urdf/"]),
    // The writer of glTF has a module of that name.
    ("gltf", &["src/core/config/mesh/", "src/write/export/"]),
    ("stl_io", &["src/core/config/mesh/"]),
    ("tobj", &["src/core/config/mesh/"]),
    ("schemars", &["src/core/config/"]),
    ("toml", &["src/core/config/", "src/wire/live/census.rs"]),
    ("toml_edit", &["src/core/config/"]),
    ("clap", &["src/cli/"]),
    ("clap_complete", &["src/cli/"]),
    ("rayon", &["src/service/"]),
    ("sha2", &["src/service/provenance.rs"]),
    ("indicatif", &["src/service/", "src/cli/"]),
    ("anyhow", &["src/service/", "src/cli/", "src/main.rs"]),
];

/// Where everything comes from outside.
const NO_UNWRAP: &[&str] = &["ingest", "wire", "config"];

/// Its files that say `expect`, how often, and why nothing from outside can make it fail.
const EXPECTS: &[(&str, usize, &str)] = &[
    ("src/core/config/body.rs", 1, "the numbers were checked"),
    ("src/core/config/unit.rs", 1, "every quantity has a unit"),
    ("src/wire/encode.rs", 2, "it encodes what is ours"),
    ("src/wire/ros2.rs", 2, "it encodes what is ours"),
    (
        "src/wire/container/walk.rs",
        1,
        "a chunk is unpacked up to its last whole record",
    ),
];

struct File {
    /// From the crate's root, with slashes.
    path: String,
    text: String,
}

/// The path within its crate.
fn inside(path: &str) -> &str {
    let of_core = path.strip_prefix("src/core/");
    let inside = of_core.or_else(|| path.strip_prefix("src/"));
    inside.unwrap_or(path)
}

/// `src/core/motion/scene.rs` → `motion`, `src/core/pipeline.rs` → `pipeline`.
fn room(path: &str) -> &str {
    let inside = inside(path);
    let first = inside.split('/').next().unwrap_or_default();
    first.strip_suffix(".rs").unwrap_or(first)
}

/// How many `super::` lead from the file's module to the crate's root.
fn depth(path: &str) -> usize {
    let inside = inside(path);
    let parts = inside.split('/').count();
    match inside.rsplit('/').next() {
        Some("mod.rs") => parts - 1,
        Some("lib.rs" | "main.rs") => 0,
        _ => parts,
    }
}

fn violations(files: &[File]) -> Vec<String> {
    let test_only: BTreeSet<String> = files
        .iter()
        .flat_map(|file| out_of_line_tests(&file.path, &file.text))
        .collect();
    let is_test = |path: &str| {
        test_only
            .iter()
            .any(|module| path == format!("{module}.rs") || path.starts_with(&format!("{module}/")))
    };
    let mut found = Vec::new();
    let mut importers = Vec::new();
    let mut dialect = Dialect::default();
    for file in files {
        let lines = file.text.lines().count();
        if lines > LINES {
            found.push(format!("{}: {lines} lines, at most {LINES}", file.path));
        }
        skips::check(file, &mut found);
        if !file.path.starts_with("src/") || is_test(&file.path) {
            continue;
        }
        let code = without_tests(&tokens(&file.text));
        check_imports(file, &code, &mut found);
        check_doors(file, &code, &mut found);
        check_core(file, &code, &mut found);
        opens::check(file, &code, &mut found);
        dialect.add(&file.path, &code);
        check_mod(file, &code, &mut found);
        check_names(file, &code, &mut found);
        importers.push(Importer {
            path: file.path.clone(),
            uses: uses(&code),
        });
        if NO_UNWRAP.contains(&room(&file.path)) {
            check_unwraps(file, &code, &mut found);
        }
    }
    found.extend(dialect.excess());
    for circle in circles(&importers) {
        found.push(format!("{}: import each other", circle.join(", ")));
    }
    found
}

fn check_unwraps(file: &File, code: &[Token], found: &mut Vec<String>) {
    for at in matches(code, &[".", "unwrap", "("]) {
        found.push(format!("{}:{}: unwrap()", file.path, code[at].line));
    }
    let allowed = EXPECTS.iter().find(|(path, ..)| *path == file.path);
    let allowed = allowed.map_or(0, |(_, count, _)| *count);
    let expects: Vec<usize> = matches(code, &[".", "expect", "("]).collect();
    if expects.len() != allowed {
        let lines = expects.iter().map(|at| code[*at].line.to_string());
        found.push(format!(
            "{}:{}: {} expect(), {allowed} in the table",
            file.path,
            lines.collect::<Vec<_>>().join(", "),
            expects.len()
        ));
    }
}

/// A crate, and what is above a module, are called by their own names, or the other checks would
/// not know them.
fn check_names(file: &File, code: &[Token], found: &mut Vec<String>) {
    for at in matches(code, &["extern", "crate"]) {
        found.push(format!("{}:{}: extern crate", file.path, code[at].line));
    }
    for used in uses(code) {
        let is_renamed = used.path.len() == 1 && used.alias.is_some();
        let is_whole = used.path.len() == 2 && used.path[1] == "*" && used.path[0] != "super";
        let is_own = matches!(used.path[0].as_str(), "self" | "Self");
        if is_renamed || is_whole && !is_own {
            found.push(format!(
                "{}:{}: {} under another name",
                file.path, used.line, used.path[0]
            ));
        }
    }
}

fn check_imports(file: &File, code: &[Token], found: &mut Vec<String>) {
    let here = room(&file.path);
    let Some((_, allowed)) = IMPORTS.iter().find(|(room, _)| *room == here) else {
        found.push(format!("{}: a room without a row in the table", file.path));
        return;
    };
    for (line, target) in imported_rooms(&file.path, code) {
        let known = IMPORTS.iter().any(|(room, _)| *room == target);
        if known && target != here && !allowed.contains(&target.as_str()) {
            found.push(format!(
                "{}:{line}: {here} imports {target}, allowed: {}",
                file.path,
                allowed.join(", ")
            ));
        }
    }
}

/// Every room named through `crate::`, `enact::` or enough `super::`.
fn imported_rooms(path: &str, code: &[Token]) -> Vec<(usize, String)> {
    let mut rooms = Vec::new();
    let is = |at: usize, text: &str| code.get(at).is_some_and(|token| token.text == text);
    for at in 0..code.len() {
        if at > 0 && is(at - 1, "::") {
            continue;
        }
        let mut next = at;
        if is(at, "crate") || is(at, "enact") {
            next += 1;
        } else {
            let mut supers = 0;
            while is(next, "super") && (supers == 0 || is(next - 1, "::")) {
                supers += 1;
                next += 1;
                if is(next, "::") && is(next + 1, "super") {
                    next += 1;
                }
            }
            if supers == 0 || supers < depth(path) {
                continue;
            }
        }
        if !is(next, "::") {
            continue;
        }
        next += 1;
        if is(next, "{") {
            rooms.extend(group_heads(&code[next..]));
        } else if let Some(token) = code.get(next) {
            rooms.push((token.line, token.text.clone()));
        }
    }
    rooms
}

/// First names inside `{a::b, c, d::{e, f}}`.
fn group_heads(code: &[Token]) -> Vec<(usize, String)> {
    let mut heads = Vec::new();
    let mut level = 0;
    for (at, token) in code.iter().enumerate() {
        match token.text.as_str() {
            "{" => level += 1,
            "}" => level -= 1,
            _ => {}
        }
        if level == 0 {
            break;
        }
        let begins = at > 0 && matches!(code[at - 1].text.as_str(), "{" | ",");
        if level == 1 && begins {
            heads.push((token.line, token.text.clone()));
        }
    }
    heads
}

fn check_doors(file: &File, code: &[Token], found: &mut Vec<String>) {
    for (name, places) in DOORS {
        if places.iter().any(|place| file.path.starts_with(place)) {
            continue;
        }
        let pattern = [*name];
        let named = matches(code, &pattern).filter(|at| names_a_crate(code, *at));
        let used = uses(code).into_iter().filter(|used| used.path[0] == *name);
        let lines: BTreeSet<usize> = named
            .map(|at| code[at].line)
            .chain(used.map(|used| used.line))
            .collect();
        for line in lines {
            let places = places.join(", ");
            found.push(format!("{}:{line}: {name} outside {places}", file.path));
        }
    }
}

/// Whether a word is the beginning of a path and not a method, a field or a module of ours.
fn names_a_crate(code: &[Token], at: usize) -> bool {
    let before = at.checked_sub(1).map(|at| code[at].text.as_str());
    let after = code.get(at + 1).map(|token| token.text.as_str());
    let begins = match before {
        Some("." | "mod" | "fn" | "let") => false,
        // `::name` begins at the crates, `a::name` and `<A>::name` go on.
        Some("::") => at
            .checked_sub(2)
            .is_none_or(|at| !code[at].text.ends_with(|c| is_word(c) || c == '>')),
        _ => true,
    };
    begins && (after == Some("::") || before == Some("use") || after == Some("!"))
}

fn check_core(file: &File, code: &[Token], found: &mut Vec<String>) {
    if !CORE.contains(&room(&file.path)) {
        return;
    }
    let uses = uses(code);
    for pattern in NOT_IN_CORE {
        let names: Vec<&str> = pattern.iter().copied().filter(|t| *t != "::").collect();
        let brings = |path: &[String]| path.windows(names.len()).any(|part| part == names);
        let used = uses.iter().filter(|used| brings(&used.path));
        let lines: BTreeSet<usize> = matches(code, pattern)
            .map(|at| code[at].line)
            .chain(used.map(|used| used.line))
            .collect();
        for line in lines {
            let pattern = pattern.concat();
            found.push(format!("{}:{line}: {pattern} in the core", file.path));
        }
    }
}

/// `mod.rs` and `lib.rs` hold modules and re-exports only.
fn check_mod(file: &File, code: &[Token], found: &mut Vec<String>) {
    if !(file.path.ends_with("/mod.rs") || file.path == "src/lib.rs") {
        return;
    }
    let mut at = 0;
    while at < code.len() {
        let begin = at;
        if code[at].text == "#" {
            at = tokens::after_group(code, at + 1 + usize::from(code[at + 1].text == "!"));
            continue;
        }
        if code[at].text == "pub" {
            at += 1;
            if code.get(at).is_some_and(|token| token.text == "(") {
                at = tokens::after_group(code, at);
            }
        }
        let kind = code.get(at).map_or("", |token| token.text.as_str());
        let end = code[at..].iter().position(|token| token.text == ";");
        let body = code[at..].iter().position(|token| token.text == "{");
        let inline = kind == "mod" && body < end && body.is_some();
        match end {
            Some(end) if matches!(kind, "mod" | "use") && !inline => at += end + 1,
            _ => {
                found.push(format!(
                    "{}:{}: code in {}, expected modules and re-exports only",
                    file.path,
                    code[begin].line,
                    file.path.rsplit('/').next().unwrap_or_default()
                ));
                return;
            }
        }
    }
}

fn matches<'a>(code: &'a [Token], pattern: &'a [&'a str]) -> impl Iterator<Item = usize> + 'a {
    code.windows(pattern.len())
        .enumerate()
        .filter(move |(_, window)| {
            window
                .iter()
                .zip(pattern)
                .all(|(token, text)| token.text == *text)
        })
        .map(|(at, _)| at)
}

/// Rust files under a folder of the crate, by name.
fn collect(root: &Path, folder: &Path, files: &mut Vec<File>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(root, &path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let inside = path.strip_prefix(root).unwrap();
            let parts: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
            files.push(File {
                path: parts.join("/"),
                text: fs::read_to_string(&path).unwrap(),
            });
        }
    }
}

#[test]
fn the_house_is_tidy() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["src", "tests", "tools", "benches", "examples"] {
        collect(root, &root.join(folder), &mut files);
    }
    assert!(files.len() > 30, "only {} files found", files.len());
    let found = violations(&files);
    assert!(found.is_empty(), "\n{}\n", found.join("\n"));
}

/// What the checks say about one file.
fn of(path: &str, text: &str) -> Vec<String> {
    violations(&[File {
        path: path.into(),
        text: text.into(),
    }])
}

#[test]
fn planted_violations_are_caught() {
    for (path, text, complaint) in [
        (
            "src/core/math/so3.rs",
            "use crate::physics::State;",
            "math imports physics",
        ),
        (
            "src/core/estimate/sqp.rs",
            "use crate::{math::Pose, segment::clean, motion};",
            "estimate imports segment",
        ),
        (
            "src/core/estimate/sqp.rs",
            "fn f() { crate::verify::check(); }",
            "estimate imports verify",
        ),
        (
            "src/wire/cdr.rs",
            "use super::super::service::replay;",
            "wire imports service",
        ),
        ("src/main.rs", "use enact::wire;", "main imports wire"),
        ("src/attic/old.rs", "", "without a row in the table"),
        (
            "src/core/verify/solid.rs",
            "use parry3d::query;",
            "parry3d outside",
        ),
        (
            "src/service/replay.rs",
            "fn f() -> mcap::McapResult<()> { todo!() }",
            "mcap outside",
        ),
        (
            "src/core/segment/cut.rs",
            "use clarabel::solver as s;",
            "clarabel outside",
        ),
        ("src/write/ros.rs", "use cdr;", "cdr outside"),
        ("src/wire/pose.rs", "use anyhow::bail;", "anyhow outside"),
        (
            "src/core/pipeline.rs",
            "use std::time::Instant;",
            "Instant in the core",
        ),
        (
            "src/core/estimate/sqp.rs",
            "fn f() { println!(\"{}\", 1); }",
            "println! in the core",
        ),
        (
            "src/core/segment/cut.rs",
            "fn f() { std::fs::read(\"x\"); }",
            "std::fs in the core",
        ),
        (
            "src/core/segment/cut.rs",
            "type T = std::collections::HashMap<u8, u8>;",
            "HashMap in the core",
        ),
        (
            "src/service/import.rs",
            "fn f() { std::fs::read(\"x\"); }",
            "fs::read past the door",
        ),
        (
            "src/core/motion/mod.rs",
            "//! Prose.\npub mod a;\npub use a::B;\nfn f() {}",
            "mod.rs:4: code in mod.rs",
        ),
        (
            "src/core/motion/mod.rs",
            "mod a { pub fn f() {} }",
            "code in mod.rs",
        ),
        (
            "src/core/config/raw.rs",
            "fn f() { g().unwrap(); }",
            "raw.rs:1: unwrap()",
        ),
        (
            "src/core/config/raw.rs",
            "#[cfg(test)]\nmod tests { fn f() {} }\nfn f() { g().unwrap(); }",
            "raw.rs:3: unwrap()",
        ),
        (
            "src/core/config/raw.rs",
            "fn f() {\n g().expect(\"x\"); }",
            "raw.rs:2: 1 expect(), 0 in the table",
        ),
        (
            "src/wire/encode.rs",
            "fn f() {}",
            "encode.rs:: 0 expect(), 2 in the table",
        ),
        (
            "src/core/segment/cut.rs",
            "use std::{\n collections::BTreeMap,\n fs,\n};",
            "cut.rs:3: std::fs in the core",
        ),
        (
            "src/core/segment/cut.rs",
            "use std::{io::{self}, thread::{self as t, sleep}};",
            "std::thread in the core",
        ),
        (
            "src/core/segment/cut.rs",
            "use {crate::math::Pose, std::{env as e}};",
            "std::env in the core",
        ),
        (
            "src/core/segment/cut.rs",
            "use std as s;",
            "std under another name",
        ),
        (
            "src/core/segment/cut.rs",
            "use std::{self as s};",
            "std under another name",
        ),
        (
            "src/core/segment/cut.rs",
            "use std::*;",
            "std under another name",
        ),
        (
            "src/wire/pose.rs",
            "use crate as c;\nfn f() { c::cli::run(); }",
            "crate under another name",
        ),
        (
            "src/wire/pose.rs",
            "use crate::{self as c};",
            "crate under another name",
        ),
        (
            "src/wire/pose.rs",
            "extern crate rayon as r;",
            "extern crate",
        ),
        (
            "src/wire/pose.rs",
            "fn f() { ::rayon::join(g, h); }",
            "rayon outside",
        ),
        ("src/wire/pose.rs", "use ::rayon as r;", "rayon outside"),
        (
            "src/write/ros.rs",
            "use {serde, cdr};",
            "ros.rs:1: cdr outside",
        ),
        (
            "tests/real.rs",
            "fn f() { eprintln!(\"skipped: no data\"); }",
            "real.rs:1: an uncounted skip",
        ),
    ] {
        let found = of(path, text);
        assert!(
            found.iter().any(|f| f.contains(complaint)),
            "{path}: {text}: {found:?}"
        );
    }
    let long = "\n".repeat(LINES + 1);
    assert_eq!(of("tests/long.rs", &long).len(), 1);
}

#[test]
fn what_is_allowed_is_not_caught() {
    for (path, text) in [
        (
            "src/core/estimate/sqp.rs",
            "use crate::{math::{so3, Pose}, motion::Scene};\nuse super::grid;",
        ),
        (
            "src/core/estimate/sqp.rs",
            "// crate::segment\n/* println! /* std::fs */ Instant */ fn f() -> &'static str { \"crate::wire println!\" }",
        ),
        (
            "src/core/estimate/sqp.rs",
            "fn f() { g(r#\"std::fs \"quoted\" \"#, '\"', b'\\''); }",
        ),
        (
            "src/core/estimate/sqp.rs",
            "#[cfg(test)]\nmod tests { use crate::config::scene_from_toml; use std::time::Instant; }",
        ),
        (
            "src/core/config/raw.rs",
            "#[cfg(test)]\nfn f() { g().unwrap(); }",
        ),
        ("src/write/error.rs", "fn f() { WriteError::mcap(path); }"),
        ("src/service/job.rs", "fn f(mcap: u8) { self.mcap(mcap) }"),
        (
            "src/core/motion/mod.rs",
            "#![warn(x)]\n//! Prose.\n#[cfg(test)]\nmod tests;\npub(crate) mod a;\npub use a::{B, C};",
        ),
        ("src/main.rs", "fn main() { enact::cli::run(); }"),
        (
            "src/core/segment/cut.rs",
            "use std::{cmp, collections::BTreeMap as Map};\nuse super::*;\nuse crate::motion::fs;\npub use self::a::*;",
        ),
        (
            "src/core/segment/cut.rs",
            "fn f<'a>(x: &'a [u8]) -> impl Fn() + use<'a> { || <A>::cdr::f(B::mcap::g(x)) }",
        ),
    ] {
        assert_eq!(of(path, text), Vec::<String>::new(), "{path}: {text}");
    }
    let split = [
        File {
            path: "src/core/segment/clean.rs".into(),
            text: "#[cfg(test)]\nmod tests;".into(),
        },
        File {
            path: "src/core/segment/clean/tests.rs".into(),
            text: "use crate::config::scene_from_toml;".into(),
        },
    ];
    assert_eq!(violations(&split), Vec::<String>::new());
    assert_eq!(violations(&split[1..]).len(), 1);
}

#[test]
fn planted_circles_are_caught() {
    let house = |files: &[(&str, &str)]| -> Vec<String> {
        let files = files.iter().map(|(path, text)| File {
            path: (*path).into(),
            text: (*text).into(),
        });
        violations(&files.collect::<Vec<_>>())
    };
    let circle = "src/core/motion/a.rs, src/core/motion/b.rs: import each other";
    // By name, through what the room hands on, and through a third; from a module to its own parts.
    let two = [
        ("src/core/motion/a.rs", "use super::b::B;"),
        ("src/core/motion/b.rs", "use crate::motion::a::A;"),
    ];
    assert_eq!(house(&two), [circle]);
    let handed_on = [
        (
            "src/core/motion/mod.rs",
            "mod a;\nmod b;\npub use self::a::A;\npub use b::{B as C, D};",
        ),
        ("src/core/motion/a.rs", "use super::C;"),
        ("src/core/motion/b.rs", "use super::A;"),
    ];
    assert_eq!(house(&handed_on), [circle]);
    let three = [
        ("src/core/motion/a.rs", "use super::b::B;"),
        ("src/core/motion/b.rs", "use super::c;"),
        ("src/core/motion/c.rs", "pub(super) use super::a::A;"),
    ];
    assert_eq!(house(&three).len(), 1);
    let parent = [
        (
            "src/core/motion.rs",
            "mod part;\nuse part::Part;\nstruct Whole;",
        ),
        ("src/core/motion/part.rs", "use super::Whole;"),
    ];
    assert_eq!(house(&parent).len(), 1);
    // One way, and the tests' way back, are no circle.
    let one_way = [
        ("src/core/motion/a.rs", "use super::b::B;\nuse std::b;"),
        (
            "src/core/motion/b.rs",
            "struct B;\n#[cfg(test)]\nmod tests { use crate::motion::a::A; }",
        ),
    ];
    assert_eq!(house(&one_way), Vec::<String>::new());
}
