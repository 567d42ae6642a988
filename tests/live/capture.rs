//! The live daemon from outside: real publishers in other processes, a real daemon, real files.
//!
//! Every test has an iceoryx2 of its own. Nothing is waited for by sleeping where the daemon
//! says that it has happened.

use std::path::Path;
use std::time::Duration;

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::ingest::live::{Command, Node, Quality, TakeListener, TakeState};
use enact::motion::{Scene, TakeEvent};
use enact::wire::live::{
    ControlRecord, EstimateRecord, EstimatedPoseRecord, MarkRecord, PoseRecord, TakeRecord,
};
use enact::write::TrackerPublisher;

mod ends;
mod kills;
mod peers;
mod stamping;
mod state;
mod told;

use crate::harness::{Daemon, House, Patience, bytes, enact, ended};

fn scene_of(recording: &Recording) -> Scene {
    let toml = recording.scene_toml().expect("scene attached");
    scene_from_toml(std::str::from_utf8(toml).expect("UTF-8")).expect("valid scene")
}

/// Samples and marks, whatever order those of different streams came in.
fn events(path: &Path) -> Vec<String> {
    let recording = Recording::open(path).expect("open");
    let scene = scene_of(&recording);
    let events = recording.take(&scene).expect("take").events;
    let mut lines: Vec<String> = events.iter().map(|event| format!("{event:?}")).collect();
    lines.sort();
    lines
}

fn raw_messages(path: &Path) -> u64 {
    let recording = Recording::open(path).expect("open");
    let channels = recording.container().channels().values();
    let is_raw = |topic: &str| topic.starts_with("/capture/") && topic != "/capture/counts";
    channels
        .filter(|c| is_raw(&c.topic))
        .map(|c| c.messages)
        .sum()
}

/// Sequence number and publisher's time [ns] of all samples of the pencil's tracker.
fn raw_sequences(path: &Path) -> Vec<(u64, i64)> {
    let recording = Recording::open(path).expect("open");
    let container = recording.container();
    let mut walk = container.walk();
    let mut found = Vec::new();
    while let Some(message) = walk.next_message() {
        let topic = &container.channels()[&message.channel_id].topic;
        if topic == "/capture/tracker/pencil/pose" {
            let sequence = message.data[4..12].try_into().expect("eight bytes");
            found.push((u64::from_le_bytes(sequence), message.publish_time as i64));
        }
    }
    found
}

#[test]
fn live_replayed_and_offline_give_the_same_bytes() {
    for (recording, scene) in [
        ("recordings/pencil_tip.mcap", "config/pencil_tip.toml"),
        ("recordings/hat_box.mcap", "config/hat_box.toml"),
        ("recordings/die.mcap", "config/die.toml"),
    ] {
        let house = House::new();
        let mut daemon = Daemon::start(&house, scene, &[]);
        house.tracker(&[recording, "--take", "--rate", "0"]);
        let closed = daemon.wait_for("closed");
        let take = house.path(closed["recording"].as_str().expect("path"));
        let estimated = daemon.wait_for("estimated");
        daemon.end();
        // What was sent is what is in the file, bit for bit.
        assert_eq!(events(&take), events(Path::new(recording)), "{recording}");
        let journal = Recording::open(&take).expect("open");
        let container = journal.container();
        assert_eq!(
            (container.damages().count(), container.is_sorted()),
            (0, true)
        );
        let live = take.with_extension("estimate.mcap");
        assert_eq!(estimated["report"]["output"], live.to_str().expect("UTF-8"));
        let replayed = house.folder().join("replayed.mcap");
        enact(&["replay", house.text(&take), "-o", house.text(&replayed)]);
        let offline = house.folder().join("offline");
        enact(&["process", house.text(&take), "-o", house.text(&offline)]);
        let offline = offline.join(live.file_name().expect("name"));
        assert!(
            bytes(&live) == bytes(&replayed),
            "{recording}: live, replayed"
        );
        assert!(
            bytes(&live) == bytes(&offline),
            "{recording}: live, offline"
        );
        // And the recording that was sent has the same estimate.
        let output = house.folder().join("original.mcap");
        let original = enact(&[
            "replay",
            recording,
            "-o",
            house.text(&output),
            "--format",
            "ndjson",
        ]);
        let original: serde_json::Value = serde_json::from_str(&original).expect("json");
        for key in ["verdict", "objective", "events", "segments", "iterations"] {
            assert_eq!(
                estimated["report"][key], original[key],
                "{recording}: {key}"
            );
        }
    }
}

