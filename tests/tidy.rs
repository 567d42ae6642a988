//! The house rules that a machine can check: which room may import which, one door per third
//! party, what the core must not touch, lengths of files, `mod.rs` without code.
//!
//! Code is looked at as tokens, so that comments, texts and doctests do not count; test code
//! may import what it likes.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

#[path = "tidy/tokens.rs"]
mod tokens;

use tokens::{Token, out_of_line_tests, tokens, without_tests};

/// Longest file [lines].
const LINES: usize = 800;

/// Each room with the rooms it may import.
const IMPORTS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("physics", &["math"]),
    ("motion", &["physics", "math"]),
    ("segment", &["motion", "physics", "math"]),
    ("initialise", &["motion", "physics", "math"]),
    ("estimate", &["motion", "physics", "math"]),
    ("verify", &["motion", "physics", "math"]),
    ("settle", &["motion", "physics", "math"]),
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
    ("write", &["wire", "motion", "physics", "math"]),
    ("config", &["motion", "physics", "math"]),
    (
        "service",
        &["pipeline", "ingest", "write", "config", "motion"],
    ),
    ("cli", &["config", "service"]),
    ("main", &["cli", "service"]),
    ("lib", &[]),
];

/// The rooms that compute and nothing else.
const CORE: &[&str] = &[
    "math",
    "motion",
    "physics",
    "segment",
    "initialise",
    "estimate",
    "verify",
    "settle",
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
    ("parry3d", &["src/physics/shape.rs", "src/physics/shape/"]),
    ("rapier3d", &["src/settle.rs"]),
    ("clarabel", &["src/estimate/"]),
    ("cdr", &["src/wire/"]),
    ("mcap", &["src/wire/", "src/ingest/", "src/write/"]),
    (
        "foxglove",
        &[
            "src/wire/",
            "src/ingest/",
            "src/write/",
            "src/service/capture/",
        ],
    ),
    ("httparse", &["src/service/capture/"]),
    (
        "iceoryx2",
        &["src/wire/live/", "src/ingest/live/", "src/write/live.rs"],
    ),
    ("tokio", &["src/service/capture/"]),
    ("rustix", &["src/service/doctor.rs"]),
    ("toml", &["src/config/", "src/wire/live/census.rs"]),
    ("clap", &["src/cli/"]),
    ("clap_complete", &["src/cli/"]),
    ("rayon", &["src/service/"]),
    ("indicatif", &["src/service/", "src/cli/"]),
    ("anyhow", &["src/service/", "src/cli/", "src/main.rs"]),
];

/// Where everything comes from outside.
const NO_UNWRAP: &[&str] = &["ingest", "wire", "config"];

struct File {
    /// From the crate's root, with slashes.
    path: String,
    text: String,
}

/// `src/motion/scene.rs` → `motion`, `src/pipeline.rs` → `pipeline`.
fn room(path: &str) -> &str {
    let inside = path.strip_prefix("src/").unwrap_or(path);
    let first = inside.split('/').next().unwrap_or_default();
    first.strip_suffix(".rs").unwrap_or(first)
}

/// How many `super::` lead from the file's module to the crate's root.
fn depth(path: &str) -> usize {
    let inside = path.strip_prefix("src/").unwrap_or(path);
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
    for file in files {
        let lines = file.text.lines().count();
        if lines > LINES {
            found.push(format!("{}: {lines} lines, at most {LINES}", file.path));
        }
        if !file.path.starts_with("src/") || is_test(&file.path) {
            continue;
        }
        let code = without_tests(&tokens(&file.text));
        check_imports(file, &code, &mut found);
        check_doors(file, &code, &mut found);
        check_core(file, &code, &mut found);
        check_mod(file, &code, &mut found);
        if NO_UNWRAP.contains(&room(&file.path)) {
            for at in matches(&code, &[".", "unwrap", "("]) {
                found.push(format!("{}:{}: unwrap()", file.path, code[at].line));
            }
        }
    }
    found
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
        for at in matches(code, &[name]) {
            if names_a_crate(code, at) {
                found.push(format!(
                    "{}:{}: {name} outside {}",
                    file.path,
                    code[at].line,
                    places.join(", ")
                ));
            }
        }
    }
}

