//! Subscribers that die, services that others made, users without rights.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use enact::ingest::live::{Node, PoseRecord, Quality};
use enact::wire::live::{EstimateRecord, LiveService, TakeRecord};
use iceoryx2::prelude::{Config, FilePath, NodeBuilder, SemanticString, SignalHandlingMode};

use crate::harness::{Daemon, House, LIFETIME, Patience};
pub use crate::skip::skip;

const PENCIL: &str = "recordings/pencil_tip.mcap";
const SCENE: &str = "config/pencil_tip.toml";

/// Not a test: who hears estimates, when a test starts this binary again as another process.
#[test]
#[ignore = "a process of other tests"]
fn listener_process() {
    let Ok(line) = std::env::var("ENACT_TEST_LISTENER") else {
        return;
    };
    let (manner, iceoryx2) = line.split_once('\n').expect("two lines");
    if manner == "deaf" {
        return deaf(Path::new(iceoryx2));
    }
    let node = Node::join("listener", Some(Path::new(iceoryx2))).expect("node");
    let estimates = node.service::<EstimateRecord>("enact/estimate", Quality::NOTES);
    let estimates = estimates.expect("service").factory;
    let estimates = estimates.subscriber_builder().create().expect("port");
    println!("\nlistening");
    let begun = Instant::now();
    while begun.elapsed() < LIFETIME {
        while let Some(sample) = estimates.receive().expect("receive") {
            println!("{} {}", sample.take, sample.is_final);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Makes the services of estimates and takes without overflow, where a publisher may wait for
/// its subscriber, holds a full buffer of one, and never looks at it.
fn deaf(iceoryx2: &Path) {
    let file = FilePath::new(iceoryx2.to_str().expect("UTF-8").as_bytes()).expect("path");
    let config = Config::from_file(&file).expect("config");
    let node = NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<LiveService>()
        .expect("node");
    let name = |name: &str| name.try_into().expect("name");
    let estimates = node
        .service_builder(&name("enact/estimate"))
        .publish_subscribe::<EstimateRecord>()
        .enable_safe_overflow(false)
        .subscriber_max_buffer_size(1)
        .create()
        .expect("service");
    let takes = node
        .service_builder(&name("enact/take"))
        .publish_subscribe::<TakeRecord>()
        .enable_safe_overflow(false)
        .subscriber_max_buffer_size(1)
        .create()
        .expect("service");
    let _estimates = estimates.subscriber_builder().create().expect("port");
    let _takes = takes.subscriber_builder().create().expect("port");
    println!("\nlistening");
    std::thread::sleep(LIFETIME);
}

/// A process that listens, until it is killed.
struct Listener {
    child: Child,
    said: Receiver<String>,
}

impl Listener {
    /// Starts one and waits until it listens.
    fn start(house: &House, manner: &str) -> Self {
        let mut child = Command::new(std::env::current_exe().expect("this binary"))
            .args(["--ignored", "--exact", "capture::peers::listener_process"])
            .arg("--nocapture")
            .env(
                "ENACT_TEST_LISTENER",
                format!("{manner}\n{}", house.text(house.iceoryx2())),
            )
            .stdout(Stdio::piped())
            .spawn()
            .expect("spawn");
        let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let (sender, said) = channel();
        std::thread::spawn(move || {
            let mut lines = lines.map_while(Result::ok);
            while lines.next().is_some_and(|line| sender.send(line).is_ok()) {}
        });
        let listener = Self { child, said };
        listener.find(|line| (line == "listening").then_some(()));
        listener
    }

    /// The first thing that it says of which something can be made.
    fn find<T>(&self, of: impl Fn(&str) -> Option<T>) -> T {
        let patience = Patience::new();
        loop {
            patience.check("a listener hears");
            let line = self.said.recv_timeout(Duration::from_secs(60));
            if let Some(found) = of(&line.expect("it lives, and hears")) {
                return found;
            }
        }
    }

    /// The take whose final estimate comes next.
    fn next_final(&self) -> Option<u64> {
        Some(self.find(|line| line.strip_suffix(" 1")?.parse().ok()))
    }

    /// As kill -9 does.
    fn kill(&mut self) {
        self.child.kill().expect("kill");
        self.child.wait().expect("wait");
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Plays a take; which one was estimated.
fn take(house: &House, daemon: &mut Daemon) -> Option<u64> {
    house.tracker(&[PENCIL, "--take", "--rate", "0"]);
    daemon.wait_for("estimated")["take"].as_u64()
}

#[test]
fn a_killed_subscriber_and_its_successors_do_not_disturb_the_daemon() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let mut first = Listener::start(&house, "hears");
    assert_eq!(take(&house, &mut daemon), Some(1));
    assert_eq!(first.next_final(), Some(1));
    first.kill();
    // While the dead one is still on the service.
    assert_eq!(take(&house, &mut daemon), Some(2));
    let second = Listener::start(&house, "hears");
    assert_eq!(take(&house, &mut daemon), Some(3));
    assert_eq!(second.next_final(), Some(3));
    // As many as there are places, all killed: their places are given back.
    let places = Quality::NOTES.subscribers - 1;
    let mut crowd: Vec<Listener> = (0..places)
        .map(|_| Listener::start(&house, "hears"))
        .collect();
    crowd.iter_mut().for_each(Listener::kill);
    daemon.wait_until_cleared(Duration::from_secs(20));
    let third = Listener::start(&house, "hears");
    assert_eq!(take(&house, &mut daemon), Some(4));
    assert_eq!(third.next_final(), Some(4));
    assert_eq!(second.next_final(), Some(4));
    daemon.end();
}

#[test]
fn a_deaf_subscriber_on_a_service_that_may_block_holds_up_nobody_dead_or_alive() {
    let house = House::new();
    let mut deaf = Listener::start(&house, "deaf");
    let output = house.enact_with_iceoryx2(&["doctor"]);
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(text.contains("safe overflow is off"), "{text}");
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    // Its buffers are full from the first take on. Ours, of one too, are read.
    assert_eq!(take(&house, &mut daemon), Some(1));
    assert_eq!(take(&house, &mut daemon), Some(2));
    deaf.kill();
    assert_eq!(take(&house, &mut daemon), Some(3));
    daemon.end();
}

/// What a doctor says of the scene, with its exit code.
fn doctor(house: &House) -> (String, Option<i32>) {
    let output = house.enact_with_iceoryx2(&["doctor", SCENE]);
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    (text, output.status.code())
}

#[test]
fn a_doctor_sees_lesser_services_and_other_payloads() {
    let house = House::new();
    let node = Node::join("peer", Some(house.iceoryx2())).expect("node");
    let topic = "enact/tracker/pencil/pose";
    {
        let small = Quality {
            buffer: 2,
            ..Quality::POSES
        };
        let _theirs = node.service::<PoseRecord>(topic, small).expect("service");
        let (text, code) = doctor(&house);
        assert!(
            text.contains("buffer of a subscriber: 2, wanted 2048"),
            "{text}"
        );
        assert_eq!(code, Some(3), "{text}");
    }
    let _theirs = node
        .service::<TakeRecord>(topic, Quality::NOTES)
        .expect("service");
    let (text, code) = doctor(&house);
    assert!(
        text.contains("carries enact.Take.1, wanted enact.Pose.1"),
        "{text}"
    );
    assert_eq!(code, Some(1), "{text}");
}

#[test]
fn a_doctor_sees_what_iceoryx2_hides_because_another_version_made_it() {
    let house = House::new();
    let node = Node::join("peer", Some(house.iceoryx2())).expect("node");
    let topic = "enact/tracker/pencil/pose";
    let _theirs = node
        .service::<PoseRecord>(topic, Quality::POSES)
        .expect("service");
    // There is one version of iceoryx2 here: the file is made to say another.
    let services = house.iceoryx2().with_file_name("iceoryx2").join("services");
    let mut files = std::fs::read_dir(services).expect("list");
    let file = files.next().expect("a service").expect("entry").path();
    let text = std::fs::read_to_string(&file).expect("read");
    let other = text.replacen("minor = 10", "minor = 9", 1);
    assert_ne!(text, other);
    std::fs::remove_file(&file).expect("remove");
    std::fs::write(&file, other).expect("write");
    let (text, code) = doctor(&house);
    let line = text.lines().find(|line| line.contains(topic));
    let line = line.unwrap_or_else(|| panic!("{text}"));
    assert!(line.contains("made by iceoryx2 0.9.0"), "{line}");
    assert_eq!(code, Some(1), "{text}");
    let said = house.daemon_fails(SCENE);
    assert!(
        said.contains(topic) && said.contains("VersionMismatch"),
        "{said}"
    );
}

#[test]
fn a_user_without_rights_is_told_so() {
    let house = House::new();
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let Some(output) = house.enact_as_nobody(&["doctor", SCENE]) else {
        skip(
            "a_user_without_rights_is_told_so",
            "we cannot be another user",
        );
        return;
    };
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("Run all as one user"), "{text}");
    // What it may not see it says nothing of.
    assert!(!text.contains("enact/"), "{text}");
    let takes = house.text(house.folder());
    let output = house
        .enact_as_nobody(&["capture", SCENE, "-o", takes])
        .expect("once more");
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("enact doctor"), "{error}");
    daemon.end();
}
