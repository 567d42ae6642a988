//! The daemon knows its trackers, its number and its like, and says so.

use std::time::Duration;

use enact::ingest::live::{Command, Node, PoseRecord};
use enact::wire::live::MarkRecord;
use enact::write::TrackerPublisher;

use super::{events, raw_messages, raw_sequences};
use crate::harness::{Daemon, House, Patience, bytes, kill};

const SCENE: &str = "config/pencil_tip.toml";
const RECORDING: &str = "recordings/pencil_tip.mcap";

/// A scene file made of the pencil's.
fn scene(house: &House, change: impl Fn(String) -> String) -> String {
    let path = house.folder().with_file_name("scene.toml");
    let text = std::fs::read_to_string(SCENE).expect("scene");
    std::fs::write(&path, change(text)).expect("write");
    house.text(&path).to_owned()
}

fn pose(sequence: u64, flags: u32) -> PoseRecord {
    PoseRecord {
        sequence,
        available_ns: 1,
        sample_ns: 1_700_000_000_000_000_000 + (sequence % (1 << 20)) as i64 * 1_000_000,
        device_ns: 0,
        position_m: [(sequence % 1000) as f64 * 1e-3, 0.0, 0.0],
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        flags,
        session: 5,
    }
}

#[test]
fn a_tracker_that_dies_in_a_take_is_said_everywhere() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let (code, said, warned) = house.take(&["start"]);
    assert_eq!((code, said.as_str()), (Some(0), "take 1 begins\n"));
    assert!(
        warned.contains("nothing comes on /tracker/pencil/pose"),
        "{warned}"
    );
    assert_eq!(
        daemon.wait_for("started")["unheard"][0],
        "/tracker/pencil/pose"
    );
    let load = ["--load", "1", "--names", "pencil", "--rate-hz", "250"];
    let tracker = house.spawn_tracker(&[&load[..], &["--seconds", "60"]].concat());
    assert_eq!(daemon.wait_for("heard")["take"], 1);
    // Long enough that there is a rate.
    let patience = Patience::new();
    loop {
        patience.check("a rate");
        let (code, said, _) = house.take(&["status"]);
        assert_eq!(code, Some(0), "{said}");
        let line = said
            .lines()
            .find(|line| line.contains("/tracker/pencil/pose"));
        let line = line.unwrap_or_else(|| panic!("{said}"));
        let words: Vec<&str> = line.split_whitespace().collect();
        let rate_hz: f64 = words[2].parse().expect("a rate");
        if words[1] == "sending" && (150.0..300.0).contains(&rate_hz) {
            assert_eq!(words[4], "100", "{line}");
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    kill(tracker);
    let silent = daemon.wait_for("silent");
    assert_eq!(
        (&silent["take"], &silent["topic"]),
        (&1.into(), &"/tracker/pencil/pose".into())
    );
    assert!(silent["seen_s"].as_f64() < Some(2.0), "{silent}");
    let (code, said, _) = house.take(&["status"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("silent"), "{said}");
    house.take(&["discard"]);
    // With a tracker that sends nobody is warned.
    let tracker = house.spawn_tracker(&[&load[..], &["--seconds", "60"]].concat());
    daemon.wait_for("heard");
    let (_, _, warned) = house.take(&["start"]);
    assert!(!warned.contains("nothing comes"), "{warned}");
    kill(tracker);
    daemon.end();
}

#[test]
fn the_share_of_valid_samples_is_known_without_a_take() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let node = Node::join("tracker", Some(house.iceoryx2())).expect("node");
    let topics = ["/tracker/pencil/pose".to_owned()];
    let tracker = TrackerPublisher::open(&node, &topics, "/marks").expect("publisher");
    // The share is that of the last second.
    let patience = Patience::new();
    let mut sequences = 0_u64..;
    loop {
        patience.check("a share");
        for sequence in sequences.by_ref().take(40) {
            let flags = u32::from(sequence % 4 > 0);
            tracker.pose(0, pose(sequence, flags)).expect("send");
        }
        let (_, said, _) = house.take(&["status"]);
        if said.contains(" 75 %") {
            break;
        }
    }
    daemon.end();
}

/// A machine that stands still while a take is asked for: what the buffers could not hold is said to be
/// missing in the take, though all that is lost came before its first sample.
#[test]
fn a_hole_across_the_start_of_a_take_is_counted() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let node = Node::join("tracker", Some(house.iceoryx2())).expect("node");
    let topics = ["/tracker/pencil/pose".to_owned()];
    let tracker = TrackerPublisher::open(&node, &topics, "/marks").expect("publisher");
    let send = |sequences: std::ops::Range<u64>| {
        for sequence in sequences {
            tracker.pose(0, pose(sequence, 1)).expect("send");
        }
    };
    send(0..100);
    // What was sent before a question has come when it is answered.
    assert_eq!(house.take(&["status"]).0, Some(0));
    daemon.stop();
    send(100..5000);
    tracker
        .control(Command::Start, 7, 1, 0, house.token())
        .expect("send");
    daemon.signal("CONT");
    daemon.wait_for("started");
    send(5000..5100);
    let (code, said, _) = house.take(&["status"]);
    let is_said = said.contains("trouble: 2852 samples are missing in take 1\n");
    assert!(code == Some(3) && is_said, "{said}");
    tracker
        .control(Command::Stop, 7, 2, 0, house.token())
        .expect("send");
    let closed = daemon.wait_for("closed");
    let counts = &closed["counts"]["trackers"][0]["counts"];
    let [received, missing, overflows] =
        ["received", "missing", "overflows"].map(|name| counts[name].as_u64());
    assert_eq!(
        (received, overflows),
        (Some(2048 + 100), Some(1)),
        "{counts}"
    );
    assert_eq!(missing, Some(5000 - 100 - 2048), "{counts}");
    daemon.end_with(3);
}

