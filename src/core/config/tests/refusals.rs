use super::{error_of, with};

/// Asserts line, a piece of the message, and that the column points at `at` on that line.
pub(super) fn refused(text: &str, line: usize, at: &str, message: &str) {
    let error = error_of(text);
    let shown = error.to_string();
    assert_eq!(error.line, line, "{shown}");
    assert!(error.message.contains(message), "{shown}");
    let content = text.lines().nth(line - 1).unwrap_or_default();
    let rest: String = content.chars().skip(error.column - 1).collect();
    assert!(rest.starts_with(at), "{shown}: points at {rest:?}");
    assert!(
        shown.starts_with(&format!("scene:{line}:{}: ", error.column)),
        "{shown}"
    );
}

#[test]
fn unknown_keys_name_those_that_are_accepted() {
    let lb = with("mass_g = 6.0", "mass_lb = 6.0");
    refused(&lb, 14, "mass_lb", "");
    assert_eq!(
        error_of(&lb).message,
        "unknown key `mass_lb`, expected one of mass_g, mass_kg, density_kg_m3"
    );
    refused(
        &with("surface = \"table\"", "surfce = \"table\""),
        37,
        "surfce",
        "did you mean surface?",
    );
    refused(
        &with("length_mm = 190.0", "length_cm = 19.0"),
        13,
        "length_cm",
        "expected length_mm",
    );
    refused(
        &with("[[obstacle]]", "[[wall]]"),
        23,
        "wall",
        "unknown key `wall`, expected one of name, gravity_m_s2",
    );
    refused(
        &with("prior_sd = 0.1", "prior_sd_m_s2 = 0.1"),
        54,
        "prior_sd_m_s2",
        "expected prior_sd",
    );
}

#[test]
fn wrong_syntax_and_types_have_a_place() {
    refused(&with("kind = \"start\"", "kind = start"), 30, "start", "");
    refused(
        &with("mass_g = 6.0", "mass_g = \"6.0\""),
        14,
        "\"6.0\"",
        "expected a number",
    );
    refused(
        &with("normal = [0, 0, 2]", "normal = [0, 2]"),
        21,
        "[0, 2]",
        "`normal` has 2 numbers, expected 3",
    );
    refused(&with("[[goal]]", "[goal]"), 44, "", "[[name]]");
    refused(
        &with("kind = \"start\"\n", ""),
        28,
        "",
        "missing key `kind`",
    );
    refused(
        &with("stamps = \"tempo\"", ""),
        4,
        "",
        "missing key `stamps`",
    );
    refused("", 1, "", "missing key `name`");
    // Columns count characters, not bytes.
    refused(
        &with(
            "tip = [0, 0, -95], eraser",
            "\"früh\" = [0, 0, -95], \"Füße\" = [nan, 0, 0], eraser",
        ),
        16,
        "[nan",
        "three finite numbers",
    );
}

