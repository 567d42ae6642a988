//! Goals on a coordinate, through the program: a height above the acted apex can only be met at a
//! stationary point of the flight, where nothing but the constraint's curvature tells the time.

use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, bounces, recording};
use enact_tools::replay::Program;
use serde_json::Value;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));
/// Stamps of a tempo, physical ones with the end at its mark, and with a free end.
const TIMINGS: [&str; 3] = ["tempo", "physical", "physical, free end"];

/// What the program says of a performance in a scene with a lower bound of a height at the end
/// \[m\].
fn said(case: &Case, scene_toml: &str, timing: &str, height_m: f64) -> Value {
    let link = &case.scene().links[enact::motion::LinkIndex(0)].name;
    let end = &case.scene().events.last().unwrap().name;
    let scene_toml = match timing {
        "tempo" => scene_toml.to_owned(),
        _ => scene_toml.replace("stamps = \"tempo\"", "stamps = \"physical\""),
    };
    let scene_toml = match timing {
        "physical, free end" => {
            scene_toml.replace("kind = \"end\"", "kind = \"end\"\ntime = \"free\"")
        }
        _ => scene_toml,
    };
    let scene_toml = format!(
        "{scene_toml}\n[[goal]]\nevent = {end:?}\nbody = {link:?}\n\
         position_within_mm = [[-inf, -inf, {:?}], [inf, inf, inf]]\n",
        1e3 * height_m
    );
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("take.mcap");
    recording::write(&case.performance, &scene_toml, &path).unwrap();
    let replayed = ENACT.report(&path, &[]);
    let is_estimate = matches!(replayed.code, Some(0 | 3));
    assert!(is_estimate, "{}", replayed.errors);
    replayed.said
}

fn acting(timing: &str) -> Acting {
    if timing == "tempo" {
        Acting::default()
    } else {
        Acting::timing_known()
    }
}

/// Height of the apex of the last flight, as estimated without a goal \[m\].
fn apex_m(case: &Case) -> f64 {
    let estimate = case.estimated(&mut ()).unwrap().estimate;
    let state = estimate.arcs.last().unwrap().state;
    state.position_m.z - state.velocity_m_s.z.powi(2) / (2.0 * estimate.gravity_m_s2.z)
}

/// All gaps are closed, by a converged motion.
fn assert_met(said: &Value, at: &str) {
    assert_eq!(
        said["termination"]["kind"], "converged",
        "{at}: {}",
        said["reason"]
    );
    assert_ne!(said["verdict"], "failed", "{at}: {}", said["reason"]);
    for event in said["events"].as_array().unwrap() {
        assert!(event["gap_m"].as_f64().unwrap() < 1e-9, "{at}: {event}");
    }
}

#[test]
fn heights_about_the_acted_apex_are_reached() {
    for seed in 6000..6004 {
        let truth = bounces(1, seed).unwrap();
        let scene_toml = bounces::scene_toml(&truth.scene);
        for timing in TIMINGS {
            let case = Case::new(&truth, &acting(timing), seed);
            let apex_m = apex_m(&case);
            for above_mm in [-50.0, -10.0, 10.0, 50.0] {
                let at = format!("{above_mm} mm, {timing}, seed {seed}");
                let said = said(&case, &scene_toml, timing, apex_m + above_mm / 1e3);
                assert_met(&said, &at);
                let end = said["events"].as_array().unwrap().last().unwrap();
                assert_eq!(end["time_is"] == "fixed", timing == "physical", "{at}");
                // At an apex the time is as certain as what makes it one.
                let duration_s = said["physical_s"].as_f64().unwrap();
                let sd_s = end["time_sd_s"].as_f64();
                assert!(sd_s.is_none_or(|sd_s| sd_s < duration_s), "{at}: {end}");
            }
        }
    }
}

#[test]
fn a_pencil_rises_to_where_it_did_not() {
    let mut truth = Style::Tip.truth();
    truth.scene.goals.clear();
    let scene_toml = Style::Tip.scene_toml();
    let without_goal = scene_toml.split("[[goal]]").next().unwrap();
    let case = Case::new(&truth, &Acting::default(), 6000);
    let apex_m = apex_m(&case);
    for height_m in [0.6, apex_m - 0.001, apex_m + 0.001] {
        let said = said(&case, without_goal, "tempo", height_m);
        assert_met(&said, &format!("{height_m} m of {apex_m} m"));
        let end = said["events"].as_array().unwrap().last().unwrap();
        let sd_s = end["time_sd_s"].as_f64();
        assert!(sd_s.is_none_or(|sd_s| sd_s < 1.0), "{end}");
    }
}

#[test]
fn what_no_throw_like_it_reaches_is_no_motion_of_it() {
    let truth = bounces(1, 6000).unwrap();
    let scene_toml = bounces::scene_toml(&truth.scene);
    for timing in TIMINGS {
        let case = Case::new(&truth, &acting(timing), 6000);
        let said = said(&case, &scene_toml, timing, 5.0);
        assert_ne!(said["verdict"], "physical", "{timing}: {}", said["reason"]);
    }
}
