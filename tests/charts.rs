//! The committed measurements of the flows against the program: what it does for a body lies on the
//! front of exactness against time, and is what was measured as its own.

use std::fs;
use std::path::Path;

use enact::physics::Body;
use enact::physics::body::Symmetry;
use nalgebra::Vector3;

#[path = "../tools/chart/flow/front.rs"]
#[allow(dead_code, reason = "the chart uses the rest")]
mod front;

use front::Turning;

/// Free flights of what one throws are no longer [s]. Beyond, where a body with three different
/// moments turns tens of times, elliptic functions are ahead, which the page says.
const LONGEST_S: f64 = 1.0;

fn turnings() -> Vec<Turning> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/charts");
    let mut turnings: Vec<Turning> = Vec::new();
    for entry in fs::read_dir(&folder).expect("the charts are committed") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("flow_") && name.ends_with(".numbers.json") {
            let text = fs::read_to_string(&path).expect("a text");
            turnings.push(serde_json::from_str(&text).expect("a turning"));
        }
    }
    turnings
}

#[test]
fn the_flow_of_every_body_lies_on_the_front() {
    let turnings = turnings();
    assert!(turnings.len() >= 4, "only {} bodies", turnings.len());
    for turning in &turnings {
        for task in turning.tasks.iter().filter(|t| t.duration_s <= LONGEST_S) {
            let ahead = task.ahead_of_ours();
            assert!(
                ahead.is_empty(),
                "{}, {} s, {} samples: {ahead:?} against {:?}",
                turning.name,
                task.duration_s,
                task.samples,
                task.ours()
            );
        }
    }
}

#[test]
fn nothing_is_faster_than_the_closed_forms() {
    let symmetric = |turning: &&Turning| turning.class != "Asymmetric";
    let turnings = turnings();
    let mut tasks = turnings.iter().filter(symmetric).flat_map(|t| &t.tasks);
    assert!(tasks.clone().count() > 0);
    assert!(tasks.all(|task| task.as_exact_and_faster().is_empty()));
}

#[test]
fn the_program_still_picks_what_was_measured_as_its_own() {
    for turning in turnings() {
        let body = Body::new(1.0, Vector3::from(turning.moments)).expect("a body");
        assert_eq!(format!("{:?}", body.symmetry()), turning.class);
        let is_series = turning.chosen.contains("Taylor");
        assert_eq!(is_series, body.symmetry() == Symmetry::Asymmetric);
        for task in &turning.tasks {
            assert_eq!(task.ours().method, turning.chosen, "{}", turning.name);
            assert!(!task.ours().failed(), "{}", turning.name);
        }
    }
}

#[test]
fn two_references_agree() {
    for turning in turnings() {
        for task in &turning.tasks {
            // Far below the rounding that separates the methods; differences of derivatives have
            // half the digits.
            let [rotation, derivative] = task.reference;
            assert!(rotation < 1e-17, "{}: {rotation:e}", turning.name);
            assert!(derivative < 1e-10, "{}: {derivative:e}", turning.name);
        }
    }
}
