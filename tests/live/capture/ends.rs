//! How takes and daemons end when they are not asked to.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::peers;
use crate::harness::{Daemon, House};

const SCENE: &str = "config/pencil_tip.toml";

/// A daemon that is told to end does so within this on a busy machine, whatever is being estimated.
const SOON: Duration = Duration::from_secs(20);

/// What is left of a take that was not closed is not taken for a whole one.
pub fn is_said_to_be_cut_short(house: &House, recording: &Path) {
    let folder = house.folder().with_file_name("left");
    std::fs::create_dir_all(&folder).expect("folder");
    let take = folder.join("take-0001-20261121T171000Z.mcap");
    std::fs::copy(recording, &take).expect("copy");
    for arguments in [
        vec!["inspect", house.text(&take)],
        vec!["take", "list", house.text(&folder)],
    ] {
        let output = house.enact(&arguments);
        let said = String::from_utf8(output.stdout).expect("UTF-8");
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {said}");
        assert!(said.contains("the take was not closed"), "{said}");
    }
}

#[test]
fn a_take_that_is_closed_is_whole_and_one_of_a_killed_daemon_is_not() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--start"]);
    daemon.wait_for("started");
    house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    daemon.end();
    let whole = daemon.wait_for("closed");
    let output = house.enact(&["inspect", whole["recording"].as_str().expect("a path")]);
    assert_eq!(output.status.code(), Some(0));
    let mut daemon = Daemon::start(&house, SCENE, &["--start"]);
    daemon.wait_for("started");
    let sent = house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    daemon.wait_until_journalled(sent["poses"].as_u64().expect("a number"));
    daemon.kill();
    let parts = house.parts();
    assert_eq!(parts.len(), 1);
    let output = house.enact(&["recover", house.text(&parts[0])]);
    assert!(output.status.code().is_some_and(|code| code != 1));
    is_said_to_be_cut_short(&house, &parts[0].with_extension(""));
}

/// A terminal that is closed ends a capture as a word does, and may say so twice.
#[test]
fn a_hangup_closes_the_take() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--start"]);
    daemon.wait_for("started");
    house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    daemon.signal("HUP");
    daemon.signal("HUP");
    let closed = daemon.wait_for("closed");
    assert_eq!(
        daemon.wait_for("estimated")["report"]["verdict"],
        "physical"
    );
    daemon.signal("HUP");
    assert_eq!(daemon.finished(), Some(0));
    assert!(house.parts().is_empty());
    let recording = house.path(closed["recording"].as_str().expect("a path"));
    assert!(enact::ingest::Recording::open(&recording).is_ok());
}

#[test]
fn no_take_is_begun_on_a_full_disk() {
    const NAME: &str = "no_take_is_begun_on_a_full_disk";
    let house = House::new();
    let Some(mut daemon) = Daemon::start_on_small_disk(&house, SCENE, "512k", "") else {
        return peers::skip(NAME, "no file system may be mounted here");
    };
    // The disk is looked at twice a second.
    std::thread::sleep(Duration::from_millis(700));
    let (code, said, _) = house.take(&["start"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("the disk is full"), "{said}");
    let seen = std::fs::read_dir(daemon.seen(house.folder())).expect("list");
    assert_eq!(seen.count(), 0);
    daemon.end();
}

/// What takes minutes to be estimated is left to be estimated later, and that is said.
#[test]
fn a_daemon_that_is_told_to_end_does_not_wait_for_a_long_estimate() {
    let house = House::new();
    let scene = house.folder().with_file_name("many.toml");
    let mut text = "name = \"many\"\n[timing]\nstamps = \"tempo\"\n".to_owned();
    for body in 1..=64 {
        text += &format!(
            "[[body]]\nname = \"t{body}\"\nmass_g = 10\n\
             shape = {{ kind = \"cuboid\", size_mm = [10, 20, 30] }}\n"
        );
    }
    text += "[[event]]\nname = \"begin\"\nkind = \"start\"\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
    std::fs::write(&scene, text).expect("write");
    let mut daemon = Daemon::start(&house, house.text(&scene), &["--start"]);
    daemon.wait_for("started");
    house.tracker(&["--load", "64", "--rate-hz", "200", "--seconds", "2"]);
    let begun = Instant::now();
    daemon.terminate();
    let closed = daemon.wait_for("closed");
    let code = daemon.finished();
    let took = begun.elapsed();
    assert!(took < SOON, "{took:?}");
    let recording = house.path(closed["recording"].as_str().expect("a path"));
    assert!(enact::ingest::Recording::open(&recording).is_ok());
    // It may have been quick, on a quick machine; no file is left that is not whole.
    let files = std::fs::read_dir(house.folder()).expect("list").flatten();
    for file in files {
        let name = file.file_name().to_string_lossy().into_owned();
        assert!(name.ends_with(".mcap"), "{name}, exit code {code:?}");
    }
}

/// A pipe where a journal or a take is looked for is waited for by nobody.
#[test]
fn pipes_are_not_waited_for() {
    let house = House::new();
    let pipe = |path: &Path| {
        let made = Command::new("mkfifo").arg(path).status();
        assert!(made.expect("mkfifo").success());
    };
    let journal = house.folder().join("x.mcap.part");
    pipe(&journal);
    pipe(&house.folder().join("take-0007-20261121T171000Z.mcap"));
    // Each of them ends, which a patient test finds out.
    for (arguments, expected) in [
        (vec!["recover", house.text(house.folder())], Some(0)),
        (vec!["recover", house.text(&journal)], Some(1)),
        (vec!["take", "list", house.text(house.folder())], Some(3)),
        (vec!["inspect", house.text(&journal)], Some(1)),
        (
            vec!["replay", house.text(&journal), "-o", "none.mcap"],
            Some(1),
        ),
        (vec!["scene", "check", house.text(&journal)], Some(1)),
        (
            vec!["import", house.text(&journal), "-o", "none.mcap"],
            Some(1),
        ),
        (vec!["mark", house.text(&journal)], Some(1)),
    ] {
        let output = house.enact(&arguments);
        assert_eq!(output.status.code(), expected, "{arguments:?}");
    }
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    assert_eq!(house.take(&["start"]).0, Some(0));
    assert_eq!(house.take(&["discard"]).0, Some(0));
    daemon.end();
}
