//! Manners of the command line: pipes, deadlines, many recordings, man pages, lines for machines, signals.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

fn enact(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("enact").expect("the program");
    command.args(arguments).env("NO_COLOR", "1");
    command
}

fn recording(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
    path.join(name).display().to_string()
}

/// The same with something on stdin.
fn piped(arguments: &[&str], input: Vec<u8>) -> std::process::Output {
    enact(arguments).write_stdin(input).output().expect("run")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Exit code, stdout, stderr.
fn ran(arguments: &[&str]) -> (i32, String, String) {
    let output = enact(arguments).output().expect("run");
    let code = output.status.code().expect("an exit code");
    (code, text(&output.stdout), text(&output.stderr))
}

fn folder() -> (TempDir, impl Fn(&str) -> String) {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().to_owned();
    (folder, move |name: &str| {
        path.join(name).display().to_string()
    })
}

/// Rows of a CSV without the comment, which names the file.
fn rows(csv: &str) -> Vec<String> {
    let lines = csv.lines().filter(|line| !line.starts_with('#'));
    lines.map(str::to_owned).collect()
}

#[test]
fn recordings_go_through_pipes() {
    let (_folder, at) = folder();
    let input = std::fs::read(recording("pencil_tip.mcap")).expect("a recording");
    let (code, _, said) = ran(&["replay", &recording("pencil_tip.mcap"), "-o", &at("x.mcap")]);
    assert_eq!(code, 0, "{said}");
    let (code, expected, said) = ran(&["export", &at("x.mcap"), "--to", "csv", "-o", "-"]);
    assert_eq!(code, 0, "{said}");

    let estimate = piped(&["replay", "-", "-o", "-"], input.clone());
    assert_eq!(
        estimate.status.code(),
        Some(0),
        "{}",
        text(&estimate.stderr)
    );
    // The account is where the recording is not.
    assert!(text(&estimate.stderr).contains("-: physical, fits well"));
    let export = piped(
        &["export", "-", "--to", "csv", "-o", "-"],
        estimate.stdout.clone(),
    );
    assert_eq!(rows(&text(&export.stdout)), rows(&expected));
    let inspect = piped(&["inspect", "-"], estimate.stdout.clone());
    assert!(text(&inspect.stdout).contains("/estimate/pencil/pose"));
    let page = piped(&["report", "-", "-o", "-"], estimate.stdout.clone());
    assert!(text(&page.stdout).starts_with("<!doctype html>"));

    // Nothing can be named after stdin.
    for (arguments, input) in [
        (&["replay", "-"][..], &input),
        (&["predict", "-"], &input),
        (&["export", "-", "--to", "csv"], &estimate.stdout),
        (&["report", "-"], &estimate.stdout),
    ] {
        let mut nameless = enact(arguments);
        nameless.current_dir(_folder.path());
        let nameless = nameless
            .write_stdin(input.as_slice())
            .output()
            .expect("run");
        let said = text(&nameless.stderr);
        assert_eq!(nameless.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(
            said.contains("stdin has no name") && said.contains("-o FILE"),
            "{said}"
        );
    }
    assert_eq!(std::fs::read_dir(_folder.path()).expect("list").count(), 1);
}

/// Stdout has the very bytes that the file would have, and nothing of the account.
#[test]
fn what_goes_to_stdout_is_the_file_alone() {
    let (_folder, at) = folder();
    let input = recording("pencil_tip.mcap");
    let commands: [(&str, &[&str]); 5] = [
        ("in.mcap", &["mark", &input, "--add", "0.5"]),
        ("in.mcap", &["import", &input, "--start", "0.1"]),
        ("in.mcap", &["predict", &input, "--limit", "0.1"]),
        ("in.toml", &["scene", "new", "die"]),
        ("in.glb", &["export", &at("estimate.mcap"), "--to", "glb"]),
    ];
    let (code, _, said) = ran(&["replay", &input, "-o", &at("estimate.mcap")]);
    assert_eq!(code, 0, "{said}");
    for (name, command) in commands {
        for format in ["text", "ndjson"] {
            let _ = std::fs::remove_file(at(name));
            let to = |output: &str| {
                let more = ["--format", format, "-o", output];
                enact(&[command, &more].concat()).output().expect("run")
            };
            let (file, pipe) = (to(&at(name)), to("-"));
            assert_eq!(file.status.code(), pipe.status.code(), "{command:?}");
            let written = std::fs::read(at(name)).expect("written");
            // The glTF names the command that made it, and so does the first line of a scene.
            let said = |bytes: &[u8]| match name {
                "in.toml" => bytes
                    .iter()
                    .skip_while(|of| **of != b'\n')
                    .copied()
                    .collect::<Vec<u8>>(),
                _ => bytes.to_vec(),
            };
            let is_same = said(&pipe.stdout) == said(&written) || name == "in.glb";
            assert!(is_same && pipe.stdout.len() > 100, "{command:?} {format}");
            assert_eq!(pipe.stdout[..4], written[..4], "{command:?} {format}");
        }
    }
}

#[test]
fn estimates_among_recordings_are_left_alone_and_a_summary_ends_the_account() {
    let (_folder, at) = folder();
    let names = ["a.mcap", "b.mcap", "c.mcap"].map(&at);
    for name in &names {
        std::fs::copy(recording("pencil_tip.mcap"), name).expect("copy");
    }
    std::fs::write(&names[1], b"no recording").expect("write");
    let (code, _, said) = ran(&["replay", &names[2]]);
    assert_eq!(code, 0, "{said}");
    let estimate = at("c.estimate.mcap");
    let before = std::fs::read(&estimate).expect("an estimate");
    let out = at("out");
    let all = [&names[0], &names[1], &names[2], &estimate];
    let all: Vec<&str> = all.iter().map(|name| name.as_str()).collect();
    let (code, said, errors) = ran(&[&["process", "-o", &out], &all[..]].concat());
    assert_eq!(code, 1, "{errors}");
    let lines: Vec<&str> = said.lines().collect();
    // No account of each: a head, a line each and the sum.
    assert_eq!(lines.len(), 6, "{said}");
    let end = &lines[lines.len() - 5..];
    for (line, [name, verdict]) in end.iter().zip([
        [&names[0], "physical"],
        [&names[1], "no estimate"],
        [&names[2], "physical"],
        [&estimate, "left alone"],
    ]) {
        assert!(line.starts_with(name) && line.contains(verdict), "{said}");
    }
    assert_eq!(
        end[4],
        "4 recordings: 2 physical, 1 without an estimate, 1 left alone"
    );
    let mut written: Vec<_> = std::fs::read_dir(&out).expect("list").collect();
    written.retain(|entry| entry.as_ref().is_ok_and(|entry| entry.path().exists()));
    assert_eq!(written.len(), 2);
    assert_eq!(std::fs::read(&estimate).expect("still there"), before);

    let (_, said, _) = ran(&[&["process", "-o", &out, "--format", "ndjson"], &all[..]].concat());
    let schemas = said.lines().map(|line| {
        let line: Value = serde_json::from_str(line).expect("JSON");
        line["schema"].as_str().expect("a schema").to_owned()
    });
    let expected = ["recording", "failure", "recording", "left_alone"];
    assert_eq!(
        schemas.collect::<Vec<_>>(),
        expected.map(|name| format!("enact.{name}/1"))
    );
}

#[test]
fn of_a_damaged_file_the_damage_is_named_first() {
    let (_folder, at) = folder();
    let whole = std::fs::read(recording("pencil_tip.mcap")).expect("a recording");
    let input = at("cut.mcap");
    let mut seen = BTreeSet::new();
    for share in [0.02, 0.1, 0.3, 0.6] {
        let cut = (whole.len() as f64 * share) as usize;
        std::fs::write(&input, &whole[..cut]).expect("write");
        let output = at("out.mcap");
        for arguments in [
            &["replay", &input, "-o", &output][..],
            &["export", &input, "--to", "csv", "-o", "-"],
        ] {
            let (code, said, errors) = ran(arguments);
            match code {
                1 => assert!(
                    errors.starts_with(&format!("error: {input}: the file is damaged")),
                    "{share}: {errors}"
                ),
                _ => assert!(
                    code == 3 && said.contains("lost: "),
                    "{share}: {said}{errors}"
                ),
            }
            seen.insert(code);
        }
    }
    assert!(seen.contains(&1), "{seen:?}");
}

#[test]
fn every_command_has_a_man_page_and_an_example() {
    let (_folder, at) = folder();
    let pages = at("man");
    let (code, said, errors) = ran(&["manual", "-o", &pages]);
    assert_eq!(code, 0, "{errors}");
    let written: Vec<PathBuf> = said.lines().map(PathBuf::from).collect();
    let (_, help, _) = ran(&["--help"]);
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let commands = commands.take_while(|line| !line.is_empty());
    let commands = commands.filter_map(|line| line.split_whitespace().next());
    let commands: Vec<&str> = commands.filter(|name| *name != "help").collect();
    assert!(commands.contains(&"replay") && commands.contains(&"scene"));
    for name in commands {
        let page = Path::new(&pages).join(format!("enact-{name}.1"));
        assert!(written.contains(&page), "{page:?}");
        let page = std::fs::read_to_string(&page).expect("a page");
        assert!(page.contains(".SH NAME"), "{name}");
    }
    for page in &written {
        let name = page.file_stem().expect("a name").to_string_lossy();
        if name == "enact" {
            continue;
        }
        // Of a command of commands the examples are there.
        let command = name.split('-').take(2).collect::<Vec<_>>().join("-");
        let texts = [name.to_string(), command].map(|name| {
            let page = Path::new(&pages).join(format!("{name}.1"));
            std::fs::read_to_string(page).expect("a page")
        });
        assert!(texts.iter().any(|text| text.contains("Example")), "{name}");
    }
}

/// Schemas in the document: name, and the fields that it lists.
fn documented() -> Vec<(String, BTreeSet<String>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/ndjson.md");
    let text = std::fs::read_to_string(path).expect("the document");
    let mut schemas: Vec<(String, BTreeSet<String>)> = Vec::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("## `") {
            schemas.push((name.trim_end_matches('`').to_owned(), BTreeSet::new()));
        } else if let (Some(field), Some((_, fields))) =
            (line.strip_prefix("| `"), schemas.last_mut())
        {
            let field = field.split('`').next().expect("a field");
            fields.insert(field.to_owned());
        }
    }
    schemas
}

#[test]
fn lines_for_machines_are_as_documented() {
    let (_folder, at) = folder();
    let tip = recording("pencil_tip.mcap");
    let (out, broken, keys) = (at("x.mcap"), at("broken.mcap"), at("keys.csv"));
    std::fs::write(&broken, b"no recording").expect("write");
    let estimates = at("estimates");
    let mut found = BTreeSet::new();
    let documented = documented();
    for arguments in [
        &["replay", &tip, "-o", &out][..],
        &["replay", &broken],
        &["process", &out, "-o", &estimates],
        &["inspect", &tip],
        &["export", &out, "--to", "csv"],
        &["sketch", &tip, "-o", &keys],
        &["recover", &at("")],
    ] {
        let (_, said, _) = ran(&[arguments, &["--format", "ndjson"]].concat());
        for line in said.lines().filter(|line| line.starts_with('{')) {
            assert!(line.starts_with("{\"schema\":"), "{line}");
            let line: serde_json::Map<String, Value> = serde_json::from_str(line).expect("JSON");
            let schema = line["schema"].as_str().expect("a schema").to_owned();
            let fields: BTreeSet<String> = line.keys().cloned().collect();
            let expected = documented.iter().find(|(name, _)| *name == schema);
            assert_eq!(
                expected.map(|(_, fields)| fields),
                Some(&fields),
                "{schema}"
            );
            found.insert(schema);
        }
    }
    let expected = [
        "recording",
        "failure",
        "left_alone",
        "inspection",
        "export",
        "sketch",
    ];
    let expected: BTreeSet<String> = expected.map(|name| format!("enact.{name}/1")).into();
    assert_eq!(found, expected);
}

#[test]
fn every_schema_of_a_line_is_documented() {
    let cli = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cli");
    let documented: Vec<String> = documented().into_iter().map(|(name, _)| name).collect();
    let mut used = BTreeSet::new();
    for entry in std::fs::read_dir(cli).expect("list") {
        let Ok(text) = std::fs::read_to_string(entry.expect("entry").path()) else {
            continue;
        };
        for part in text.split("\"enact.").skip(1) {
            let name = part.split('"').next().expect("its end");
            if name.contains('/') {
                used.insert(format!("enact.{name}"));
            }
        }
    }
    assert!(used.len() > 6, "{used:?}");
    for name in &used {
        assert!(documented.contains(name), "{name} is not in docs/ndjson.md");
    }
}

#[cfg(unix)]
#[test]
fn a_signal_leaves_no_file_that_is_not_whole() {
    use std::os::unix::process::ExitStatusExt;
    use std::time::{Duration, Instant};
    let (folder, at) = folder();
    // Much beside the performance, so that writing takes its time.
    let input = at("large.mcap");
    let bytes = std::fs::read(recording("pencil_tip.mcap")).expect("a recording");
    std::fs::write(&input, enlarged(&bytes, 96 << 20)).expect("write");
    let program = assert_cmd::cargo::cargo_bin("enact");
    let mut child = std::process::Command::new(program)
        .args(["replay", &input, "-o", &at("out.mcap")])
        .spawn()
        .expect("run");
    let names = || -> Vec<String> {
        let entries = std::fs::read_dir(folder.path()).expect("list");
        entries
            .map(|entry| {
                entry
                    .expect("entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect()
    };
    let patience = Instant::now() + Duration::from_secs(60);
    while !names().iter().any(|name| name.ends_with(".part")) {
        assert!(
            child.try_wait().expect("wait").is_none(),
            "it ended before it wrote"
        );
        assert!(Instant::now() < patience, "it writes nothing");
        std::thread::sleep(Duration::from_millis(1));
    }
    let pid = child.id().to_string();
    let killed = std::process::Command::new("kill")
        .args(["-INT", &pid])
        .status();
    assert!(killed.expect("kill").success());
    let status = child.wait().expect("wait");
    assert_eq!(status.signal(), Some(2), "{status:?}");
    assert_eq!(names(), ["large.mcap"]);
}

/// A recording with so many bytes on a topic of no use beside what it has.
#[cfg(unix)]
fn enlarged(recording: &[u8], bytes: usize) -> Vec<u8> {
    use std::collections::BTreeMap;
    let mut file = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(None);
    let mut writer = options.create(&mut file).expect("writer");
    let channel = std::sync::Arc::new(mcap::Channel {
        id: 60_000,
        topic: "/noise".to_owned(),
        schema: None,
        message_encoding: "raw".to_owned(),
        metadata: BTreeMap::new(),
    });
    let summary = mcap::Summary::read(recording)
        .expect("read")
        .expect("a summary");
    for index in &summary.attachment_indexes {
        let attachment = mcap::read::attachment(recording, index).expect("an attachment");
        writer.attach(&attachment).expect("attach");
    }
    let mut last = 0;
    for message in mcap::MessageStream::new(recording).expect("messages") {
        let message = message.expect("a message");
        last = message.log_time;
        writer.write(&message).expect("write");
    }
    // What does not compress takes the longest.
    let mut state: u64 = 1;
    let noise: Vec<u8> = (0..1 << 20)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        })
        .collect();
    for sequence in 0..bytes >> 20 {
        let message = mcap::Message {
            channel: channel.clone(),
            sequence: sequence as u32,
            log_time: last,
            publish_time: last,
            data: noise.as_slice().into(),
        };
        writer.write(&message).expect("write");
    }
    writer.finish().expect("finish");
    drop(writer);
    file.into_inner()
}
