//! Clients of sockets, byte by byte: nothing of what the daemon is made with.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::{Value, json};

use crate::harness::Patience;

/// Longer than a read takes.
const PATIENCE: Duration = Duration::from_secs(60);

pub fn connect(url: &str) -> TcpStream {
    let address = url.split("//").nth(1).expect("an address");
    let stream = TcpStream::connect(address).expect("connect");
    stream.set_read_timeout(Some(PATIENCE)).expect("set");
    stream
}

/// Sends bytes and reads until the other side closes.
pub fn exchange(url: &str, bytes: &[u8]) -> String {
    let mut stream = connect(url);
    // The other side may refuse before it has read everything.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let mut part = [0; 4096];
    let patience = Patience::new();
    loop {
        patience.check("the answer ends");
        match stream.read(&mut part) {
            Ok(0) => break,
            Ok(length) => answer.extend_from_slice(&part[..length]),
            Err(error) if error.kind() == ErrorKind::ConnectionReset => break,
            Err(error) => panic!("{error}"),
        }
    }
    String::from_utf8_lossy(&answer).into_owned()
}

/// The token in the link to the operator's page.
pub fn token(ready: &Value) -> String {
    let link = ready["page"].as_str().expect("a link");
    let (_, token) = link.split_once("/#token=").expect("a token");
    token.to_owned()
}

/// Status and body of a page.
pub fn get(url: &str, path: &str) -> (u16, String) {
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n");
    let answer = exchange(url, request.as_bytes());
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
    (status(head), body.to_owned())
}

pub fn status(answer: &str) -> u16 {
    let word = answer.split(' ').nth(1).unwrap_or_default();
    word.parse().unwrap_or(0)
}

/// The beginning of a WebSocket that asks for that protocol, on behalf of that page.
pub fn upgrade_for(origin: &str, protocol: Option<&str>) -> String {
    let request = upgrade(protocol);
    request.replacen("\r\n", &format!("\r\nOrigin: {origin}\r\n"), 1)
}

/// Status and body of the answer to an order in JSON, on behalf of that page, of one who knows that token.
pub fn order(url: &str, origin: Option<&str>, token: Option<&str>, json: &str) -> (u16, String) {
    let host = url.split("//").nth(1).expect("an address");
    let origin = origin.map_or(String::new(), |origin| format!("Origin: {origin}\r\n"));
    let token = token.map_or(String::new(), |token| {
        format!("Authorization: Bearer {token}\r\n")
    });
    let length = json.len();
    let request = format!(
        "POST /take HTTP/1.1\r\nHost: {host}\r\n{origin}{token}Content-Length: {length}\r\n\r\n{json}"
    );
    let answer = exchange(url, request.as_bytes());
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
    (status(head), body.to_owned())
}

/// The beginning of a WebSocket that asks for that protocol.
pub fn upgrade(protocol: Option<&str>) -> String {
    let protocol = protocol.map_or(String::new(), |protocol| {
        format!("Sec-WebSocket-Protocol: {protocol}\r\n")
    });
    format!(
        "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n{protocol}\r\n"
    )
}

/// A viewer.
pub struct Viewer {
    stream: TcpStream,
    /// Topics by the numbers of their channels.
    pub topics: Vec<(u64, String)>,
}

/// A message of a subscribed topic.
pub struct Message {
    pub topic: String,
    pub data: Vec<u8>,
}

impl Viewer {
    /// Connects and waits until that many topics are advertised.
    pub fn new(url: &str, topics: usize) -> Self {
        Self::open(url, topics).unwrap_or_else(|head| panic!("{head}"))
    }

