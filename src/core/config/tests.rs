use nalgebra::Vector3;
use proptest::prelude::*;

use super::{SceneError, scene_from_toml};
use crate::motion::{
    Collision, ContactLaw, ContactLawIndex, EventKind, GoalTarget, LinkIndex, Quantity, Timing,
    TrackIndex,
};
use crate::physics::body::Symmetry;
use crate::physics::{Shape, contact};

mod counted;
mod frames;
mod free;
mod goals;
mod held;
mod laws;
mod reach;
mod refusals;
mod sticking;
mod waypoints;

/// Uses every kind of table; line numbers matter to the tests below.
const PENCIL: &str = r#"name = "pencil, tip first"
gravity_m_s2 = [0.0, 0.0, -9.81]

[timing]
stamps = "tempo"

[weights]
position_mm = 5
orientation_deg = 3.0

[[body]]
name = "pencil"
shape = { kind = "cylinder", length_mm = 190.0, radius_mm = 3.75 }
mass_g = 6.0
tracker = { position_mm = [0, 0, 60], orientation_wxyz = [0.70710678, 0.70710678, 0, 0] }
features_mm = { tip = [0, 0, -95], eraser = [0, 0, 95] }

[[surface]]
name = "table"
point_mm = [0, 0, 10]
normal = [0, 0, 2]

[[obstacle]]
name = "mug floor"
shape = { kind = "cylinder", length_mm = 4, radius_mm = 40 }
position_mm = [300, 0, 2]

[[event]]
name = "release"
kind = "start"

[[event]]
name = "bounce"
kind = "collision"
body = "pencil"
feature = "tip"
surface = "table"
restitution = 0.6

[[event]]
name = "landing"
kind = "end"

[[goal]]
event = "landing"
body = "pencil"
position_mm = [300, 0, 99]
orientation_wxyz = [1, 0, 0, 0]

[[free]]
quantity = "gravity.z"
lower = -12.0
upper = -7.0
prior_sd = 0.1

[[free]]
quantity = "bounce.restitution"

[[free]]
quantity = "bounce.tilt.1"
lower = -6
upper = 6
"#;

fn error_of(text: &str) -> SceneError {
    match scene_from_toml(text) {
        Ok(scene) => panic!("accepted as {scene:?}"),
        Err(error) => error,
    }
}

/// The scene with one piece of text replaced, which must be there exactly once.
fn with(from: &str, to: &str) -> String {
    assert_eq!(PENCIL.matches(from).count(), 1, "{from:?}");
    PENCIL.replace(from, to)
}

#[test]
fn faces_of_bodies_come_after_their_corners() {
    let face = |name: &str| {
        format!(
            "[[body.face]]\nname = \"{name}\"\npoint_mm = [0, 3, 95]\nnormal = [0, 0, 5]\n\n[[surface]]"
        )
    };
    let scene = scene_from_toml(&PENCIL.replace("[[surface]]", &face("end"))).unwrap();
    let [_, _, end, ..] = &scene.links[LinkIndex(0)].features[..] else {
        panic!("{:?}", scene.links[LinkIndex(0)].features);
    };
    let point_m = Vector3::new(0.0, 0.003, 0.095);
    assert_eq!(end.name, "end");
    assert_eq!(end.geometry, contact::Feature::face(point_m, Vector3::z()));
    let twice = scene_from_toml(&PENCIL.replace("[[surface]]", &face("tip"))).unwrap_err();
    let text = twice.to_string();
    assert!(text.contains("\"tip\"") && twice.line > 0, "{text}");
}

