//! The committed measurements of the flows against the program: it is still as exact as was
//! measured, and does for a body what was measured as its own. Of times, which no test asserts,
//! only the committed ones are read: that they say what the page says of them.

use enact_tools::front;
use enact_tools::reference;
use std::fs;
use std::path::Path;

use enact::physics::Body;
use enact::physics::body::Symmetry;
use enact::physics::flow::Spin;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;

use enact_tools::front::Turning;
use enact_tools::reference::Pair;

/// Free flights of what one throws are no longer [s]. Beyond, where a body with three different
/// moments turns tens of times, elliptic functions are ahead, which the page says.
const LONGEST_S: f64 = 1.0;

fn turnings() -> Vec<Turning> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/results/flow.json");
    let text = fs::read_to_string(path).expect("the measurements are committed");
    let mut record: Value = serde_json::from_str(&text).expect("a record");
    serde_json::from_value(record["numbers"]["flow"].take()).expect("turnings")
}

#[test]
fn the_committed_times_put_every_body_on_the_front() {
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
fn no_committed_time_is_below_that_of_the_closed_forms() {
    let symmetric = |turning: &&Turning| turning.class != "Asymmetric";
    let turnings = turnings();
    let mut tasks = turnings.iter().filter(symmetric).flat_map(|t| &t.tasks);
    assert!(tasks.clone().count() > 0);
    assert!(tasks.all(|task| task.as_exact_and_faster().is_empty()));
}

/// Angle from a quaternion to one of thirty digits \[rad\].
fn angle_to(rotation: &UnitQuaternion<f64>, exact: [Pair; 4]) -> f64 {
    let Quaternion { coords } = rotation.quaternion();
    let got = [coords.w, coords.x, coords.y, coords.z];
    let dot: f64 = got
        .iter()
        .zip(exact)
        .map(|(got, exact)| got * exact.0)
        .sum();
    let off = got.iter().zip(exact);
    let off = off.map(|(got, exact)| (Pair::from(got * dot.signum()) - exact).0);
    2.0 * off.map(|off| off * off).sum::<f64>().sqrt()
}

/// Twice what was measured, for another machine's sines.
#[test]
fn the_program_is_as_exact_as_was_measured() {
    let mut checked = 0;
    for turning in turnings() {
        let body = Body::new(1.0, Vector3::from(turning.moments)).expect("a body");
        let start = reference::epoch(turning.omega.map(Pair::from));
        let short = |task: &&front::Task| task.samples == 1 && task.duration_s <= LONGEST_S;
        for task in turning.tasks.iter().filter(short) {
            let rotation = Spin::new(&body, &turning.omega.into()).turn(task.duration_s);
            let exact = reference::turn(turning.moments, &start, task.duration_s);
            let error_rad = angle_to(&rotation, std::array::from_fn(|i| exact[i]));
            let measured_rad = task.ours().error_rad.expect("a number");
            let most_rad = 2.0 * measured_rad.max(task.rounding()[0]);
            println!(
                "{} {}: {error_rad:e} of {most_rad:e}",
                turning.name, task.duration_s
            );
            assert!(
                error_rad <= most_rad && most_rad < 1e-12,
                "{}, {} s: {error_rad:e}, measured {measured_rad:e}",
                turning.name,
                task.duration_s
            );
            checked += 1;
        }
    }
    assert!(checked >= 8, "only {checked} turns");
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
fn the_committed_references_agree() {
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
