use nalgebra::{Point3, UnitQuaternion};

use super::*;
use crate::config::scene_from_toml;
use crate::motion::{ContactLawIndex, Link};
use crate::physics::contact::Contact;

const SCENE: &str = r#"
name = "box"
[timing]
stamps = "physical"
[[body]]
name = "box"
shape = { kind = "cuboid", size_mm = [100, 60, 40] }
mass_kg = 0.3
tracker = { position_mm = [10, 0, 20], orientation_wxyz = [0.6, 0.8, 0, 0] }
features_mm = { corner = [50, 30, -20] }
[[body]]
name = "rod"
shape = { kind = "cylinder", length_mm = 200, radius_mm = 5 }
mass_kg = 0.1
[[surface]]
name = "table"
point_mm = [20, 0, 10]
normal = [0, 0.6, 0.8]
[[obstacle]]
name = "mug"
shape = { kind = "cylinder", length_mm = 100, radius_mm = 40 }
position_mm = [300, 0, 50]
[[event]]
name = "bounce"
kind = "collision"
body = "box"
feature = "corner"
surface = "table"
restitution = 0.6
[[event]]
name = "top"
kind = "collision"
body = "box"
feature = "corner"
surface = "mug/end +z"
restitution = 0.5
[[event]]
name = "landing"
kind = "end"
[[goal]]
event = "landing"
body = "box"
position_mm = [300, 0, 400]
orientation_wxyz = [0.6, 0, 0.8, 0]
"#;

const BOX: LinkIndex = LinkIndex(0);
const ROD: LinkIndex = LinkIndex(1);
const OF_BOX: TrackIndex = TrackIndex(0);

fn given() -> Scene {
    scene_from_toml(SCENE).unwrap()
}

fn with(values: &[(Quantity, f64)]) -> Scene {
    given().with_values(values).unwrap()
}

fn body(link: LinkIndex, values: &[(Quantity, f64)]) -> Body {
    with(values).links[link].body
}

fn assert_near(a: Vector3<f64>, b: Vector3<f64>) {
    assert!((a - b).norm() < 1e-14, "{a} {b}");
}

