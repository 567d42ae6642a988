//! Commands over several recordings and folders of them: each has its account, a bad one costs a line, and what is done stays
//! done.

use std::fs;
use std::path::Path;
use std::process::Output;
use std::time::Instant;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::enact;

fn folder_of_takes() -> TempDir {
    let folder = TempDir::new().expect("folder");
    let takes = folder.path().join("takes");
    fs::create_dir(&takes).expect("folder");
    for name in ["pencil_tip", "die"] {
        let recording =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recordings/{name}.mcap"));
        fs::copy(recording, takes.join(format!("{name}.mcap"))).expect("copy");
    }
    fs::write(takes.join("bad.mcap"), "no recording").expect("write");
    folder
}

fn schemas(output: &Output) -> Vec<(String, Value)> {
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"));
    lines
        .map(|line: Value| (line["schema"].as_str().expect("a schema").to_owned(), line))
        .collect()
}

fn named<'a>(lines: &'a [(String, Value)], schema: &str) -> Vec<&'a Value> {
    let of = lines.iter().filter(|(of, _)| of == schema);
    of.map(|(_, line)| line).collect()
}

#[test]
fn a_folder_stands_for_its_recordings() {
    let folder = folder_of_takes();
    for command in [&["inspect"][..], &["mark", "--propose"]] {
        let words = [command, &["takes", "--format", "ndjson"]].concat();
        let said = enact(folder.path(), &words);
        assert_eq!(said.status.code(), Some(1), "{said:?}");
        let lines = schemas(&said);
        assert_eq!(lines.len(), 3, "{lines:?}");
        assert_eq!(named(&lines, "enact.failure/1").len(), 1);
    }
}

#[test]
fn marks_are_proposed_for_several_into_a_folder_and_changed_of_one_only() {
    let folder = folder_of_takes();
    let takes = ["takes/pencil_tip.mcap", "takes/die.mcap"];
    let words = [&["mark", "--propose"], &takes[..], &["-o", "marked"]].concat();
    let said = enact(folder.path(), &words);
    // They have marks of their own, which are not replaced.
    assert_eq!(said.status.code(), Some(1), "{said:?}");
    let words = [
        &["mark", "--propose", "--remove", "all"],
        &takes[..],
        &["-o", "marked"],
    ]
    .concat();
    let said = enact(folder.path(), &words);
    assert_eq!(said.status.code(), Some(0), "{said:?}");
    for name in ["pencil_tip.mcap", "die.mcap"] {
        assert!(folder.path().join("marked").join(name).is_file(), "{name}");
    }
    let words = [&["mark", "--add", "0.5"], &takes[..], &["-o", "other"]].concat();
    let said = enact(folder.path(), &words);
    assert_eq!(said.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&said.stderr).contains("2 recordings, expected one"));
}

#[test]
fn each_table_becomes_a_recording_of_its_own() {
    let folder = TempDir::new().expect("folder");
    let rows = |height: f64| {
        let rows = (0..20).map(|row| {
            let time = f64::from(row) / 100.0;
            format!("{time},0,0,{height},1,0,0,0\n")
        });
        format!("time,x,y,z,qw,qx,qy,qz\n{}", rows.collect::<String>())
    };
    for (name, height) in [("a.csv", 1.0), ("b.1.csv", 2.0)] {
        fs::write(folder.path().join(name), rows(height)).expect("write");
    }
    fs::write(folder.path().join("c.csv"), "nothing").expect("write");
    let words = [
        "import", "--each", "a.csv", "b.1.csv", "c.csv", "-o", "takes",
    ];
    let said = enact(folder.path(), &words);
    assert_eq!(said.status.code(), Some(1), "{said:?}");
    assert!(folder.path().join("takes/a.mcap").is_file());
    assert!(folder.path().join("takes/b.1.mcap").is_file());
    assert!(!folder.path().join("takes/c.mcap").exists());
}