#[test]
fn estimates_come_out_after_every_mark_and_at_the_end() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let node = Node::join("test", Some(house.iceoryx2())).expect("node");
    let estimates = node.service::<EstimateRecord>("enact/estimate", Quality::NOTES);
    let estimates = estimates.expect("service");
    let frames = "enact/estimate/pencil/pose";
    let frames = node
        .service::<EstimatedPoseRecord>(frames, Quality::FRAMES)
        .expect("service");
    let takes = node
        .service::<TakeRecord>("enact/take", Quality::NOTES)
        .expect("service");
    assert!(estimates.shortcomings.is_empty() && frames.shortcomings.is_empty());
    let estimates = estimates
        .factory
        .subscriber_builder()
        .create()
        .expect("port");
    let frames = frames.factory.subscriber_builder().create().expect("port");
    let takes = takes.factory.subscriber_builder().create().expect("port");
    // So slow that the estimate after a mark is there before the next: a take that is over has its final one.
    house.tracker(&[
        "recordings/pencil_tip.mcap",
        "--take",
        "--rate",
        "2",
        "--now",
    ]);
    for marks in 1..=2 {
        let so_far = daemon.wait_for("so_far");
        assert_eq!(
            (so_far["marks"].as_u64(), so_far["take"].as_u64()),
            (Some(marks), Some(1))
        );
        assert_eq!(so_far["verdict"], "physical");
    }
    daemon.wait_for("estimated");
    let mut records = Vec::new();
    while let Some(sample) = estimates.receive().expect("receive") {
        records.push(*sample);
    }
    let mut motion = Vec::new();
    while let Some(sample) = frames.receive().expect("receive") {
        motion.push(*sample);
    }
    let last = records.last().expect("an estimate");
    assert_eq!(
        (last.take, last.marks, last.verdict, last.is_final),
        (1, 2, 2, 1)
    );
    assert!(
        records[..records.len() - 1]
            .iter()
            .all(|record| record.is_final == 0)
    );
    let of_last = motion
        .iter()
        .filter(|frame| frame.estimate == last.sequence);
    let indices: Vec<u64> = of_last.map(|frame| frame.index).collect();
    assert_eq!(indices, (0..last.frames).collect::<Vec<_>>());
    assert!(last.frames > 50, "{} frames", last.frames);
    let mut states = Vec::new();
    while let Some(sample) = takes.receive().expect("receive") {
        states.push(sample.state);
    }
    // A command that is repeated before its answer comes is answered twice.
    states.dedup();
    // A tracker asks before it starts a take.
    let expected = [
        TakeState::Ready,
        TakeState::Recording,
        TakeState::Closed,
        TakeState::Estimated,
    ];
    assert_eq!(states, expected.map(TakeState::number));
    daemon.end();
}

