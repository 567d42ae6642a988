//! Scenes of URDF files: the mechanism is the one that the description has, and what no scene can have is refused
//! with its place.

mod robots;

use enact::config::{UrdfScene, scene_from_toml, scene_from_urdf};
use enact::math::Pose;
use enact::motion::Scene;
use enact::physics::tree::{JointKind, Snapshot, Tree, TreeState};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use robots::{Kind, Moving, Origin, Part, about, energy, inertial, kinematics, origin, part};
use robots::{place_of, signed, turn_of, urdf, vector};

fn imported(parts: &[Part]) -> (UrdfScene, Scene) {
    let text = urdf(parts);
    let made = scene_from_urdf(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let scene = scene_from_toml(&made.toml).expect("the scene is read again");
    (made, scene)
}

fn quaternion(turn: &Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*turn))
}

/// The turns of a joint that was made of several: parts of the description, in the order of its name.
fn turning(parts: &[Part], joint: &str) -> Vec<usize> {
    let of = |name: &str| {
        let is_it = |part: &Part| part.hung.as_ref().is_some_and(|hung| hung.joint == name);
        parts.iter().position(is_it).expect("a joint of the robot")
    };
    joint.split(' ').map(of).collect()
}

/// The state of the scene's tree that is the state of a robot.
struct Posed<'a> {
    parts: &'a [Part],
    scene: &'a Scene,
    tree: Tree,
}

impl<'a> Posed<'a> {
    fn new(parts: &'a [Part], scene: &'a Scene) -> Self {
        let (_, joined) = scene.joint_trees().next().expect("a tree");
        Self {
            parts,
            scene,
            tree: scene.tree_model(joined),
        }
    }

    /// Frames of the bodies' links in their axes: where the trackers are.
    fn body_from_link(&self, name: &str) -> Pose {
        let mut tracks = self.scene.tracks.iter();
        let track = tracks.find(|of| self.scene.links[of.link].name == name);
        track.expect("a tracked body").link_from_tracker
    }

    fn state(&self, angles: &[f64], rates: &[f64], base: &Moving) -> TreeState {
        let (_, joined) = self.scene.joint_trees().next().expect("a tree");
        let mut state = self.tree.at_rest();
        if let Some(link) = joined.base {
            let body_from_link = self.body_from_link(&self.scene.links[link].name);
            let turn = quaternion(&turn_of(&base.world_from_link));
            let world_from_link = Pose::from_parts(place_of(&base.world_from_link).into(), turn);
            let world_from_body = world_from_link * body_from_link.inverse();
            let at = world_from_body.translation.vector;
            state.coordinates[..3].copy_from_slice(at.as_slice());
            let coordinates = world_from_body.rotation.coords;
            state.coordinates[3..7].copy_from_slice(coordinates.as_slice());
            let arm = at - place_of(&base.world_from_link);
            let velocity = base.velocity + base.angular.cross(&arm);
            state.rates[..3].copy_from_slice(velocity.as_slice());
            let angular = world_from_body.rotation.inverse() * base.angular;
            state.rates[3..6].copy_from_slice(angular.as_slice());
        }
        for joint in &joined.joints {
            let place = joined.place_of(joint.child).expect("of the tree");
            let turning = turning(self.parts, &joint.name);
            if let Some([columns, coordinates]) = self.tree.angles_of(place) {
                assert_eq!(columns.len(), turning.len(), "{}", joint.name);
                for (at, part) in turning.iter().enumerate() {
                    state.coordinates[coordinates.start + at] = angles[*part];
                    state.rates[columns.start + at] = rates[*part];
                }
            } else if joint.joint.kind == JointKind::Ball {
                // The axes at angle zero, in the parent's axes.
                let zero = vec![0.0; self.parts.len()];
                let links = kinematics(self.parts, &zero, &zero, base);
                let parent = match joint.parent {
                    Some(parent) => {
                        let parent = &self.scene.links[parent].name;
                        let index = self.parts.iter().position(|of| of.name == *parent);
                        let world_from_link = turn_of(&links[index.unwrap()].world_from_link);
                        quaternion(&world_from_link)
                            * self.body_from_link(parent).rotation.inverse()
                    }
                    None => UnitQuaternion::identity(),
                };
                let mut turn = Matrix3::identity();
                let mut angular = Vector3::zeros();
                for part in turning {
                    let Some(hung) = &self.parts[part].hung else {
                        continue;
                    };
                    let Kind::Turns { axis } = hung.kind else {
                        continue;
                    };
                    let world =
                        turn_of(&links[part].world_from_link) * Vector3::from(axis).normalize();
                    let own = parent.inverse() * world;
                    angular = about(&own, angles[part]).transpose() * angular + own * rates[part];
                    turn *= about(&own, angles[part]);
                }
                let columns = self.tree.columns_of(place);
                state.rates[columns.clone()].copy_from_slice(angular.as_slice());
                let mut delta = vec![0.0; 2 * self.tree.freedoms()];
                let by = quaternion(&turn).scaled_axis();
                delta[columns].copy_from_slice(by.as_slice());
                state = self.tree.retract(&state, &delta);
            }
        }
        state
    }

