//! The operator's page, and who may direct through it.

use serde_json::Value;

use super::harness::{Daemon, House, Patience};
use super::socket::{Viewer, exchange, get, post};
use super::{SCENE, metrics};

pub fn state(url: &str) -> Value {
    let (status, body) = get(url, "/state");
    assert_eq!(status, 200);
    serde_json::from_str(&body).expect("json")
}

/// The state once it is so.
pub fn wait(url: &str, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
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
    // A picture follows; none of a take that is not.
    wait(&url, "a picture", |now| {
        now["takes"][0]["has_picture"] == true
    });
    let answer = exchange(&url, b"GET /picture/1.svg HTTP/1.1\r\nHost: x\r\n\r\n");
    let (head, picture) = answer.split_once("\r\n\r\n").expect("a head");
    assert!(head.starts_with("HTTP/1.1 200 "), "{head}");
    assert!(head.contains("Content-Type: image/svg+xml\r\n"), "{head}");
    assert!(head.contains("default-src 'none'; style-src"), "{head}");
    assert!(!head.contains("script-src"), "{head}");
    let picture = roxmltree::Document::parse(picture).expect("SVG");
    let drawn = picture
        .descendants()
        .filter(|node| node.has_tag_name("path"));
    assert!(drawn.count() > 10);
    for none in ["2", "0", "-1", "x", "1.svg/..", "99999999999999999999"] {
        assert_eq!(get(&url, &format!("/picture/{none}.svg")).0, 404, "{none}");
    }
    // The recorder's counts are renewed five times a second.
    wait(&url, "all samples are counted", |now| {
        now["status"]["totals"]["trackers"][0]["counts"]["received"] == sent["poses"]
    });
    daemon.end();
    // A later daemon knows what became of the take.
    let daemon = Daemon::start(&house, SCENE, &["--metrics-port", "0"]);
    let url = daemon.ready["metrics"].as_str().expect("served");
    let known = wait(url, "the take of before", |now| {
        now["takes"][0]["take"] == 1
    });
    for key in ["state", "is_good", "text", "recording", "output", "label"] {
        assert_eq!(known["takes"][0][key], over["takes"][0][key], "{key}");
    }
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