#[test]
fn the_example_becomes_a_scene_in_si_units() {
    let scene = scene_from_toml(PENCIL).unwrap();
    assert_eq!(scene.name, "pencil, tip first");
    assert_eq!(scene.gravity_m_s2, Vector3::new(0.0, 0.0, -9.81));
    assert_eq!(scene.marks_topic, "/marks");
    assert_eq!(
        scene.timing,
        Timing::Unknown {
            tempo_sd_per_sqrt_s: 0.5
        }
    );
    assert_eq!(scene.weights.position_m, 0.005);
    assert_eq!(scene.weights.orientation_rad, 3.0_f64.to_radians());
    let link = &scene.links[LinkIndex(0)];
    let track = &scene.tracks[TrackIndex(0)];
    assert_eq!(track.topic, "/tracker/pencil/pose");
    assert_eq!(
        link.shape,
        Shape::Cylinder {
            half_length_m: 0.095,
            radius_m: 0.00375
        }
    );
    assert_eq!(link.body.mass_kg(), 0.006);
    assert_eq!(link.body.symmetry(), Symmetry::Axial { axis: 2 });
    assert_eq!(
        track.link_from_tracker.translation.vector,
        Vector3::new(0.0, 0.0, 0.06)
    );
    let turn = track.link_from_tracker.rotation;
    assert!((turn.norm() - 1.0).abs() < 1e-15);
    assert!((turn.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-7);
    let names: Vec<&str> = link.features.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names[..2], ["eraser", "tip"]);
    assert_eq!(names[2..], ["rim +z", "rim -z", "side", "end +z", "end -z"]);
    assert_eq!(link.candidate_features(), [0, 1]);
    let tip = contact::Feature::corner(Vector3::new(0.0, 0.0, -0.095));
    assert_eq!(link.features[1].geometry, tip);
    let table = contact::Feature::face(Vector3::new(0.0, 0.0, 0.01), Vector3::z());
    assert_eq!(scene.surfaces[0].geometry, table);
    assert_eq!(
        scene.obstacles[0].world_from_shape.translation.vector,
        Vector3::new(0.3, 0.0, 0.002)
    );
    assert_eq!(
        scene.events[1].kind,
        EventKind::Collision(Collision::bounce(LinkIndex(0), 1, 0, ContactLawIndex(0)))
    );
    assert_eq!(
        scene.contact_laws.raw,
        [ContactLaw::frictionless("bounce", 0.6)]
    );
    assert_eq!(scene.events[0].kind, EventKind::Start);
    assert_eq!(scene.events[2].kind, EventKind::End);
    assert_eq!(
        (scene.goals[0].event, scene.goals[0].link),
        (2, LinkIndex(0))
    );
    assert!(matches!(scene.goals[0].target, GoalTarget::Pose { .. }));
    let [gravity, restitution, tilt] = scene.parameters.as_slice() else {
        panic!("{:?}", scene.parameters);
    };
    assert_eq!(gravity.quantity, Quantity::Gravity { axis: 2 });
    assert_eq!(
        (gravity.initial, gravity.lower, gravity.upper),
        (-9.81, -12.0, -7.0)
    );
    assert_eq!(gravity.prior_sd, Some(0.1));
    assert_eq!(
        restitution.quantity,
        Quantity::Restitution {
            law: ContactLawIndex(0)
        }
    );
    assert_eq!(
        (restitution.initial, restitution.lower, restitution.upper),
        (0.6, 0.0, 1.0)
    );
    assert_eq!(
        tilt.quantity,
        Quantity::Tilt {
            event: 1,
            tangent: 1
        }
    );
    assert_eq!(
        (tilt.initial, tilt.lower, tilt.upper),
        (0.0, (-6.0_f64).to_radians(), 6.0_f64.to_radians())
    );
}

#[test]
fn box_goals_and_defaults() {
    let text = with(
        "position_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]",
        "position_within_mm = [[-inf, 0, 99], [inf, 50, 99]]",
    );
    let text = text.replace("gravity_m_s2 = [0.0, 0.0, -9.81]\n", "");
    let text = text.replace("position_mm = 5\norientation_deg = 3.0\n", "");
    let scene = scene_from_toml(&text).unwrap();
    assert_eq!(
        scene.goals[0].target,
        GoalTarget::PositionWithin {
            lower_m: Vector3::new(f64::NEG_INFINITY, 0.0, 0.099),
            upper_m: Vector3::new(f64::INFINITY, 0.05, 0.099),
        }
    );
    assert_eq!(scene.gravity_m_s2, Vector3::new(0.0, 0.0, -9.80665));
    assert_eq!(scene.weights.position_m, 0.01);
    assert_eq!(scene.weights.orientation_rad, 0.1);
}

