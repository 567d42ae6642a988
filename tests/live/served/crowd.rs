//! Crowds at the daemon's ports: what they take, and what is left for recording.

use std::io::{Read, Write};
use std::time::{Duration, Instant};

use super::socket::{Viewer, connect, get, upgrade};
use super::{RECORDING, SCENE, metrics};
use crate::harness::{Daemon, House, Patience, ended};

const TOPICS: usize = 8;

/// Descriptors of the daemon, and connections of the crowd at each port.
const DESCRIPTORS: usize = 400;
const CROWD: usize = 300;

/// What all viewers together may take.
const MEMORY_BYTES: u64 = 64 << 20;

/// How long a page takes: the quickest of some, for this machine has others to serve.
fn quickest(url: &str, path: &str) -> Duration {
    let times = (0..10).map(|_| {
        let begun = Instant::now();
        assert_eq!(get(url, path).0, 200);
        begun.elapsed()
    });
    times.min().expect("some")
}

#[test]
fn a_crowd_that_says_nothing_stops_neither_takes_nor_health_nor_viewers() {
    let house = House::new();
    let ports = ["--metrics-port", "0", "--viewer-port", "0"];
    let mut daemon = Daemon::start_with_descriptors(&house, SCENE, &ports, DESCRIPTORS);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    let mut crowd = Vec::new();
    for half in 0..CROWD {
        for url in [&url, &shown] {
            let mut stream = connect(url);
            // Some begin to speak and do not end.
            if half % 2 == 0 {
                let _ = stream.write_all(b"GET / HTTP/1.1\r\n");
            }
            crowd.push(stream);
        }
    }
    let health = quickest(&url, "/health");
    assert!(health < Duration::from_millis(100), "{health:?}");
    let (code, said, _) = house.take(&["start"]);
    assert_eq!((code, said.as_str()), (Some(0), "take 1 begins\n"));
    house.tracker(&[RECORDING, "--rate", "0"]);
    let mut viewer = Viewer::new(&shown, TOPICS);
    viewer.subscribe();
    let patience = Patience::new();
    while viewer.message().topic != "/scene" {
        patience.check("the scene is shown");
    }
    let (code, said, _) = house.take(&["stop", "--wait"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("take 1: physical"), "{said}");
    let counted = metrics(&url);
    assert!(
        counted["enact_connections_closed_total"] > CROWD as f64,
        "{counted:?}"
    );
    // The crowd goes, and the ports are as they were.
    drop(crowd);
    Viewer::new(&shown, TOPICS);
    daemon.end();
}

#[test]
fn viewers_that_do_not_read_are_bounded_in_number_and_in_memory_and_sent_away() {
    let house = House::new();
    let ports = ["--metrics-port", "0", "--viewer-port", "0"];
    let mut daemon = Daemon::start(&house, SCENE, &ports);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    // An estimate, so that there is much to show.
    house.tracker(&[RECORDING, "--take", "--rate", "0"]);
    daemon.wait_for("estimated");
    let before = daemon.memory_bytes();
    let load = [
        "--load",
        "1",
        "--names",
        "pencil",
        "--rate-hz",
        "1000",
        "--seconds",
        "25",
    ];
    let tracker = house.spawn_tracker(&load);
    let (mut deaf, mut refused) = (Vec::new(), 0);
    for _ in 0..200 {
        match Viewer::open(&shown, TOPICS) {
            Ok(mut viewer) => {
                viewer.subscribe();
                deaf.push(viewer);
            }
            Err(head) => {
                assert!(head.contains("503"), "{head}");
                refused += 1;
            }
        }
    }
    assert!(refused > 0 && deaf.len() <= 64, "{refused} of 200 refused");
    let mut most = 0;
    let patience = Patience::new();
    loop {
        patience.check("those that do not read are sent away");
        most = most.max(daemon.memory_bytes().saturating_sub(before));
        let now = metrics(&url);
        if now["enact_viewers"] == 0.0 {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(most < MEMORY_BYTES, "{} MiB", most >> 20);
    // There is room again.
    let mut viewer = Viewer::new(&shown, TOPICS);
    viewer.subscribe();
    viewer.message();
    assert!(ended(tracker).status.success());
    daemon.end();
}

/// What is sent in answer to what a viewer says waits for one that reads nothing; it is not to gather.
#[test]
fn pings_of_one_who_does_not_read_cost_nothing() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--viewer-port", "0"]);
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    let mut ping = vec![0x89, 0x80 | 125, 0, 0, 0, 0];
    ping.extend([b'x'; 125]);
    let pings = ping.repeat(1000);
    let before = daemon.memory_bytes();
    let (mut most, mut sent) = (0, 0);
    let mut stream = connect(&shown);
    let hello = upgrade(Some("foxglove.sdk.v1"));
    stream.write_all(hello.as_bytes()).expect("write");
    // Nothing may be said before the answer.
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).expect("an answer");
        head.push(byte[0]);
    }
    let wait = Some(Duration::from_millis(500));
    stream.set_write_timeout(wait).expect("set");
    // Until no more is taken, or far more is than may be kept.
    while sent < 8 * MEMORY_BYTES && stream.write_all(&pings).is_ok() {
        sent += pings.len() as u64;
        most = most.max(daemon.memory_bytes().saturating_sub(before));
    }
    most = most.max(daemon.memory_bytes().saturating_sub(before));
    assert!(sent > 0, "it is not listened to at all");
    assert!(
        most < MEMORY_BYTES / 4,
        "{} MiB of {} MiB",
        most >> 20,
        sent >> 20
    );
    daemon.end();
}