#[test]
fn a_recording_that_is_published_looks_like_a_live_take() {
    let house = House::new();
    let node = Node::join("consumer", Some(house.iceoryx2())).expect("node");
    let pose = "enact/tracker/pencil/pose";
    let poses = node
        .service::<PoseRecord>(pose, Quality::POSES)
        .expect("service");
    let estimates = node.service::<EstimateRecord>("enact/estimate", Quality::NOTES);
    let poses = poses.factory.subscriber_builder().create().expect("port");
    let estimates = estimates
        .expect("service")
        .factory
        .subscriber_builder()
        .create();
    let estimates = estimates.expect("port");
    let recording = "recordings/pencil_tip.mcap";
    let output = house.folder().join("published.mcap");
    let arguments = [
        "replay",
        recording,
        "-o",
        house.text(&output),
        "--rate",
        "4",
        "--publish",
    ];
    let replay = house.spawn_enact(&arguments);
    // As a consumer does: until the estimate is there.
    let (mut sent, mut estimate) = (Vec::new(), None);
    let patience = Patience::new();
    while estimate.is_none() {
        patience.check("an estimate");
        while let Some(sample) = poses.receive().expect("receive") {
            sent.push(*sample);
        }
        estimate = estimates.receive().expect("receive").map(|sample| *sample);
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(ended(replay).status.code(), Some(0));
    let estimate = estimate.expect("an estimate");
    assert_eq!(
        (estimate.verdict, estimate.is_final, estimate.marks),
        (2, 1, 2)
    );
    assert!(
        sent.iter()
            .enumerate()
            .all(|(k, pose)| pose.sequence == k as u64)
    );
    // The file is what it is without publishing.
    let plain = house.folder().join("plain.mcap");
    enact(&["replay", recording, "-o", house.text(&plain)]);
    assert!(bytes(&plain) == bytes(&output));
    assert_eq!(sent.len(), 269);
}

#[test]
fn faults_are_counted_and_every_sample_that_came_is_kept() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let sent = house.tracker(&[
        "recordings/pencil_tip.mcap",
        "--take",
        "--rate",
        "0",
        "--drop",
        "10..14",
        "--drop",
        "20..21",
        "--double",
        "30..33",
        "--invalid",
        "40..46",
        "--garbage",
        "50..52",
        "--freeze",
        "60..67",
        "--swap",
        "80..82",
        "--restart",
        "200",
    ]);
    let closed = daemon.wait_for("closed");
    let take = house.path(closed["recording"].as_str().expect("path"));
    let counts = &closed["counts"]["trackers"][0]["counts"];
    for (what, expected) in [
        ("received", sent["poses"].as_u64().expect("number")),
        ("gaps", 3),
        ("missing", 5),
        ("duplicated", 3),
        ("invalid", 6),
        ("malformed", 2),
        // The second garbage is the first again, bit for bit.
        ("frozen", 8),
        ("late", 1),
        ("restarts", 1),
    ] {
        assert_eq!(counts[what].as_u64(), Some(expected), "{what}: {counts}");
    }
    daemon.wait_for("estimated");
    daemon.end_with(3);
    let all = sent["poses"].as_u64().expect("number") + sent["marks"].as_u64().expect("number");
    assert_eq!(raw_messages(&take), all);
    assert_eq!(closed["messages"].as_u64(), Some(all));
    // Doubles and invalid ones are in the raw stream alone.
    let recording = Recording::open(&take).expect("open");
    let taken = recording.take(&scene_of(&recording)).expect("take").events;
    let is_pose = |event: &&TakeEvent| matches!(event, TakeEvent::Pose { .. });
    assert_eq!(
        taken.iter().filter(is_pose).count() as u64 + 3 + 6,
        sent["poses"]
    );
}

#[test]
fn a_clock_that_is_set_in_the_middle_of_a_take_is_survived() {
    for source in [&[][..], &["--no-sample-time"]] {
        let house = House::new();
        let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
        // At an hour back and in real time: arrivals bridge the step.
        let step = [
            "recordings/pencil_tip.mcap",
            "--take",
            "--now",
            "--step",
            "100",
        ];
        house.tracker(&[&step, source].concat());
        let closed = daemon.wait_for("closed");
        let clock = &closed["counts"]["trackers"][0]["clock"];
        assert_eq!(clock["steps"].as_u64(), Some(1), "{clock}");
        let estimated = daemon.wait_for("estimated");
        assert_eq!(estimated["report"]["verdict"], "physical", "{source:?}");
        daemon.end();
    }
}

#[test]
fn a_killed_tracker_and_its_successor_do_not_disturb_a_take() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &["--start"]);
    daemon.wait_for("started");
    let recording = "recordings/pencil_tip.mcap";
    house.tracker_that_dies(&[recording, "--rate", "20", "--kill", "100"]);
    let sent = house.tracker(&[recording, "--rate", "20"]);
    daemon.terminate();
    let closed = daemon.wait_for("closed");
    let counts = &closed["counts"]["trackers"][0]["counts"];
    assert_eq!(counts["restarts"].as_u64(), Some(1), "{counts}");
    let received = sent["poses"].as_u64().expect("number") + 100;
    assert_eq!(counts["received"].as_u64(), Some(received), "{counts}");
    assert_eq!(counts["missing"].as_u64(), Some(0), "{counts}");
    daemon.finished();
}

