//! The operator's page, and who may direct through it.

use serde_json::Value;

use super::harness::{Daemon, House, Patience};
use super::socket::{Viewer, get, post};
use super::{SCENE, metrics};

fn state(url: &str) -> Value {
    let (status, body) = get(url, "/state");
    assert_eq!(status, 200);
    serde_json::from_str(&body).expect("json")
}

/// The state once it is so.
fn wait(url: &str, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
    let patience = Patience::new();
    loop {
        patience.check(what);
        let now = state(url);
        if is_so(&now) {
            return now;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

#[test]
fn a_take_is_directed_from_the_page_and_from_no_other() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &["--metrics-port", "0"]);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let (status, page) = get(&url, "/");
    assert_eq!(status, 200);
    // It needs nothing from elsewhere.
    for outside in ["http://", "https://", "src=", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let own = Some(url.as_str());
    let start = r#"{"command":"start"}"#;
    let evil = ["http://evil.example", "null", "http://localhost:1"];
    for origin in evil.map(Some).into_iter().chain([None]) {
        let (status, _) = post(&url, "/take", origin, start);
        assert_eq!(status, 403, "{origin:?}");
    }
    assert_eq!(get(&url, "/take").0, 405);
    let stop = r#"{"command":"stop","name":"Wurf <b>ü</b>","note":"n","rating":4}"#;
    for (order, expected) in [
        (stop, 409),
        (r#"{"command":"mark"}"#, 409),
        (r#"{"command":"fly"}"#, 400),
        ("\u{1}", 400),
        (start, 202),
    ] {
        let (status, said) = post(&url, "/take", own, order);
        assert_eq!(status, expected, "{order}: {said}");
    }
    let running = wait(&url, "a take runs", |now| now["status"]["take"] == 1);
    assert_eq!(running["events"][0], "bounce");
    assert!(running["free_bytes"].as_u64() > Some(0));
    let sent = house.tracker(&["recordings/pencil_tip.mcap", "--rate", "0"]);
    for (order, expected) in [
        (start, 409),
        (r#"{"command":"mark","event":"bonce"}"#, 409),
        (r#"{"command":"stop","rating":6}"#, 409),
        (stop, 202),
    ] {
        let (status, said) = post(&url, "/take", own, order);
        assert_eq!(status, expected, "{order}: {said}");
    }
    let over = wait(&url, "a verdict", |now| {
        now["takes"][0]["state"] == "physical"
    });
    assert_eq!(over["takes"][0]["is_good"], true);
    assert_eq!(over["takes"][0]["label"]["rating"], 4);
    assert_eq!(over["takes"][0]["label"]["name"], "Wurf <b>ü</b>");
    // The recorder's counts are renewed five times a second.
    wait(&url, "all samples are counted", |now| {
        now["status"]["totals"]["trackers"][0]["counts"]["received"] == sent["poses"]
    });
    daemon.end();
}

#[test]
fn viewers_are_warned_of_a_silent_tracker_until_it_is_there_again() {
    let house = House::new();
    let ports = ["--viewer-port", "0", "--metrics-port", "0"];
    let mut daemon = Daemon::start(&house, SCENE, &ports);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let silent = "enact_tracker_silent{topic=\"/tracker/pencil/pose\"}";
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    let mut early = Viewer::new(&shown, 8);
    let load = ["--load", "1", "--names", "pencil", "--rate-hz", "200"];
    house.tracker(&[&load[..], &["--seconds", "1"]].concat());
    let said = early.text("status");
    assert_eq!(said["level"], 1);
    let text = said["message"].as_str().expect("text");
    assert_eq!(text, "/tracker/pencil/pose: its tracker fell silent");
    assert_eq!(metrics(&url)[silent], 1.0);
    // One who comes late is told, too.
    let mut late = Viewer::new(&shown, 8);
    assert_eq!(late.text("status")["message"], text);
    house.tracker(&[&load[..], &["--seconds", "3"]].concat());
    for viewer in [&mut early, &mut late] {
        assert_eq!(viewer.text("removeStatus")["statusIds"][0], said["id"]);
    }
    daemon.end();
}
