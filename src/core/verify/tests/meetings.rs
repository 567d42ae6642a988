//! Single shots through impacts of every kind.

use super::*;
use crate::motion::{
    Collision, ContactLawIndex, EventKind, Feature as Named, ParameterEstimate, Quantity, Touching,
};
use crate::physics::Shape;
use crate::physics::contact::{Feature, Frame};
use crate::physics::flow;

const TIME_S: f64 = 0.4;

/// The motion about the first event of a scene, at which the bodies are in these states but for
/// a shift of the first that closes the gap.
fn about(scene: &Scene, law: &Law, mut before: Vec<State>) -> Estimate {
    let meeting = scene.contact_set(0).unwrap().unwrap();
    let other = before.get(1).map_or(Frame::world(), Frame::of);
    let touch = meeting.as_slice()[0].touch(&Frame::of(&before[0]), &other);
    let touch = touch.unwrap();
    before[0].position_m -= touch.normal * touch.gap_m;
    let after = struck(scene, 0, law, &before);
    let collision = scene.events[0].kind.collision().unwrap();
    let mut arcs = Vec::new();
    for (link, (before, after)) in collision.links().zip(before.iter().zip(&after)) {
        let mechanism = scene.mechanism_of(link);
        let body = scene.body_of(mechanism);
        let start = flow::advance(body, &scene.gravity_m_s2, before, -TIME_S);
        arcs.push(arc(mechanism, start, 0.0, TIME_S));
        arcs.push(arc(mechanism, *after, TIME_S, 0.7));
    }
    let mut motion = estimate(scene, arcs, &[TIME_S, 0.7]);
    motion.parameters = scene
        .parameters
        .iter()
        .map(|free| ParameterEstimate {
            name: free.name.clone(),
            value: match free.quantity {
                Quantity::Tilt { tangent, .. } => law.tilt_rad[tangent],
                _ => panic!("only tilts are free here"),
            },
            sd: None,
            at_bound: None,
            lower: free.lower,
            upper: free.upper,
        })
        .collect();
    motion
}

/// The shot ends where the motion does, and nothing is created.
fn assert_exact(scene: &Scene, motion: &Estimate, tolerance: f64) {
    let checked = verify(scene, motion);
    let shot = &checked.single_shot;
    assert!(
        shot.restarts.is_empty() && shot.missed.is_empty(),
        "{shot:?}"
    );
    assert_eq!(shot.deviations.len(), motion.arcs.len());
    for deviation in &shot.deviations {
        assert!(deviation.time_s < tolerance, "{deviation:?}");
        assert!(deviation.position_m < 10.0 * tolerance, "{deviation:?}");
        assert!(deviation.velocity_m_s < 100.0 * tolerance, "{deviation:?}");
        let turned = deviation
            .orientation_rad
            .max(deviation.angular_velocity_rad_s);
        assert!(turned < 1e4 * tolerance, "{deviation:?}");
    }
    let balance = &checked.balance;
    assert!(balance.impact_energy < 1e-12, "{balance:?}");
    assert!(balance.impact_momentum < 1e-12, "{balance:?}");
    assert!(balance.impact_angular_momentum < 1e-12, "{balance:?}");
}

/// A cube's corner on a board that flies, too.
fn cube_and_board(more: &str) -> Scene {
    let text = format!(
        "[[body]]\nname = \"board\"\nshape = {{ kind = \"cuboid\", size_mm = [400, 300, 40] }}\n\
         mass_g = 90\n[[body.face]]\nname = \"top\"\npoint_mm = [0, 0, 20]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"thing\"\nfeature = \"tip\"\n\
         other = \"board\"\nother_feature = \"top\"\nrestitution = 0.5\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{more}"
    );
    scene(-9.81, CUBE, "tip = [-50, 50, -50]", &text)
}

fn cube_over_board() -> Vec<State> {
    let tip = Vector3::new(-0.05, 0.05, -0.05);
    let down = UnitQuaternion::rotation_between(&tip, &-Vector3::z()).unwrap();
    let cube = State {
        orientation: UnitQuaternion::from_euler_angles(0.2, -0.1, 0.4) * down,
        velocity_m_s: Vector3::new(0.8, -0.3, -2.0),
        angular_velocity_rad_s: Vector3::new(3.0, -2.0, 4.0),
        ..at_rest(0.03, 0.02, 0.12)
    };
    let board = State {
        orientation: UnitQuaternion::from_euler_angles(0.1, -0.15, 1.0),
        velocity_m_s: Vector3::new(0.1, 0.2, 0.3),
        angular_velocity_rad_s: Vector3::new(1.0, 0.5, -2.0),
        ..at_rest(0.0, 0.0, 0.0)
    };
    vec![cube, board]
}

#[test]
fn two_bodies_meet_with_and_without_friction_and_tilt() {
    for (friction, tilt_rad) in [
        (0.0, [0.0; 2]),
        (0.0, [0.05, -0.03]),
        (0.05, [0.0, 0.02]),
        (2.0, [0.0; 2]),
    ] {
        let tilted = "[[free]]\nquantity = \"hit.tilt\"\ncone_deg = 6\n";
        let mut scene = cube_and_board(tilted);
        scene.contact_laws[ContactLawIndex(0)].friction = friction;
        let law = Law {
            restitution: 0.5,
            friction,
            tangential_restitution: 0.0,
            tilt_rad,
        };
        let motion = about(&scene, &law, cube_over_board());
        assert_exact(&scene, &motion, 1e-12);
    }
}