#[test]
fn unfinished_frames_cost_what_they_have_sent() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--viewer-port", "0"]);
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    let before = daemon.memory_bytes();
    let mut crowd = Vec::new();
    for k in 0..60 {
        let mut stream = connect(&shown);
        stream
            .write_all(upgrade(Some("foxglove.sdk.v1")).as_bytes())
            .expect("write");
        // A frame of just under 16 MiB, or of as much as a viewer may send, of which little comes.
        let length: u64 = if k % 2 == 0 { (16 << 20) - 1 } else { 8 << 10 };
        let mut frame = vec![0x82, 0xff];
        frame.extend(length.to_be_bytes());
        frame.extend([0; 4 + 1000]);
        let _ = stream.write_all(&frame);
        crowd.push(stream);
    }
    let begun = Instant::now();
    let mut most = 0;
    while begun.elapsed() < Duration::from_secs(2) {
        most = most.max(daemon.memory_bytes().saturating_sub(before));
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(most < MEMORY_BYTES / 2, "{} MiB", most >> 20);
    drop(crowd);
    daemon.end();
}

/// The figures of the documentation: `cargo test --features live --test live -- --ignored --nocapture figures`.
#[test]
#[ignore = "measures; needs 2200 descriptors"]
fn figures() {
    let house = House::new();
    let ports = ["--metrics-port", "0", "--viewer-port", "0"];
    let mut daemon = Daemon::start(&house, SCENE, &ports);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    house.tracker(&[RECORDING, "--take", "--rate", "0"]);
    daemon.wait_for("estimated");
    let load = [
        "--load",
        "1",
        "--names",
        "pencil",
        "--rate-hz",
        "1000",
        "--seconds",
        "20",
        "--take",
    ];
    let tracker = house.spawn_tracker(&load);
    let mut waits: Vec<Duration> = Vec::new();
    let mut crowd: Vec<std::net::TcpStream> = (0..1054).map(|_| connect(&url)).collect();
    crowd.extend((0..1054).map(|_| connect(&shown)));
    for _ in 0..50 {
        let begun = Instant::now();
        assert_eq!(get(&url, "/health").0, 200);
        waits.push(begun.elapsed());
    }
    waits.sort();
    println!(
        "/health under 2108 half-open connections: median {:?}, longest {:?}",
        waits[25], waits[49]
    );
    let before = daemon.memory_bytes();
    let deaf: Vec<Viewer> = (0..200)
        .filter_map(|_| Viewer::open(&shown, TOPICS).ok())
        .map(|mut viewer| {
            viewer.subscribe();
            viewer
        })
        .collect();
    println!("{} of 200 viewers that never read are served", deaf.len());
    let (begun, mut most) = (Instant::now(), 0);
    while metrics(&url)["enact_viewers"] > 0.0 {
        most = most.max(daemon.memory_bytes().saturating_sub(before));
        std::thread::sleep(Duration::from_millis(50));
    }
    println!(
        "… take {:.1} MiB at most, and are sent away after {:.1} s",
        most as f64 / 1048576.0,
        begun.elapsed().as_secs_f64()
    );
    daemon.wait_for("closed");
    let closed = daemon.wait_for("closed");
    println!("the take: {}", closed["counts"]);
    assert!(ended(tracker).status.success());
    daemon.end();
}
