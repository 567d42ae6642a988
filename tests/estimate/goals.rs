//! Goals through the program. A height above the acted apex can only be met at a stationary point of the
//! flight, where nothing but the constraint's curvature tells the time. The examples of the page of goals
//! are met.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::physics::State;
use enact_tools::case::Case;
use enact_tools::goals::{Pair, Quantity, Set, is_closed};
use enact_tools::perform::{Acting, Style, bounces, perform, recording, simulate};
use enact_tools::replay::Program;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
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
        assert_ne!(said["verdict"], "physical", "{timing}: {said}");
    }
}

/// Along a ball of spins or a cone of directions the Lagrangian is concave far from the optimum.
#[test]
fn goals_on_curved_sets_are_met_from_far() {
    let quantities = [
        Quantity::BouncedSpin,
        Quantity::Velocity,
        Quantity::Direction,
    ];
    let mut asked = 0;
    for seed in 8010..8016 {
        let Some(mut pair) = Pair::of_one(seed) else {
            continue;
        };
        for quantity in quantities {
            let Some(goal) = pair.goal((quantity, Set::Ball), true, None) else {
                continue;
            };
            let mut truth = pair.truth.clone();
            truth.scene.goals.push(goal);
            let case = Case::new(&truth, &Acting::default(), seed);
            let outcome = case.estimated(&mut ()).unwrap();
            let attained = outcome.scene.goals_attained(&outcome.estimate);
            let what = format!("{seed}, {}", quantity.as_str());
            assert!(attained.iter().all(|goal| goal.is_met()), "{what}");
            assert!(is_closed(&outcome.estimate), "{what}");
            asked += 1;
        }
    }
    assert!(asked > 12, "{asked}");
}

/// The blocks of TOML on a page.
fn examples(page: &str) -> Vec<&str> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(page);
    let text: &'static str = std::fs::read_to_string(path).unwrap().leak();
    let blocks = text.split("```toml\n").skip(1);
    blocks
        .map(|block| block.split("```").next().unwrap())
        .collect()
}

#[test]
fn every_example_of_the_page_is_met() {
    let examples = examples("goals.md");
    let (scene_toml, goals) = examples.split_first().expect("a scene");
    let scene = scene_from_toml(scene_toml).unwrap();
    let state = |position_m: [f64; 3], turn: [f64; 4], velocity_m_s: [f64; 3], spin: [f64; 3]| {
        let [w, x, y, z] = turn;
        State {
            position_m: Vector3::from(position_m),
            orientation: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
            velocity_m_s: Vector3::from(velocity_m_s),
            angular_velocity_rad_s: Vector3::from(spin),
        }
    };
    let turn = [0.99445, 0.02834, 0.05552, -0.08472];
    let spin = [2.57135, -4.59538, 0.84827];
    let first = [
        state([-0.075, -0.005, 0.27084], turn, [0.5, 0.1, 0.45166], spin),
        state(
            [0.3, 0.2, 0.6],
            [1.0, 0.0, 0.0, 0.0],
            [-0.3, 0.0, 1.6],
            [1.0, 2.0, 0.0],
        ),
    ];
    // Nothing happens at the waypoint but that it is marked.
    let way = scene
        .events
        .iter()
        .position(|of| of.kind.waypoint().is_some());
    let mut acted = scene.clone();
    let way = acted.events.remove(way.expect("a waypoint"));
    let truth = simulate(&acted, &[], &first, 0.45).unwrap();
    let link = way.kind.waypoint().unwrap();
    let (truth, _) = truth.with_waypoint(&way.name, link, 0.33);
    assert_eq!(truth.scene, scene);
    let performance = perform(&truth, &Acting::timing_known(), 6000);
    let said = |scene_toml: &str| {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("take.mcap");
        recording::write(&performance, scene_toml, &path).unwrap();
        let replayed = ENACT.report(&path, &[]);
        let is_estimate = matches!(replayed.code, Some(0 | 3));
        assert!(is_estimate, "{scene_toml}\n{}", replayed.errors);
        replayed.said
    };
    assert_met(&said(scene_toml), "without goals");
    assert!(goals.len() > 20, "{}", goals.len());
    for example in goals {
        let asked = said(&format!("{scene_toml}\n{example}"));
        assert_met(&asked, example);
        let lines = asked["goals"].as_array().unwrap();
        assert!(!lines.is_empty(), "{example}");
        for line in lines.iter().filter(|line| line["sd"].is_null()) {
            assert_eq!(line["is_met"], true, "{example}: {line}");
        }
        if let Some((rest, sd)) = example.trim_end().rsplit_once("sd_") {
            // The more a wish weighs, the nearer the motion comes to it.
            let (unit, value) = sd.split_once(" = ").unwrap();
            let value: f64 = value.parse().unwrap();
            let distance = |share: f64| {
                let example = format!("{rest}sd_{unit} = {:?}", value * share);
                let asked = said(&format!("{scene_toml}\n{example}"));
                assert_met(&asked, &example);
                asked["goals"][0]["distance"].as_f64().unwrap()
            };
            let [none, some, all] = [1e4, 1.0, 1e-2].map(distance);
            assert!(
                none > 1.2 * some && some > 20.0 * all,
                "{example}: {none} {some} {all}"
            );
        }
    }
}