    /// How far the bodies' links, and points of links without mass, are from where the robot has them \[m, rad\].
    fn off(&self, snapshot: &Snapshot, links: &[Moving]) -> f64 {
        let (_, joined) = self.scene.joint_trees().next().expect("a tree");
        let mut most: f64 = 0.0;
        for link in joined.links() {
            let body = &self.scene.links[link];
            let state = snapshot.link_state(joined.place_of(link).expect("of the tree"));
            let world_from_body = Pose::from_parts(state.position_m.into(), state.orientation);
            let found = (world_from_body * self.body_from_link(&body.name)).to_homogeneous();
            let index = self.parts.iter().position(|of| of.name == body.name);
            let expected = links[index.expect("a link")].world_from_link;
            most = most.max((found - expected).amax());
            for feature in &body.features {
                let Some(index) = self.parts.iter().position(|of| of.name == feature.name) else {
                    continue;
                };
                let at = match feature.geometry {
                    enact::physics::contact::Feature::Point { point_m, .. } => point_m,
                    ref other => panic!("{other:?}"),
                };
                let found = world_from_body * nalgebra::Point3::from(at);
                let expected = place_of(&links[index].world_from_link);
                most = most.max((found.coords - expected).amax());
            }
        }
        most
    }
}

/// Compares frames and kinetic energies at random angles; every entry of the mass matrix is a difference of energies.
fn agree(parts: &[Part], random: &mut ChaCha8Rng) {
    let (made, scene) = imported(parts);
    let posed = Posed::new(parts, &scene);
    let freedoms = posed.tree.freedoms();
    let flies = posed.tree.translations() > 0;
    // A pendulum's numbers: the base's twist, then a rate per part that turns.
    let is_turning = |part: &Part| {
        let hung = part.hung.as_ref();
        hung.is_some_and(|hung| matches!(hung.kind, Kind::Turns { .. }))
    };
    let turning: Vec<usize> = (0..parts.len())
        .filter(|at| is_turning(&parts[*at]))
        .collect();
    let count = turning.len() + if flies { 6 } else { 0 };
    assert_eq!(freedoms, count, "{}", made.toml);
    for _ in 0..4 {
        let angles: Vec<f64> = parts.iter().map(|_| signed(random, 3.0)).collect();
        let base_turn = Origin {
            rpy: vector(random, 3.0),
            ..Origin::default()
        };
        let base_at = Vector3::from(vector(random, 1.0));
        let moved = |numbers: &DVector<f64>| {
            let mut rates = vec![0.0; parts.len()];
            let shift = count - turning.len();
            for (at, part) in turning.iter().enumerate() {
                rates[*part] = numbers[shift + at];
            }
            let three = |at: usize| match flies {
                true => Vector3::new(numbers[at], numbers[at + 1], numbers[at + 2]),
                false => Vector3::zeros(),
            };
            let turn = about(&Vector3::from([1.0, 2.0, 3.0]), base_turn.rpy[0]);
            let mut world_from_link = Matrix4::identity();
            world_from_link
                .fixed_view_mut::<3, 3>(0, 0)
                .copy_from(&turn);
            world_from_link
                .fixed_view_mut::<3, 1>(0, 3)
                .copy_from(&base_at);
            let base = Moving {
                world_from_link,
                velocity: three(0),
                angular: three(3),
            };
            let links = kinematics(parts, &angles, &rates, &base);
            (posed.state(&angles, &rates, &base), links)
        };
        let of = |numbers: &DVector<f64>| {
            let (state, links) = moved(numbers);
            let mut snapshot = Snapshot::new(&posed.tree, &scene.gravity_m_s2);
            snapshot.set(&state);
            let off = posed.off(&snapshot, &links);
            assert!(off < 1e-9, "{off}\n{}", urdf(parts));
            let mut mass = DMatrix::zeros(freedoms, freedoms);
            snapshot.mass_matrix(&mut mass);
            let rates = DVector::from_vec(state.rates);
            (0.5 * rates.dot(&(mass * &rates)), energy(parts, &links))
        };
        let unit = |at: usize| DVector::from_fn(count, |of, _| if of == at { 1.0 } else { 0.0 });
        for row in 0..count {
            for column in row..count {
                let (found, expected) = of(&(unit(row) + unit(column)));
                let tolerance = 1e-9 * expected.max(1.0);
                assert!(
                    (found - expected).abs() < tolerance,
                    "{row} {column}: {found} {expected}\n{}",
                    urdf(parts)
                );
            }
        }
    }
}

const X: Kind = Kind::Turns {
    axis: [1.0, 0.0, 0.0],
};
const Y: Kind = Kind::Turns {
    axis: [0.0, 2.0, 0.0],
};
const Z: Kind = Kind::Turns {
    axis: [0.0, 0.0, -1.0],
};

fn at(x: f64, y: f64, z: f64) -> Origin {
    Origin {
        xyz: [x, y, z],
        rpy: [0.0; 3],
    }
}