#[test]
fn a_signal_closes_the_take_and_waits_for_its_estimate() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &["--start"]);
    daemon.wait_for("started");
    let sent = house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    daemon.terminate();
    let closed = daemon.wait_for("closed");
    assert_eq!(
        closed["counts"]["trackers"][0]["counts"]["received"],
        sent["poses"]
    );
    let estimated = daemon.wait_for("estimated");
    assert_eq!(estimated["report"]["verdict"], "physical");
    assert_eq!(daemon.finished(), Some(0));
    assert!(house.parts().is_empty());
}

#[test]
fn takes_follow_one_another_and_can_be_thrown_away() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let node = Node::join("director", Some(house.iceoryx2())).expect("node");
    let director = TrackerPublisher::open(&node, &[], "/marks").expect("publisher");
    let token = house.token();
    let say = |command: u32, sequence: u64| {
        let command = Command::of(command).expect("command");
        assert_eq!(
            director
                .control(command, 7, sequence, 0, token)
                .expect("send"),
            1
        );
    };
    say(2, 0);
    assert_eq!(daemon.wait_for("refused")["reason"], "no take runs");
    say(1, 1);
    daemon.wait_for("started");
    say(3, 2);
    daemon.wait_for("discarded");
    // A start while one runs ends that one.
    for take in 2..5 {
        say(1, take);
        let started = daemon.wait_for("started");
        assert_eq!(started["take"].as_u64(), Some(take));
        house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    }
    say(2, 9);
    for take in 2..5 {
        let estimated = daemon.wait_for("estimated");
        assert_eq!(estimated["take"].as_u64(), Some(take));
        assert_eq!(estimated["report"]["verdict"], "physical");
    }
    daemon.end();
    assert_eq!(house.recordings().len(), 6);
}

#[test]
fn a_command_that_comes_again_is_answered_again_and_obeyed_once() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let node = Node::join("director", Some(house.iceoryx2())).expect("node");
    let answers = TakeListener::open(&node).expect("answers");
    let director = TrackerPublisher::open(&node, &[], "/marks").expect("publisher");
    let token = house.token();
    let answer = |command: Command, sequence: u64| {
        assert_eq!(
            director
                .control(command, 7, sequence, 5, token)
                .expect("send"),
            1
        );
        let patience = Patience::new();
        loop {
            patience.check("an answer");
            let heard = answers.next().expect("answers");
            let Some(heard) = heard else {
                std::thread::sleep(Duration::from_millis(1));
                continue;
            };
            if (heard.control_session, heard.control_sequence) == (7, sequence) {
                return (heard.take, TakeState::of(heard.state));
            }
        }
    };
    for _ in 0..3 {
        assert_eq!(answer(Command::Start, 1), (1, Some(TakeState::Recording)));
    }
    for _ in 0..2 {
        assert_eq!(answer(Command::Discard, 2), (1, Some(TakeState::Discarded)));
    }
    // Late, as a tunnel may deliver it: the take is over, and none begins.
    assert_eq!(answer(Command::Start, 1), (1, Some(TakeState::Recording)));
    assert_eq!(answer(Command::Ask, 3), (0, Some(TakeState::Ready)));
    daemon.wait_for("asked");
    assert_eq!(daemon.kept("started"), 1);
    assert_eq!(daemon.kept("discarded"), 1);
    daemon.end();
}

#[test]
fn a_take_is_directed_from_the_command_line() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let take = |arguments: &[&str], expected: i32| {
        let output = house.enact_with_iceoryx2(&[&["take"], arguments].concat());
        let said = String::from_utf8(output.stdout).expect("UTF-8");
        assert_eq!(
            output.status.code(),
            Some(expected),
            "{arguments:?}: {said}"
        );
        said
    };
    assert!(take(&["status"], 0).starts_with("no take runs\n"));
    assert_eq!(take(&["stop"], 1), "refused: no take runs\n");
    assert_eq!(take(&["start"], 0), "take 1 begins\n");
    let sent = house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    let all = sent["poses"].as_u64().expect("number") + 2;
    assert_eq!(
        take(&["mark"], 0),
        format!("take 1: {} samples and marks\n", all + 1)
    );
    take(&["mark", "--event", "landing"], 0);
    let over = format!("take 1 is over: {} samples and marks\n", all + 2);
    assert!(take(&["stop"], 0).starts_with(&over));
    let closed = daemon.wait_for("closed");
    daemon.end();
    let taken = events(&house.path(closed["recording"].as_str().expect("path")));
    let marks = taken.iter().filter(|event| event.starts_with("Mark"));
    let named = taken
        .iter()
        .filter(|event| event.contains("Some(\"landing\")"));
    assert_eq!((marks.count(), named.count()), (4, 1));
    // Without a daemon there is no answer.
    assert_eq!(take(&["status"], 1), "");
}

