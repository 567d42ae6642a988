//! What the program says of waypoints: which goal is missed, where they are, which mark is absent.

use enact::motion::TakeEvent;
use enact_tools::perform::{Acting, bounces, recording};
use enact_tools::replay::Program;
use enact_tools::waypoints::{Asked, In, Kind, time_s};
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// The cube's scene file with two waypoints in its first flight and these goals, and what the program says.
fn said_of_cube(number: u64, goals: &str) -> (String, serde_json::Value) {
    let pair = Kind::Cube.pair(number).unwrap();
    let waypoints = [0.3, 0.7].map(|share| (time_s(&pair.truth, In::First, share), 0.0));
    let asked = Asked::new(
        &pair.truth,
        &Acting::timing_known(),
        8000 + number,
        &waypoints,
    );
    let scene_toml = bounces::scene_toml(&asked.case.performance.truth.scene) + goals;
    let folder = TempDir::new().unwrap();
    let written = |name: &str| {
        let path = folder.path().join(name);
        recording::write(&asked.case.performance, &scene_toml, &path).unwrap();
        path
    };
    let account = ENACT.account(&written("account.mcap"), &[]);
    let report = ENACT.report(&written("report.mcap"), &[]);
    (account.said + &account.errors, report.said)
}

/// No flight falls first and rises then: which goal is missed is said, with its waypoint.
#[test]
fn what_no_flight_does_is_no_motion_and_is_named() {
    let goal = |event: &str, speed: f64| {
        let normal = speed.signum();
        format!(
            "\n[[goal]]\nevent = {event:?}\nbody = \"cube\"\n\
             velocity_m_s = [0, 0, {speed:?}]\nnormal = [0, 0, {normal:?}]\n"
        )
    };
    for number in (0..7).step_by(4) {
        let goals = goal("way 0", -1.0) + &goal("way 1", 1.0);
        let (account, said) = said_of_cube(number, &goals);
        assert_eq!(said["verdict"], "failed", "{account}");
        let missed = said["goals"].as_array().unwrap().iter();
        let missed: Vec<_> = missed.filter(|goal| goal["is_met"] == false).collect();
        assert!(!missed.is_empty(), "{said}");
        for goal in missed {
            let name = goal["event"].as_str().unwrap();
            assert!(
                account.contains(&format!("goal      {name}: cube")),
                "{account}"
            );
        }
    }
}

#[test]
fn the_account_and_the_report_list_waypoints_among_the_events() {
    let goals = "\n[[goal]]\nevent = \"way 1\"\nbody = \"cube\"\n\
                 velocity_m_s = [0, 0, 5]\nnormal = [0, 0, -1]\n";
    let (account, said) = said_of_cube(0, goals);
    let events = said["events"].as_array().unwrap();
    let names: Vec<&str> = events
        .iter()
        .map(|of| of["name"].as_str().unwrap())
        .collect();
    assert_eq!(names[..3], ["way 0", "way 1", "bounce 1"], "{names:?}");
    for way in &events[..2] {
        assert_eq!(way["kind"], "waypoint");
        assert_eq!(way["bodies"], serde_json::json!(["cube"]));
        assert_eq!(way["time_is"], "estimated");
        assert!(way["time_sd_s"].as_f64().unwrap() > 0.0, "{way}");
    }
    let line = account.lines().find(|line| line.contains("way 0")).unwrap();
    assert!(line.contains("waypoint") && line.contains('±'), "{line}");
}

/// Nothing in a stream shows where a waypoint is: it needs a mark, and the error says which is missing.
#[test]
fn a_waypoint_without_a_mark_is_refused_by_name() {
    let pair = Kind::Pencil.pair(0).unwrap();
    let at_s = time_s(&pair.truth, In::First, 0.5);
    let mut asked = Asked::new(&pair.truth, &Acting::default(), 8000, &[(at_s, 0.0)]);
    let is_other = |of: &TakeEvent| match of {
        TakeEvent::Mark(mark) => mark.event.as_deref() != Some("way 0"),
        TakeEvent::Pose { .. } => true,
    };
    asked.case.performance.events.retain(is_other);
    let error = asked.case.estimated(&mut ()).unwrap_err().to_string();
    assert!(error.contains("no mark names \"way 0\""), "{error}");
}
