//! The acting page: a browser's page as a tracker, and those that are none.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::ingest::live::{NO_TIME, Node, PoseRecord};
use enact::motion::TakeEvent;
use enact::write::TrackerPublisher;
use serde_json::{Value, json};

use super::page::{state, wait};
use super::socket::{connect, exchange, get, status};
use super::{MARKS, POSES, RECORDING, SCENE};
use crate::harness::{Daemon, House, Patience, ended};

/// A page in a house, and a daemon that serves it.
pub fn begin(house: &House, more: &[&str]) -> (Daemon, String) {
    begin_with(house, SCENE, more)
}

/// [`begin`] with another scene.
pub fn begin_with(house: &House, scene: &str, more: &[&str]) -> (Daemon, String) {
    let page: PathBuf = house.folder().join("page.html");
    std::fs::write(&page, "<!doctype html><title>acting</title>").expect("write");
    let acting = format!("--acting={}", page.display());
    let daemon = Daemon::start(
        house,
        scene,
        &[&[acting.as_str(), "--metrics-port", "0"], more].concat(),
    );
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    (daemon, url)
}

/// The code in the link to the acting page.
pub fn code(daemon: &Daemon) -> String {
    let link = daemon.ready["acting"].as_str().expect("a link");
    let (_, code) = link.split_once("/act#code=").expect("a code");
    assert!(
        code.len() == 6 && code.bytes().all(|byte| byte.is_ascii_digit()),
        "{code}"
    );
    code.to_owned()
}

