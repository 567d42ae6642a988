//! Waypoints of scene files.

use super::refusals::refused;
use super::{PENCIL, with};
use crate::config::scene_from_toml;
use crate::motion::{EventKind, LinkIndex};

/// The pencil with a waypoint after its bounce, whose table begins on line 40.
fn passing(keys: &str) -> String {
    let waypoint = format!("[[event]]\nname = \"top\"\nkind = \"waypoint\"\n{keys}\n\n");
    let landing = "[[event]]\nname = \"landing\"";
    PENCIL.replace(landing, &format!("{waypoint}{landing}"))
}

#[test]
fn a_waypoint_is_an_event_of_one_body_that_ends_no_flight() {
    let scene = scene_from_toml(&passing("body = \"pencil\"")).unwrap();
    assert_eq!(scene.events[2].kind, EventKind::Waypoint(LinkIndex(0)));
    assert_eq!(scene.events[2].kind.as_str(), "waypoint");
    assert!(scene.time_is_free(2));
    let mechanism = scene.mechanism_of(LinkIndex(0));
    let concerned: Vec<bool> = (0..4).map(|e| scene.concerns(e, mechanism)).collect();
    assert_eq!(concerned, [true, true, false, true]);
    // The goal at the landing is still there.
    assert_eq!(scene.goals[0].event, 3);

    let timed = "body = \"pencil\"\ntime_sd_ms = 20\nearliest_ms = -100\nlatest_ms = 50";
    let scene = scene_from_toml(&passing(timed)).unwrap();
    let time = scene.events[2].time;
    assert_eq!(time.mark_sd_s, Some(0.02));
    assert_eq!(time.window_s, [-0.1, 0.05]);
    let fixed = scene_from_toml(&passing("body = \"pencil\"\ntime = \"fixed\"")).unwrap();
    assert!(!fixed.time_is_free(2));
}

#[test]
fn goals_hold_at_it() {
    for keys in [
        "position_mm = [1, 2, 300]",
        "feature = \"tip\"\nposition_mm = [1, 2, 300]\nwithin_mm = 3",
        "orientation_wxyz = [1, 0, 0, 0]",
        "axis = \"+z\"",
        "velocity_m_s = [0, 0, 0]\nnormal = [0, 0, 1]",
        "spin_rad_s = [0, 0, 0]\nwithin_rad_s = 3\nsd_rad_s = 1",
        "position_mm = [1, 2, 300]\nsd_mm = 2",
    ] {
        let goal = format!("\n[[goal]]\nevent = \"top\"\nbody = \"pencil\"\n{keys}\n");
        let scene = scene_from_toml(&(passing("body = \"pencil\"") + &goal)).unwrap();
        assert_eq!(scene.goals.last().unwrap().event, 2, "{keys}");
    }
}

#[test]
fn a_wrong_waypoint_says_where_and_what_is_expected() {
    refused(
        &passing("time_sd_ms = 20"),
        42,
        "\"waypoint\"",
        "missing key `body`: a waypoint is of the flight of one body",
    );
    refused(
        &passing("body = \"pen\""),
        43,
        "\"pen\"",
        "unknown body \"pen\", expected \"pencil\"",
    );
    for (key, value) in [
        ("feature", "\"tip\""),
        ("features", "[\"tip\"]"),
        ("surface", "\"table\""),
        ("other", "\"pencil\""),
        ("other_feature", "\"tip\""),
        ("restitution", "0.5"),
        ("friction", "0.5"),
        ("count", "2"),
    ] {
        refused(
            &passing(&format!("body = \"pencil\"\n{key} = {value}")),
            44,
            value,
            &format!("{key} does not apply to an event of kind \"waypoint\""),
        );
    }
    let edited = passing("body = \"pencil\"").replace("\"tempo\"", "\"edited\"");
    refused(
        &edited,
        42,
        "\"waypoint\"",
        "expected stamps \"physical\" or \"tempo\"",
    );
    refused(
        &with("kind = \"start\"", "kind = \"way\""),
        30,
        "\"way\"",
        "expected one of start, collision, change, waypoint, end",
    );
    let goal = |keys: &str| {
        let goal = format!("\n[[goal]]\nevent = \"top\"\nbody = \"pencil\"\n{keys}\n");
        passing("body = \"pencil\"") + &goal
    };
    let line = |text: &str, of: &str| 1 + text.lines().position(|line| line == of).unwrap();
    let after = goal("velocity_m_s = [0, 0, 1]\nafter = true");
    refused(
        &after,
        line(&after, "after = true"),
        "true",
        "expected a collision of it",
    );
    let contact = goal("position_mm = [0, 0, 10]\ncontact = true");
    refused(
        &contact,
        line(&contact, "contact = true"),
        "true",
        "expected a collision",
    );
}

#[test]
fn a_waypoint_of_a_held_body_is_refused() {
    let text = include_str!("../../../../config/racket.toml");
    let at = text.find("[[event]]").unwrap();
    let waypoint = "[[event]]\nname = \"way\"\nkind = \"waypoint\"\nbody = \"racket\"\n\n";
    let line = text[..at].lines().count() + 4;
    let whole = format!("{}{waypoint}{}", &text[..at], &text[at..]);
    refused(&whole, line, "\"racket\"", "expected a body that flies");
}