/// Three links that fly, with universal joints of two turns and no mass between: one with both axes at the same place,
/// one with the second further along the first.
fn chain(random: &mut ChaCha8Rng) -> Vec<Part> {
    vec![
        part("a", Some(inertial(random))),
        part("ab", None).on(0, origin(random), X),
        part("b", Some(inertial(random))).on(1, at(0.0, 0.0, 0.0), Y),
        part("bc", None).on(2, origin(random), Y),
        part("c", Some(inertial(random))).on(3, at(0.0, 0.07, 0.0), Z),
        part("tip", None).on(4, origin(random), Kind::Fixed),
    ]
}

/// An arm on the world, behind frames without mass, with a hand that is fixed to its last link.
fn arm(random: &mut ChaCha8Rng) -> Vec<Part> {
    vec![
        part("world", None),
        part("stand", None).on(0, origin(random), Kind::Fixed),
        part("upper", Some(inertial(random))).on(
            1,
            origin(random),
            Kind::Turns {
                axis: [0.3, -0.5, 0.8],
            },
        ),
        part("fore", Some(inertial(random))).on(2, origin(random), Z),
        part("hand", Some(inertial(random))).on(3, origin(random), Kind::Fixed),
        part("tool", None).on(4, origin(random), Kind::Fixed),
        part("finger", Some(inertial(random))).on(5, origin(random), X),
    ]
}

/// A trunk that floats, with two arms and a head on a ball.
fn tree(random: &mut ChaCha8Rng) -> Vec<Part> {
    vec![
        part("world", None),
        part("trunk", Some(inertial(random))).on(0, at(0.0, 0.0, 0.0), Kind::Floating),
        part("left", Some(inertial(random))).on(1, origin(random), X),
        part("left_hand", Some(inertial(random))).on(2, origin(random), Y),
        part("right", Some(inertial(random))).on(1, origin(random), Z),
        part("neck_1", None).on(1, origin(random), Z),
        part("neck_2", None).on(5, at(0.0, 0.0, 0.02), X),
        part("head", Some(inertial(random))).on(6, at(0.0, 0.0, 0.0), Z),
        part("right_hand", Some(inertial(random))).on(4, origin(random), Y),
    ]
}

#[test]
fn three_robots_are_where_and_as_heavy_as_their_descriptions_say() {
    for (seed, robot) in [chain, arm, tree].into_iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(9000 + seed as u64);
        agree(&robot(&mut random), &mut random);
    }
}

/// A root without mass that is fixed to what flies.
#[test]
fn a_base_frame_without_mass_flies_with_what_it_is_fixed_to() {
    let mut random = ChaCha8Rng::seed_from_u64(9010);
    let parts = vec![
        part("base_link", None),
        part("body", Some(inertial(&mut random))).on(0, at(0.0, 0.0, 0.0), Kind::Fixed),
        part("leg", Some(inertial(&mut random))).on(0, origin(&mut random), X),
    ];
    agree(&parts, &mut random);
}

/// A first body that is bolted to the world holds two arms: one tree.
#[test]
fn a_body_that_is_fixed_to_the_world_holds_what_hangs_from_it() {
    let mut random = ChaCha8Rng::seed_from_u64(9020);
    let parts = vec![
        part("world", None),
        part("stand", Some(inertial(&mut random))).on(0, origin(&mut random), Kind::Fixed),
        part("left", Some(inertial(&mut random))).on(1, origin(&mut random), X),
        part("right", Some(inertial(&mut random))).on(1, origin(&mut random), Z),
    ];
    agree(&parts, &mut random);
}

/// Robots that nobody drew: any tree of pins, universal joints, balls and fixed ones.
#[test]
fn any_robot_is_where_and_as_heavy_as_its_description_says() {
    for seed in 0..30 {
        let mut random = ChaCha8Rng::seed_from_u64(9100 + seed);
        let random = &mut random;
        let mut parts = match random.random::<bool>() {
            true => vec![part("base", Some(inertial(random)))],
            false => vec![
                part("world", None),
                part("first", Some(inertial(random))).on(0, origin(random), Y),
            ],
        };
        let clamped = parts.len() - 1;
        for link in 0..3 {
            let mut parent = clamped + random.random_range(0..parts.len() - clamped);
            while parts[parent].inertial.is_none() {
                parent = clamped + random.random_range(0..parts.len() - clamped);
            }
            let kind = random.random_range(0..5);
            let turns: &[Kind] = match kind {
                0 => &[Kind::Fixed],
                1 => &[X, Y],
                2 => &[Y, X, Y],
                _ => &[Z],
            };
            for (place, turn) in turns.iter().enumerate() {
                let is_last = place + 1 == turns.len();
                let mass = is_last.then(|| inertial(random));
                let origin = if place == 0 {
                    origin(random)
                } else {
                    at(0.0, 0.0, 0.0)
                };
                parts.push(part(&format!("{link}_{place}"), mass).on(parent, origin, *turn));
                parent = parts.len() - 1;
            }
        }
        agree(&parts, random);
    }
}