#[test]
fn peers_with_another_payload_are_refused_and_lesser_services_complained_of() {
    let house = House::new();
    let node = Node::join("peer", Some(house.iceoryx2())).expect("node");
    let topic = "enact/tracker/pencil/pose";
    {
        let _theirs = node
            .service::<TakeRecord>(topic, Quality::NOTES)
            .expect("service");
        let said = house.daemon_fails("config/pencil_tip.toml");
        assert!(
            said.contains(topic) && said.contains("IncompatibleTypes"),
            "{said}"
        );
    }
    {
        let small = Quality {
            buffer: 2,
            ..Quality::POSES
        };
        let _theirs = node.service::<PoseRecord>(topic, small).expect("service");
        let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
        let shortcoming = daemon.ready["shortcomings"][0].as_str().expect("text");
        assert!(
            shortcoming.contains("buffer of a subscriber: 2, wanted 2048"),
            "{shortcoming}"
        );
        daemon.end();
    }
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    assert_eq!(
        daemon.ready["shortcomings"].as_array().map(Vec::len),
        Some(0)
    );
    assert!(node.service::<TakeRecord>(topic, Quality::NOTES).is_err());
    daemon.end();
}

#[test]
fn garbage_on_every_service_is_refused_and_counted() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &["--start"]);
    daemon.wait_for("started");
    let node = Node::join("vandal", Some(house.iceoryx2())).expect("node");
    let topics = ["/tracker/pencil/pose".to_owned()];
    let vandal = TrackerPublisher::open(&node, &topics, "/marks").expect("publisher");
    let control = node.service::<ControlRecord>("enact/control", Quality::NOTES);
    let control = control
        .expect("service")
        .factory
        .publisher_builder()
        .create();
    let control = control.expect("port");
    let extremes = [i64::MIN, i64::MIN + 1, -1, 0, 1, i64::MAX];
    let numbers = [
        f64::NAN,
        f64::INFINITY,
        -f64::MAX,
        f64::MIN_POSITIVE,
        0.0,
        1.0,
    ];
    for k in 0..600_usize {
        let pose = PoseRecord {
            sequence: extremes[k % 6] as u64,
            available_ns: extremes[k / 6 % 6],
            sample_ns: extremes[k / 36 % 6],
            device_ns: extremes[k / 7 % 6],
            position_m: [numbers[k % 6], numbers[k / 6 % 6], numbers[k / 36 % 6]],
            quaternion_xyzw: [numbers[k / 5 % 6]; 4],
            flags: k as u32,
            session: (k / 100) as u32,
        };
        vandal.pose(0, pose).expect("send");
        if k % 10 == 0 {
            vandal
                .mark(MarkRecord {
                    sequence: pose.sequence,
                    available_ns: pose.available_ns,
                    sample_ns: pose.sample_ns,
                    device_ns: pose.device_ns,
                    event: [k as u8; 256],
                    flags: u32::MAX,
                    session: 0,
                })
                .expect("send");
        }
    }
    for command in [0, 77, u32::MAX] {
        let record = ControlRecord {
            sequence: 1,
            available_ns: -1,
            command,
            session: 1,
            token: [0; 16],
        };
        control.send_copy(record).expect("send");
        assert_eq!(daemon.wait_for("refused")["reason"], "no such command");
    }
    daemon.terminate();
    let closed = daemon.wait_for("closed");
    let counts = &closed["counts"]["trackers"][0]["counts"];
    assert_eq!(counts["received"].as_u64(), Some(600), "{counts}");
    assert_eq!(closed["counts"]["marks"]["received"].as_u64(), Some(60));
    assert!(closed["counts"]["marks"]["refused"].as_u64() > Some(10));
    for what in ["malformed", "invalid", "duplicated", "late", "restarts"] {
        assert!(counts[what].as_u64() > Some(0), "{what}: {counts}");
    }
    // Of garbage there is no estimate, or one that is not physical; the daemon ends properly, and
    // all that came is in the file.
    assert_eq!(daemon.finished(), Some(0));
    let take = house.path(closed["recording"].as_str().expect("path"));
    assert_eq!(raw_messages(&take), 660);
}