/// A feature's point and direction in the world, where the link has a pose.
fn face(scene: &Scene, surface: usize) -> (Vector3<f64>, Vector3<f64>) {
    match scene.surfaces[surface].geometry {
        Feature::Face { point_m, normal } => (point_m, normal),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_a_scene_gives_changes_nothing() {
    let scene = given();
    let all = scene.quantities();
    let values: Vec<(Quantity, f64)> = all.iter().map(|q| (*q, scene.value_of(*q))).collect();
    assert_eq!(scene.with_values(&values).unwrap(), scene);
    assert_eq!(scene.with_values(&[]).unwrap(), scene);
    let names: Vec<String> = all.iter().map(|q| scene.name_of_quantity(*q)).collect();
    let mut different = names.clone();
    different.sort();
    different.dedup();
    assert_eq!(different.len(), names.len(), "{names:?}");
}

#[test]
fn gravity_laws_and_tilts_are_set() {
    let (bounce, top) = (ContactLawIndex(0), ContactLawIndex(1));
    let scene = with(&[
        (Quantity::Gravity { axis: 0 }, 0.5),
        (Quantity::Restitution { law: bounce }, 0.3),
        (Quantity::Friction { law: bounce }, 0.2),
        (
            Quantity::Tilt {
                event: 1,
                tangent: 1,
            },
            0.05,
        ),
    ]);
    assert_eq!(scene.gravity_m_s2, Vector3::new(0.5, 0.0, -9.80665));
    let laws = &scene.contact_laws;
    assert_eq!(
        (laws[bounce].restitution, laws[bounce].friction),
        (0.3, 0.2)
    );
    assert_eq!((laws[top].restitution, laws[top].friction), (0.5, 0.0));
    let tilt = |event: usize| scene.events[event].kind.collision().unwrap().tilt_rad;
    assert_eq!([tilt(0), tilt(1)], [[0.0; 2], [0.0, 0.05]]);
}

#[test]
fn bodies_get_mass_moments_force_and_drag() {
    let [link, before] = [BOX, ROD].map(|link| given().links[link].body);
    let moments = link.moments_kg_m2();
    let one = body(BOX, &[(Quantity::Moment { link: BOX, axis: 1 }, 1.1)]);
    assert_near(
        one.moments_kg_m2(),
        moments.component_mul(&Vector3::new(1.0, 1.1, 1.0)),
    );
    assert_eq!(one.mass_kg(), link.mass_kg());
    // The rod's first two are equal and move together.
    let pair = body(ROD, &[(Quantity::Moment { link: ROD, axis: 0 }, 1.2)]);
    let factors = Vector3::new(1.2, 1.2, 1.0);
    assert_near(
        pair.moments_kg_m2(),
        before.moments_kg_m2().component_mul(&factors),
    );
    let heavy = body(BOX, &[(Quantity::Mass { link: BOX }, 2.0)]);
    assert_eq!(heavy.mass_kg(), 2.0 * link.mass_kg());
    assert_near(heavy.moments_kg_m2(), moments * 2.0);
    let pushed = body(
        BOX,
        &[
            (Quantity::Force { link: BOX, axis: 2 }, 0.4),
            (Quantity::LinearDrag { link: BOX }, 0.1),
            (Quantity::QuadraticDrag { link: BOX }, 0.2),
        ],
    );
    assert_eq!(pushed.force_m_s2(), Vector3::new(0.0, 0.0, 0.4));
    let drag = Drag {
        linear_per_s: 0.1,
        quadratic_per_m: 0.2,
    };
    assert_eq!((pushed.drag(), pushed.mass_kg()), (drag, link.mass_kg()));
    assert_eq!(
        body(ROD, &[(Quantity::LinearDrag { link: BOX }, 0.1)]),
        before
    );
    let impossible = given().with_values(&[(Quantity::Moment { link: ROD, axis: 2 }, 1e4)]);
    assert!(matches!(impossible, Err(BodyError::Triangle(..))));
}

#[test]
fn an_object_stays_where_it_is_when_its_centre_of_mass_moves() {
    let by_m = Vector3::new(0.004, -0.003, 0.002);
    let values = [0, 1, 2].map(|axis| (Quantity::Centre { link: BOX, axis }, by_m[axis]));
    let (before, after) = (given(), with(&values));
    let old_from_new = Pose::translation(by_m.x, by_m.y, by_m.z);
    let (old, new): (&Link, &Link) = (&before.links[BOX], &after.links[BOX]);
    assert_eq!(new.body, old.body);
    for (old, new) in old.features.iter().zip(&new.features) {
        let there = new.geometry.placed(&old_from_new);
        let (Feature::Point { point_m: a, .. }, Feature::Point { point_m: b, .. }) =
            (old.geometry, there)
        else {
            assert_eq!(old.geometry.kind(), there.kind());
            continue;
        };
        assert_near(a, b);
    }
    assert_near(new.shape_at_m, -by_m);
    let far = |link: &Link, pose: &Pose| {
        let down = Vector3::new(0.3, -0.5, 0.8).normalize();
        let lowest = link.solid().lowest(pose, &Vector3::zeros(), &down).unwrap();
        lowest.other_point_m + down * lowest.gap_m
    };
    let pose = Pose::from_parts(
        Vector3::new(0.1, 0.2, 0.3).into(),
        UnitQuaternion::from_euler_angles(0.3, -0.8, 1.9),
    );
    assert_near(far(old, &pose), far(new, &(pose * old_from_new)));
    assert!(new.radius_m() > old.radius_m());
    let mount = |scene: &Scene| scene.tracks[OF_BOX].link_from_tracker;
    let there = old_from_new * mount(&after);
    assert_near(there.translation.vector, mount(&before).translation.vector);
    let goal = |scene: &Scene| match scene.goals[0].target {
        GoalTarget::Pose { world_from_body } => world_from_body,
        _ => panic!("a pose"),
    };
    let centre = goal(&before) * Point3::from(by_m);
    assert_near(goal(&after).translation.vector, centre.coords);
    assert_eq!(after.links[ROD], before.links[ROD]);
}

#[test]
fn trackers_are_corrected_in_their_axes() {
    let track = OF_BOX;
    let scene = with(&[
        (Quantity::TrackerPosition { track, axis: 1 }, 0.007),
        (Quantity::TrackerOrientation { track, axis: 2 }, 0.1),
    ]);
    let [old, new] = [&given(), &scene].map(|scene| scene.tracks[track].link_from_tracker);
    let shift = new.translation.vector - old.translation.vector;
    assert_near(shift, Vector3::new(0.0, 0.007, 0.0));
    // About the tracker's own third axis, which stays.
    let turn = old.rotation.inverse() * new.rotation;
    assert_near(turn.scaled_axis(), Vector3::new(0.0, 0.0, 0.1));
    let clock = with(&[
        (Quantity::ClockRate { track }, 0.03),
        (Quantity::ClockOffset { track }, 0.01),
    ]);
    assert_eq!(clock, given());
}

#[test]
fn surfaces_move_along_their_normal_and_turn_about_their_point() {
    let (height, tilt) = (0.008, 0.02);
    let moved = with(&[
        (Quantity::SurfaceHeight { surface: 0 }, height),
        (
            Quantity::SurfaceTilt {
                surface: 0,
                tangent: 1,
            },
            tilt,
        ),
    ]);
    let before = given();
    let (point_m, normal) = face(&before, 0);
    let (there_m, turned) = face(&moved, 0);
    assert_near(there_m, point_m + normal * height);
    let corner = before.links[BOX].features[0].geometry;
    let contact = Contact::new(corner, before.surfaces[0].geometry).unwrap();
    let axes = contact.tilt_axes().unwrap();
    assert_near(
        turned,
        UnitQuaternion::from_scaled_axis(axes[1] * tilt) * normal,
    );
    assert_eq!(moved.obstacles, before.obstacles);
    assert_eq!(moved.surfaces[1], before.surfaces[1]);
}

#[test]
fn an_obstacle_follows_its_surface() {
    let before = given();
    let surface = before.surfaces.iter().position(|s| s.name == "mug/end +z");
    let surface = surface.unwrap();
    let moved = with(&[
        (Quantity::SurfaceHeight { surface }, 0.01),
        (
            Quantity::SurfaceTilt {
                surface,
                tangent: 0,
            },
            0.1,
        ),
    ]);
    let (there_m, normal) = face(&moved, surface);
    assert_near(there_m, Vector3::new(0.3, 0.0, 0.11));
    let mug = &moved.obstacles[0];
    let own = mug.shape.features().unwrap();
    let (_, end) = own.iter().find(|(name, _)| name == "end +z").unwrap();
    let Feature::Face {
        point_m,
        normal: up,
    } = end.placed(&mug.world_from_shape)
    else {
        panic!("a face");
    };
    assert_near(point_m, there_m);
    assert_near(up, normal);
    assert!((normal.z - 0.1f64.cos()).abs() < 1e-14);
}
