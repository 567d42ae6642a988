//! What the daemon serves while a take runs: previews, viewers, health and metrics.

use std::collections::{BTreeMap, BTreeSet};

use foxglove::Decode;
use foxglove::messages::{FrameTransforms, PoseInFrame, SceneUpdate};

mod acting;
mod calibration;
mod crowd;
mod descriptors;
mod health;
mod https;
mod page;
mod socket;

use crate::harness::{Daemon, House, Patience, ended};
use socket::{Viewer, connect, exchange, get, status, upgrade, upgrade_for};

const RECORDING: &str = "recordings/pencil_tip.mcap";
const SCENE: &str = "config/pencil_tip.toml";

/// What the recording holds.
const POSES: u64 = 269;
const MARKS: u64 = 2;

/// Lines of a page as Prometheus reads them: name with labels, value.
fn samples(page: &str) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    for line in page.lines().filter(|line| !line.starts_with('#')) {
        let (series, value) = line.rsplit_once(' ').expect("a value");
        let value: f64 = value.parse().unwrap_or_else(|_| panic!("{line}"));
        let name = series.split('{').next().expect("a name");
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        assert!(
            name.starts_with("enact_") && name.chars().all(is_name),
            "{line}"
        );
        assert_eq!(series.contains('{'), series.ends_with('}'), "{line}");
        // Every series belongs to a family of known type.
        let family = ["_bucket", "_sum", "_count"].iter();
        let family = family.fold(name, |name, end| name.strip_suffix(end).unwrap_or(name));
        assert!(page.contains(&format!("# TYPE {family} ")), "{line}");
        assert!(found.insert(series.to_owned(), value).is_none(), "{line}");
    }
    found
}

fn metrics(url: &str) -> BTreeMap<String, f64> {
    let (status, page) = get(url, "/metrics");
    assert_eq!(status, 200);
    samples(&page)
}

#[test]
fn metrics_are_right_while_a_take_runs_and_garbage_is_refused() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--metrics-port", "0"]);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    assert!(url.starts_with("http://127.0.0.1:"), "{url}");
    assert_eq!(get(&url, "/health"), (200, "ready\n".to_owned()));
    assert_eq!(metrics(&url)["enact_recording"], 0.0);

    let received = "enact_tracker_samples_total{topic=\"/tracker/pencil/pose\",fate=\"received\"}";
    let tracker = house.spawn_tracker(&[RECORDING, "--take", "--rate", "1", "--now"]);
    // Both at once, while it runs; the page is up to a fifth of a second old.
    let patience = Patience::new();
    let running = loop {
        patience.check("samples are counted");
        let now = metrics(&url);
        if now["enact_recording"] == 1.0 && now.get(received).is_some_and(|n| *n > 0.0) {
            break now;
        }
    };
    assert!(running[received] < POSES as f64, "{running:?}");
    for garbage in [
        &b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"[..],
        b"GET /metrics\r\n\r\n",
        b"\0\0\0\0\r\n\r\n",
    ] {
        let answer = exchange(&url, garbage);
        assert_eq!(status(&answer), 400, "{answer}");
    }
    let long = format!("GET / HTTP/1.1\r\nX: {}", "x".repeat(1 << 16));
    let answer = exchange(&url, long.as_bytes());
    // It may be cut off before it has said what it thinks of that.
    assert!(matches!(status(&answer), 0 | 431), "{answer}");
    let answer = exchange(&url, b"DELETE /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert_eq!(status(&answer), 405);
    assert_eq!(get(&url, "/../secrets").0, 404);
    drop(connect(&url));
    // One that never says anything does not keep others out.
    let _silent = connect(&url);

    daemon.wait_for("closed");
    daemon.wait_for("estimated");
    assert!(ended(tracker).status.success());
    let all = (POSES + MARKS) as f64;
    // The recorder's counts are renewed five times a second.
    let patience = Patience::new();
    let after = loop {
        patience.check("the take is over");
        let now = metrics(&url);
        if now["enact_recording"] == 0.0 {
            break now;
        }
    };
    for (series, expected) in [
        (received, POSES as f64),
        ("enact_marks_total", MARKS as f64),
        ("enact_takes_total{state=\"started\"}", 1.0),
        ("enact_takes_total{state=\"estimated\"}", 1.0),
        ("enact_takes_total{state=\"broken\"}", 0.0),
        ("enact_journal_latency_seconds_count{}", all),
        ("enact_journal_latency_seconds_bucket{le=\"+Inf\"}", all),
        ("enact_estimate_seconds_count{}", 1.0),
        ("enact_estimates_at_marks_total", MARKS as f64),
        ("enact_queue_depth{queue=\"finals\"}", 0.0),
    ] {
        assert_eq!(after.get(series), Some(&expected), "{series}: {after:?}");
    }
    assert!(after["enact_requests_refused_total"] >= 6.0, "{after:?}");
    // It followed: previews went on from the one before, but after marks. Of few samples at a time, which a slow machine does
    // not have, nearly all do.
    let previews =
        |start: &str| after[&format!("enact_preview_seconds_count{{start=\"{start}\"}}")];
    let (warm, cold) = (previews("warm"), previews("cold"));
    assert!(warm >= 1.0 && cold >= MARKS as f64, "{warm} {cold}");
    daemon.end();
}

