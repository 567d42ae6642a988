//! Other devices act by HTTPS: with a certificate that is kept, and nothing but acting.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};

use super::acting::{ActingPage, begin};
use super::socket::status;
use crate::harness::{Daemon, House};

/// A browser that has taken the daemon's certificate.
fn browser(house: &House, port: &str) -> StreamOwned<ClientConnection, TcpStream> {
    let pem = std::fs::read(house.data().join("enact/acting.pem")).expect("it is kept");
    let certificate = CertificateDer::from_pem_slice(&pem).expect("a certificate");
    let mut roots = RootCertStore::empty();
    roots.add(certificate).expect("it is taken");
    let config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .expect("versions")
        .with_root_certificates(roots)
        .with_no_client_auth();
    let name = ServerName::try_from("localhost").expect("a name");
    let client = ClientConnection::new(Arc::new(config), name).expect("a client");
    let stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("connect");
    let patience = Some(Duration::from_secs(60));
    stream.set_read_timeout(patience).expect("set");
    StreamOwned::new(client, stream)
}

/// What is answered, whatever ends it.
fn answer(mut stream: impl Read + Write, request: &str) -> String {
    let _ = stream.write_all(request.as_bytes());
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// The link for other devices: its port, and the pairing code.
fn link(daemon: &Daemon) -> (String, String) {
    let link = daemon.ready["https"]["link"].as_str().expect("a link");
    let (address, code) = link.split_once("/act#code=").expect("a code");
    let (scheme, address) = address.split_once("://").expect("a scheme");
    assert_eq!(scheme, "https");
    let (_, port) = address.rsplit_once(':').expect("a port");
    (port.to_owned(), code.to_owned())
}

#[test]
fn another_device_acts_by_https_and_finds_nothing_else() {
    let house = House::new();
    let (mut daemon, url) = begin(&house, &["--https=0"]);
    let (port, code) = link(&daemon);
    let host = format!("localhost:{port}");
    let get = |path: &str| {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        answer(browser(&house, &port), &request)
    };
    let page = get("/act");
    assert!(
        status(&page) == 200 && page.contains("<title>acting</title>"),
        "{page}"
    );
    assert_eq!(status(&get("/act/scene.glb")), 200);
    for path in [
        "/",
        "/state",
        "/health",
        "/metrics",
        "/picture/1.svg",
        "/take",
    ] {
        assert_eq!(status(&get(path)), 404, "{path}");
    }
    let order = format!("POST /take HTTP/1.1\r\nHost: {host}\r\nContent-Length: 2\r\n\r\n{{}}");
    assert_eq!(status(&answer(browser(&house, &port), &order)), 404);
    let other = "GET /act HTTP/1.1\r\nHost: evil.example\r\n\r\n";
    assert_eq!(status(&answer(browser(&house, &port), other)), 421);
    // Who does not speak TLS is told nothing, whatever it says.
    for said in [
        "GET /act HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "\u{16}\u{3}\u{1}",
        "",
    ] {
        let stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("connect");
        let heard = answer(stream, said);
        assert!(
            !heard.contains("HTTP") && !heard.contains("acting"),
            "{heard}"
        );
    }
    let mut page = ActingPage::on(browser(&house, &port), &format!("https://{host}"));
    page.pair(&code);
    page.say(&json!({"say": "start"}));
    daemon.wait_for("started");
    for sequence in 0..10 {
        let device_ns = 5_000_000_000 + 10_000_000 * sequence as i64;
        assert!(page.reading(sequence, device_ns, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]));
    }
    page.say(&json!({"say": "stop"}));
    let closed = daemon.wait_for("closed");
    assert_eq!(closed["messages"], 10);
    drop(page);
    assert_eq!(super::get(&url, "/health").0, 200);
    daemon.end();
}

#[test]
fn its_certificate_is_the_same_the_next_day_and_its_code_is_not() {
    let house = House::new();
    let said = [0, 1].map(|_| {
        let (mut daemon, _) = begin(&house, &["--https=0"]);
        let (_, code) = link(&daemon);
        let fingerprint = daemon.ready["https"]["fingerprint"].clone();
        daemon.end();
        (fingerprint, code)
    });
    let [(first, code), (second, next_code)] = &said;
    assert_eq!(first, second);
    assert_ne!(code, next_code);
    let bytes = first.as_str().expect("a text").split(':');
    assert_eq!(bytes.count(), 32);
}

#[test]
fn without_the_acting_page_there_is_nothing_to_serve() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    let output = command.args(["capture", super::SCENE, "--https"]).output();
    assert_eq!(output.expect("it runs").status.code(), Some(2));
}
