//! Few descriptors, and none: trackers and takes go on, viewers are refused, and health says what cannot be done.

use std::collections::BTreeSet;
use std::path::Path;

use rustix::process::{Pid, Resource, Rlimit, prlimit};

use super::SCENE;
use super::health::{wait, wait_for_red};
use super::page::{state, wait as wait_for_state};
use super::socket::{Viewer, get, order, token};
use crate::harness::{Daemon, House, Patience, ended};

const LOAD: [&str; 7] = [
    "--load",
    "1",
    "--names",
    "pencil",
    "--rate-hz",
    "500",
    "--seconds",
];

const PORTS: [&str; 4] = ["--metrics-port", "0", "--viewer-port", "0"];

#[test]
fn with_few_descriptors_viewers_are_refused_and_takes_are_whole() {
    let house = House::new();
    // Some more than are reserved.
    let mut daemon = Daemon::start_with_descriptors(&house, SCENE, &PORTS, 320);
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let (mut served, mut refused) = (Vec::new(), 0);
    for _ in 0..60 {
        match Viewer::open(&shown, 8) {
            Ok(viewer) => served.push(viewer),
            Err(head) => {
                assert!(head.contains("503"), "{head}");
                refused += 1;
            }
        }
    }
    assert!(served.len() <= 12 && refused >= 48, "{refused} refused");
    assert_eq!(get(&url, "/health").0, 200);
    let sent = house.tracker(&[&LOAD[..], &["2", "--take"]].concat());
    let closed = daemon.wait_for("closed");
    assert_eq!(
        closed["counts"]["trackers"][0]["counts"]["received"],
        sent["poses"]
    );
    assert_eq!(closed["counts"]["trackers"][0]["counts"]["missing"], 0);
    daemon.end();
}

/// Sets the limit of a process so that it gets no descriptor more; what it was. Waits until there are none to be had
/// below the one that its port keeps to spare: what is closed must be of use again.
fn exhaust(process: u32) -> Rlimit {
    let folder = format!("/proc/{process}/fd");
    let patience = Patience::new();
    loop {
        patience.check("descriptors without holes");
        let (mut numbers, mut spare) = (BTreeSet::new(), 0);
        for entry in std::fs::read_dir(&folder)
            .expect("its descriptors")
            .flatten()
        {
            let number: u64 = entry
                .file_name()
                .to_str()
                .expect("text")
                .parse()
                .expect("a number");
            let is_null =
                std::fs::read_link(entry.path()).is_ok_and(|of| of == Path::new("/dev/null"));
            spare = if is_null { spare.max(number) } else { spare };
            numbers.insert(number);
        }
        let free = (0..).find(|number| !numbers.contains(number));
        if free > Some(spare) && spare > 2 {
            let none_more = Rlimit {
                current: free,
                maximum: None,
            };
            return limit(process, none_more);
        }
    }
}

fn limit(process: u32, new: Rlimit) -> Rlimit {
    let process = Pid::from_raw(process as i32).expect("a process");
    let old = rustix::process::getrlimit(Resource::Nofile);
    let maximum = old.maximum;
    prlimit(Some(process), Resource::Nofile, Rlimit { maximum, ..new }).expect("its limit")
}

#[test]
fn with_no_descriptor_left_a_take_goes_on_and_health_says_that_none_can_begin() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &PORTS);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let own = Some(url.as_str());
    let token = token(&daemon.ready);
    let order = |json: &str| order(&url, own, Some(&token), json).0;
    let is_recording = |now: &serde_json::Value| now["status"]["messages"].as_u64() > Some(100);
    assert_eq!(order(r#"{"command":"start"}"#), 202);
    let tracker = house.spawn_tracker(&[&LOAD[..], &["4"]].concat());
    wait_for_state(&url, "samples come", is_recording);
    let before = exhaust(daemon.id());
    wait_for_red(&url, "Too many open files");
    let during = state(&url)["status"]["messages"].as_u64();
    let sent = ended(tracker);
    assert!(sent.status.success());
    // All of it is in the take.
    wait_for_state(&url, "the rest of the samples", |now| {
        now["status"]["counts"]["trackers"][0]["counts"]["received"] == 2000
    });
    assert!(during < Some(2000), "the limit came after the samples");
    assert_eq!(order(r#"{"command":"stop"}"#), 202);
    let closed = daemon.wait_for("closed");
    assert_eq!(closed["counts"]["trackers"][0]["counts"]["received"], 2000);
    assert_eq!(closed["counts"]["trackers"][0]["counts"]["missing"], 0);
    let recording = house.path(closed["recording"].as_str().expect("a path"));
    let read = enact::ingest::Recording::open(&recording).expect("open");
    assert!(!read.container().damages().is_loss());
    limit(daemon.id(), before);
    wait(&url, 200);
    daemon.end();
}

#[test]
fn before_a_take_it_is_said_that_none_can_begin_until_one_can() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &PORTS);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    assert_eq!(get(&url, "/health").0, 200);
    let before = exhaust(daemon.id());
    wait_for_red(&url, "Too many open files");
    // Again and again: one descriptor serves them all.
    for _ in 0..5 {
        assert_eq!(get(&url, "/health").0, 503);
    }
    limit(daemon.id(), before);
    wait(&url, 200);
    let (code, said, _) = house.take(&["start"]);
    assert_eq!(code, Some(0), "{said}");
    daemon.end();
}
