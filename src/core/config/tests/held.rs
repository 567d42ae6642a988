//! Bodies in the hand.

use super::error_of;
use super::refusals::refused;
use crate::config::scene_from_toml;
use crate::motion::{LinkIndex, Quantity, Untold};
use crate::physics::Body;

const RACKET: &str = include_str!("../../../../config/racket.toml");

fn with(old: &str, new: &str) -> String {
    assert!(RACKET.contains(old), "{old}");
    RACKET.replacen(old, new, 1)
}

/// Line of the first occurrence of a text, and that line from its place on.
fn line_of(text: &str, at: &str) -> usize {
    let before = text.split_once(at).expect("it is there").0;
    before.matches('\n').count() + 1
}

fn is_refused(text: &str, at: &str, message: &str) {
    refused(text, line_of(text, at), at, message);
}

#[test]
fn a_held_body_has_no_inertia_and_what_is_known_of_its_tracker() {
    let scene = scene_from_toml(RACKET).expect("valid");
    let [ball, racket] = [0, 1].map(|link| &scene.links[LinkIndex(link)]);
    assert!(ball.held.is_none() && racket.held.is_some());
    assert_eq!(racket.body, Body::IMMOVABLE);
    let known = with(
        "held = true",
        "held = true\ntracker_sd_mm = 2\ntracker_sd_deg = 90",
    );
    let scene = scene_from_toml(&known).expect("valid");
    let held = scene.links[LinkIndex(1)].held.expect("held");
    assert_eq!(held.position_sd_m, Some(2e-3));
    let sd = held.orientation_sd_rad.expect("given");
    assert!((sd - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    for config in ["paddle", "ramp"] {
        let path = format!("{}/../../config/{config}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("a scene");
        assert!(scene_from_toml(&text).is_ok(), "{config}");
    }
}

#[test]
fn what_means_nothing_for_a_held_body_is_refused_by_name() {
    for (key, number) in [
        ("mass_g", "100"),
        ("moments_kg_m2", "[1, 1, 1]"),
        ("force_m_s2", "[0, 0, 1]"),
        ("drag_linear_per_s", "1"),
    ] {
        let text = with("held = true", &format!("held = true\n{key} = {number}"));
        is_refused(
            &text,
            number,
            &format!("{key} does not apply to a held body"),
        );
    }
    let text = with("mass_g = 2.7", "mass_g = 2.7\ntracker_sd_mm = 0.5");
    is_refused(&text, "0.5", "expected held = true");
    let text = with("held = true", "held = true\ntracker_sd_mm = -0.5");
    is_refused(&text, "-0.5", "expected a positive number");
    let text = with("\"physical\"", "\"edited\"");
    assert!(
        error_of(&text)
            .message
            .contains("which edited stamps do not tell")
    );
    let text = with("mass_g = 2.7", "held = true");
    assert!(error_of(&text).message.contains("at least one that flies"));
    let goal = "\n[[goal]]\nevent = \"caught\"\nbody = \"racket\"\nposition_within_mm = [[0, 0, 0], [1, 1, 1]]\n";
    let text = format!("{RACKET}{goal}");
    assert!(
        error_of(&text)
            .message
            .contains("a goal of \"racket\", which is held")
    );
}

#[test]
fn what_is_deflected_comes_first() {
    let text = with(
        "body = \"ball\"\nother = \"racket\"",
        "body = \"racket\"\nother = \"ball\"",
    );
    let error = error_of(&text).message;
    assert!(
        error.contains("body = \"ball\", other = \"racket\""),
        "{error}"
    );
    let table =
        "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n[[event]]";
    let text = with("[[event]]", table);
    let text = text.replace(
        "body = \"ball\"\nother = \"racket\"\nfeature = \"ball\"\nother_feature = \"end +z\"",
        "body = \"racket\"\nsurface = \"table\"",
    );
    let error = error_of(&text).message;
    assert!(
        error.contains("what it hits does not deflect it"),
        "{error}"
    );
}

#[test]
fn only_its_tracker_may_be_free() {
    let scene = scene_from_toml(RACKET).expect("valid");
    for quantity in scene.quantities() {
        let name = scene.name_of_quantity(quantity);
        let untold = scene.untold(quantity);
        if let Some(of_racket) = name.strip_prefix("racket.") {
            let is_of_tracker = of_racket.starts_with("tracker") || of_racket.starts_with("clock");
            assert_eq!(untold != Some(Untold::Held), is_of_tracker, "{name}");
            assert!(!is_of_tracker || untold.is_none(), "{name}: {untold:?}");
        }
    }
    // Of the ball that only a hand deflects, the mass cancels.
    let mass = Quantity::Mass { link: LinkIndex(0) };
    assert_eq!(scene.untold(mass), Some(Untold::MassCancels));
    let free = |name: &str| format!("{RACKET}\n[[free]]\nquantity = \"{name}\"\n");
    let error = error_of(&free("racket.mass")).message;
    assert!(
        error.contains("a held body moves as it was tracked"),
        "{error}"
    );
    assert!(scene_from_toml(&free("racket.tracker.z")).is_ok());
    assert!(scene_from_toml(&free("racket.clock.offset")).is_ok());
}

/// A pendulum that hangs from a handle.
const IN_HAND: &str = r#"
name = "hand"

[timing]
stamps = "physical"

[[body]]
name = "handle"
held = true
shape = { kind = "sphere", radius_mm = 20 }
tracker = {}

[[body]]
name = "rod"
shape = { kind = "cylinder", length_mm = 200, radius_mm = 5 }
mass_g = 100
tracker = {}

[[joint]]
name = "wrist"
kind = "ball"
parent = "handle"
parent_at_mm = [0, 0, -30]
child = "rod"
child_at_mm = [0, 0, 100]

[[event]]
name = "start"
kind = "start"

[[event]]
name = "end"
kind = "end"
"#;

#[test]
fn bodies_hang_from_a_held_one() {
    let scene = scene_from_toml(IN_HAND).unwrap();
    let (mechanism, joined) = scene.joint_trees().next().expect("a tree");
    assert_eq!(joined.base, None);
    assert_eq!(scene.hand_of(joined), Some(LinkIndex(0)));
    assert!(scene.carries(LinkIndex(0)) && !scene.carries(LinkIndex(1)));
    assert!(scene.are_joined(LinkIndex(0), LinkIndex(1)));
    let moving: Vec<_> = scene.moving().map(|(index, _)| index).collect();
    assert_eq!(moving, [mechanism], "the handle is not unknown");
    // A second rod may hang from the same hand.
    let other = IN_HAND.split("[[body]]\nname = \"rod\"").nth(1).unwrap();
    let other = other.split("[[event]]").next().unwrap();
    let other = format!("[[body]]\nname = \"rod\"{other}");
    let other = other
        .replace("\"rod\"", "\"other\"")
        .replace("wrist", "thumb");
    let scene = scene_from_toml(&format!("{IN_HAND}{other}")).unwrap();
    assert_eq!(scene.joint_trees().count(), 2);
}

#[test]
fn what_is_not_done_of_joined_bodies_beside_a_held_one_is_refused() {
    let said = |text: &str| scene_from_toml(text).unwrap_err().to_string();
    let with = |from: &str, to: &str| IN_HAND.replacen(from, to, 1);
    let swapped = with("parent = \"handle\"", "parent = \"rod\"");
    let swapped = swapped.replacen("child = \"rod\"", "child = \"handle\"", 1);
    let added = |more: &str| format!("{IN_HAND}{more}");
    let hit = |what: &str| {
        format!(
            "[[event]]\nname = \"hit\"\nkind = \"collision\"\n{what}\nrestitution = 0.5\nfriction = 0\n\
        [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n"
        )
    };
    let end = "[[event]]\nname = \"end\"";
    let before_end = |more: String| with(end, &(more + end));
    // What hangs from it may hit the table.
    let table = hit("body = \"rod\"\nsurface = \"table\"");
    assert!(scene_from_toml(&before_end(table)).is_ok());
    let lamp = "[[body]]\nname = \"lamp\"\nshape = { kind = \"sphere\", radius_mm = 20 }\nmass_g = 100\n\
        [[joint]]\nname = \"hook\"\nkind = \"ball\"\nparent_at_mm = [0, 0, 900]\nchild = \"lamp\"\nchild_at_mm = [0, 0, 100]\n";
    for (text, expected) in [
        (swapped, "expected it as the parent of what hangs from it"),
        (
            with("stamps = \"physical\"", "stamps = \"tempo\""),
            "where the tempo must be known: expected stamps = \"physical\"",
        ),
        (
            before_end(lamp.to_owned() + &hit("body = \"lamp\"\nother = \"handle\"")),
            "expected no collision of it",
        ),
        (
            added(
                "[[goal]]\nevent = \"end\"\nbody = \"rod\"\nposition_mm = [0, 0, 0]\nrelative_to = \"handle\"\n",
            ),
            "which is held and goes where it was tracked, expected a body that flies",
        ),
        (
            with("[timing]", "settle_s = 2\n\n[timing]"),
            "not continued beside a held one, expected no settle_s",
        ),
    ] {
        let error = said(&text);
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
