//! Places to which joined bodies can, and cannot, come.

use super::refusals::refused;
use crate::config::scene_from_toml;

/// A rod of 300 mm on a nail at a height of 1 m, and one of 100 mm on that, with a goal for the end of the second.
fn with(goal: &str, parent: &str) -> String {
    format!(
        r#"name = "two rods"
[timing]
stamps = "physical"
[[body]]
name = "upper"
shape = {{ kind = "cylinder", length_mm = 300, radius_mm = 5 }}
mass_g = 100
tracked = false
[[body]]
name = "lower"
shape = {{ kind = "cylinder", length_mm = 100, radius_mm = 5 }}
mass_g = 30
features_mm = {{ end = [0, 0, -50] }}
[[body.track]]
sees = "point"
tracker = {{ position_mm = [0, 0, -50] }}
{parent}
[[joint]]
name = "elbow"
kind = "ball"
parent = "upper"
parent_at_mm = [0, 0, -150]
child = "lower"
child_at_mm = [0, 0, 50]
[[event]]
name = "start"
kind = "start"
[[event]]
name = "end"
kind = "end"
[[goal]]
event = "end"
body = "lower"
{goal}
"#
    )
}

const NAIL: &str = r#"[[joint]]
name = "nail"
kind = "ball"
parent_at_mm = [0, 0, 1000]
child = "upper"
child_at_mm = [0, 0, 150]"#;

#[test]
fn places_out_of_reach_are_refused() {
    for (goal, message) in [
        (
            "feature = \"end\"\nposition_mm = [401, 0, 1000]",
            "401.000 mm from \"nail\", from which what hangs reaches at most 400.000 mm",
        ),
        (
            "feature = \"end\"\nposition_mm = [0, 411, 1000]\nwithin_mm = 10",
            "reaches at most 400.000 mm",
        ),
        (
            "feature = \"end\"\nposition_within_mm = [[-inf, -inf, -inf], [inf, inf, 599]]",
            "reaches at most 400.000 mm",
        ),
        ("position_mm = [0, 351, 1000]", "reaches at most 350.000 mm"),
        (
            "feature = \"end\"\nposition_mm = [0, 0, 1199]",
            "reaches at least 200.000 mm",
        ),
    ] {
        let text = with(goal, NAIL);
        let line = text
            .split("[[goal]]")
            .next()
            .map(|of| of.matches('\n').count() + 1);
        refused(&text, line.expect("a goal"), "[[goal]]", message);
    }
}

#[test]
fn places_within_reach_and_wishes_are_not() {
    for goal in [
        "feature = \"end\"\nposition_mm = [400, 0, 1000]",
        "feature = \"end\"\nposition_mm = [0, 0, 1200]",
        "feature = \"end\"\nposition_mm = [0, 409, 1000]\nwithin_mm = 10",
        "feature = \"end\"\nposition_mm = [0, 0, 1199]\nwithin_mm = 10",
        "feature = \"end\"\nposition_mm = [0, 900, 1000]\nsd_mm = 10",
    ] {
        let read = scene_from_toml(&with(goal, NAIL));
        assert!(read.is_ok(), "{goal}: {read:?}");
    }
    // What flies comes everywhere.
    let flies = with("feature = \"end\"\nposition_mm = [0, 900, 1000]", "");
    assert!(scene_from_toml(&flies).is_ok());
}
