use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use super::*;
use crate::ingest::live::PoseRecord;

/// Runs a property on so many cases.
fn check<S: Strategy>(cases: u32, strategy: S, property: impl Fn(S::Value)) {
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    let ran = TestRunner::new(config).run(&strategy, |value| {
        property(value);
        Ok(())
    });
    ran.unwrap_or_else(|error| panic!("{error}"));
}

/// A reply that HTTP allows: a status, its headers, and a body as long as they say.
fn status(sent: &[u8]) -> u16 {
    let end = sent.windows(4).position(|of| of == b"\r\n\r\n");
    let end = end.expect("the end of the head");
    let head = std::str::from_utf8(&sent[..end]).expect("text");
    let length = head.split("\r\n").find_map(|line| {
        let (name, value) = line.split_once(": ")?;
        (name == "Content-Length").then(|| value.parse::<usize>().expect("a number"))
    });
    assert_eq!(length, Some(sent.len() - end - 4), "{head}");
    let rest = head.strip_prefix("HTTP/1.1 ").expect("HTTP");
    rest[..3].parse().expect("a status")
}

fn is_asked(ports: &Ports, bytes: &[u8]) -> u16 {
    let met = ports.asks(bytes);
    assert!(met.taken <= REQUEST_BYTES, "{} bytes", met.taken);
    let status = status(&met.sent);
    let known = [200, 202, 400, 403, 404, 405, 409, 411, 413, 421, 431];
    assert!(known.contains(&status), "{status}");
    assert_eq!(met.orders > 0, status == 202, "{} orders", met.orders);
    status
}

