use nalgebra::Vector3;

use super::refusals::refused;
use super::{error_of, with};
use crate::config::scene_from_toml;
use crate::motion::{Axes, BodyPoint, Condition, Goal, GoalQuantity, GoalSet, GoalTarget, Moment};

/// The scene with other keys in its goal at the landing; they begin at line 47.
fn goal(keys: &str) -> String {
    with(
        "position_mm = [300, 0, 99]\norientation_wxyz = [1, 0, 0, 0]",
        keys,
    )
}

/// The same at the bounce.
fn at_bounce(keys: &str) -> String {
    goal(keys).replace("event = \"landing\"", "event = \"bounce\"")
}

fn goals(text: &str) -> Vec<Goal> {
    match scene_from_toml(text) {
        Ok(scene) => scene.goals,
        Err(error) => panic!("{error}\n{text}"),
    }
}

fn condition(text: &str) -> Condition {
    match &goals(text)[..] {
        [goal] => match &goal.target {
            GoalTarget::Condition(condition) => condition.clone(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn sets_of_a_position() {
    let centre = BodyPoint::Centre;
    let quantity = GoalQuantity::Position {
        point: centre,
        seen_from: None,
    };
    let at = Vector3::new(0.3, 0.0, 0.1);
    let ball = condition(&goal("position_mm = [300, 0, 100]\nwithin_mm = 20"));
    assert_eq!(ball.quantity, quantity);
    assert_eq!(
        ball.set,
        GoalSet::Ball {
            centre: at,
            radius: 0.02
        }
    );
    let half = condition(&goal("position_mm = [300, 0, 100]\nnormal = [0, 0, 4]"));
    assert_eq!(
        half.set,
        GoalSet::HalfSpace {
            normal: Vector3::z(),
            least: 0.1
        }
    );
    let soft = condition(&goal("position_mm = [300, 0, 100]\nsd_mm = 5"));
    assert_eq!((soft.set, soft.sd), (GoalSet::point(at), Some(0.005)));
    // What is hard and of the centre of mass has a short form.
    let exact = &goals(&goal("position_mm = [300, 0, 100]"))[0].target;
    let short = GoalTarget::PositionWithin {
        lower_m: at,
        upper_m: at,
    };
    assert_eq!(*exact, short);
}

#[test]
fn points_of_a_body() {
    let point = |keys: &str| condition(&goal(keys)).quantity.point();
    let tip = Some(BodyPoint::Fixed(Vector3::new(0.0, 0.0, -0.095)));
    assert_eq!(point("position_mm = [0, 0, 50]\nfeature = \"tip\""), tip);
    assert_eq!(
        point("position_mm = [0, 0, 50]\npoint_mm = [0, 0, -95]"),
        tip
    );
    assert_eq!(point("velocity_m_s = [0, 0, 1]\nfeature = \"tip\""), tip);
    let contact = condition(&at_bounce("position_mm = [0, 0, 10]\ncontact = true"));
    assert_eq!(contact.quantity.point(), Some(BodyPoint::Contact(0)));
    // A point and an orientation are a pose.
    let text = goal("position_mm = [0, 0, 50]\nfeature = \"tip\"\norientation_wxyz = [0, 1, 0, 0]");
    let GoalTarget::Pose { world_from_body } = goals(&text)[0].target else {
        panic!("a pose");
    };
    let off = world_from_body.translation.vector - Vector3::new(0.0, 0.0, -0.045);
    assert!(off.norm() < 1e-15, "{off}");
}

#[test]
fn turns_directions_velocities_spins_and_times() {
    let turn = condition(&goal(
        "orientation_wxyz = [1, 0, 0, 0]\nwithin_deg = 90\nsd_deg = 9",
    ));
    assert!(matches!(turn.quantity, GoalQuantity::Turn { .. }));
    assert_eq!(
        turn.set,
        GoalSet::about_zero(Some(std::f64::consts::FRAC_PI_2))
    );
    assert!((turn.sd.unwrap() - 0.05 * std::f64::consts::PI).abs() < 1e-15);
    let up = condition(&goal("axis = \"-z\""));
    let expected = GoalQuantity::Direction {
        axis: -Vector3::z(),
        towards: Vector3::z(),
        seen_from: None,
    };
    assert_eq!(up.quantity, expected);
    assert!(up.is_equality());
    let along = condition(&goal("axis = [0, 0, -3]\ndirection = [0, 0, 1]"));
    assert_eq!(along.quantity, expected);
    let after = condition(&at_bounce(
        "velocity_m_s = [0, 0, 1]\nwithin_m_s = 0.5\nafter = true",
    ));
    assert_eq!(after.moment, Moment::After);
    let spin = condition(&goal(
        "spin_within_rad_s = [[-inf, -inf, 3], [inf, inf, inf]]\naxes = \"body\"",
    ));
    assert_eq!(spin.quantity, GoalQuantity::Spin { axes: Axes::Body });
    let still = goals(&goal("at_rest = true\nwithin_m_s = 0.1\nwithin_rad_s = 2"));
    assert_eq!(still.len(), 2);
    let time = goal("time_within_ms = [200, inf]\nsince = \"bounce\"")
        .replace("body = \"pencil\"\ntime", "time");
    let time = condition(&time);
    assert_eq!(time.quantity, GoalQuantity::Time { since: Some(1) });
    let off_s = time.set.distance(&Vector3::new(0.15, 0.0, 0.0));
    assert!((off_s - 0.05).abs() < 1e-15, "{off_s}");
}

#[test]
fn several_goals_at_one_event_and_body() {
    let text = goal(
        "position_mm = [300, 0, 100]\nwithin_mm = 5\naxis = \"+z\"\nwithin_deg = 10\nvelocity_m_s = [0, 0, -1]\nsd_m_s = 1",
    );
    assert_eq!(goals(&text).len(), 3);
    let with_box = format!(
        "{text}\n[[goal]]\nevent = \"landing\"\nbody = \"pencil\"\nposition_within_mm = [[-inf, -inf, 97], [inf, inf, inf]]\n"
    );
    assert_eq!(goals(&with_box).len(), 4);
}

#[test]
fn misuses_are_refused_with_what_is_expected() {
    for (keys, line, at, message) in [
        ("within_mm = 3", 47, "3", "within_mm needs position_mm"),
        (
            "position_within_mm = [[0, 0, 0], [1, 1, 1]]\nwithin_mm = 3",
            48,
            "3",
            "within_mm needs position_mm",
        ),
        (
            "position_mm = [0, 0, 0]\nposition_within_mm = [[0, 0, 0], [1, 1, 1]]",
            48,
            "[[0",
            "expected one of position_mm, position_within_mm",
        ),
        (
            "position_mm = [0, 0, 0]\nwithin_mm = 3\nnormal = [0, 0, 1]",
            49,
            "[0, 0, 1]",
            "expected one of within_mm, normal",
        ),
        (
            "position_mm = [0, 0, 0]\nwithin_mm = 0",
            48,
            "0",
            "expected a positive number",
        ),
        (
            "position_mm = [0, 0, 0]\nsd_mm = -1",
            48,
            "-1",
            "expected a positive number",
        ),
        (
            "position_mm = [0, 0, 0]\nsd_mm = 0.0009",
            48,
            "0.0009",
            "without it the goal is hard",
        ),
        (
            "position_mm = [0, 0, 0]\nsd_deg = 1",
            48,
            "1",
            "sd_deg needs orientation_wxyz or axis",
        ),
        (
            "position_mm = [0, 0, 0]\nwithin_deg = 1",
            48,
            "1",
            "within_deg needs orientation_wxyz or axis",
        ),
        (
            "position_mm = [0, 0, 0]\nnormal = [0, 0, 0]",
            48,
            "[0, 0, 0]",
            "expected a direction",
        ),
        (
            "normal = [0, 0, 1]\naxis = \"+z\"",
            47,
            "[0, 0, 1]",
            "normal needs position_mm",
        ),
        (
            "position_mm = [0, 0, 0]\nvelocity_m_s = [0, 0, 0]\nnormal = [0, 0, 1]",
            49,
            "[0, 0, 1]",
            "expected a goal for each",
        ),
        (
            "position_mm = [0, 0, 0]\nfeature = \"point\"",
            48,
            "\"point\"",
            "unknown feature",
        ),
        (
            "position_mm = [0, 0, 0]\nfeature = \"end +z\"",
            48,
            "\"end +z\"",
            "no one point",
        ),
        (
            "position_mm = [0, 0, 0]\nfeature = \"tip\"\npoint_mm = [0, 0, 0]",
            48,
            "\"tip\"",
            "expected one of point_mm, feature",
        ),
        (
            "position_mm = [0, 0, 0]\ncontact = true",
            48,
            "true",
            "touches nothing at \"landing\"",
        ),
        (
            "axis = \"+z\"\nfeature = \"tip\"",
            48,
            "\"tip\"",
            "feature needs a position or a velocity",
        ),
        (
            "position_mm = [0, 0, 0]\nrelative_to = \"hat\"",
            48,
            "\"hat\"",
            "unknown body",
        ),
        (
            "position_mm = [0, 0, 0]\nrelative_to = \"pencil\"",
            48,
            "\"pencil\"",
            "expected another",
        ),
        ("axis = \"z\"", 47, "\"z\"", "expected an axis or a face"),
        ("axis = [0, 0, 0]", 47, "[0, 0, 0]", "expected a direction"),
        (
            "axis = \"+z\"\nwithin_deg = 180",
            48,
            "180",
            "expected less than 180",
        ),
        (
            "axis = \"+z\"\norientation_wxyz = [1, 0, 0, 0]",
            47,
            "\"+z\"",
            "expected one of orientation_wxyz, axis",
        ),
        (
            "direction = [0, 0, 1]\nposition_mm = [0, 0, 0]",
            47,
            "[0, 0, 1]",
            "direction needs axis",
        ),
        (
            "spin_rad_s = [0, 0, 0]\naxes = \"own\"",
            48,
            "\"own\"",
            "expected \"world\" or \"body\"",
        ),
        (
            "position_mm = [0, 0, 0]\naxes = \"body\"",
            48,
            "\"body\"",
            "axes needs a spin",
        ),
        (
            "velocity_m_s = [0, 0, 0]\nafter = true",
            48,
            "true",
            "expected a collision of it",
        ),
        (
            "at_rest = true\nspin_rad_s = [0, 0, 0]",
            47,
            "true",
            "expected it or others",
        ),
        (
            "time_ms = 300\ntime_within_ms = [0, 1]",
            48,
            "[0, 1]",
            "expected one of time_ms",
        ),
        ("time_within_ms = [2, 1]", 47, "[2, 1]", "one not before it"),
        (
            "time_ms = 300\nsince = \"landing\"",
            48,
            "\"landing\"",
            "expected another",
        ),
        (
            "position_mm = [0, 0, 0]\nsince = \"bounce\"",
            48,
            "\"bounce\"",
            "since needs a time",
        ),
        (
            "time_ms = 300",
            46,
            "\"pencil\"",
            "body does not apply to a time",
        ),
        ("labels = \"free\"", 47, "\"free\"", "labels needs face_up"),
    ] {
        refused(&goal(keys), line, at, message);
    }
    let nobody = goal("axis = \"+z\"").replace("body = \"pencil\"\naxis", "axis");
    refused(&nobody, 44, "", "missing key `body`");
    let later = at_bounce("position_mm = [0, 0, 10]\nafter = true");
    refused(&later, 48, "true", "after needs a velocity");
    let both = at_bounce("position_mm = [0, 0, 10]\ncontact = true\npoint_mm = [0, 0, 0]");
    refused(&both, 49, "[0, 0, 0]", "expected one of contact, point_mm");
    let off = at_bounce("position_mm = [0, 0, 30]\ncontact = true");
    refused(&off, 44, "", "on a face 20.000 mm from there");
    let fixed = goal("time_ms = 300")
        .replace("body = \"pencil\"\ntime", "time")
        .replace("stamps = \"tempo\"", "stamps = \"physical\"");
    refused(&fixed, 44, "", "expected time = \"free\"");
}

#[test]
fn contradictions_are_refused_where_they_can_be_told() {
    let tip = "position_mm = [0, 0, 50]\nfeature = \"tip\"";
    for (first, second, message) in [
        (
            "position_mm = [0, 0, 0]\norientation_wxyz = [1, 0, 0, 0]",
            "position_mm = [0, 0, 10]\norientation_wxyz = [1, 0, 0, 0]",
            "0.010000 m off",
        ),
        (
            "position_mm = [0, 0, 0]\norientation_wxyz = [1, 0, 0, 0]",
            "position_mm = [0, 0, 0]\norientation_wxyz = [0, 1, 0, 0]",
            "rad",
        ),
        (
            "position_mm = [0, 0, 0]\norientation_wxyz = [1, 0, 0, 0]",
            "axis = \"-z\"\nwithin_deg = 170",
            "rad off",
        ),
        (
            "position_mm = [0, 0, 0]\norientation_wxyz = [1, 0, 0, 0]",
            tip,
            "off",
        ),
        (
            "position_within_mm = [[0, 0, 0], [1, 1, 1]]",
            "position_within_mm = [[0, 0, 2], [1, 1, inf]]",
            "0.001000 m apart",
        ),
        (
            "position_mm = [0, 0, 0]\nwithin_mm = 3",
            "position_mm = [0, 8, 0]\nwithin_mm = 4",
            "0.001000 m apart",
        ),
        (
            "position_mm = [0, 0, 0]\nnormal = [0, 0, 1]",
            "position_mm = [0, 0, -2]\nnormal = [0, 0, -1]",
            "0.002000 m apart",
        ),
        (
            "orientation_wxyz = [1, 0, 0, 0]\nwithin_deg = 10",
            "orientation_wxyz = [0, 1, 0, 0]\nwithin_deg = 160",
            "rad apart",
        ),
        (
            "axis = \"+z\"\nwithin_deg = 30",
            "axis = \"-z\"\nwithin_deg = 30",
            "rad apart",
        ),
        (
            "axis = \"+z\"",
            "axis = \"+x\"\ndirection = [0, 1, 0]",
            "expected orientation_wxyz",
        ),
        (
            tip,
            "position_mm = [0, 0, 240]\nfeature = \"eraser\"",
            "expected one with within_mm",
        ),
        (
            "velocity_m_s = [0, 0, 0]",
            "velocity_m_s = [0, 0, 1]\nwithin_m_s = 0.5",
            "0.500000 m/s apart",
        ),
    ] {
        let text = goal(&format!(
            "{first}\n[[goal]]\nevent = \"landing\"\nbody = \"pencil\"\n{second}"
        ));
        let line = 47 + first.lines().count();
        refused(&text, line, "", message);
        // With a weight one of them may be missed.
        let sd = match () {
            () if second.contains("axis") || !second.contains("_m") => "sd_deg = 5",
            () if second.contains("m_s") => "sd_m_s = 1",
            () if second.contains("orientation") => "sd_mm = 5\nsd_deg = 5",
            () => "sd_mm = 5",
        };
        goals(&text.replace(second, &format!("{second}\n{sd}")));
    }
    let agree = "position_mm = [0, 0, 50]\norientation_wxyz = [1, 0, 0, 0]\n[[goal]]\nevent = \"landing\"\nbody = \"pencil\"\naxis = \"+z\"\nwithin_deg = 5";
    assert_eq!(goals(&goal(agree)).len(), 2);
    let again = error_of(&goal("position_mm = [0, 0, 0]\nposition_mm = [0, 0, 1]"));
    assert!(again.to_string().contains("duplicate key"), "{again}");
}

#[test]
fn a_pose_at_a_collision_is_in_one_of_its_contacts() {
    let open = |text: &str| text.replace("feature = \"tip\"\nsurface = \"table\"", "");
    let pose = |z_mm: f64| {
        at_bounce(&format!(
            "position_mm = [0, 0, {z_mm}]\norientation_wxyz = [1, 0, 0, 0]"
        ))
    };
    let z_m = |text: &str| match goals(text)[0].target {
        GoalTarget::Pose { world_from_body } => world_from_body.translation.z,
        ref other => panic!("{other:?}"),
    };
    // The table is at 10 mm, the mug's floor ends at 4 mm.
    let apart = "between \"pencil\" and what it touches at \"bounce\", expected at most 1 mm";
    refused(&pose(3000.0), 44, "", &format!("leaves 2895 mm {apart}"));
    refused(
        &open(&pose(3000.0)),
        43,
        "",
        &format!("leaves 2895 mm {apart}"),
    );
    refused(&open(&pose(12.0)), 43, "", apart);
    assert!((z_m(&pose(105.5)) - 0.105).abs() < 1e-12);
    let scene = scene_from_toml(&open(&pose(105.0))).unwrap();
    let [only] = &scene.candidates(1)[..] else {
        panic!("{:?}", scene.candidates(1));
    };
    assert_eq!(scene.words_of(1, only).unwrap(), "tip on table");
}