    /// The same where it may be refused: with that head.
    pub fn open(url: &str, topics: usize) -> Result<Self, String> {
        let mut stream = connect(url);
        let request = upgrade(Some("foxglove.sdk.v1"));
        stream.write_all(request.as_bytes()).expect("write");
        let mut head = Vec::new();
        let patience = Patience::new();
        while !head.ends_with(b"\r\n\r\n") {
            patience.check("a head");
            let mut byte = [0];
            if let Err(error) = stream.read_exact(&mut byte) {
                return Err(error.to_string());
            }
            head.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        if status(&head) != 101 {
            return Err(head);
        }
        // The key of RFC 6455, section 1.3.
        assert!(head.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{head}");
        let mut viewer = Self {
            stream,
            topics: Vec::new(),
        };
        while viewer.topics.len() < topics {
            patience.check("topics");
            let (opcode, data) = viewer.frame();
            if opcode != 1 {
                continue;
            }
            let said: Value = serde_json::from_slice(&data).expect("json");
            if said["op"] == "advertise" {
                for channel in said["channels"].as_array().expect("channels") {
                    let id = channel["id"].as_u64().expect("number");
                    let topic = channel["topic"].as_str().expect("topic");
                    viewer.topics.push((id, topic.to_owned()));
                }
            }
        }
        Ok(viewer)
    }

    /// Subscribes to everything, each topic by the number of its channel.
    pub fn subscribe(&mut self) {
        let ids = self.topics.iter().map(|(id, _)| *id);
        let all: Vec<Value> = ids.map(|id| json!({"id": id, "channelId": id})).collect();
        let text = json!({"op": "subscribe", "subscriptions": all}).to_string();
        self.send(1, text.as_bytes());
    }

    /// Sends a frame, masked with zeros.
    pub fn send(&mut self, opcode: u8, data: &[u8]) {
        let length = u16::try_from(data.len()).expect("short");
        let mut frame = vec![0x80 | opcode, 0x80 | 126];
        frame.extend_from_slice(&length.to_be_bytes());
        frame.extend_from_slice(&[0; 4]);
        frame.extend_from_slice(data);
        self.stream.write_all(&frame).expect("write");
    }

    /// Sends bytes that need not be a frame.
    pub fn send_raw(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("write");
    }

    /// The next message of a topic.
    pub fn message(&mut self) -> Message {
        let patience = Patience::new();
        loop {
            patience.check("a message");
            let (opcode, data) = self.frame();
            // Message data: 1, number of the subscription, log time, the message.
            if opcode == 2 && data.first() == Some(&1) {
                let id = u32::from_le_bytes(data[1..5].try_into().expect("four"));
                let mut topics = self.topics.iter();
                let (_, topic) = topics.find(|(of, _)| *of == u64::from(id)).expect("known");
                return Message {
                    topic: topic.clone(),
                    data: data[13..].to_vec(),
                };
            }
        }
    }

    /// The next frame that is no ping; pings are answered, as they must be.
    fn frame(&mut self) -> (u8, Vec<u8>) {
        loop {
            let (opcode, data) = self.any_frame();
            if opcode != 9 {
                return (opcode, data);
            }
            self.send(10, &data);
        }
    }

    /// A text of the protocol with that `op`.
    pub fn text(&mut self, op: &str) -> Value {
        let patience = Patience::new();
        loop {
            patience.check(op);
            let (opcode, data) = self.frame();
            if opcode == 1 {
                let said: Value = serde_json::from_slice(&data).expect("json");
                if said["op"] == op {
                    return said;
                }
            }
        }
    }

    /// A frame of a server: not masked.
    fn any_frame(&mut self) -> (u8, Vec<u8>) {
        let mut head = [0; 2];
        self.stream.read_exact(&mut head).expect("read");
        let length = match head[1] {
            126 => {
                let mut long = [0; 2];
                self.stream.read_exact(&mut long).expect("read");
                u64::from(u16::from_be_bytes(long))
            }
            127 => {
                let mut long = [0; 8];
                self.stream.read_exact(&mut long).expect("read");
                u64::from_be_bytes(long)
            }
            short => u64::from(short),
        };
        assert!(length < 1 << 24, "a frame of {length} bytes");
        let mut data = vec![0; length as usize];
        self.stream.read_exact(&mut data).expect("read");
        (head[0] & 0x0f, data)
    }
}