#[test]
fn what_a_full_buffer_drops_is_counted_as_overflow() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &["--start"]);
    daemon.wait_for("started");
    let sent = house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    let node = Node::join("flood", Some(house.iceoryx2())).expect("node");
    let topics = ["/tracker/pencil/pose".to_owned()];
    let flood = TrackerPublisher::open(&node, &topics, "/marks").expect("publisher");
    let send = |sequences: std::ops::Range<u64>| {
        for sequence in sequences {
            let pose = PoseRecord {
                sequence,
                available_ns: 1,
                sample_ns: 1_700_000_000_000_000_000 + sequence as i64 * 1_000_000,
                device_ns: 0,
                position_m: [sequence as f64, 0.0, 0.0],
                quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
                flags: 1,
                session: 5,
            };
            assert_eq!(flood.pose(0, pose).expect("send"), 1);
        }
    };
    send(0..10);
    let received = sent["poses"].as_u64().expect("number");
    daemon.wait_until_journalled(received + 10);
    daemon.stop();
    send(10..5000);
    daemon.signal("CONT");
    daemon.wait_until_journalled(received + 10 + 2048);
    daemon.terminate();
    let counts = daemon.wait_for("closed")["counts"]["trackers"][0]["counts"].clone();
    assert_eq!(
        counts["received"].as_u64(),
        Some(received + 10 + 2048),
        "{counts}"
    );
    assert_eq!(counts["missing"].as_u64(), Some(4990 - 2048), "{counts}");
    assert_eq!(counts["overflows"].as_u64(), Some(1), "{counts}");
    daemon.finished();
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_daemon() {
    let house = House::new();
    let Some(mut daemon) = Daemon::start_on_small_disk(&house, "config/pencil_tip.toml", "3m", "")
    else {
        return peers::skip(
            "a_full_disk_ends_the_recording_and_not_the_daemon",
            "no file system may be mounted here",
        );
    };
    let load = [
        "--load",
        "1",
        "--names",
        "pencil",
        "--rate-hz",
        "1000",
        "--seconds",
        "6",
        "--take",
    ];
    let child = house.spawn_tracker(&load);
    // So little is left that the take fills it.
    daemon.wait_for("started");
    let filler = daemon.seen(&house.folder().join("filler"));
    std::fs::write(&filler, vec![1; 11 << 18]).expect("write");
    let broken = daemon.wait_for("broken");
    let error = broken["error"].as_str().expect("text");
    assert!(error.contains("No space left"), "{error}");
    assert!(ended(child).status.success());
    // It lives: the stop that follows makes no sense any more, and is answered.
    assert_eq!(daemon.wait_for("refused")["reason"], "no take runs");
    let copy = house.folder().join("copy.mcap");
    daemon.copy_out(broken["recording"].as_str().expect("path"), &copy);
    let recording = Recording::open(&copy).expect("open");
    assert_eq!(recording.container().damages().count(), 0);
    ends::is_said_to_be_cut_short(&house, &copy);
    assert!(
        raw_messages(&copy) > 500,
        "{} messages",
        raw_messages(&copy)
    );
    daemon.terminate();
    assert_eq!(daemon.finished(), Some(3));
}

#[test]
fn a_doctor_sees_services_and_what_was_killed() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    let doctor = |expected: i32| {
        let output = house.enact_with_iceoryx2(&["doctor", "config/pencil_tip.toml"]);
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        assert_eq!(output.status.code(), Some(expected), "{text}");
        text
    };
    // No tracker publishes.
    let text = doctor(3);
    let line = "enact/tracker/pencil/pose: enact.Pose.1 of 96 bytes, buffer 2048";
    assert!(text.contains(line), "{text}");
    daemon.kill();
    let text = doctor(3);
    assert!(text.contains("was killed"), "{text}");
    // The next one clears it away.
    let mut daemon = Daemon::start(&house, "config/pencil_tip.toml", &[]);
    daemon.wait_until_cleared(Duration::from_secs(20));
    assert!(!doctor(3).contains("was killed"));
    daemon.end();
}
