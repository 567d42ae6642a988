//! The operator's page, and who may direct through it.

use serde_json::Value;

use super::socket::{Viewer, exchange, get, order, status, token, upgrade};
use super::{SCENE, metrics};
use crate::harness::{Daemon, House, Patience};

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
    let token = token(&daemon.ready);
    let post = |json: &str| order(&url, own, Some(&token), json);
    let start = r#"{"command":"start"}"#;
    assert_eq!(get(&url, "/take").0, 405);
    let stop = r#"{"command":"stop","name":"Wurf <b>ü</b>","note":"n","rating":4}"#;
    for (order, expected) in [
        (stop, 409),
        (r#"{"command":"mark"}"#, 409),
        (r#"{"command":"fly"}"#, 400),
        ("\u{1}", 400),
        (start, 202),
    ] {
        let (status, said) = post(order);
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
        let (status, said) = post(order);
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
    let answer = exchange(
        &url,
        b"GET /picture/1.svg HTTP/1.1\r\nHost: localhost\r\n\r\n",
    );
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

/// Whoever may watch, and whatever is forged: nobody directs without the token, and who asks by a name that
/// somebody else may have given this machine gets nothing.
#[test]
fn watching_is_not_directing_and_names_are_looked_at() {
    let house = House::new();
    let scene = std::fs::read_to_string(SCENE).expect("a scene");
    let watched = house.folder().with_file_name("watched.toml");
    let viewer = "https://viewer.example";
    let capture =
        format!("[capture]\norigins = [\"{viewer}\", \"*\"]\nhosts = [\"mocap.local\"]\n");
    std::fs::write(&watched, format!("{scene}\n{capture}")).expect("write");
    let ports = ["--metrics-port", "0", "--viewer-port", "0"];
    let mut daemon = Daemon::start(&house, house.text(&watched), &ports);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let shown = daemon.ready["viewer"].as_str().expect("served").to_owned();
    let token = token(&daemon.ready);
    // Only its user can read the token, and no page has it.
    let file = house.iceoryx2().with_file_name("iceoryx2");
    let tokens = std::fs::read_dir(file)
        .expect("list")
        .map(|entry| entry.expect("entry"));
    let tokens: Vec<_> = tokens
        .filter(|entry| entry.file_name().to_string_lossy().ends_with(".token"))
        .collect();
    assert_eq!(tokens.len(), 1);
    use std::os::unix::fs::PermissionsExt;
    let mode = tokens[0].metadata().expect("there").permissions().mode();
    assert_eq!(mode & 0o7777, 0o600);
    for path in ["/", "/state", "/metrics", "/health"] {
        let (status, body) = get(&url, path);
        assert!(status == 200 && !body.contains(&token), "{path}");
    }
    let own = url.as_str();
    let wrong = "0".repeat(32);
    let last = if token.ends_with('0') { "1" } else { "0" };
    let near = format!("{}{last}", &token[..31]);
    let start = r#"{"command":"start"}"#;
    // With the token only the own page directs, and a program that says no page.
    let pages = [
        viewer,
        "*",
        "http://evil.example",
        "null",
        "http://localhost:1",
        "file://",
    ];
    for page in pages.map(Some) {
        for knows in [None, Some(token.as_str())] {
            let (status, _) = order(&url, page, knows, start);
            assert_eq!(status, 403, "{page:?} {knows:?}");
        }
    }
    for page in [Some(own), None] {
        for knows in [None, Some(wrong.as_str()), Some(near.as_str()), Some("")] {
            for command in ["start", "stop", "discard", "mark"] {
                let json = format!("{{\"command\":\"{command}\"}}");
                let (status, _) = order(&url, page, knows, &json);
                assert_eq!(status, 403, "{page:?} {knows:?} {command}");
            }
        }
    }
    // What a form sends, without a question before.
    let length = start.len();
    let form = format!(
        "POST /take HTTP/1.1\r\nHost: {}\r\nOrigin: {own}\r\nContent-Type: text/plain\r\n\
         Content-Length: {length}\r\n\r\n{start}",
        &own["http://".len()..]
    );
    assert_eq!(status(&exchange(&url, form.as_bytes())), 403);
    // Browsers ask before they send the token on behalf of another page, and are not allowed to.
    let asks = format!("OPTIONS /take HTTP/1.1\r\nHost: localhost\r\nOrigin: {viewer}\r\n\r\n");
    let answer = exchange(&url, asks.as_bytes());
    assert_eq!(status(&answer), 405, "{answer}");
    assert!(
        !answer.to_ascii_lowercase().contains("access-control"),
        "{answer}"
    );
    // Names, on every route.
    let routes = [
        "/",
        "/state",
        "/take",
        "/health",
        "/metrics",
        "/picture/1.svg",
        "/none",
    ];
    let one = |host: &str| format!("Host: {host}\r\n");
    let hosts = [
        "evil.example",
        "evil.example:9464",
        "localhost.evil.example",
        "127.0.0.1.evil.example",
        "",
    ];
    let hosts = hosts.map(one).into_iter().chain([
        String::new(),
        "Host: localhost\r\nHost: evil.example\r\n".to_owned(),
    ]);
    for host in hosts {
        for route in routes {
            let asked = format!("GET {route} HTTP/1.1\r\n{host}\r\n");
            assert_eq!(
                status(&exchange(&url, asked.as_bytes())),
                421,
                "{host}{route}"
            );
        }
        let known = format!("{host}Authorization: Bearer {token}\r\nContent-Length: {length}\r\n");
        let asked = format!("POST /take HTTP/1.1\r\n{known}\r\n{start}");
        assert_eq!(status(&exchange(&url, asked.as_bytes())), 421, "{host}");
        let watches = upgrade(Some("foxglove.sdk.v1")).replacen("Host: localhost\r\n", &host, 1);
        let answer = exchange(&shown, watches.as_bytes());
        assert_ne!(status(&answer), 101, "{host}: {answer}");
    }
    for host in [
        "localhost",
        "LOCALHOST:1",
        "127.0.0.1:1",
        "[::1]:1",
        "mocap.local",
        "Mocap.Local:9",
    ] {
        let asked = format!("GET /health HTTP/1.1\r\n{}\r\n", one(host));
        assert_eq!(status(&exchange(&url, asked.as_bytes())), 200, "{host}");
    }
    // Nothing of all that was obeyed; the user of the daemon directs without ado.
    assert_eq!(state(&url)["status"]["take"], serde_json::Value::Null);
    assert_eq!(house.take(&["start"]).0, Some(0));
    let (_, said, _) = house.take(&["status"]);
    assert!(
        said.contains(&format!("operator's page: {url}/#token={token}\n")),
        "{said}"
    );
    // What is thrown away can be had back.
    let (status, why) = order(&url, Some(own), Some(&token), r#"{"command":"discard"}"#);
    assert_eq!(status, 202, "{why}");
    let discarded = daemon.wait_for("discarded");
    let kept = house.path(discarded["recording"].as_str().expect("a path"));
    assert!(
        kept.starts_with(house.folder().join("discarded")),
        "{kept:?}"
    );
    assert!(enact::ingest::Recording::open(&kept).is_ok());
    assert!(house.recordings().is_empty() && house.parts().is_empty());
    daemon.end();
}

/// Over iceoryx2 too nobody directs without the token: not who forges a command, nor another user.
#[test]
fn commands_without_the_token_are_refused() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let node = enact::ingest::live::Node::join("stranger", Some(house.iceoryx2())).expect("node");
    let stranger = enact::write::TrackerPublisher::open(&node, &[], "/marks").expect("publisher");
    use enact::ingest::live::{Command, Token};
    let other = Token::make().expect("random bytes");
    for (sequence, token) in [(1, Token::NONE), (2, other)] {
        for command in [Command::Start, Command::Stop, Command::Discard] {
            stranger
                .control(command, 7, sequence, 0, token)
                .expect("send");
            let refused = daemon.wait_for("refused");
            let reason = refused["reason"].as_str().expect("text");
            assert!(reason.contains("without the daemon's token"), "{reason}");
        }
    }
    // A file with a copy of it is as good, for a daemon elsewhere.
    let copy = house.folder().with_file_name("copy");
    std::fs::write(&copy, other.text()).expect("write");
    let (code, said, _) = house.take(&["start", "--token", house.text(&copy)]);
    assert_eq!(code, Some(1), "{said}");
    std::fs::write(&copy, house.token().text()).expect("write");
    let (code, said, _) = house.take(&["start", "--token", house.text(&copy)]);
    assert_eq!(code, Some(0), "{said}");
    if let Some(output) = house.enact_as_nobody(&["take", "discard"]) {
        assert_eq!(output.status.code(), Some(1));
    }
    assert_eq!(house.take(&["discard"]).0, Some(0));
    daemon.end();
    assert_eq!(house.take(&["start"]).0, Some(1));
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
