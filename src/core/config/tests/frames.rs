//! Bodies in frames of any origin and axes: what the core gets is the same as of a body that is given at its
//! centre of mass along its principal axes.

use nalgebra::{Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::config::scene_from_toml;
use crate::math::Pose;
use crate::motion::{Condition, GoalQuantity, GoalSet, GoalTarget, LinkIndex, Scene, TrackIndex};
use crate::physics::Shape;

fn frame() -> impl Strategy<Value = Pose> {
    let number = || -1.0..1.0_f64;
    let turn = (number(), number(), number(), number());
    let turn = turn.prop_filter("a rotation", |(w, x, y, z)| {
        w * w + x * x + y * y + z * z > 0.01
    });
    (turn, number(), number(), number()).prop_map(|((w, x, y, z), a, b, c)| {
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        Pose::from_parts(Translation3::new(0.3 * a, 0.3 * b, 0.3 * c), turn)
    })
}

fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    let numbers: Vec<String> = numbers.into_iter().map(|x| x.to_string()).collect();
    format!("[{}]", numbers.join(", "))
}

/// Texts of what is fixed in a body, written in a frame that is there in the body's own.
struct Writer {
    given_from_own: Pose,
}

impl Writer {
    fn point(&self, mm: [f64; 3]) -> String {
        let point_m = self.given_from_own * Point3::from(Vector3::from(mm) / 1e3);
        list((point_m.coords * 1e3).iter().copied())
    }

    fn direction(&self, of: [f64; 3]) -> String {
        let turned = self.given_from_own.rotation * Vector3::from(of);
        list(turned.iter().copied())
    }

    fn turn(&self, of: UnitQuaternion<f64>) -> String {
        let q = self.given_from_own.rotation * of;
        list([q.w, q.i, q.j, q.k])
    }

    /// A turn from this frame: world or another from body.
    fn turned_from_here(&self, of: UnitQuaternion<f64>) -> String {
        let q = of * self.given_from_own.rotation.inverse();
        list([q.w, q.i, q.j, q.k])
    }
}

fn tilt(x: f64, y: f64, z: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(x, y, z)
}

/// A brick and a ball that is joined to nothing; the brick in one frame, the ball in another.
fn scene_in(brick: &Pose, ball: &Pose) -> String {
    let [brick, ball] = [brick, ball].map(|of| Writer {
        given_from_own: *of,
    });
    let zero = [0.0; 3];
    let identity = UnitQuaternion::identity();
    format!(
        r#"name = "frames"
[timing]
stamps = "physical"
[[body]]
name = "brick"
shape = {{ kind = "cuboid", size_mm = [120, 80, 60], position_mm = {}, orientation_wxyz = {} }}
mass_g = 200
tracker = {{ position_mm = {}, orientation_wxyz = {} }}
features_mm = {{ knob = {} }}
restitution = 0.5
[[body.face]]
name = "lid"
point_mm = {}
normal = {}
[[body]]
name = "ball"
shape = {{ kind = "sphere", radius_mm = 20, position_mm = {}, orientation_wxyz = {} }}
mass_g = 50
[[body.track]]
sees = "direction"
axis = {}
[[event]]
name = "end"
kind = "end"
time = "free"
[[goal]]
event = "end"
body = "brick"
point_mm = {}
position_mm = [10, 20, 30]
orientation_wxyz = {}
[[goal]]
event = "end"
body = "ball"
relative_to = "brick"
position_mm = {}
within_mm = 7
[[goal]]
event = "end"
body = "ball"
relative_to = "brick"
axis = {}
direction = {}
within_deg = 40
[[goal]]
event = "end"
body = "brick"
spin_rad_s = {}
within_rad_s = 30
axes = "body"
"#,
        brick.point(zero),
        brick.turn(identity),
        brick.point([1.0, 2.0, 33.0]),
        brick.turn(tilt(0.1, -0.2, 0.3)),
        brick.point([5.0, 6.0, 31.0]),
        brick.point([0.0, 0.0, 32.0]),
        brick.direction([0.0, 0.6, 0.8]),
        ball.point(zero),
        ball.turn(identity),
        ball.direction([0.6, 0.0, 0.8]),
        brick.point([10.0, -3.0, 4.0]),
        brick.turned_from_here(tilt(1.0, 0.4, -0.3)),
        brick.point([100.0, -50.0, 25.0]),
        ball.direction([0.0, 0.8, 0.6]),
        brick.direction([0.0, 1.0, 0.0]),
        brick.direction([1.0, 2.0, 3.0]),
    )
}