/// A request for the WebSocket, on behalf of that page.
fn request(host: &str, origin: Option<&str>) -> String {
    let origin = origin.map_or(String::new(), |origin| format!("Origin: {origin}\r\n"));
    format!(
        "GET /act/socket HTTP/1.1\r\nHost: {host}\r\n{origin}Upgrade: websocket\r\nConnection: keep-alive, Upgrade\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
}

/// An acting page, byte by byte.
pub struct ActingPage<S = TcpStream>(S);

impl ActingPage {
    pub fn open(url: &str) -> Self {
        Self::on(connect(url), url)
    }

    /// One that was let in and is the tracker of the scene's stream.
    pub fn paired(url: &str, code: &str) -> Self {
        let mut page = Self::open(url);
        page.pair(code);
        page
    }
}

impl<S: Read + Write> ActingPage<S> {
    /// A page of that server, on a connection to it.
    pub fn on(mut stream: S, url: &str) -> Self {
        let host = url.split("//").nth(1).expect("an address");
        let request = request(host, Some(url));
        stream.write_all(request.as_bytes()).expect("write");
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).expect("a head");
            head.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        assert_eq!(status(&head), 101, "{head}");
        // The key of RFC 6455, section 1.3.
        assert!(head.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{head}");
        Self(stream)
    }

    /// Is let in, and is the tracker of the scene's stream.
    pub fn pair(&mut self, code: &str) {
        self.say(&json!({"say": "pair", "code": code}));
        self.hear("paired");
        self.say(&json!({"say": "act", "stream": 0}));
    }

    /// A frame, masked with zeros; whether it was taken.
    fn frame(&mut self, opcode: u8, data: &[u8]) -> bool {
        let mut frame = vec![0x80 | opcode, 0x80 | 126];
        let length = u16::try_from(data.len()).expect("short");
        frame.extend_from_slice(&length.to_be_bytes());
        frame.extend_from_slice(&[0; 4]);
        frame.extend_from_slice(data);
        self.0.write_all(&frame).is_ok()
    }

    pub fn say(&mut self, what: &Value) {
        self.frame(1, what.to_string().as_bytes());
    }

    /// A reading of the scene's stream.
    pub fn reading(&mut self, sequence: u64, device_ns: i64, numbers: [f64; 7]) -> bool {
        self.reading_of(0, sequence, device_ns, numbers)
    }

    /// A reading of any stream.
    fn reading_of(
        &mut self,
        stream: u32,
        sequence: u64,
        device_ns: i64,
        numbers: [f64; 7],
    ) -> bool {
        let mut bytes = stream.to_le_bytes().to_vec();
        bytes.extend([0; 4]);
        bytes.extend(sequence.to_le_bytes());
        for time_ns in [i64::MIN, i64::MIN, device_ns] {
            bytes.extend(time_ns.to_le_bytes());
        }
        for number in numbers {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([1, 0, 0, 0, 0, 0, 0, 0]);
        self.frame(2, &bytes)
    }

    /// The next message of that kind; `None` once the connection is over.
    pub fn heard(&mut self, what: &str) -> Option<Value> {
        let patience = Patience::new();
        loop {
            patience.check(what);
            let mut head = [0; 2];
            self.0.read_exact(&mut head).ok()?;
            let length = match head[1] {
                126 => {
                    let mut long = [0; 2];
                    self.0.read_exact(&mut long).ok()?;
                    usize::from(u16::from_be_bytes(long))
                }
                127 => panic!("a long message"),
                short => usize::from(short),
            };
            let mut data = vec![0; length];
            self.0.read_exact(&mut data).ok()?;
            match head[0] & 0x0f {
                1 => {
                    let said: Value = serde_json::from_slice(&data).expect("json");
                    if said["what"] == what {
                        return Some(said);
                    }
                }
                9 => {
                    self.frame(10, &data);
                }
                8 if what == "close" => {
                    return Some(json!(String::from_utf8_lossy(&data[2.min(length)..])));
                }
                _ => {}
            }
        }
    }

    pub fn hear(&mut self, what: &str) -> Value {
        self.heard(what).unwrap_or_else(|| panic!("no {what}"))
    }
}

/// What the recording has, with times since its first pose [ns].
fn performance() -> Vec<(i64, Option<[f64; 7]>)> {
    let recording = Recording::open(RECORDING.as_ref()).expect("the recording");
    let toml = std::fs::read_to_string(SCENE).expect("the scene");
    let scene = scene_from_toml(&toml).expect("a scene");
    let events = recording.take(&scene).expect("a take").events;
    let mut acted: Vec<(i64, Option<[f64; 7]>)> = events
        .iter()
        .map(|event| match event {
            TakeEvent::Pose { sample, .. } => {
                let ([x, y, z], [a, b, c, d]) = (sample.position_m.into(), sample.quaternion_xyzw);
                (sample.stamp.0, Some([x, y, z, a, b, c, d]))
            }
            TakeEvent::Mark(mark) => (mark.stamp.0, None),
        })
        .collect();
    acted.sort_by_key(|(at, _)| *at);
    let first = acted[0].0;
    for (at, _) in &mut acted {
        *at -= first;
    }
    acted
}

#[test]
fn a_page_acts_a_take_and_is_given_its_verdict_and_its_motion() {
    let house = House::new();
    let (mut daemon, url) = begin(&house, &[]);
    assert!(get(&url, "/act").1.starts_with("<!doctype html>"));
    let scene = exchange(
        &url,
        b"GET /act/scene.glb HTTP/1.1\r\nHost: localhost\r\n\r\n",
    );
    assert!(scene.contains("model/gltf-binary") && scene.contains("glTF"));
    let mut page = ActingPage::open(&url);
    page.say(&json!({"say": "pair", "code": code(&daemon)}));
    let paired = page.hear("paired");
    assert_eq!(paired["streams"][0]["topic"], "/tracker/pencil/pose");
    assert_eq!(paired["streams"][0]["body"], "pencil");
    assert_eq!(paired["events"], json!(["bounce", "landing"]));
    let place = &paired["streams"][0]["position_m"];
    assert!(
        (place[0].as_f64().expect("x") - 0.012).abs() < 1e-12,
        "{place}"
    );
    page.say(&json!({"say": "act", "stream": 0}));
    page.say(&json!({"say": "start"}));
    daemon.wait_for("started");
    // As it was acted, on a clock of the page's own.
    let begun = Instant::now();
    let device_ns = 5_000_000_000;
    let mut sequence = 0;
    for (at_ns, reading) in performance() {
        let at = Duration::from_nanos(at_ns as u64);
        std::thread::sleep(at.saturating_sub(begun.elapsed()));
        match reading {
            Some(numbers) => {
                assert!(page.reading(sequence, device_ns + at_ns, numbers));
                sequence += 1;
            }
            // Marks come late, and are put where they belong.
            None => page.say(&json!({"say": "mark", "device_ns": device_ns + at_ns})),
        }
    }
    page.say(&json!({"say": "stop", "name": "by a page", "rating": 4}));
    let closed = daemon.wait_for("closed");
    assert_eq!(closed["messages"], POSES + MARKS);
    let tracker = &closed["counts"]["trackers"][0];
    assert_eq!(tracker["counts"]["missing"], 0);
    assert_eq!(tracker["clock"]["source"], "device");
    assert_eq!(closed["label"]["name"], "by a page");
    let estimated = daemon.wait_for("estimated");
    assert_eq!(estimated["report"]["verdict"], "physical", "{estimated}");
    let patience = Patience::new();
    loop {
        patience.check("a motion");
        let state = page.hear("state");
        let last = &state["takes"][0];
        // The motion so far is there before the verdict.
        if last["has_motion"] == true && last["is_good"] != Value::Null {
            assert_eq!(last["state"], "physical");
            assert_eq!(last["so_far"], "physical");
            break;
        }
    }
    let motion = exchange(
        &url,
        b"GET /motion/1.glb HTTP/1.1\r\nHost: localhost\r\n\r\n",
    );
    assert!(motion.contains("pencil acted"), "the ghost");
    assert_eq!(get(&url, "/motion/2.glb").0, 404);
    // Back with its key, it has its stream at once.
    let key = paired["key"].as_str().expect("a key").to_owned();
    let mut again = ActingPage::open(&url);
    again.say(&json!({"say": "resume", "key": key}));
    again.hear("paired");
    again.say(&json!({"say": "act", "stream": 0}));
    // A refusal says that what was said before was heard.
    again.say(&json!({"say": "mark", "event": "no such", "device_ns": 0}));
    again.hear("refused");
    assert!(again.reading(0, device_ns, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]));
    assert!(page.reading(sequence, device_ns, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]));
    let refused = page.hear("refused");
    assert!(
        refused["why"]
            .as_str()
            .expect("why")
            .contains("not the tracker")
    );
    daemon.end();
}

