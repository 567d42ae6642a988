//! `enact scene from-urdf`: what it writes, what it says, what it refuses and where.

use std::fs;
use std::path::Path;
use std::time::Instant;

use assert_cmd::Command;
use enact::config::{scene_from_toml, scene_from_urdf};
use enact::math::Pose;
use enact::motion::Scene;
use enact::physics::Shape;
use enact::physics::tree::JointKind;
use enact::pipeline::Pipeline;
use enact_tools::replay::Program;
use enact_tools::trees::{self, Jointed, Kind, TreeActing};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use serde_json::Value;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

const MASS: &str = r#"<inertial><mass value="1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.0025"/></inertial>"#;

/// A hinge on the world and a bracket, a line each.
fn hinge(of_link: &str, of_joint: &str) -> String {
    format!(
        r#"<robot name="gate">
<link name="world"/>
<link name="gate">
{MASS}
{of_link}
</link>
<joint name="hinge" type="revolute">
<parent link="world"/><child link="gate"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1.5"/>
{of_joint}
</joint>
</robot>
"#
    )
}

fn read(text: &str) -> Scene {
    let made = scene_from_urdf(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    scene_from_toml(&made.toml).expect("the scene is read again")
}

/// Where the first body's tracker is: the frame of its link.
fn body_from_link(scene: &Scene) -> Pose {
    let track = scene.tracks.iter().next().expect("a tracked body");
    track.link_from_tracker
}

#[test]
fn limits_damping_and_names_come_through_and_nothing_is_said_of_what_is_read() {
    let text = hinge("", r#"<dynamics damping="0.25"/>"#);
    let made = scene_from_urdf(&text).unwrap();
    assert_eq!(
        (made.name.as_str(), made.bodies, made.joints),
        ("gate", 1, 1)
    );
    assert_eq!(made.lost, [""; 0]);
    let box_of_moments = r#"line 4: "gate" has no solid: its shape is a box of the same moments"#;
    assert_eq!(made.notes, [box_of_moments]);
    let scene = read(&text);
    let (_, joined) = scene.joint_trees().next().unwrap();
    let joint = &joined.joints[0];
    assert_eq!(joint.name, "hinge");
    assert_eq!(joint.parent, None);
    let axis = Vector3::z();
    assert_eq!(joint.joint.kind, JointKind::Pin { axis });
    assert_eq!(joint.joint.damping_n_m_s, 0.25);
    let [lower, upper] = joint.joint.limits_rad[0];
    assert!((lower + 1.0).abs() < 1e-15 && (upper - 1.5).abs() < 1e-15);
    // The box has the moments that the body has.
    let body = scene.links.iter().next().unwrap();
    let uniform = body.shape.body_of_mass_kg(1.0).unwrap();
    let off = uniform.moments_kg_m2() - body.body.moments_kg_m2();
    assert!(off.amax() < 1e-15, "{off}");
    assert_eq!(
        body.body.moments_kg_m2(),
        Vector3::new(0.001, 0.002, 0.0025)
    );
}

#[test]
fn what_is_not_read_is_said_with_its_line() {
    let of_link = r#"<visual><geometry><mesh filename="gate.stl"/></geometry><material name="grey"/></visual>
<collision><origin xyz="0 0 0"/><geometry><box size="0.4 0.2 0.1"/></geometry></collision>"#;
    let of_joint = r#"<dynamics damping="0" friction="0.1"/>
<safety_controller k_velocity="1"/>
<limits/>"#;
    let text = hinge(of_link, of_joint).replace("</robot>", "<gazebo/>\n<gazebo/>\n</robot>");
    let made = scene_from_urdf(&text).unwrap();
    let friction = "dry friction in a joint is not read: joints have damping alone";
    assert_eq!(made.lost, [format!("line 11: {friction}")]);
    assert_eq!(
        made.notes,
        [
            "line 5: <material> in <visual> is not read",
            "line 12: <safety_controller> in <joint> is not read",
            "line 13: <limits> in <joint> is not read",
            "line 15: <gazebo> in <robot> is not read, 2 times in all",
            "line 5: a mesh of \"gate\" is not read",
        ]
    );
}

/// What no scene can have: a change of the hinge, where the error is, what it says.
#[test]
fn what_no_scene_can_have_is_refused_where_it_is() {
    let changed = |from: &str, to: &str| {
        let text = hinge("", "");
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let second_root = "</robot>";
    let circle = r#"<link name="a"/><link name="b"/>
<joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint>
</robot>"#;
    let moving = r#"<link name="end"/>
<joint name="last" type="continuous"><parent link="gate"/><child link="end"/></joint>
</robot>"#;
    let cases: Vec<(String, [usize; 2], &[&str])> = vec![
        (String::new(), [1, 1], &["no XML"]),
        ("<robot name=\"x\">".into(), [1, 1], &["no XML"]),
        ("<scene/>".into(), [1, 1], &["<scene>", "expected <robot>"]),
        (changed(" name=\"gate\">\n<link", ">\n<link"), [1, 1], &["<robot> has no name"]),
        ("<robot name=\"x\"/>".into(), [1, 1], &["no <link>"]),
        (changed("\"revolute\"", "\"prismatic\""), [7, 21], &["hinge", "prismatic", "expected joints that turn"]),
        (changed("\"revolute\"", "\"planar\""), [7, 21], &["planar", "expected joints that turn"]),
        (changed("\"revolute\"", "\"hinged\""), [7, 21], &["\"hinged\"", "\"continuous\""]),
        (hinge("", "<mimic joint=\"other\"/>"), [10, 1], &["hinge", "<mimic>"]),
        (changed("lower=\"-1\"", "lower=\"2\""), [7, 1], &["limits 2 and 1.5", "continuous"]),
        (changed("<limit lower=\"-1\" upper=\"1.5\"/>", ""), [7, 1], &["no <limit>"]),
        (changed("xyz=\"0 0 1\"", "xyz=\"0 0 0\""), [8, 43], &["axis", "is zero"]),
        (changed("xyz=\"0 0 1\"", "xyz=\"0 0 x 1\""), [8, 49], &["\"0 0 x 1\"", "3 numbers"]),
        (changed("xyz=\"0 0 1\"", "xyz=\"0,0,1\""), [8, 49], &["\"0,0,1\"", "3 numbers"]),
        (changed("xyz=\"0 0 1\"", "xyz=\"0 NaN 1\""), [8, 49], &["NaN"]),
        (changed("value=\"1\"", "value=\"-1\""), [4, 1], &["mass is -1 kg"]),
        (changed("value=\"1\"", "value=\"1e5\""), [3, 7], &["100000 kg"]),
        (changed("ixx=\"0.001\"", "ixx=\"0.1\""), [3, 7], &["sum of any two"]),
        (changed("<mass value=\"1\"/>", ""), [4, 1], &["expected <mass> and <inertia>"]),
        (changed(MASS, ""), [3, 7], &["\"gate\" moves and has no mass", "<inertial>"]),
        (changed(MASS, &format!("{MASS}{MASS}")), [4, 1 + MASS.len()], &["second <inertial>"]),
        (changed("child link=\"gate\"", "child link=\"door\""), [8, 30], &["\"door\"", "<link> of that name"]),
        (changed("name=\"gate\">\n<inertial", "name=\"world\">\n<inertial"), [3, 7], &["second link \"world\""]),
        (changed(second_root, "<link name=\"other\"/></robot>"), [12, 7], &["\"world\" and \"other\"", "a joint that ties"]),
        (changed(second_root, circle), [12, 7], &["\"a\" hangs from itself", "circle"]),
        (changed("parent link=\"world\"", "parent link=\"gate\""), [3, 7], &["\"gate\" hangs from itself", "circle"]),
        (changed(second_root, moving), [12, 7], &["\"end\" moves and has no mass"]),
        (changed("<link name=\"world\"/>", ""), [8, 9], &["ties \"world\""]),
        (
            changed("name=\"world\"", "name=\"stand\"").replace("link=\"world\"", "link=\"stand\""),
            [2, 7],
            &["\"stand\" has no mass", "the name \"world\""],
        ),
        (
            changed("type=\"revolute\"", "type=\"fixed\""),
            [1, 1],
            &["nothing can move"],
        ),
        (
            changed(second_root, "<link name=\"second\">\n")
                + MASS
                + "</link>\n<joint name=\"more\" type=\"fixed\"><parent link=\"world\"/><child link=\"second\"/></joint></robot>",
            [15, 8],
            &["\"more\" hangs a second mechanism from the world"],
        ),
        (
            hinge("<collision><geometry><box size=\"0.01 0.01 0.01\"/></geometry></collision>", ""),
            [3, 7],
            &["no 1 kg within this shape have more"],
        ),
        (
            hinge("<collision><geometry><box size=\"1 1 0\"/></geometry></collision>", ""),
            [5, 22],
            &["<box> has no size"],
        ),
        (
            "<robot name=\"x\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:include filename=\"a\"/></robot>".into(),
            [2, 1],
            &["xacro"],
        ),
        (changed("name=\"hinge\"", "name=\" \""), [7, 8], &["is empty"]),
    ];
    for (text, place, said) in cases {
        let error = match scene_from_urdf(&text) {
            Ok(made) => panic!("{said:?} is not refused\n{text}\n{}", made.toml),
            Err(error) => error,
        };
        for part in said {
            assert!(error.message.contains(part), "{part}: {error}\n{text}");
        }
        assert_eq!([error.line, error.column], place, "{error}\n{text}");
    }
}

/// Turns in a row with no mass between: axes that meet are one joint, others are refused.
#[test]
fn axes_that_do_not_meet_are_refused() {
    let robot = |second: &str, more: &str, third: &str| {
        format!(
            r#"<robot name="r"><link name="base">{MASS}</link><link name="between"/>{third}
<link name="end">{MASS}</link>
<joint name="one" type="continuous"><parent link="base"/><child link="between"/><axis xyz="1 0 0"/></joint>
<joint name="two" type="continuous">{second}<parent link="between"/><child link="end"/>{more}</joint></robot>"#
        )
    };
    let ok = robot("<origin xyz=\"0.3 0 0\"/><axis xyz=\"0 1 0\"/>", "", "");
    let made = scene_from_urdf(&ok).unwrap();
    let merged = r#"line 4: "one", "two" become one universal joint"#;
    assert!(made.notes.iter().any(|of| of == merged), "{:?}", made.notes);
    // One with limits and one without.
    let limited = ok.replace(
        "name=\"two\" type=\"continuous\">",
        "name=\"two\" type=\"revolute\"><limit lower=\"-0.5\" upper=\"1e16\"/>",
    );
    let scene = read(&limited);
    let (_, joined) = scene.joint_trees().next().unwrap();
    let [first, second] = joined.joints[0].joint.limits_rad;
    assert_eq!(first, [f64::NEG_INFINITY, f64::INFINITY]);
    assert!(
        (second[0] + 0.5).abs() < 1e-15 && second[1] > 1e15,
        "{second:?}"
    );
    let third = "<link name=\"third\"/><joint name=\"zero\" type=\"continuous\"><parent link=\"between\"/><child link=\"third\"/><axis xyz=\"0 0 1\"/></joint>";
    let ball = |more: &str| {
        robot("<axis xyz=\"0 1 0\"/>", more, third).replace(
            "<parent link=\"between\"/><child link=\"end\"/>",
            "<parent link=\"third\"/><child link=\"end\"/>",
        )
    };
    let scene = read(&ball(""));
    let (_, joined) = scene.joint_trees().next().unwrap();
    assert_eq!(joined.joints[0].joint.kind, JointKind::Ball);
    for (text, said) in [
        (
            robot("<origin xyz=\"0 0 0.001\"/><axis xyz=\"0 1 0\"/>", "", ""),
            "pass each other at 1 mm",
        ),
        (robot("<axis xyz=\"-1 0 0\"/>", "", ""), "are parallel"),
        (
            robot("<axis xyz=\"0 1 0\"/>", "<dynamics damping=\"1\"/>", ""),
            "one damping, not 0 and 1",
        ),
        (ball("<dynamics damping=\"1\"/>"), "none of a ball"),
        (ball("<origin xyz=\"0 0.1 0.2\"/>"), "\"one\" and \"zero\""),
        (
            ball("").replace("\"0 1 0\"", "\"0 1 1\""),
            "not at right angles",
        ),
    ] {
        let error = scene_from_urdf(&text).map(|made| made.toml);
        let error = error.expect_err(said);
        if said.starts_with("\"one\"") {
            assert!(error.message.contains("do not meet in a point"), "{error}");
        } else {
            assert!(error.message.contains(said), "{said}: {error}");
        }
    }
}

/// The axes of a body: the link's own where they are principal, those of its solid where these are.
#[test]
fn solids_are_whole_where_they_lie_along_principal_axes_and_hulls_elsewhere() {
    let solid = |origin: &str, geometry: &str| {
        format!("<collision><origin {origin}/><geometry>{geometry}</geometry></collision>")
    };
    let shape_and_turn = |text: &str| {
        let scene = read(text);
        let link = scene.links.iter().next().unwrap();
        let turn = body_from_link(&scene).rotation.inverse();
        (link.shape.clone(), turn.to_rotation_matrix().into_inner())
    };
    let brick = r#"<box size="0.4 0.2 0.1"/>"#;
    let (shape, turn) = shape_and_turn(&hinge(&solid("", brick), ""));
    let half_extents_m = Vector3::new(0.2, 0.1, 0.05);
    assert_eq!(shape, Shape::Cuboid { half_extents_m });
    assert_eq!(turn, Matrix3::identity());
    // A quarter turn as people type it.
    let (shape, turn) = shape_and_turn(&hinge(&solid("rpy=\"0 0 1.5708\"", brick), ""));
    let half_extents_m = Vector3::new(0.1, 0.2, 0.05);
    assert_eq!(shape, Shape::Cuboid { half_extents_m });
    assert_eq!(turn, Matrix3::identity());
    // A rod along x: the body's z is along it.
    let rod = r#"<cylinder radius="0.1" length="0.6"/>"#;
    let quarter = std::f64::consts::FRAC_PI_2;
    let (shape, turn) = shape_and_turn(&hinge(&solid(&format!("rpy=\"0 {quarter} 0\""), rod), ""));
    assert!(matches!(shape, Shape::Cylinder { .. }), "{shape:?}");
    assert!((turn.column(2) - Vector3::x()).amax() < 1e-12, "{turn}");
    // Somewhere else: the hull of its corners, which are where it is.
    let (shape, turn) =
        shape_and_turn(&hinge(&solid("xyz=\"0.1 0 0\" rpy=\"0 0 0.3\"", brick), ""));
    assert_eq!(turn, Matrix3::identity());
    let Shape::Hull { points_m } = shape else {
        panic!("{shape:?}");
    };
    assert_eq!(points_m.len(), 8);
    let (sin, cos) = 0.3_f64.sin_cos();
    let corner = Vector3::new(0.1 + 0.2 * cos - 0.1 * sin, 0.2 * sin + 0.1 * cos, 0.05);
    let nearest = points_m.iter().map(|of| (of - corner).norm());
    assert!(
        nearest.fold(f64::INFINITY, f64::min) < 1e-12,
        "{points_m:?}"
    );
    let round = [
        r#"<sphere radius="0.2"/>"#,
        r#"<capsule radius="0.1" length="0.4"/>"#,
        rod,
    ];
    for solid_of in round {
        let (shape, _) = shape_and_turn(&hinge(&solid("xyz=\"0 0 0.01\"", solid_of), ""));
        let Shape::Hull { points_m } = shape else {
            panic!("{shape:?}");
        };
        // All corners are on the solid.
        for of in points_m {
            let at = of - Vector3::new(0.0, 0.0, 0.01);
            let off = match solid_of {
                ball if ball.starts_with("<sphere") => at.norm() - 0.2,
                capsule if capsule.starts_with("<capsule") => {
                    (at - Vector3::z() * at.z.clamp(-0.2, 0.2)).norm() - 0.1
                }
                _ => (at.xy().norm() - 0.1).abs().max((at.z.abs() - 0.3).abs()),
            };
            assert!(off.abs() < 1e-12, "{solid_of}: {of}");
        }
    }
}

/// A tensor turned by a third of a turn about the diagonal, and then a little: the axes are the nearest principal ones.
#[test]
fn axes_of_a_turned_tensor_are_the_principal_ones_nearest_to_the_links() {
    let angle: f64 = 0.2;
    let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    for moments in [
        Vector3::new(0.001, 0.002, 0.0025),
        Vector3::new(0.003, 0.001, 0.003),
    ] {
        let tensor = turn.matrix() * Matrix3::from_diagonal(&moments) * turn.matrix().transpose();
        let text = hinge("", "").replace(
            "ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.002\" iyz=\"0\" izz=\"0.0025\"",
            &format!(
                "ixx=\"{:?}\" ixy=\"{:?}\" ixz=\"0\" iyy=\"{:?}\" iyz=\"0\" izz=\"{:?}\"",
                tensor[(0, 0)],
                tensor[(0, 1)],
                tensor[(1, 1)],
                tensor[(2, 2)]
            ),
        );
        let scene = read(&text);
        let link = scene.links.iter().next().unwrap();
        let found = body_from_link(&scene)
            .rotation
            .inverse()
            .to_rotation_matrix();
        assert!((found.matrix() - turn.matrix()).amax() < 1e-9, "{found}");
        assert!((link.body.moments_kg_m2() - moments).amax() < 1e-14);
    }
}

fn from_urdf(input: &Path, options: &[&str]) -> std::process::Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    let command = command.env_remove("RUST_LOG").args(["scene", "from-urdf"]);
    command.arg(input).args(options).output().unwrap()
}

#[test]
fn the_command_writes_a_scene_beside_the_file_and_replaces_none() {
    let folder = TempDir::new().unwrap();
    let input = folder.path().join("gate.urdf");
    let absent = from_urdf(&input, &[]);
    assert_eq!(absent.status.code(), Some(1));
    let said = String::from_utf8(absent.stderr).unwrap();
    assert!(said.contains("gate.urdf: cannot read"), "{said}");
    fs::write(&input, hinge("", "<dynamics friction=\"1\"/>")).unwrap();
    let lossy = from_urdf(&input, &["--format", "ndjson"]);
    assert_eq!(lossy.status.code(), Some(3), "{lossy:?}");
    let said: Value = serde_json::from_slice(&lossy.stdout).unwrap();
    assert_eq!(said["lost"].as_array().unwrap().len(), 1, "{said}");
    let output = folder.path().join("gate.toml");
    let text = fs::read_to_string(&output).unwrap();
    assert_eq!(scene_from_toml(&text).unwrap().name, "gate");
    fs::write(&output, "worked on").unwrap();
    fs::write(&input, hinge("", "")).unwrap();
    let again = from_urdf(&input, &[]);
    assert_eq!(again.status.code(), Some(1));
    let said = String::from_utf8(again.stderr).unwrap();
    assert!(
        said.contains("is there already") && said.contains("-o FILE"),
        "{said}"
    );
    assert_eq!(fs::read_to_string(&output).unwrap(), "worked on");
    let other = folder.path().join("other.toml");
    let done = from_urdf(&input, &["-o", other.to_str().unwrap()]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(
        said.contains("bodies 1, joints 1") && said.contains("note: line 4"),
        "{said}"
    );
    assert!(other.exists());
    fs::write(&input, hinge("", "<mimic joint=\"x\"/>")).unwrap();
    let refused = from_urdf(
        &input,
        &["-o", folder.path().join("none.toml").to_str().unwrap()],
    );
    assert_eq!(refused.status.code(), Some(1));
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains("gate.urdf:10:1: joint \"hinge\""), "{said}");
    assert!(!folder.path().join("none.toml").exists());
}

/// The pendulum of the performances as URDF: two rods on universal joints, link frames at the joints.
fn pendulum() -> String {
    let (length, radius) = (trees::ROD_M, 0.005);
    let across = 0.1 * (3.0 * radius * radius + length * length) / 12.0;
    let along = 0.1 * radius * radius / 2.0;
    let mut text = String::from("<robot name=\"rods\"><link name=\"world\"/>\n");
    for rod in 1..=2 {
        let (parent, z) = match rod {
            1 => ("world".to_owned(), 1.5),
            _ => ("rod 1".to_owned(), -length),
        };
        text += &format!(
            r#"<link name="cross {rod}"/><link name="rod {rod}"><inertial><origin xyz="0 0 {centre:?}"/><mass value="0.1"/>
<inertia ixx="{across:?}" iyy="{across:?}" izz="{along:?}"/></inertial>
<collision><origin xyz="0 0 {centre:?}"/><geometry><cylinder radius="{radius:?}" length="{length:?}"/></geometry></collision></link>
<joint name="first {rod}" type="continuous"><origin xyz="0 0 {z:?}"/><axis xyz="1 0 0"/><parent link="{parent}"/><child link="cross {rod}"/></joint>
<joint name="second {rod}" type="continuous"><axis xyz="0 1 0"/><parent link="cross {rod}"/><child link="rod {rod}"/></joint>
"#,
            centre = -0.5 * length,
        );
    }
    text + "</robot>\n"
}

/// A performance replayed with the scene of a URDF file gives the estimate that its own scene gives.
#[test]
fn a_scene_of_a_urdf_file_gives_the_estimate_of_a_written_one() {
    let acting = TreeActing {
        asks_start: false,
        ..TreeActing::of(1.0)
    };
    let performance = trees::perform(&Kind::pendulum(2, Jointed::Universal), &acting, 8010);
    let folder = TempDir::new().unwrap();
    let recording = folder.path().join("rods.mcap");
    performance.write(&recording).unwrap();
    let input = folder.path().join("rods.urdf");
    fs::write(&input, pendulum()).unwrap();
    let done = from_urdf(&input, &[]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let scene_file = folder.path().join("rods.toml");
    // What is added by hand: what the tracker sees, the weight, the goal.
    let text = fs::read_to_string(&scene_file).unwrap();
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let trackers: Vec<usize> = (0..lines.len())
        .filter(|at| lines[*at].starts_with("tracker ="))
        .collect();
    let mut lines = lines;
    lines[trackers[0]] = "tracked = false".into();
    lines[trackers[1]] =
        "[[body.track]]\nsees = \"point\"\ntracker = { position_mm = [0, 0, -100] }".into();
    let own = &performance.scene_toml;
    let goals = &own[own.find("\n[[goal]]").expect("a goal")..];
    let text = lines.join("\n") + "\n[weights]\nposition_mm = 10\n" + goals;
    fs::write(&scene_file, &text).unwrap();
    let written = ENACT.report(&recording, &[]);
    let made = ENACT.report(&recording, &["--scene", scene_file.to_str().unwrap()]);
    assert_eq!(
        (written.code, made.code),
        (Some(0), Some(0)),
        "{written:?} {made:?}"
    );
    assert_eq!(made.said["verdict"], "physical");
    for key in ["objective", "residual_mm"] {
        let [written, made] = [&written, &made].map(|of| of.said[key].as_f64().unwrap());
        assert!(
            (written - made).abs() < 1e-6 * written,
            "{key}: {written} {made}"
        );
    }
    let states = [performance.scene.clone(), scene_from_toml(&text).unwrap()].map(|scene| {
        let events = performance.events.iter().cloned();
        let outcome = Pipeline::of(scene, events).finish(&mut ()).unwrap();
        outcome.estimate.trees[0].knots[0].state.clone()
    });
    let [written, made] = states.map(|of| [of.coordinates, of.rates].concat());
    assert_eq!(written.len(), 8);
    for (written, made) in written.iter().zip(&made) {
        assert!((written - made).abs() < 1e-6, "{written} {made}");
    }
}

/// A description with every element that is read.
fn whole() -> String {
    let of_link = r#"<visual><origin xyz="0 0 0.1" rpy="0 0.1 0"/><geometry><cylinder radius="0.1" length="0.5"/></geometry></visual>
<visual><geometry><sphere radius="0.5"/></geometry></visual><visual><geometry><capsule radius="0.1" length="0.5"/></geometry></visual>
<collision><origin xyz="0 0 0.1" rpy="0.3 0 0"/><geometry><box size="0.4 0.3 0.2"/></geometry></collision>"#;
    let more = format!(
        r#"<link name="tool"/><joint name="mount" type="fixed"><parent link="gate"/><child link="tool"/></joint>
<link name="cross"/><joint name="swing" type="continuous"><parent link="tool"/><child link="cross"/></joint>
<link name="leaf">{MASS}</link><joint name="turn" type="continuous"><axis xyz="0 1 0"/><parent link="cross"/><child link="leaf"/></joint>
</robot>"#
    );
    hinge(of_link, r#"<dynamics damping="0.1" friction="0"/>"#).replace("</robot>", &more)
}

#[test]
fn deep_and_odd_files_are_refused_without_harm() {
    let deep = format!(
        "<robot name=\"r\"><link name=\"a\">{}{}</link></robot>",
        "<a>".repeat(100_000),
        "</a>".repeat(100_000)
    );
    assert!(scene_from_urdf(&deep).is_err());
    let mut long = String::from("<robot name=\"r\"><link name=\"0\"/>");
    for link in 1..20_000 {
        long += &format!(
            "<link name=\"{link}\"/><joint name=\"{link}\" type=\"fixed\"><parent link=\"{}\"/><child link=\"{link}\"/></joint>",
            link - 1
        );
    }
    let error = scene_from_urdf(&(long + "</robot>")).unwrap_err();
    assert!(error.message.contains("has no mass"), "{error}");
    let laughs = r#"<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">]><robot name="&a;"/>"#;
    assert!(scene_from_urdf(laughs).is_err());
}

/// Time goes with the length of the text, and what is said of it is for people.
#[test]
fn attributes_and_elements_without_number_take_no_time_and_few_words() {
    let begun = Instant::now();
    let many = |count: usize| -> String {
        let attributes = (0..count).map(|at| format!(" a{at}=\"x\""));
        attributes.collect()
    };
    let crowded = whole().replacen("<robot", &format!("<robot{}", many(80_000)), 1);
    let error = scene_from_urdf(&crowded).unwrap_err();
    assert!(
        error.message.contains("more than 1000 attributes"),
        "{error}"
    );
    let named = whole().replacen("<robot", &format!("<robot{}", many(900)), 1);
    let made = scene_from_urdf(&named).expect("a scene");
    assert!(made.notes.len() <= 101, "{}", made.notes.len());
    let last = made.notes.last().expect("notes");
    assert!(last.ends_with("more of the kind"), "{last}");
    let strange = (0..100_000)
        .map(|at| format!("<strange{at}/>"))
        .collect::<String>();
    let strange = whole().replacen("</robot>", &format!("{strange}</robot>"), 1);
    let made = scene_from_urdf(&strange).expect("a scene");
    assert!(made.notes.len() <= 101, "{}", made.notes.len());
    let mut long = String::from("<robot name=\"r\">");
    for link in 0..20_000 {
        long += &format!("<link name=\"l{link}\">{MASS}</link>");
    }
    for link in 1..20_000 {
        let above = link - 1;
        long += &format!(
            "<joint name=\"j{link}\" type=\"fixed\"><parent link=\"l{above}\"/><child link=\"l{link}\"/></joint>"
        );
    }
    let error = scene_from_urdf(&(long + "</robot>")).unwrap_err();
    assert!(error.message.contains("2000 at most"), "{error}");
    // Seconds of the slowest build; it took half a minute.
    assert!(begun.elapsed().as_secs() < 15, "{:?}", begun.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Damaged descriptions: never a panic, and what is written is read again.
    #[test]
    fn no_damage_makes_it_panic(
        cuts in proptest::collection::vec((0.0..1.0_f64, 0_usize..12, 0_usize..16), 1..4),
    ) {
        const PIECES: [&str; 16] = [
            "", "0", "-1", "1e300", "nan", "<", ">", "\"", "world", "gate", "leaf", "floating", "revolute",
            "<link name=\"gate\"/>", " 0 0 0", "é",
        ];
        let mut text = whole();
        for (at, length, piece) in cuts {
            let mut start = (at * text.len() as f64) as usize;
            while !text.is_char_boundary(start) {
                start -= 1;
            }
            let mut end = (start + length).min(text.len());
            while !text.is_char_boundary(end) {
                end += 1;
            }
            text.replace_range(start..end, PIECES[piece]);
        }
        if let Ok(made) = scene_from_urdf(&text) {
            prop_assert!(scene_from_toml(&made.toml).is_ok());
        }
    }

    /// Values of every attribute, any number and any word.
    #[test]
    fn no_value_makes_it_panic(attribute in 0_usize..80, value in "[-+.0-9eE ]{0,12}|[a-z]{0,6}|1e308|-0|1e-320") {
        let text = whole();
        let quotes: Vec<usize> = text.match_indices('"').map(|(at, _)| at).collect();
        let pair = attribute % (quotes.len() / 2);
        let changed = format!("{}{}{}", &text[..=quotes[2 * pair]], value, &text[quotes[2 * pair + 1]..]);
        if let Ok(made) = scene_from_urdf(&changed) {
            prop_assert!(scene_from_toml(&made.toml).is_ok());
        }
    }
}