#[test]
fn density_and_moments_may_be_given() {
    let scene = scene_from_toml(&with("mass_g = 6.0", "density_kg_m3 = 700")).unwrap();
    let volume_m3 = std::f64::consts::PI * 0.00375_f64.powi(2) * 0.19;
    assert!((scene.links[LinkIndex(0)].body.mass_kg() / (700.0 * volume_m3) - 1.0).abs() < 1e-12);
    let scene = scene_from_toml(&with(
        "mass_g = 6.0",
        "mass_kg = 0.006\nmoments_kg_m2 = [1e-5, 1e-5, 5e-8]",
    ))
    .unwrap();
    assert_eq!(
        scene.links[LinkIndex(0)].body.moments_kg_m2(),
        Vector3::new(1e-5, 1e-5, 5e-8)
    );
}

#[test]
fn three_different_moments_make_an_asymmetric_body() {
    for (old, new) in [
        (
            "mass_g = 6.0",
            "mass_g = 6.0\nmoments_kg_m2 = [1e-5, 1.1e-5, 1.2e-5]",
        ),
        (
            "kind = \"cylinder\", length_mm = 190.0, radius_mm = 3.75",
            "kind = \"cuboid\", size_mm = [10, 20, 30]",
        ),
    ] {
        let scene = scene_from_toml(&with(old, new)).unwrap();
        assert_eq!(
            scene.links[LinkIndex(0)].body.symmetry(),
            Symmetry::Asymmetric
        );
    }
}

#[test]
fn an_error_names_its_file() {
    let error = error_of("name = 3").in_file("config/drop.toml");
    assert!(
        error.to_string().starts_with("config/drop.toml:1:8: "),
        "{error}"
    );
}