fn read(text: &str) -> Scene {
    scene_from_toml(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn near(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    (a - b).norm() < 1e-9
}

fn near_pose(a: &Pose, b: &Pose) -> bool {
    near(&a.translation.vector, &b.translation.vector) && a.rotation.angle_to(&b.rotation) < 1e-7
}

fn near_set(a: &GoalSet, b: &GoalSet) -> bool {
    match (a, b) {
        (
            GoalSet::Ball { centre, radius },
            GoalSet::Ball {
                centre: other,
                radius: same,
            },
        ) => near(centre, other) && radius == same,
        (a, b) => a == b,
    }
}

fn near_goal(a: &GoalTarget, b: &GoalTarget) -> bool {
    use GoalQuantity::{Direction, Position, Spin};
    match (a, b) {
        (GoalTarget::Pose { world_from_body: a }, GoalTarget::Pose { world_from_body: b }) => {
            near_pose(a, b)
        }
        (GoalTarget::Condition(a), GoalTarget::Condition(b)) => {
            let same = match (a.quantity, b.quantity) {
                (Position { .. }, Position { .. }) | (Spin { .. }, Spin { .. }) => {
                    a.quantity == b.quantity
                }
                (
                    Direction { axis, towards, .. },
                    Direction {
                        axis: other,
                        towards: same,
                        ..
                    },
                ) => near(&axis, &other) && near(&towards, &same),
                _ => false,
            };
            same && near_set(&a.set, &b.set)
        }
        _ => false,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A shape at a place: its own axes stay those of the link, and all that is fixed in the body comes to where
    /// it is without the frame.
    #[test]
    fn everything_of_a_body_is_in_its_frame(brick in frame(), ball in frame()) {
        let plain = read(&scene_in(&Pose::identity(), &Pose::identity()));
        let moved = read(&scene_in(&brick, &ball));
        for (link, given) in [(LinkIndex(0), brick), (LinkIndex(1), ball)] {
            let (a, b) = (&plain.links[link], &moved.links[link]);
            prop_assert!(near_pose(&a.link_from_given, &Pose::identity()));
            prop_assert!(near_pose(&b.link_from_given, &given.inverse()));
            prop_assert!((a.body.moments_kg_m2() / b.body.moments_kg_m2().x
                - b.body.moments_kg_m2() / b.body.moments_kg_m2().x).norm() < 1e-9);
            prop_assert_eq!(a.features.len(), b.features.len());
            for (one, other) in a.features.iter().zip(&b.features) {
                prop_assert_eq!(&one.name, &other.name);
                prop_assert!(near(&one.geometry.place_m(), &other.geometry.place_m()), "{}", one.name);
            }
        }
        let [a, b] = [&plain, &moved].map(|of| of.tracks[TrackIndex(0)].link_from_tracker);
        prop_assert!(near_pose(&a, &b), "{a} {b}");
        let [a, b] = [&plain, &moved].map(|of| of.tracks[TrackIndex(1)].sees);
        let (crate::motion::Sees::Direction(a), crate::motion::Sees::Direction(b)) = (a, b) else {
            panic!("directions");
        };
        prop_assert!(near(&a, &b));
        prop_assert_eq!(plain.goals.len(), moved.goals.len());
        for (a, b) in plain.goals.iter().zip(&moved.goals) {
            prop_assert!(near_goal(&a.target, &b.target), "{:?} {:?}", a.target, b.target);
        }
    }

    /// A hull from anywhere has its centre and its principal axes where its points are.
    #[test]
    fn the_inertia_of_a_hull_goes_with_its_points(given in frame()) {
        let half_mm = [60.0, 40.0, 25.0];
        let writer = Writer { given_from_own: given };
        let corners = (0..8).map(|corner| {
            let sign = |axis: usize| if corner >> axis & 1 == 1 { half_mm[axis] } else { -half_mm[axis] };
            writer.point([sign(0), sign(1), sign(2)])
        });
        let corners: Vec<String> = corners.collect();
        let text = format!(
            "name = \"h\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"h\"\nmass_g = 300\n\
             shape = {{ kind = \"hull\", points_mm = [{}] }}\n",
            corners.join(", ")
        );
        let scene = read(&text);
        let link = &scene.links[LinkIndex(0)];
        let given_from_link = link.link_from_given.inverse();
        prop_assert!(near(&given_from_link.translation.vector, &given.translation.vector));
        let half_m = Vector3::from(half_mm) / 1e3;
        let own = Shape::Cuboid { half_extents_m: half_m }.body_of_mass_kg(0.3).unwrap();
        let tensor = |turn: &UnitQuaternion<f64>, moments: Vector3<f64>| {
            let r = turn.to_rotation_matrix();
            r.matrix() * Matrix3::from_diagonal(&moments) * r.matrix().transpose()
        };
        let expected = tensor(&given.rotation, own.moments_kg_m2());
        let found = tensor(&given_from_link.rotation, link.body.moments_kg_m2());
        prop_assert!((expected - found).amax() < 1e-9 * expected.amax(), "{expected} {found}");
        // And the solid is there: its radius is that of the brick.
        prop_assert!((link.radius_m() - half_m.norm()).abs() < 1e-9);
    }
}

/// A hammer: two cylinders at right angles, by the parallel-axis theorem.
#[test]
fn parts_add_up() {
    let text = r#"name = "hammer"
[timing]
stamps = "physical"
[[body]]
name = "hammer"
[[body.part]]
name = "handle"
shape = { kind = "cylinder", length_mm = 300, radius_mm = 14, position_mm = [0, 0, 150] }
mass_g = 120
[[body.part]]
name = "head"
shape = { kind = "cylinder", length_mm = 100, radius_mm = 15, position_mm = [0, 10, 290], orientation_wxyz = [0.7071067811865476, 0, 0.7071067811865476, 0] }
mass_g = 480
"#;
    let scene = read(text);
    let link = &scene.links[LinkIndex(0)];
    assert!((link.body.mass_kg() - 0.6).abs() < 1e-12);
    let centre_m = link.link_from_given.inverse().translation.vector;
    let expected = Vector3::new(0.0, 0.48 * 0.01 / 0.6, (0.12 * 0.15 + 0.48 * 0.29) / 0.6);
    assert!(near(&centre_m, &expected), "{centre_m}");
    let rod = |mass: f64, radius: f64, length: f64| {
        let across = mass * (radius * radius / 4.0 + length * length / 12.0);
        (across, 0.5 * mass * radius * radius)
    };
    let (handle, head) = (rod(0.12, 0.014, 0.3), rod(0.48, 0.015, 0.1));
    let apart = |mass: f64, at: Vector3<f64>| {
        let d = at - expected;
        (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * mass
    };
    let tensor = Matrix3::from_diagonal(&Vector3::new(handle.0, handle.0, handle.1))
        + apart(0.12, Vector3::new(0.0, 0.0, 0.15))
        + Matrix3::from_diagonal(&Vector3::new(head.1, head.0, head.0))
        + apart(0.48, Vector3::new(0.0, 0.01, 0.29));
    let turn = link.link_from_given.rotation.to_rotation_matrix();
    let seen = turn.matrix() * tensor * turn.matrix().transpose();
    let found = Matrix3::from_diagonal(&link.body.moments_kg_m2());
    assert!((seen - found).amax() < 1e-12, "{seen} {found}");
    let names: Vec<&str> = link.features.iter().map(|of| of.name.as_str()).collect();
    assert!(
        names.contains(&"handle/rim -z") && names.contains(&"head/end +z"),
        "{names:?}"
    );
}

/// A box in axes that are not principal is the half-spaces of its sides; without a width it is refused.
#[test]
fn boxes_in_turned_axes_are_their_sides() {
    let given = Pose::from_parts(Translation3::new(0.01, 0.0, 0.0), tilt(0.0, 0.0, 0.5));
    let plain = scene_in(&given, &Pose::identity());
    let ball = "within_mm = 7\n";
    let at = plain.find(ball).expect("a ball");
    let line = plain[..at].rfind("position_mm").expect("its centre");
    let with = |sides: &str| format!("{}{sides}\n{}", &plain[..line], &plain[at + ball.len()..]);
    let scene = read(&with(
        "position_within_mm = [[-10, -20, -30], [10, inf, 30]]",
    ));
    let sides = scene.goals.iter().filter_map(|goal| match &goal.target {
        GoalTarget::Condition(Condition {
            quantity: GoalQuantity::Position { .. },
            set: GoalSet::HalfSpace { normal, least },
            ..
        }) => Some((*normal, *least)),
        _ => None,
    });
    let sides: Vec<(Vector3<f64>, f64)> = sides.collect();
    assert_eq!(sides.len(), 5);
    let is_in = |mm: [f64; 3]| {
        let point_m = given.inverse() * Point3::from(Vector3::from(mm) / 1e3);
        sides
            .iter()
            .all(|(normal, least)| normal.dot(&point_m.coords) >= least - 1e-12)
    };
    assert!(is_in([9.9, 500.0, 29.9]) && is_in([-9.9, -19.9, -29.9]));
    assert!(!is_in([10.1, 0.0, 0.0]) && !is_in([0.0, -20.1, 0.0]) && !is_in([0.0, 0.0, -30.1]));
    let error = scene_from_toml(&with("position_within_mm = [[-10, -20, 5], [10, inf, 5]]"));
    let error = error.expect_err("no width").message;
    assert!(error.contains("no side without a width"), "{error}");
}

/// What follows from shape and mass, and what may be given in place of it.
#[test]
fn masses_are_given_once_and_whole() {
    let scene = |keys: &str| {
        let text = format!(
            "name = \"x\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"x\"\n{keys}\n"
        );
        scene_from_toml(&text)
    };
    let cube = "shape = { kind = \"cuboid\", size_mm = [10, 10, 10] }";
    let said = |keys: &str| scene(&format!("{cube}\n{keys}")).expect_err(keys).message;
    assert!(said("mass_g = 1\ncentre_mm = [1, 0, 0]").contains("expected it with inertia_kg_m2"));
    assert!(said("mass_g = 1\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]").contains("expected centre_mm"));
    let twice =
        "mass_g = 1\nmoments_kg_m2 = [1e-8, 1e-8, 1e-8]\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]";
    assert!(said(twice).contains("given twice"));
    let great = "mass_g = 1\ncentre_mm = [1, 0, 0]\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]";
    assert!(said(great).contains("expected at most"));
    let part = |mass: &str, other: &str| {
        format!(
            "[[body.part]]\nname = \"a\"\n{cube}\n{mass}\n[[body.part]]\nname = \"b\"\n{cube}\n{other}\n"
        )
    };
    let said = |keys: &str| scene(keys).expect_err(keys).message;
    assert!(said(&part("mass_g = 1", "")).contains("1 of the body's 2 parts have a mass"));
    assert!(said(&part("", "")).contains("no mass"));
    assert!(
        said(&format!("mass_g = 1\n{}", part("mass_g = 1", "mass_g = 1"))).contains("beside those")
    );
    assert!(said("mass_g = 1").contains("missing key `shape`"));
    let whole = scene(&format!("mass_g = 3\n{}", part("", ""))).expect("a mass for all");
    assert!((whole.links[LinkIndex(0)].body.mass_kg() - 3e-3).abs() < 1e-15);
}

/// A shell of a ball: 2/3 m r² as its wall gets thin.
#[test]
fn walls_make_shells() {
    let text = |wall: &str| {
        format!(
            "name = \"x\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"x\"\nmass_g = 60\n\
             shape = {{ kind = \"sphere\", radius_mm = 30{wall} }}\n"
        )
    };
    let moment = |wall: &str| read(&text(wall)).links[LinkIndex(0)].body.moments_kg_m2().x;
    let scale = 0.06 * 0.03_f64.powi(2);
    assert!((moment("") / scale - 0.4).abs() < 1e-12);
    assert!((moment(", wall_mm = 0.001") / scale - 2.0 / 3.0).abs() < 1e-4);
    let inner = 20.0_f64 / 30.0;
    let shell = 0.4 * (1.0 - inner.powi(5)) / (1.0 - inner.powi(3));
    assert!((moment(", wall_mm = 10") / scale - shell).abs() < 1e-12);
    let error = scene_from_toml(&text(", wall_mm = 30")).expect_err("no cavity");
    assert!(error.message.contains("leaves no cavity"), "{error}");
}

/// A board is solid where it is, and not beyond.
#[test]
fn boards_end() {
    let text = r#"name = "x"
[timing]
stamps = "physical"
[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 10 }
mass_g = 5
restitution = 0.5
[[surface]]
name = "shelf"
point_mm = [100, 0, 400]
normal = [0, 0, 2]
size_mm = [200, 80]
thickness_mm = 20
along = [0, 1, 0]
"#;
    let scene = read(text);
    let ball = Shape::Sphere { radius_m: 0.01 };
    let gap_m = |x: f64, y: f64, z: f64| {
        let board = &scene.obstacles[0];
        let at = Pose::translation(x, y, z);
        ball.distance_m(&at, &board.shape, &board.world_from_shape)
            .unwrap()
    };
    assert!((gap_m(0.1, 0.0, 0.42) - 0.01).abs() < 1e-9);
    // 40 mm to both sides along x, 100 along y; 20 below.
    assert!((gap_m(0.16, 0.0, 0.39) - 0.01).abs() < 1e-9);
    assert!((gap_m(0.1, 0.12, 0.39) - 0.01).abs() < 1e-9);
    assert!((gap_m(0.1, 0.0, 0.36) - 0.01).abs() < 1e-9);
    // What hits it is inferred among its sides, each once.
    let open = format!("{text}[[event]]\nname = \"e\"\nkind = \"collision\"\nbody = \"ball\"\n");
    let faces = read(&open).surfaces;
    let faces = faces
        .iter()
        .filter(|of| of.geometry.kind() == scene.surfaces[0].geometry.kind());
    assert_eq!(faces.count(), 6);
    let said = |from: &str, to: &str| {
        scene_from_toml(&text.replace(from, to))
            .expect_err(to)
            .message
    };
    assert!(said("size_mm = [200, 80]\n", "").contains("expected size_mm beside it"));
    assert!(said("[200, 80]", "[200, -80]").contains("two positive sides"));
    assert!(said("along = [0, 1, 0]", "along = [0, 0, 1]").contains("along is the normal"));
}

/// Degrees in place of a quaternion, wherever one is.
#[test]
fn angles_are_roll_pitch_and_yaw() {
    let plain = scene_in(&Pose::identity(), &Pose::identity());
    let q = tilt(0.1, -0.2, 0.3);
    let wxyz = format!("orientation_wxyz = {}", list([q.w, q.i, q.j, q.k]));
    let rpy = list([0.1_f64, -0.2, 0.3].map(f64::to_degrees));
    assert!(plain.contains(&wxyz));
    let turned = read(&plain.replace(&wxyz, &format!("rpy_deg = {rpy}")));
    let [a, b] = [&read(&plain), &turned].map(|of| of.tracks[TrackIndex(0)].link_from_tracker);
    assert!(near_pose(&a, &b), "{a} {b}");
    let both = plain.replace(&wxyz, &format!("{wxyz}, rpy_deg = {rpy}"));
    let said = scene_from_toml(&both).expect_err("twice").message;
    assert!(
        said.contains("expected one of orientation_wxyz, rpy_deg"),
        "{said}"
    );
    let goal = tilt(1.0, 0.4, -0.3);
    let wxyz = format!(
        "orientation_wxyz = {}\n",
        list([goal.w, goal.i, goal.j, goal.k])
    );
    let rpy = list([1.0_f64, 0.4, -0.3].map(f64::to_degrees));
    assert!(plain.contains(&wxyz));
    let turned = read(&plain.replace(&wxyz, &format!("rpy_deg = {rpy}\n")));
    assert!(near_goal(
        &read(&plain).goals[0].target,
        &turned.goals[0].target
    ));
}