/// Whether a word is the beginning of a path and not a method, a field or a module of ours.
fn names_a_crate(code: &[Token], at: usize) -> bool {
    let before = at.checked_sub(1).map(|at| code[at].text.as_str());
    let after = code.get(at + 1).map(|token| token.text.as_str());
    let begins = !matches!(before, Some("::" | "." | "mod" | "fn" | "let"));
    begins && (after == Some("::") || before == Some("use") || after == Some("!"))
}

fn check_core(file: &File, code: &[Token], found: &mut Vec<String>) {
    if !CORE.contains(&room(&file.path)) {
        return;
    }
    for pattern in NOT_IN_CORE {
        for at in matches(code, pattern) {
            found.push(format!(
                "{}:{}: {} in the core",
                file.path,
                code[at].line,
                pattern.concat()
            ));
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
            "src/math/so3.rs",
            "use crate::physics::State;",
            "math imports physics",
        ),
        (
            "src/estimate/sqp.rs",
            "use crate::{math::Pose, segment::clean, motion};",
            "estimate imports segment",
        ),
        (
            "src/estimate/sqp.rs",
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
            "src/verify/solid.rs",
            "use parry3d::query;",
            "parry3d outside",
        ),
        (
            "src/service/replay.rs",
            "fn f() -> mcap::McapResult<()> { todo!() }",
            "mcap outside",
        ),
        (
            "src/segment/cut.rs",
            "use clarabel::solver as s;",
            "clarabel outside",
        ),
        ("src/write/ros.rs", "use cdr;", "cdr outside"),
        ("src/wire/pose.rs", "use anyhow::bail;", "anyhow outside"),
        (
            "src/pipeline.rs",
            "use std::time::Instant;",
            "Instant in the core",
        ),
        (
            "src/estimate/sqp.rs",
            "fn f() { println!(\"{}\", 1); }",
            "println! in the core",
        ),
        (
            "src/segment/cut.rs",
            "fn f() { std::fs::read(\"x\"); }",
            "std::fs in the core",
        ),
        (
            "src/segment/cut.rs",
            "type T = std::collections::HashMap<u8, u8>;",
            "HashMap in the core",
        ),
        (
            "src/motion/mod.rs",
            "//! Prose.\npub mod a;\npub use a::B;\nfn f() {}",
            "mod.rs:4: code in mod.rs",
        ),
        (
            "src/motion/mod.rs",
            "mod a { pub fn f() {} }",
            "code in mod.rs",
        ),
        (
            "src/config/raw.rs",
            "fn f() { g().unwrap(); }",
            "raw.rs:1: unwrap()",
        ),
        (
            "src/config/raw.rs",
            "#[cfg(test)]\nmod tests { fn f() {} }\nfn f() { g().unwrap(); }",
            "raw.rs:3: unwrap()",
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
            "src/estimate/sqp.rs",
            "use crate::{math::{so3, Pose}, motion::Scene};\nuse super::grid;",
        ),
        (
            "src/estimate/sqp.rs",
            "// crate::segment\n/* println! /* std::fs */ Instant */ fn f() -> &'static str { \"crate::wire println!\" }",
        ),
        (
            "src/estimate/sqp.rs",
            "fn f() { g(r#\"std::fs \"quoted\" \"#, '\"', b'\\''); }",
        ),
        (
            "src/estimate/sqp.rs",
            "#[cfg(test)]\nmod tests { use crate::config::scene_from_toml; use std::time::Instant; }",
        ),
        (
            "src/config/raw.rs",
            "#[cfg(test)]\nfn f() { g().unwrap(); }",
        ),
        ("src/write/error.rs", "fn f() { WriteError::mcap(path); }"),
        ("src/service/job.rs", "fn f(mcap: u8) { self.mcap(mcap) }"),
        (
            "src/motion/mod.rs",
            "#![warn(x)]\n//! Prose.\n#[cfg(test)]\nmod tests;\npub(crate) mod a;\npub use a::{B, C};",
        ),
        ("src/main.rs", "fn main() { enact::cli::run(); }"),
    ] {
        assert_eq!(of(path, text), Vec::<String>::new(), "{path}: {text}");
    }
    let split = [
        File {
            path: "src/segment/clean.rs".into(),
            text: "#[cfg(test)]\nmod tests;".into(),
        },
        File {
            path: "src/segment/clean/tests.rs".into(),
            text: "use crate::config::scene_from_toml;".into(),
        },
    ];
    assert_eq!(violations(&split), Vec::<String>::new());
    assert_eq!(violations(&split[1..]).len(), 1);
}