#[test]
fn bodies_that_cannot_be_are_refused() {
    for (from, to, line, at, message) in [
        (
            "mass_g = 6.0\n",
            "",
            11,
            "",
            "the body has no mass, expected one of",
        ),
        (
            "mass_g = 6.0",
            "mass_g = 6.0\nmass_kg = 0.006",
            15,
            "0.006",
            "given twice",
        ),
        (
            "mass_g = 6.0",
            "mass_g = -6.0",
            14,
            "-6.0",
            "expected a positive number",
        ),
        (
            "mass_g = 6.0",
            "mass_g = nan",
            14,
            "nan",
            "expected a finite number",
        ),
        (
            "mass_g = 6.0",
            "mass_g = 6e-9",
            14,
            "6e-9",
            "mass_g is in grams",
        ),
        (
            "mass_g = 6.0",
            "mass_kg = 60000",
            14,
            "60000",
            "mass_kg in kilograms",
        ),
        (
            "length_mm = 190.0",
            "length_mm = 190000.0",
            13,
            "{",
            "lengths are in millimetres",
        ),
        (
            "length_mm = 190.0, radius_mm = 3.75",
            "length_mm = 0.01, radius_mm = 0.00375",
            13,
            "{",
            "not in metres",
        ),
        (
            "length_mm = 190.0, ",
            "",
            13,
            "{",
            "missing key `length_mm`: a cylinder needs length_mm and radius_mm",
        ),
        (
            "radius_mm = 3.75 }",
            "radius_mm = 3.75, size_mm = [1, 1, 1] }",
            13,
            "[1",
            "size_mm does not apply to a cylinder",
        ),
        (
            "kind = \"cylinder\", length_mm = 190.0",
            "kind = \"tube\", length_mm = 190.0",
            13,
            "\"tube\"",
            "expected one of cuboid, rounded_cuboid, sphere",
        ),
        (
            "radius_mm = 3.75",
            "radius_mm = 0",
            13,
            "0 }",
            "expected a positive number",
        ),
        (
            "mass_g = 6.0",
            "mass_g = 6.0\nmoments_kg_m2 = [1e-5, 1e-5, 3e-5]",
            15,
            "[1e-5",
            "the sum of any two",
        ),
        (
            "mass_g = 6.0",
            "mass_g = 6.0\nmoments_kg_m2 = [1e-5, 1e-5, 0]",
            15,
            "[1e-5",
            "moment 2 is 0",
        ),
        (
            "mass_g = 6.0",
            "mass_g = 6.0\nmoments_kg_m2 = [18, 18, 0.04]",
            15,
            "[18",
            "expected at most",
        ),
        (
            "kind = \"cylinder\", length_mm = 190.0, radius_mm = 3.75",
            "kind = \"hull\", points_mm = [[0, 0, 0], [10, 0, 0], [0, 10, 0]]",
            13,
            "{",
            "span no volume",
        ),
        (
            "kind = \"cylinder\", length_mm = 190.0, radius_mm = 3.75",
            "kind = \"revolution\", profile_mm = [[0, 0], [40, 0], [40, -40]]",
            13,
            "[[0",
            "point 3 of the profile is lower",
        ),
        (
            "orientation_wxyz = [0.70710678, 0.70710678, 0, 0]",
            "orientation_wxyz = [0.7, 0.7, 0, 0]",
            15,
            "[0.7",
            "expected a unit quaternion",
        ),
        (
            "orientation_wxyz = [0.70710678, 0.70710678, 0, 0]",
            "orientation_wxyz = [nan, 1, 0, 0]",
            15,
            "[nan",
            "expected a unit quaternion",
        ),
        (
            "name = \"pencil\"\n",
            "name = \"\"\n",
            12,
            "\"\"",
            "is empty",
        ),
    ] {
        refused(&with(from, to), line, at, message);
    }
}

#[test]
fn the_world_must_be_one() {
    for (from, to, line, at, message) in [
        (
            "normal = [0, 0, 2]",
            "normal = [0, 0, 0]",
            21,
            "[0",
            "normal is zero",
        ),
        (
            "normal = [0, 0, 2]",
            "normal = [0, 0, inf]",
            21,
            "[0",
            "finite",
        ),
        (
            "[0.0, 0.0, -9.81]",
            "[0.0, 0.0, -9810]",
            2,
            "[",
            "in metres",
        ),
        (
            "stamps = \"tempo\"",
            "stamps = \"real\"",
            5,
            "\"real",
            "\"tempo\", \"physical\" or \"edited\"",
        ),
        (
            "stamps = \"tempo\"",
            "stamps = \"physical\"\ntempo_sd_per_sqrt_s = 1",
            6,
            "1",
            "does not apply",
        ),
        ("position_mm = 5", "position_mm = 0", 8, "0", "positive"),
        (
            "name = \"pencil, tip first\"",
            "name = \" \"",
            1,
            "\" \"",
            "empty",
        ),
        (
            "name = \"pencil, tip first\"",
            "name = \"a\"\nmarks_topic = \"/tracker/pencil/pose\"",
            13,
            "\"pencil\"",
            "a second use of the topic",
        ),
    ] {
        refused(&with(from, to), line, at, message);
    }
    refused(
        "name = \"x\"\ntiming = { stamps = \"physical\" }",
        1,
        "\"x\"",
        "no body",
    );
}