/// Fragments that are meaningful to the format, so that random texts pass the parser.
fn scrap() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just("0".to_owned()),
        Just("1e308".to_owned()),
        Just("1e-320".to_owned()),
        Just("-1".to_owned()),
        Just("[[body]]\n".to_owned()),
        Just("[[goal]]\n".to_owned()),
        Just("\"hull\"".to_owned()),
        Just("\"bounce.tilt.0\"".to_owned()),
        Just("\n".to_owned()),
        Just("ü".to_owned()),
        any::<f64>().prop_map(|x| format!("{x:e}")),
        "[\\PC]{0,6}",
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn any_text_is_a_scene_or_an_error(text in "\\PC{0,200}") {
        if let Err(error) = scene_from_toml(&text) {
            prop_assert!(error.line >= 1 && error.column >= 1);
            prop_assert!(!error.message.is_empty());
        }
    }

    #[test]
    fn a_scene_cut_and_patched_is_a_scene_or_an_error(
        start in 0_usize..PENCIL.len(),
        length in 0_usize..12,
        scrap in scrap(),
        drop_line in any::<prop::sample::Index>(),
        dropping in any::<bool>(),
    ) {
        // The example is ASCII, so every index is a boundary.
        let end = (start + length).min(PENCIL.len());
        let mut text = format!("{}{scrap}{}", &PENCIL[..start], &PENCIL[end..]);
        if dropping {
            let mut lines: Vec<&str> = text.lines().collect();
            lines.remove(drop_line.index(lines.len()));
            text = lines.join("\n");
        }
        if let Err(error) = scene_from_toml(&text) {
            prop_assert!(error.line >= 1 && error.line <= text.lines().count() + 1);
            prop_assert!(error.column >= 1);
        }
    }

    #[test]
    fn any_number_anywhere_is_a_scene_or_an_error(
        which in any::<prop::sample::Index>(),
        value in any::<f64>(),
    ) {
        let numbers: Vec<&str> = ["-9.81", "190.0", "3.75", "6.0", "60", "95]", "2]", "0.6", "99", "-12.0", "0.1", "-6"].to_vec();
        let target = numbers[which.index(numbers.len())];
        let kept = if target.ends_with(']') { "]" } else { "" };
        let text = PENCIL.replacen(target, &format!("{value:e}{kept}"), 1);
        if let Ok(scene) = scene_from_toml(&text) {
            prop_assert!(scene.links[LinkIndex(0)].body.mass_kg() > 0.0);
            prop_assert!((scene.surfaces[0].plane().unwrap().1.norm() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn the_scenes_that_come_along_are_accepted() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let scene = scene_from_toml(&text).unwrap_or_else(|error| {
            panic!("{}", error.in_file(path.display().to_string()));
        });
        names.push(scene.name);
    }
    assert!(names.contains(&"cube toss, first flight".to_owned()));
}

#[test]
fn motions_settle_where_the_scene_says_so() {
    assert_eq!(scene_from_toml(PENCIL).unwrap().settle_s, None);
    let settling = PENCIL.replace("[timing]", "settle_s = 2.5\n[timing]");
    assert_eq!(scene_from_toml(&settling).unwrap().settle_s, Some(2.5));
}

#[test]
fn what_scenes_leave_open_is_what_may_touch() {
    let open = with("feature = \"tip\"\nsurface = \"table\"\n", "");
    let scene = scene_from_toml(&open).unwrap();
    assert_eq!(scene.open_events(), [1]);
    let obstacle = |name: &str| scene.surfaces.iter().find(|s| s.name == name).unwrap();
    let top = obstacle("mug floor/end +z");
    assert_eq!(top.obstacle, Some(0));
    let at = contact::Feature::face(Vector3::new(0.3, 0.0, 0.004), Vector3::z());
    assert_eq!(top.geometry, at);
    // Two sharp points against the table and the floor's two ends; its round side has no tilt.
    assert_eq!(scene.candidates(1).len(), 2 * 3);

    let named = with("surface = \"table\"", "surface = \"mug floor/end +z\"");
    let scene = scene_from_toml(&named).unwrap();
    assert_eq!(scene.open_events(), [0; 0]);
    assert_eq!(scene.contact_words(1).unwrap(), "tip on mug floor/end +z");
    assert_eq!(scene.surfaces.len(), 2);

    let own = with("feature = \"tip\"", "feature = \"rim -z\"");
    let scene = scene_from_toml(&own).unwrap();
    assert_eq!(scene.contact_words(1).unwrap(), "rim -z on table");
}

#[test]
fn counts_become_collisions_by_the_marks() {
    let counted = PENCIL
        .replace("restitution = 0.6", "restitution = 0.6\ncount = [2, 4]")
        .replace(
            "[[free]]\nquantity = \"bounce.tilt.1\"\nlower = -6\nupper = 6\n",
            "",
        );
    let scene = scene_from_toml(&counted).unwrap();
    assert!(scene.has_repeats());
    for (marks, bounces) in [(0, 2), (4, 2), (5, 3), (6, 4), (9, 4)] {
        let scene = scene.with_marks(marks);
        assert_eq!(scene.events.len(), bounces + 2, "{marks} marks");
        assert_eq!(scene.events[bounces].name, format!("bounce {bounces}"));
        assert_eq!(scene.events[bounces + 1].kind, EventKind::End);
        assert_eq!(scene.goals[0].event, bounces + 1);
    }
    for (count, complaint) in [
        ("0", "count is 0 to 0, expected 1 to 1000, the least first"),
        (
            "[4, 2]",
            "count is 4 to 2, expected 1 to 1000, the least first",
        ),
    ] {
        let wrong = counted.replace("[2, 4]", count);
        assert_eq!(error_of(&wrong).message, complaint);
    }
}