#[test]
fn viewers_see_the_tracker_the_motion_and_its_ghost_whatever_others_send() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--viewer-port", "0"]);
    let url = daemon.ready["viewer"].as_str().expect("served").to_owned();
    assert!(url.starts_with("ws://127.0.0.1:"), "{url}");
    for protocol in [None, Some("chat"), Some("foxglove.websocket.v1")] {
        let answer = exchange(&url, upgrade(protocol).as_bytes());
        assert_eq!(status(&answer), 400, "{protocol:?}: {answer}");
    }
    let answer = exchange(&url, b"\x00\xff\x00\xffgarbage\r\n\r\n");
    assert_ne!(status(&answer), 101, "{answer}");
    for origin in [
        "http://evil.example",
        "null",
        "http://localhost.evil.example:8080",
    ] {
        let request = upgrade_for(origin, Some("foxglove.sdk.v1"));
        let answer = exchange(&url, request.as_bytes());
        assert_eq!(status(&answer), 403, "{origin}: {answer}");
    }

    let expected = [
        "/estimate/pencil/pose",
        "/estimate/report",
        "/estimate/time_map",
        "/marks",
        "/scene",
        "/sketch/pencil/pose",
        "/tf",
        "/tracker/pencil/pose",
    ];
    let mut viewer = Viewer::new(&url, expected.len());
    let topics: BTreeSet<&str> = viewer.topics.iter().map(|(_, t)| t.as_str()).collect();
    assert_eq!(topics, BTreeSet::from(expected));
    viewer.subscribe();
    // One that subscribes and never reads, and some that send what no client may.
    let mut deaf = Viewer::new(&url, expected.len());
    deaf.subscribe();
    for (opcode, bytes) in [
        (
            1,
            &b"{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":-1}]}"[..],
        ),
        (1, b"not json \xff\xfe"),
        (2, b"\xff\xff\xff\xff\xff"),
        (2, b""),
        (7, b"no such kind of frame"),
    ] {
        Viewer::new(&url, expected.len()).send(opcode, bytes);
    }
    // A frame of 2^63 bytes, of which none come; one that is not masked; one that is not whole.
    for frame in [
        &[
            0x82, 0xff, 0x7f, 255, 255, 255, 255, 255, 255, 255, 0, 0, 0, 0,
        ][..],
        b"\x81\x02{}",
        b"\x81",
    ] {
        Viewer::new(&url, expected.len()).send_raw(frame);
    }

    let tracker = house.spawn_tracker(&[RECORDING, "--take", "--rate", "1", "--now"]);
    let (mut seen, mut frames, mut entities) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let mut verdict = String::new();
    let (mut live_m, mut estimate_m) = (Vec::new(), Vec::new());
    let patience = Patience::new();
    while seen.len() < expected.len() || frames.len() < 3 || verdict != "physical" {
        patience.check("every topic, three frames, a verdict");
        let message = viewer.message();
        let data = &message.data[..];
        match message.topic.as_str() {
            "/tf" => {
                let transforms = FrameTransforms::decode(data).expect("decode").transforms;
                frames.extend(transforms.into_iter().map(|t| t.child_frame_id));
            }
            "/scene" => {
                let update = SceneUpdate::decode(data).expect("decode");
                entities.extend(update.entities.into_iter().map(|e| (e.id, e.frame_id)));
            }
            "/tracker/pencil/pose" => live_m.push(position_m(data)),
            "/estimate/pencil/pose" => estimate_m.push(position_m(data)),
            "/estimate/report" => {
                let report: serde_json::Value = serde_json::from_slice(data).expect("json");
                // Whole: both events are in it.
                if report["events"].as_array().is_some_and(|e| e.len() == 2) {
                    verdict = report["verdict"].as_str().expect("word").to_owned();
                }
            }
            _ => {}
        }
        seen.insert(message.topic);
    }
    let names = ["pencil_estimate", "pencil_live", "pencil_sketch"].map(str::to_owned);
    assert_eq!(frames, BTreeSet::from(names));
    for (id, frame) in [
        ("body/pencil", "pencil_estimate"),
        ("sketch/pencil", "pencil_sketch"),
        ("live/pencil", "pencil_live"),
        ("surface/table", "world"),
    ] {
        let entity = (id.to_owned(), frame.to_owned());
        assert!(entities.contains(&entity), "{entity:?} in {entities:?}");
    }
    // It moves, above the table.
    let is_above = |p: &[f64; 3]| p[2] > 0.0 && p[2] < 2.0;
    assert!(
        live_m.len() > 20 && live_m.iter().all(is_above),
        "{live_m:?}"
    );
    estimate_m.dedup();
    assert!(estimate_m.len() > 5, "{} poses", estimate_m.len());
    let closed = daemon.wait_for("closed");
    assert_eq!(closed["messages"].as_u64(), Some(POSES + MARKS));
    assert!(ended(tracker).status.success());
    daemon.wait_for("estimated");
    daemon.end();
}

fn position_m(data: &[u8]) -> [f64; 3] {
    let pose = PoseInFrame::decode(data)
        .expect("decode")
        .pose
        .expect("a pose");
    let position = pose.position.expect("a position");
    [position.x, position.y, position.z]
}