#[test]
fn events_and_goals_refer_to_what_exists() {
    for (from, to, line, at, message) in [
        (
            "feature = \"tip\"",
            "feature = \"point\"",
            36,
            "\"point\"",
            "expected one of \"eraser\", \"tip\"",
        ),
        (
            "surface = \"table\"",
            "surface = \"floor\"",
            37,
            "\"floor\"",
            "unknown surface \"floor\", expected \"table\"",
        ),
        (
            "restitution = 0.6",
            "restitution = 1.6",
            38,
            "1.6",
            "expected 0 to 1",
        ),
        (
            "restitution = 0.6",
            "restitution = nan",
            38,
            "nan",
            "finite",
        ),
        (
            "restitution = 0.6\n",
            "",
            32,
            "",
            "missing key `restitution`",
        ),
        (
            "kind = \"start\"",
            "kind = \"start\"\nbody = \"pencil\"",
            31,
            "\"pencil\"",
            "body does not apply to an event of kind \"start\"",
        ),
        (
            "kind = \"start\"",
            "kind = \"split\"",
            30,
            "\"split\"",
            "expected one of start, collision, change, waypoint, end",
        ),
        (
            "kind = \"start\"",
            "kind = \"end\"",
            30,
            "\"end\"",
            "expected it after every other",
        ),
        (
            "kind = \"end\"",
            "kind = \"start\"",
            42,
            "\"start\"",
            "expected it before every other",
        ),
        (
            "name = \"landing\"",
            "name = \"bounce\"",
            41,
            "\"bounce\"",
            "a second event",
        ),
        (
            "event = \"landing\"",
            "event = \"rest\"",
            45,
            "\"rest\"",
            "unknown event",
        ),
        (
            "position_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]",
            "",
            44,
            "",
            "a goal needs",
        ),
        (
            "position_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]",
            "position_within_mm = [[0, 0, 100], [1, 1, 99]]",
            47,
            "[[0",
            "allows z from 100 to 99",
        ),
        (
            "position_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]",
            "position_within_mm = [[nan, 0, 0], [1, 1, 1]]",
            47,
            "[[nan",
            "allows x from NaN",
        ),
        (
            "position_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]",
            "position_within_mm = [[-inf, -inf, -inf], [inf, inf, inf]]",
            47,
            "[[-inf",
            "bounds nothing",
        ),
        (
            "[[free]]\nquantity = \"gravity.z\"",
            "[[goal]]\nevent = \"landing\"\nbody = \"pencil\"\nposition_within_mm = [[0, 0, 0], [1, 1, 1]]\n[[free]]\nquantity = \"gravity.z\"",
            50,
            "",
            "an earlier goal for \"pencil\" at \"landing\" contradicts this",
        ),
    ] {
        refused(&with(from, to), line, at, message);
    }
}

