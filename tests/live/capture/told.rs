//! What a doctor says of daemons, strangers and places.

use enact::ingest::live::Node;
use enact::write::TrackerPublisher;

use crate::harness::{Daemon, House};

const SCENE: &str = "config/pencil_tip.toml";

fn doctor(house: &House) -> (String, Option<i32>) {
    let output = house.enact_with_iceoryx2(&["doctor", SCENE]);
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    (text, output.status.code())
}

#[test]
fn a_doctor_says_who_records_who_is_a_stranger_and_which_places_are_taken() {
    let house = House::new();
    let (text, code) = doctor(&house);
    assert!(text.contains("poor  daemon: no daemon runs"), "{text}");
    assert_eq!(code, Some(3), "{text}");
    let mut daemon = Daemon::start(&house, SCENE, &[]);
    let (text, code) = doctor(&house);
    let process = format!("ok    daemon: process {} records scene", daemon.id());
    assert!(text.contains(&process), "{text}");
    let places = "enact/tracker/pencil/pose: enact.Pose.1 of 96 bytes, buffer 2048, 0 of 4 publishers, \
                  1 of 8 subscribers";
    assert!(text.contains(places), "{text}");
    assert!(
        text.contains("no tracker publishes: start its driver"),
        "{text}"
    );
    assert_eq!(code, Some(3), "{text}");
    let node = Node::join("tracker", Some(house.iceoryx2())).expect("node");
    let open = |topic: &str| {
        TrackerPublisher::open(&node, &[topic.to_owned()], "/marks").expect("publisher")
    };
    let own = open("/tracker/pencil/pose");
    let (text, code) = doctor(&house);
    assert!(text.contains("1 of 4 publishers"), "{text}");
    assert_eq!(code, Some(0), "{text}");
    let stranger = open("/tracker/Becher ü/pose");
    let (text, code) = doctor(&house);
    let said = "somebody publishes poses on \"/tracker/Becher ü/pose\", which scene \"pencil, tip first\" \
                does not have; it has /tracker/pencil/pose";
    assert!(text.contains(said), "{text}");
    assert_eq!(code, Some(3), "{text}");
    drop((own, stranger));
    let all: Vec<_> = (0..4).map(|_| open("/tracker/pencil/pose")).collect();
    let (text, code) = doctor(&house);
    assert!(
        text.contains("4 of 4 publishers") && text.contains("no place is left"),
        "{text}"
    );
    assert_eq!(code, Some(3), "{text}");
    drop(all);
    daemon.end();
}