#[test]
fn a_second_daemon_refuses_and_names_the_first() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let said = house.daemon_fails("config/die.toml");
    let process = format!("process {}", daemon.id());
    assert!(
        said.contains(&process) && said.contains("pencil_tip.toml"),
        "{said}"
    );
    // The first goes on, and alone.
    let (code, said, _) = house.take(&["start"]);
    assert_eq!((code, said.as_str()), (Some(0), "take 1 begins\n"));
    assert_eq!(house.parts().len(), 1);
    // One that is killed leaves no lock.
    daemon.kill();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    daemon.end();
}

#[test]
fn a_take_refuses_what_cannot_work_and_says_what_became_of_it() {
    let house = House::new();
    let (code, _, error) = house.take(&["status"]);
    assert_eq!(code, Some(1));
    assert!(error.contains("no daemon runs"), "{error}");
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    for (arguments, why) in [
        (&["mark"][..], "no take runs"),
        (&["stop"], "no take runs"),
        (&["discard"], "no take runs"),
    ] {
        let (code, said, _) = house.take(arguments);
        assert_eq!((code, said), (Some(1), format!("refused: {why}\n")));
    }
    for arguments in [
        &["stop", "--rating", "6"][..],
        &["stop", "--name", ""],
        &["start", "--wait"],
    ] {
        assert_eq!(house.take(arguments).0, Some(2), "{arguments:?}");
    }
    house.take(&["start"]);
    let (code, said, _) = house.take(&["start"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("take 1 runs"), "{said}");
    let (code, said, _) = house.take(&["mark", "--event", "bonce"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("bounce, landing"), "{said}");
    house.tracker(&[RECORDING, "--rate", "0"]);
    let label = ["--name", "Wurf ü", "--note", "a bit slow", "--rating", "4"];
    let (code, said, _) = house.take(&[&["stop", "--wait"], &label[..]].concat());
    assert_eq!(code, Some(0), "{said}");
    let estimate = said
        .lines()
        .last()
        .and_then(|line| line.trim().strip_prefix("written "));
    let estimate = house.path(estimate.unwrap_or_else(|| panic!("{said}")));
    assert!(said.contains("take 1: physical"), "{said}");
    let closed = daemon.wait_for("closed");
    assert_eq!(closed["label"]["rating"], 4);
    let take = house.path(closed["recording"].as_str().expect("path"));
    assert_eq!(estimate, take.with_extension("estimate.mcap"));
    let name = take
        .file_name()
        .expect("name")
        .to_string_lossy()
        .into_owned();
    assert!(name.starts_with("take-0001-"), "{name}");
    // It was said of the take, and it is in both files.
    for path in [&take, &estimate] {
        let recording = enact::ingest::Recording::open(path).expect("open");
        let metadata = recording.container().metadata();
        let of_take = metadata
            .iter()
            .find(|of| of.name == "take")
            .expect("metadata");
        let pairs: Vec<(&str, &str)> = of_take
            .pairs
            .iter()
            .map(|(k, v)| (k.as_str(), v.as_str()))
            .collect();
        let expected = [
            ("name", "Wurf ü"),
            ("note", "a bit slow"),
            ("number", "1"),
            ("rating", "4"),
        ];
        assert_eq!(pairs, expected);
    }
    let (code, said, _) = house.take(&["list", house.text(house.folder())]);
    let words: Vec<&str> = said
        .lines()
        .nth(1)
        .expect("a take")
        .split_whitespace()
        .collect();
    let expected = ["1", "Wurf", "ü", "4", "of", "5"];
    assert_eq!((code, &words[..6]), (Some(0), &expected[..]), "{said}");
    assert!(
        said.contains("physical") && said.contains("a bit slow"),
        "{said}"
    );
    // The ends of files say it all; a file without its end is read whole.
    let listed = || {
        let folder = house.text(house.folder());
        let (code, said, _) = house.take(&["list", folder, "--format", "ndjson"]);
        let line = said.lines().next().expect("a take");
        (
            code,
            serde_json::from_str::<serde_json::Value>(line).expect("json"),
        )
    };
    let whole = listed();
    assert_eq!(whole.0, Some(0));
    assert_eq!(whole.1["verdict"], "physical");
    assert_eq!(whole.1["is_good"], true);
    let recording = enact::ingest::Recording::open(&take).expect("open");
    let messages = recording.container().message_count();
    assert_eq!(whole.1["messages"].as_u64(), Some(messages));
    let bytes = std::fs::read(&take).expect("read");
    let mut damaged = bytes.clone();
    let chunk = bytes.len() / 4..bytes.len() / 2;
    damaged[chunk].fill(0x55);
    std::fs::write(&take, &damaged).expect("write");
    assert_eq!(listed(), whole, "the middle of the take is read");
    std::fs::write(&take, &bytes[..bytes.len() - 9]).expect("write");
    assert_eq!(listed(), whole, "a take without its end is not listed");
    std::fs::write(&take, b"nothing").expect("write");
    let (code, broken) = listed();
    assert_eq!((code, broken["error"].is_string()), (Some(3), true));
    assert_eq!(broken["verdict"], "physical");
    std::fs::write(&take, &bytes).expect("write");
    // Of nothing there is no estimate.
    house.take(&["start"]);
    let (code, said, _) = house.take(&["stop", "--wait"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("take 2: not estimated"), "{said}");
    daemon.end();
    // Numbers go on.
    let mut daemon = Daemon::start(&house, SCENE, &["--start"]);
    assert_eq!(daemon.wait_for("started")["take"], 3);
    daemon.end();
}

#[test]
fn a_take_begins_before_its_start_where_the_scene_says_so() {
    let house = House::new();
    let scene = scene(&house, |text| {
        format!("{text}\n[capture]\npre_roll_s = 20\n")
    });
    let mut daemon = Daemon::start(&house, &scene, &[]);
    let sent = house.tracker(&[RECORDING, "--rate", "0"]);
    let (code, ..) = house.take(&["start"]);
    assert_eq!(code, Some(0));
    let all = sent["poses"].as_u64().expect("number") + sent["marks"].as_u64().expect("number");
    assert_eq!(daemon.wait_for("started")["before"].as_u64(), Some(all));
    let (code, said, _) = house.take(&["stop", "--wait"]);
    assert_eq!(code, Some(0), "{said}");
    let closed = daemon.wait_for("closed");
    let take = house.path(closed["recording"].as_str().expect("path"));
    assert_eq!(events(&take), events(std::path::Path::new(RECORDING)));
    let recording = enact::ingest::Recording::open(&take).expect("open");
    assert!(recording.container().is_sorted());
    // What was kept is used once, and did not wait for the journal.
    assert!(
        closed["counts"]["latency_ms"]["max"].as_f64() < Some(1000.0),
        "{closed}"
    );
    house.take(&["start"]);
    assert_eq!(daemon.wait_for("started")["before"], 0);
    daemon.end();
}

#[test]
fn a_bogus_sequence_number_makes_nothing_missing() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--start"]);
    daemon.wait_for("started");
    let node = Node::join("tracker", Some(house.iceoryx2())).expect("node");
    let topics = ["/tracker/pencil/pose".to_owned()];
    let tracker = TrackerPublisher::open(&node, &topics, "/marks").expect("publisher");
    let numbers: Vec<u64> = (0..20).chain([u64::MAX - 7]).chain(20..40).collect();
    for sequence in &numbers {
        tracker.pose(0, pose(*sequence, 1)).expect("send");
    }
    tracker
        .control(Command::Stop, 7, 1, 0, house.token())
        .expect("send");
    let closed = daemon.wait_for("closed");
    let counts = &closed["counts"]["trackers"][0]["counts"];
    for (what, expected) in [("received", 41), ("missing", 0), ("late", 0), ("leaps", 1)] {
        assert_eq!(counts[what].as_u64(), Some(expected), "{what}: {counts}");
    }
    let take = house.path(closed["recording"].as_str().expect("path"));
    let kept: Vec<u64> = raw_sequences(&take)
        .into_iter()
        .map(|(number, _)| number)
        .collect();
    assert_eq!(kept, numbers);
    daemon.end();
}

#[test]
fn names_of_any_script_work_and_those_that_a_terminal_obeys_are_shown() {
    let house = House::new();
    let scene = scene(&house, |text| text.replace("\"pencil\"", "\"Stift ü €\""));
    let mut daemon = Daemon::start(&house, &scene, &["--start"]);
    assert_eq!(daemon.ready["topics"][0], "/tracker/Stift ü €/pose");
    daemon.wait_for("started");
    let node = Node::join("tracker", Some(house.iceoryx2())).expect("node");
    let topics = ["/tracker/Stift ü €/pose".to_owned()];
    let tracker = TrackerPublisher::open(&node, &topics, "/marks").expect("publisher");
    for sequence in 0..30 {
        tracker.pose(0, pose(sequence, 1)).expect("send");
    }
    let odd = "\u{1b}[2Jx\nerror: \u{202e}y";
    let mark = MarkRecord {
        sequence: 0,
        available_ns: 1,
        sample_ns: 1_700_000_000_000_000_000,
        device_ns: 0,
        event: MarkRecord::event_bytes(odd),
        flags: 0,
        session: 5,
    };
    tracker.mark(mark).expect("send");
    let (code, said, _) = house.take(&["stop", "--name", odd]);
    assert_eq!(code, Some(0), "{said}");
    let closed = daemon.wait_for("closed");
    daemon.end();
    let take = house.path(closed["recording"].as_str().expect("path"));
    assert_eq!(raw_messages(&take), 31);
    let inspected = house.enact(&["inspect", house.text(&take)]);
    let replayed = house.enact(&["replay", house.text(&take)]);
    for (what, output) in [("inspect", &inspected), ("replay", &replayed)] {
        let all = [&output.stdout[..], &output.stderr[..]].concat();
        let said = String::from_utf8(all).expect("UTF-8");
        assert!(!said.contains(['\u{1b}', '\u{202e}']), "{what}: {said:?}");
        assert!(
            !said.lines().any(|line| line.starts_with("error: \\u")),
            "{what}: {said:?}"
        );
    }
    let said = String::from_utf8_lossy(&inspected.stdout);
    assert!(
        said.contains("Stift ü €") && said.contains("\\u{1b}[2Jx"),
        "{said}"
    );
    assert!(!bytes(&take).is_empty());
}

#[test]
fn a_stdout_that_nobody_reads_holds_up_neither_takes_nor_the_end() {
    let house = House::new();
    let mut daemon = Daemon::start_unread(&house, SCENE);
    let node = Node::join("director", Some(house.iceoryx2())).expect("node");
    let director = TrackerPublisher::open(&node, &[], "/marks").expect("publisher");
    let patience = Patience::new();
    while director
        .control(Command::Start, 7, 0, 0, house.token())
        .expect("send")
        == 0
    {
        patience.check("the daemon listens");
        std::thread::sleep(Duration::from_millis(10));
    }
    // More than a pipe holds.
    for sequence in 1..1500 {
        director
            .control(Command::Ask, 7, sequence, 0, house.token())
            .expect("send");
        if sequence % 100 == 0 {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    house.tracker(&[RECORDING, "--rate", "0"]);
    let begun = std::time::Instant::now();
    daemon.terminate();
    let code = daemon.finished();
    // What was said is lost, and nothing else.
    assert_eq!(code, Some(3));
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(20), "{took:?}");
    assert!(house.parts().is_empty());
    let takes = house.recordings();
    assert_eq!(takes.len(), 2, "{takes:?}");
}