#[test]
fn goals_at_rest_are_of_what_can_rest_so() {
    let pose = "event = \"landing\"\nbody = \"pencil\"\nposition_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]";
    let settles = with("[timing]", "settle_s = 5\n[timing]");
    let goal = |keys: &str| settles.replace(pose, keys);
    for (keys, line, at, message) in [
        (
            "event = \"landing\"\nbody = \"pencil\"\nface_up = \"+z\"",
            46,
            "\"landing\"",
            "expected event = \"rest\"",
        ),
        (
            "event = \"rest\"\nbody = \"pencil\"\nface_up = \"z\"",
            48,
            "\"z\"",
            "expected an axis or a face of \"pencil\": +x, -x, +y, -y, +z, -z",
        ),
        (
            "event = \"rest\"\nbody = \"pencil\"\nface_up = \"+z\"\nwithin_deg = 90",
            49,
            "90",
            "expected less than 90",
        ),
        (
            "event = \"rest\"\nbody = \"pencil\"\nface_up = \"+z\"\nlabels = \"loose\"",
            49,
            "\"loose\"",
            "expected \"fixed\" or \"free\"",
        ),
        (
            "event = \"rest\"\nbody = \"pencil\"\nface_up = \"+z\"\nposition_mm = [0, 0, 0]",
            49,
            "[0, 0, 0]",
            "does not apply to a goal at rest",
        ),
        (
            "event = \"rest\"\nbody = \"pencil\"\nface_up = \"+z\"\n[[goal]]\nevent = \"rest\"\nbody = \"pencil\"\nface_up = \"-z\"",
            49,
            "",
            "a second goal",
        ),
    ] {
        refused(&goal(keys), line, at, message);
    }
    let up = "event = \"rest\"\nbody = \"pencil\"\nface_up = \"+z\"";
    let still = with(pose, up);
    refused(&still, 45, "\"rest\"", "expected settle_s");
    let weightless = goal(up).replace("[0.0, 0.0, -9.81]", "[0, 0, 0]");
    refused(&weightless, 48, "\"+z\"", "without gravity nothing is up");
}

#[test]
fn free_quantities_are_consistent() {
    for (from, to, line, at, message) in [
        (
            "\"gravity.z\"",
            "\"gravity.w\"",
            51,
            "\"gravity.w\"",
            "one of gravity.x, gravity.y, gravity.z, bounce.restitution, bounce.friction, bounce.tilt.0",
        ),
        (
            "\"gravity.z\"",
            "\"landing.restitution\"",
            51,
            "\"landing",
            "unknown quantity",
        ),
        (
            "lower = -12.0",
            "lower_deg = -12.0",
            52,
            "lower_deg",
            "unknown key `lower_deg`, expected lower",
        ),
        (
            "lower = -12.0",
            "lower = -9.0",
            51,
            "\"gravity.z\"",
            "begins at -9.81 m/s²",
        ),
        (
            "lower = -12.0",
            "lower = -5.0",
            53,
            "-7.0",
            "the upper one above",
        ),
        (
            "lower = -12.0",
            "lower = nan",
            52,
            "nan",
            "lower bound of gravity.z is NaN",
        ),
        (
            "upper = -7.0",
            "upper = nan",
            53,
            "nan",
            "upper bound of gravity.z is NaN",
        ),
        (
            "lower = -12.0",
            "initial = -13\nlower = -12.0",
            52,
            "-13",
            "begins at -13",
        ),
        ("prior_sd = 0.1", "prior_sd = 0.0", 54, "0.0", "positive"),
        ("prior_sd = 0.1", "prior_sd = inf", 54, "inf", "finite"),
        (
            "\"bounce.restitution\"",
            "\"bounce.restitution\"\nupper = 1.5",
            58,
            "1.5",
            "expected 1 or less",
        ),
        (
            "\"bounce.restitution\"",
            "\"gravity.z\"",
            57,
            "\"gravity.z\"",
            "a second free quantity",
        ),
    ] {
        refused(&with(from, to), line, at, message);
    }
}

#[test]
fn settling_takes_a_time() {
    for (value, message) in [
        ("0", "settle_s is 0, expected a positive number"),
        ("nan", "settle_s is NaN, expected a finite number"),
        ("61", "settle_s is 61 s, expected at most 60"),
        ("true", "expected a number"),
    ] {
        let text = super::PENCIL.replace("[timing]", &format!("settle_s = {value}\n\n[timing]"));
        refused(&text, 4, value, message);
    }
}