/// What a browser, a program or somebody who tries it out would say, and what they would not.
fn request() -> impl Strategy<Value = Vec<u8>> {
    let method = prop::sample::select(vec!["GET", "POST", "DELETE", "get", "", "G\0T", "PRI *"]);
    let path = prop_oneof![
        prop::sample::select(vec![
            "/",
            "/state",
            "/take",
            "/health",
            "/metrics",
            "/take?x",
            "*",
            "/picture/1.svg",
            "/picture/99999999999999999999.svg",
            "/picture/",
            "/picture/1.svg/..",
            "/motion/1.glb",
            "/act",
            "/act/socket",
            "/act/scene.glb",
        ])
        .prop_map(str::to_owned),
        "/[ -~]{0,40}",
        "\\PC{0,40}",
    ];
    let names = vec![
        "Host",
        "Origin",
        "Content-Length",
        "Authorization",
        "X",
        "host",
        "",
    ];
    let name = prop::sample::select(names);
    let value = prop_oneof![
        prop::sample::select(vec![
            "127.0.0.1:9464",
            "http://127.0.0.1:9464",
            "Bearer 000102030405060708090a0b0c0d0e0f",
            "Bearer 0",
            "0",
            "19",
            "8192",
            "8193",
            "-1",
            "18446744073709551616",
            "\u{fc}",
        ])
        .prop_map(str::to_owned),
        "[ -~]{0,60}",
    ];
    let headers = prop::collection::vec((name, value), 0..70);
    let body = prop_oneof![
        Just(br#"{"command":"start"}"#.to_vec()),
        Just(br#"{"command":"stop","name":"x","rating":4}"#.to_vec()),
        prop::collection::vec(any::<u8>(), 0..200),
    ];
    (method, path, headers, body).prop_map(|(method, path, headers, body)| {
        let mut text = format!("{method} {path} HTTP/1.1\r\n");
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        text += "\r\n";
        [text.into_bytes(), body].concat()
    })
}

#[test]
fn whatever_is_asked_is_answered_and_little_of_it_is_kept() {
    for runs in [false, true] {
        let ports = Ports::new(runs);
        check(300, prop::collection::vec(any::<u8>(), 0..2000), |bytes| {
            is_asked(&ports, &bytes);
        });
        check(600, request(), |bytes| {
            is_asked(&ports, &bytes);
        });
        // Half of a request is a request that has an end.
        check(
            200,
            (request(), any::<prop::sample::Index>()),
            |(bytes, at)| {
                is_asked(&ports, &bytes[..at.index(bytes.len())]);
            },
        );
    }
}

/// One who says no end of anything is answered once it is too much.
#[test]
fn requests_without_end_are_cut_off() {
    let ports = Ports::new(false);
    let own = format!(
        "Host: 127.0.0.1:9464\r\nOrigin: http://127.0.0.1:9464\r\nAuthorization: Bearer {TOKEN}\r\n"
    );
    let long = |start: &str, more: &str, bytes: usize| {
        let mut text = start.to_owned();
        while text.len() < bytes {
            text += more;
        }
        text.into_bytes()
    };
    for (bytes, expected) in [
        (long("GET / HTTP/1.1\r\nX: ", "x", 1 << 20), 431),
        (long("GET /", "x", 1 << 20), 431),
        (long("GET / HTTP/1.1\r\n", "X: y\r\n", 1 << 20), 431),
        (
            long(
                &format!("POST /take HTTP/1.1\r\n{own}Content-Length: 8193\r\n\r\n"),
                " ",
                1 << 20,
            ),
            413,
        ),
        (
            long(
                &format!("POST /take HTTP/1.1\r\n{own}Content-Length: 8192\r\n\r\n"),
                " ",
                1 << 20,
            ),
            400,
        ),
        // Less than was announced.
        (
            long(
                &format!("POST /take HTTP/1.1\r\n{own}Content-Length: 8192\r\n\r\n"),
                " ",
                4000,
            ),
            400,
        ),
    ] {
        assert_eq!(is_asked(&ports, &bytes), expected);
    }
    let order = r#"{"command":"start"}"#;
    let length = order.len();
    let start = format!("POST /take HTTP/1.1\r\n{own}Content-Length: {length}\r\n\r\n{order}");
    assert_eq!(is_asked(&ports, start.as_bytes()), 202);
    assert_eq!(is_asked(&Ports::new(true), start.as_bytes()), 409);
}

/// A frame of a viewer.
fn frame(first: u8, said_length: u64, is_masked: bool, data: &[u8]) -> Vec<u8> {
    let mask = if is_masked { 0x80 } else { 0 };
    let mut frame = vec![first];
    match said_length {
        0..126 => frame.push(mask | said_length as u8),
        126..0x1_0000 => {
            frame.push(mask | 126);
            frame.extend((said_length as u16).to_be_bytes());
        }
        _ => {
            frame.push(mask | 127);
            frame.extend(said_length.to_be_bytes());
        }
    }
    if is_masked {
        // A mask of zeros changes nothing.
        frame.extend([0; 4]);
    }
    [frame, data.to_vec()].concat()
}

fn said() -> impl Strategy<Value = Vec<u8>> {
    let numbers = prop::collection::vec((any::<u32>(), 0..20u32), 0..50);
    let subscribe = numbers.prop_map(|pairs| {
        let each = pairs
            .iter()
            .map(|(id, channel)| format!(r#"{{"id":{id},"channelId":{channel}}}"#));
        let all = each.collect::<Vec<_>>().join(",");
        format!(r#"{{"op":"subscribe","subscriptions":[{all}]}}"#)
    });
    let ids = prop::collection::vec(0..20u32, 0..50);
    let unsubscribe =
        ids.prop_map(|ids| format!(r#"{{"op":"unsubscribe","subscriptionIds":{ids:?}}}"#));
    let all = r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":1},{"id":1,"channelId":2},{"id":2,"channelId":1}]}"#;
    prop_oneof![
        3 => subscribe.prop_map(String::into_bytes),
        2 => unsubscribe.prop_map(String::into_bytes),
        1 => Just(all.as_bytes().to_vec()),
        1 => Just(br#"{"op":"advertise","channels":[]}"#.to_vec()),
        1 => Just(vec![b'['; 5000]),
        1 => prop::collection::vec(any::<u8>(), 0..300),
        1 => prop::collection::vec(any::<u8>(), 8000..9000),
    ]
}

fn frames() -> impl Strategy<Value = Vec<u8>> {
    let opcode = prop_oneof![
        4 => Just(0x81u8),
        1 => prop::sample::select(vec![0x01u8, 0x00, 0x80, 0x82, 0x88, 0x89, 0x8a]),
        1 => any::<u8>(),
    ];
    let lie = prop_oneof![
        8 => Just(None),
        1 => any::<u64>().prop_map(Some),
        1 => (0..300u64).prop_map(Some),
    ];
    let one = (opcode, said(), lie, prop::bool::weighted(0.95));
    let one = one.prop_map(|(first, data, lie, is_masked)| {
        // Control frames are short.
        let data = match first & 0x08 {
            0 => &data[..],
            _ => &data[..data.len().min(125)],
        };
        frame(first, lie.unwrap_or(data.len() as u64), is_masked, data)
    });
    prop::collection::vec(one, 0..12).prop_map(|frames| frames.concat())
}

/// Whatever viewers send, their connections end, and nothing of them stays.
#[test]
fn whatever_viewers_send_they_go_without_a_trace() {
    let ports = Ports::new(false);
    let watched = |first: &[u8], then: &[u8]| {
        let met = ports.watches(first, then);
        assert!(ports.is_empty(), "something of a viewer is left");
        met
    };
    check(200, prop::collection::vec(any::<u8>(), 0..2000), |bytes| {
        let met = watched(&bytes, &[]);
        assert!(!met.sent.starts_with(b"HTTP/1.1 101"));
    });
    check(300, request(), |bytes| {
        watched(&bytes, &[]);
    });
    let garbage = prop::collection::vec(any::<u8>(), 0..2000);
    check(300, prop_oneof![garbage, frames()], |bytes| {
        let met = watched(HANDSHAKE, &bytes);
        assert!(met.sent.starts_with(b"HTTP/1.1 101"));
    });
    check(600, frames(), |bytes| {
        watched(HANDSHAKE, &bytes);
    });
    // A handshake without end.
    let endless = [&HANDSHAKE[..HANDSHAKE.len() - 2], &vec![b'x'; 1 << 20]].concat();
    let met = watched(&endless, &[]);
    assert!(met.taken <= HANDSHAKE_BYTES, "{} bytes", met.taken);
}

/// One who subscribes is sent what is shown; else the properties above would show nothing.
#[test]
fn a_viewer_that_subscribes_is_served() {
    let ports = Ports::new(false);
    let text = br#"{"op":"subscribe","subscriptions":[{"id":77,"channelId":1}]}"#;
    // Pongs do no harm, and give the server time to show something.
    let pong = frame(0x8a, 100, true, &[0; 100]);
    let said = [frame(0x81, text.len() as u64, true, text), pong.repeat(50)].concat();
    let met = ports.watches(HANDSHAKE, &said);
    let message = [&[1, 77, 0, 0, 0][..]].concat();
    let is_sent = met.sent.windows(message.len()).any(|of| of == message);
    assert!(is_sent, "{} bytes", met.sent.len());
}

/// One who pings, or anything else that is answered, and reads nothing, is listened to no more.
#[test]
fn answers_that_nobody_reads_do_not_gather() {
    let ports = Ports::new(false);
    let ping = frame(0x89, 125, true, &[b'x'; 125]);
    let most = 16 << 20;
    let taken = ports.floods(&ping, most);
    assert!(taken < 64 << 10, "{taken} bytes of pings were taken");
    assert!(ports.is_empty());
    // What needs no answer is taken for ever.
    let pong = frame(0x8a, 125, true, &[b'x'; 125]);
    assert!(ports.floods(&pong, 1 << 20) >= 1 << 20);
}

/// Text frames of a page.
fn texts(said: &[&str]) -> Vec<u8> {
    let frames = said.iter().map(|text| page_frame(1, text.as_bytes()));
    frames.collect::<Vec<_>>().concat()
}

fn paired() -> String {
    format!(r#"{{"say":"pair","code":"{CODE}"}}"#)
}

/// A message with readings of the scene's stream.
fn readings(count: u64) -> Vec<u8> {
    let mut bytes = vec![0; 8];
    for number in 0..count {
        bytes.extend(PoseRecord::numbered(number).to_bytes());
    }
    page_frame(2, &bytes)
}

#[test]
fn nothing_of_a_page_is_taken_before_the_code_and_all_of_it_after() {
    let act = r#"{"say":"act","stream":0}"#;
    let acts = |then: &[u8]| Ports::new(true).acts(ACTING_HANDSHAKE, then).orders;
    let after = |first: &[&str], rest: Vec<u8>| [texts(first), rest].concat();
    let code = paired();
    // Four readings, a mark and a stop, whose label is an order of its own.
    let rest = [
        readings(4),
        texts(&[r#"{"say":"mark","device_ns":5}"#, r#"{"say":"stop"}"#]),
    ]
    .concat();
    assert_eq!(acts(&after(&[&code, act], rest.clone())), 7);
    // Of a stream that it does not have nothing is taken.
    assert_eq!(acts(&after(&[&code], readings(4))), 0);
    for first in [
        "",
        act,
        r#"{"say":"stop"}"#,
        r#"{"say":"pair","code":"042138"}"#,
        r#"{"say":"pair","code":""}"#,
        r#"{"say":"resume","key":"00000000000000000000000000000000"}"#,
    ] {
        assert_eq!(
            acts(&after(&[first, &code, act], rest.clone())),
            0,
            "{first}"
        );
    }
    assert_eq!(acts(&[readings(1), after(&[&code, act], rest)].concat()), 0);
}

#[test]
fn a_socket_is_for_a_page_of_the_servers_own() {
    let ports = Ports::new(true);
    let asked = |from: &str, to: &str| {
        let request = String::from_utf8_lossy(ACTING_HANDSHAKE).replace(from, to);
        let sent = ports.asks(request.as_bytes()).sent;
        String::from_utf8_lossy(&sent)[9..12].to_owned()
    };
    assert_eq!(asked("", ""), "101");
    let origin = "Origin: http://localhost:9464";
    for (from, to, expected) in [
        (origin, "Origin: http://localhost:9465", "403"),
        (origin, "Origin: https://app.foxglove.dev", "403"),
        (origin, "Origin: null", "403"),
        (origin, "X: y", "403"),
        (
            origin,
            "Origin: http://localhost:9464\r\nOrigin: http://localhost:9464",
            "403",
        ),
        ("localhost:9464", "rebound.example:9464", "421"),
        ("Upgrade: websocket", "Upgrade: h2c", "400"),
        ("Version: 13", "Version: 8", "400"),
        ("Sec-WebSocket-Key", "X", "400"),
        ("GET", "POST", "404"),
    ] {
        assert_eq!(asked(from, to), expected, "{to}");
    }
}

#[test]
fn a_page_that_floods_is_sent_away_and_what_came_is_bounded() {
    let begin = texts(&[&paired(), r#"{"say":"act","stream":0}"#]);
    // The queue holds 64 here, and what finds no place in it is dropped.
    let flood = vec![readings(64); 60].concat();
    let met = Ports::new(true).acts(ACTING_HANDSHAKE, &[begin.clone(), flood].concat());
    assert!(met.orders <= 64, "{}", met.orders);
    assert!(met.taken < 400 << 10, "{} bytes", met.taken);
    let said = String::from_utf8_lossy(&met.sent).into_owned();
    assert!(
        said.contains("more readings than a tracker sends"),
        "{said}"
    );
    let chat = texts(&[r#"{"say":"mark","event":"no such","device_ns":0}"#; 200]);
    let met = Ports::new(true).acts(ACTING_HANDSHAKE, &[begin, chat].concat());
    let said = String::from_utf8_lossy(&met.sent).into_owned();
    assert!(said.contains("more messages than a page sends"), "{said}");
}

#[test]
fn whatever_a_page_says_it_goes_without_a_trace() {
    let ports = Ports::new(true);
    let frame = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..300).prop_map(|bytes| page_frame(2, &bytes)),
        "\\PC{0,60}".prop_map(|text| page_frame(1, text.as_bytes())),
        prop::collection::vec(any::<u8>(), 0..40),
        (0_u8..16, prop::collection::vec(any::<u8>(), 0..130))
            .prop_map(|(opcode, bytes)| page_frame(opcode, &bytes)),
        (1_u64..3).prop_map(readings),
    ];
    check(
        300,
        (any::<bool>(), prop::collection::vec(frame, 0..6)),
        |(knows, frames)| {
            let begin = texts(&[&paired(), r#"{"say":"act","stream":0}"#]);
            let begin = if knows { begin } else { Vec::new() };
            let met = ports.acts(ACTING_HANDSHAKE, &[begin, frames.concat()].concat());
            assert!(met.sent.starts_with(b"HTTP/1.1 101"));
            assert!(knows || met.orders == 0, "{} orders", met.orders);
        },
    );
    // It is still there for the next one, who has the stream at once.
    let next = texts(&[&paired(), r#"{"say":"act","stream":0}"#]);
    let met = ports.acts(ACTING_HANDSHAKE, &[next, readings(2)].concat());
    assert_eq!(met.orders, 2);
}