#[test]
fn energy_from_nowhere_is_found_in_a_meeting_of_two() {
    let scene = cube_and_board("");
    let law = Law::frictionless(0.5);
    let mut motion = about(&scene, &law, cube_over_board());
    let bounced_m_s = motion.arcs[1].state.velocity_m_s;
    motion.arcs[1].state.velocity_m_s *= 1.1;
    let balance = verify(&scene, &motion).balance;
    assert!(balance.impact_momentum > 1e-3, "{balance:?}");
    assert!(balance.impact_energy > 1e-3, "{balance:?}");
    // What one gains and the other loses is not lost from the sum, but from its place.
    motion.arcs[1].state.velocity_m_s = bounced_m_s + Vector3::new(0.05, 0.0, 0.0);
    motion.arcs[3].state.velocity_m_s.x -= 0.05 * 50.0 / 90.0;
    let balance = verify(&scene, &motion).balance;
    assert!(balance.impact_angular_momentum > 1e-3, "{balance:?}");
}

#[test]
fn a_cube_lands_flat_on_three_corners() {
    let features = "a = [-50, -50, -50], b = [50, -50, -50], tip = [-50, 50, -50]";
    let mut scene = scene(-9.81, CUBE, features, &format!("{TABLE}{DROP}"));
    if let EventKind::Collision(hit) = &mut scene.events[0].kind {
        *hit = Collision {
            contacts: (0..3)
                .map(|feature| Touching {
                    feature: Some(feature),
                    other: Some(0),
                })
                .collect(),
            ..hit.clone()
        };
    }
    let state = State {
        orientation: UnitQuaternion::from_euler_angles(0.0, 0.0, 0.7),
        velocity_m_s: Vector3::new(0.3, 0.1, -2.0),
        angular_velocity_rad_s: Vector3::new(0.0, 0.0, 5.0),
        ..at_rest(0.0, 0.0, 0.05)
    };
    let motion = about(&scene, &Law::frictionless(0.6), vec![state]);
    assert_exact(&scene, &motion, 1e-13);
}

#[test]
fn a_rim_and_a_rounded_end_are_followed_as_they_are() {
    let rim = Feature::Rim {
        centre_m: Vector3::new(0.0, 0.0, -0.095),
        axis: Vector3::z(),
        radius_m: 0.00375,
    };
    let end = Feature::Point {
        point_m: Vector3::new(0.0, 0.0, -0.095),
        radius_m: 0.015,
    };
    let capsule = "{ kind = \"capsule\", length_mm = 190, radius_mm = 15 }";
    for (shape, geometry) in [(PENCIL, rim), (capsule, end)] {
        for friction in [0.0, 0.2] {
            let text = format!("{TABLE}{DROP}");
            let mut scene = scene(-9.81, shape, "tip = [0, 0, -95]", &text);
            scene.links[LinkIndex(0)].features = vec![Named {
                name: "tip".to_owned(),
                geometry,
            }];
            scene.contact_laws[ContactLawIndex(0)].friction = friction;
            let law = Law {
                friction,
                ..Law::frictionless(0.6)
            };
            let mut state = leaning(0.4);
            state.angular_velocity_rad_s = Vector3::new(5.0, -4.0, 9.0);
            let motion = about(&scene, &law, vec![state]);
            assert_exact(&scene, &motion, 1e-12);
        }
    }
}

/// Two edges across each other: their line of contact is that of the solids.
#[test]
fn an_edge_meets_an_edge() {
    let edge = |z: f64, along: Vector3<f64>| Feature::Line {
        point_m: Vector3::new(0.0, 0.0, z),
        direction: along,
        radius_m: 0.0,
    };
    let mut scene = cube_and_board("");
    // Both bodies as wedges: edges along x below one, along y on top of the other.
    let wedge = |z: f64, along: f64| Shape::Hull {
        points_m: [-1.0, 1.0]
            .into_iter()
            .flat_map(|end| {
                let place = move |across: f64, z: f64| match along > 0.0 {
                    true => Vector3::new(0.1 * end, across, z),
                    false => Vector3::new(across, 0.1 * end, z),
                };
                [place(0.0, z), place(0.04, -z), place(-0.04, -z)]
            })
            .collect(),
    };
    scene.links[LinkIndex(0)].shape = wedge(-0.05, 1.0);
    scene.links[LinkIndex(1)].shape = wedge(0.05, -1.0);
    scene.links[LinkIndex(0)].features[0].geometry = edge(-0.05, Vector3::x());
    scene.links[LinkIndex(1)].features[0].geometry = edge(0.05, Vector3::y());
    let mut states = cube_over_board();
    states[0].orientation = UnitQuaternion::from_euler_angles(0.1, 0.05, 0.2);
    states[0].position_m = Vector3::new(0.01, 0.0, 0.15);
    states[1].orientation = UnitQuaternion::from_euler_angles(-0.1, 0.1, 0.1);
    let motion = about(&scene, &Law::frictionless(0.5), states);
    assert_exact(&scene, &motion, 1e-8);
}