#[test]
fn hostile_pages_change_nothing_of_a_take_that_runs() {
    let house = House::new();
    let (mut daemon, url) = begin(&house, &[]);
    let host = url.split("//").nth(1).expect("an address").to_owned();
    // One that was let in, and one that will be half-open: it neither reads nor answers any more.
    let mut page = ActingPage::open(&url);
    page.say(&json!({"say": "pair", "code": code(&daemon)}));
    page.hear("paired");
    let silent = ActingPage::paired(&url, &code(&daemon));
    let tracker = house.spawn_tracker(&[RECORDING, "--take", "--rate", "1", "--now"]);
    daemon.wait_for("started");
    // Pages of strangers, of nobody, and one that has made a name lead here.
    for (host, origin, expected) in [
        (host.as_str(), Some("http://evil.example"), 403),
        (host.as_str(), Some("https://app.foxglove.dev"), 403),
        (host.as_str(), Some("null"), 403),
        (host.as_str(), None, 403),
        ("evil.example", Some("http://evil.example"), 421),
    ] {
        let answer = exchange(&url, request(host, origin).as_bytes());
        assert_eq!(status(&answer), expected, "{origin:?}: {answer}");
    }
    // One that guesses, and one that does not ask.
    let wrong = match code(&daemon).as_str() {
        "000000" => "000001",
        _ => "000000",
    };
    for first in [
        json!({"say": "pair", "code": wrong}),
        json!({"say": "stop"}),
        json!({"say": "discard"}),
        json!({"say": "resume", "key": "0".repeat(32)}),
    ] {
        let mut page = ActingPage::open(&url);
        page.say(&first);
        page.say(&json!({"say": "act", "stream": 0}));
        page.say(&json!({"say": "discard"}));
        page.reading(0, 0, [0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 1.0]);
        page.hear("refused");
        assert_eq!(page.heard("state"), None, "{first}");
    }
    // The one that was let in is not the tracker of what a tracker sends; what it floods is not taken.
    wait(&url, "the tracker is heard", |now| {
        now["status"]["trackers"][0]["state"] == "sending"
    });
    page.say(&json!({"say": "act", "stream": 0}));
    let refused = page.hear("refused");
    let why = refused["why"].as_str().expect("why");
    assert!(
        why.contains("acts with this tracker") || why.contains("sends there already"),
        "{why}"
    );
    let mut number = 0;
    while number < 100_000 && page.reading(number, 0, [0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 1.0]) {
        number += 1;
    }
    let closed = daemon.wait_for("closed");
    assert_eq!(closed["messages"], POSES + MARKS);
    let counts = &closed["counts"]["trackers"][0]["counts"];
    for what in ["missing", "invalid", "restarts", "duplicated"] {
        assert_eq!(counts[what], 0, "{what}: {counts}");
    }
    let estimated = daemon.wait_for("estimated");
    assert_eq!(estimated["report"]["verdict"], "physical");
    assert!(ended(tracker).status.success());
    drop(silent);
    daemon.end();
}