#[test]
fn what_is_done_is_kept_where_it_is_of_the_same() {
    let folder = folder_of_takes();
    let words = [
        "process", "takes", "-o", "done", "--resume", "--format", "ndjson",
    ];
    let run = |words: &[&str]| schemas(&enact(folder.path(), words));
    let first = run(&words);
    assert_eq!(named(&first, "enact.recording/1").len(), 2, "{first:?}");
    assert_eq!(named(&first, "enact.failure/1").len(), 1);
    let stamps = || {
        let names = ["die", "pencil_tip"];
        names.map(|name| {
            let path = folder.path().join(format!("done/{name}.estimate.mcap"));
            fs::metadata(path).expect("it").modified().expect("a time")
        })
    };
    let before = stamps();
    let again = run(&words);
    assert_eq!(named(&again, "enact.left_alone/1").len(), 2, "{again:?}");
    assert_eq!(before, stamps());
    // Of other options, or damaged, it is made anew.
    let options = [&words[..], &["--no-diagnose"]].concat();
    assert_eq!(named(&run(&options), "enact.recording/1").len(), 2);
    let path = folder.path().join("done/die.estimate.mcap");
    let bytes = fs::read(&path).expect("it");
    fs::write(&path, &bytes[..bytes.len() / 2]).expect("cut");
    let mended = run(&options);
    assert_eq!(named(&mended, "enact.recording/1").len(), 1, "{mended:?}");
    assert_eq!(fs::read(&path).expect("it"), bytes);
}

/// Estimates one recording with a deadline that ends it: the words of the deadline. How long that takes differs from run to run.
fn ended_early(folder: &TempDir, words: &[&str]) -> String {
    let begun = Instant::now();
    let whole = enact(folder.path(), words);
    assert!(matches!(whole.status.code(), Some(0 | 3)), "{whole:?}");
    let (mut low_s, mut high_s) = (0.0, begun.elapsed().as_secs_f64());
    for _ in 0..40 {
        let limit_s = 0.5 * (low_s + high_s);
        let limit = format!("{}us", (limit_s * 1e6) as u64 + 1);
        let lines = schemas(&enact(
            folder.path(),
            &[words, &["--deadline", &limit]].concat(),
        ));
        match named(&lines, "enact.recording/1").first() {
            None => low_s = limit_s,
            Some(line) if line["ended_early"] == true => return limit,
            Some(_) => high_s = limit_s,
        }
    }
    panic!("no deadline ends it");
}

#[test]
fn what_a_deadline_ended_is_made_again_where_there_is_more_time() {
    let folder = TempDir::new().expect("folder");
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/hat_box_bent.mcap");
    fs::copy(recording, folder.path().join("bent.mcap")).expect("copy");
    let words = ["process", "bent.mcap", "-o", "done", "--format", "ndjson"];
    let limit = ended_early(&folder, &words);
    let written = || fs::read(folder.path().join("done/bent.estimate.mcap")).expect("it");
    let ended = written();

    let again = |more: &[&str]| enact(folder.path(), &[&words[..], &["--resume"], more].concat());
    let kept = again(&["--deadline", &limit]);
    let lines = schemas(&kept);
    let left = named(&lines, "enact.left_alone/1");
    assert_eq!(left.len(), 1, "{lines:?}");
    assert_eq!(
        left[0]["why"],
        "its estimate is there, ended at its deadline"
    );
    assert_eq!(kept.status.code(), Some(3), "it is not whole");
    assert_eq!(written(), ended);

    for more in [&["--deadline", "1000s"][..], &[]] {
        let made = schemas(&again(more));
        let made = named(&made, "enact.recording/1");
        // The second is there already: nothing ended it.
        assert_eq!(made.len(), usize::from(!more.is_empty()), "{more:?}");
        assert!(made.iter().all(|line| line["ended_early"] == false));
        assert_ne!(written(), ended);
    }
}