#[test]
fn a_flood_of_a_page_that_was_let_in_ends_with_its_connection() {
    let house = House::new();
    let (mut daemon, url) = begin(&house, &[]);
    let mut page = ActingPage::paired(&url, &code(&daemon));
    page.say(&json!({"say": "start"}));
    daemon.wait_for("started");
    let mut sent = 0;
    while sent < 200_000 && page.reading(sent, sent as i64, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]) {
        sent += 1;
    }
    assert!(sent < 200_000, "it is not sent away");
    // The take goes on, and who directs it ends it.
    assert_eq!(state(&url)["status"]["take"], 1);
    assert_eq!(get(&url, "/health").0, 200);
    assert_eq!(house.take(&["stop"]).0, Some(0));
    let closed = daemon.wait_for("closed");
    let messages = closed["messages"].as_u64().expect("a number");
    assert!(messages < 10_000, "{messages}");
    daemon.end_with(daemon_code(&closed));
}

/// What a daemon ends with after that take: 3 where readings of it are missing.
fn daemon_code(closed: &Value) -> i32 {
    match closed["counts"]["trackers"][0]["counts"]["missing"].as_u64() {
        Some(0) => 0,
        _ => 3,
    }
}

#[test]
fn a_half_open_page_is_sent_away_and_its_stream_is_free() {
    let house = House::new();
    let (mut daemon, url) = begin(&house, &[]);
    let code = code(&daemon);
    let mut page = ActingPage::paired(&url, &code);
    page.say(&json!({"say": "start"}));
    daemon.wait_for("started");
    page.reading(0, 0, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    // It does not read, nor answer pings.
    let patience = Patience::new();
    loop {
        patience.check("the stream is free");
        let mut next = ActingPage::paired(&url, &code);
        next.say(&json!({"say": "mark", "event": "no such", "device_ns": 0}));
        let refused = next.hear("refused");
        if refused["why"].as_str().expect("why").contains("no such") {
            break;
        }
        assert_eq!(refused["why"], "another page acts with this tracker");
        std::thread::sleep(Duration::from_millis(500));
    }
    assert_eq!(state(&url)["status"]["take"], 1);
    assert_eq!(house.take(&["discard"]).0, Some(0));
    daemon.end();
}

#[test]
fn without_the_page_it_is_said_how_to_get_it() {
    let house = House::new();
    let (takes, missing) = (house.folder().to_owned(), house.folder().join("none.html"));
    let acting = format!("--acting={}", missing.display());
    let output = house.enact_with_iceoryx2(&["capture", SCENE, "-o", house.text(&takes), &acting]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("none.html"), "{said}");
    let mut daemon = Daemon::start(&house, SCENE, &["--metrics-port", "0"]);
    let url = daemon.ready["metrics"].as_str().expect("served").to_owned();
    let (status, said) = get(&url, "/act");
    assert!(status == 404 && said.contains("--acting"), "{said}");
    assert_eq!(get(&url, "/act/socket").0, 404);
    assert!(daemon.ready.get("acting").is_none());
    daemon.end();
}

/// Four controllers of a page at 90 Hz beside four trackers at 500 Hz, for five seconds.
#[test]
fn controllers_and_trackers_lose_nothing_beside_each_other() {
    const CONTROLLERS: u64 = 4;
    const SPAN_S: u64 = 5;
    let house = House::new();
    let body = |number: u64| {
        format!(
            "[[body]]\nname = \"b{number}\"\nshape = {{ kind = \"sphere\", radius_mm = 20 }}\nmass_g = 50\n"
        )
    };
    let bodies: String = (0..8).map(body).collect();
    let scene = house.folder().join("eight.toml");
    let text = format!("name = \"eight\"\n[timing]\nstamps = \"physical\"\n{bodies}");
    let event = "[[event]]\nname = \"start\"\nkind = \"start\"\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
    std::fs::write(&scene, text + event).expect("write");
    let (mut daemon, url) = begin_with(&house, house.text(&scene), &[]);
    let mut page = ActingPage::open(&url);
    page.say(&json!({"say": "pair", "code": code(&daemon)}));
    page.hear("paired");
    for stream in 0..CONTROLLERS {
        page.say(&json!({"say": "act", "stream": stream}));
    }
    page.say(&json!({"say": "start"}));
    daemon.wait_for("started");
    let node = Node::join("trackers", Some(house.iceoryx2())).expect("a node");
    let topics: Vec<String> = (4..8)
        .map(|number| format!("/tracker/b{number}/pose"))
        .collect();
    let trackers = TrackerPublisher::open(&node, &topics, "/marks").expect("publishers");
    let begun = Instant::now();
    let (mut of_pages, mut of_trackers) = (0, 0);
    let due = |rate_hz: u64| begun.elapsed().as_nanos() as u64 * rate_hz / 1_000_000_000;
    while of_trackers < SPAN_S * 500 {
        while of_pages < due(90).min(SPAN_S * 90) {
            for stream in 0..CONTROLLERS as u32 {
                let x_m = of_pages as f64 * 1e-3;
                let at_ns = (of_pages * 1_000_000_000 / 90) as i64;
                assert!(page.reading_of(
                    stream,
                    of_pages,
                    at_ns,
                    [x_m, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
                ));
            }
            of_pages += 1;
        }
        while of_trackers < due(500).min(SPAN_S * 500) {
            for topic in 0..4 {
                let at_ns = (of_trackers * 2_000_000) as i64;
                let record = PoseRecord {
                    sequence: of_trackers,
                    available_ns: at_ns,
                    sample_ns: NO_TIME,
                    device_ns: at_ns,
                    position_m: [of_trackers as f64 * 1e-4, 0.0, 1.0],
                    quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
                    flags: 1,
                    session: 7,
                };
                trackers.pose(topic, record).expect("sent");
            }
            of_trackers += 1;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    // What was sent on the page's connection before the stop is in the take; trackers are given a while.
    std::thread::sleep(Duration::from_millis(50));
    page.say(&json!({"say": "stop"}));
    let closed = daemon.wait_for("closed");
    for (number, line) in closed["counts"]["trackers"]
        .as_array()
        .expect("lines")
        .iter()
        .enumerate()
    {
        let expected = if number < 4 { of_pages } else { of_trackers };
        assert_eq!(line["counts"]["received"], expected, "{line}");
        assert_eq!(line["counts"]["missing"], 0, "{line}");
    }
    println!(
        "{of_pages} of each of 4 controllers, {of_trackers} of each of 4 trackers: {}",
        closed["counts"]["latency_ms"]
    );
    // Its estimate is nobody's concern here.
    daemon.kill();
}
