//! Files of joined bodies, read by others' means: what URDF, angles and the poses of bases say is what the
//! transforms and the poses say.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use enact::config::scene_from_toml;
use enact::motion::{
    Estimate, Mark, PoseSample, Scene, Settled, SettledLink, Stamp, TakeEvent, TreeEstimate,
    TreeKnot,
};
use enact::physics::tree::Snapshot;
use enact::pipeline::{Outcome, Pipeline};
use enact::report::Reported;
use enact::wire::encode::{JointState, Transform};
use enact::wire::ros2::{self, RosMessage};
use enact::wire::{Container, PoseFormat};
use enact::write::topics::{self, estimate_frame};
use enact::write::{EstimateFile, write_estimate};
use enact_tools::replay::Program;
use enact_tools::trees::{self, Jointed, Kind, TreeActing};
use foxglove::Decode;
use foxglove::messages::JointStates;
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tempfile::TempDir;

use crate::robot::{JointKind, Robot};

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// All kinds of joints, turned and off their centres, with limits at both ends, at one, at none, in two branches,
/// and names that want to be others'.
const BODIES: &str = r#"
name = "a thing"
[timing]
stamps = "physical"
[[body]]
name = "trunk"
shape = { kind = "cuboid", size_mm = [200, 100, 60] }
mass_g = 300
[[body]]
name = "arm"
shape = { kind = "cylinder", length_mm = 200, radius_mm = 5 }
mass_g = 100
tracked = false
[[body]]
name = "hand"
shape = { kind = "cylinder", length_mm = 100, radius_mm = 10 }
mass_g = 50
tracked = false
[[body]]
name = "ring"
shape = { kind = "sphere", radius_mm = 10 }
mass_g = 5
tracked = false
[[body]]
name = "leg"
shape = { kind = "cylinder", length_mm = 300, radius_mm = 8 }
mass_g = 120
tracked = false
[[body]]
name = "foot"
shape = { kind = "cuboid", size_mm = [100, 40, 20] }
mass_g = 40
tracked = false
ROOT
[[joint]]
name = "hip"
kind = "ball"
parent = "trunk"
parent_at_mm = [-100, 0, -30]
child = "leg"
child_at_mm = [0, 0, 150]
child_orientation_wxyz = [0.8, 0.36, -0.48, 0]
[[joint]]
name = "hip_x"
kind = "pin"
axis = [1, 2, -0.5]
parent = "leg"
parent_at_mm = [0, 0, -150]
child = "foot"
child_at_mm = [-30, 0, 10]
damping_n_m_s = 0.01
[[joint]]
name = "shoulder"
kind = "universal"
axes = [[1, 0.2, 0], [0.1, 1, 0.3]]
limits_deg = [[-720, 720], [-100, inf]]
parent = "trunk"
parent_at_mm = [100, 20, 30]
child = "arm"
child_at_mm = [0, 3, 100]
child_orientation_wxyz = [0.7071067811865476, 0, 0.7071067811865476, 0]
[[joint]]
name = "elbow"
kind = "pin"
axis = [0, 1, 0]
parent = "arm"
parent_at_mm = [0, 0, -100]
child = "hand"
child_at_mm = [0, 0, 50]
[[joint]]
name = "finger"
kind = "fixed"
parent = "hand"
parent_at_mm = [5, 0, -50]
child = "ring"
child_orientation_wxyz = [0.6, 0, 0, 0.8]
[[event]]
name = "start"
kind = "start"
[[event]]
name = "end"
kind = "end"
"#;

/// What holds the first body: nothing, a ball at the wall, a fixed joint.
const ROOTS: [&str; 3] = [
    "",
    "[[joint]]\nname = \"nail\"\nkind = \"ball\"\nparent_at_mm = [10, 20, 1500]\nchild = \"trunk\"\nchild_at_mm = [0, 50, 0]\n",
    "[[joint]]\nname = \"wall\"\nkind = \"fixed\"\nparent_at_mm = [10, 20, 1500]\nchild = \"trunk\"\nchild_orientation_wxyz = [0.6, 0.8, 0, 0]\n",
];

/// How long a motion lasts \[s\].
const END_S: f64 = 0.5;

/// What is written.
struct Motion {
    scene: Scene,
    scene_toml: String,
    /// A pendulum's, but for the motion.
    outcome: Outcome,
}

/// A motion that begins with every joint turned and turning.
fn moving(root: &str) -> Motion {
    let scene_toml = BODIES.replace("ROOT", root);
    let scene = scene_from_toml(&scene_toml).expect("a valid scene");
    let acting = TreeActing {
        asks_start: false,
        ..TreeActing::of(1.0)
    };
    let other = trees::perform(&Kind::pendulum(1, Jointed::Pin), &acting, 8100);
    let events = other.events.iter().cloned();
    let mut outcome = Pipeline::of(other.scene.clone(), events)
        .finish(&mut ())
        .expect("an estimate");
    let (mechanism, joined) = scene.joint_trees().next().expect("a tree");
    let tree = scene.tree_model(joined);
    let freedoms = tree.freedoms();
    let delta = (0..2 * freedoms).map(|k| match k < freedoms {
        true => 1.3 * (1.0 + 2.0 * k as f64).sin(),
        false => 4.0 * (2.0 + 3.0 * k as f64).cos(),
    });
    let delta: Vec<f64> = delta.collect();
    let knot = |time_s, state| TreeKnot { time_s, state };
    let first = tree.retract(&tree.at_rest(), &delta);
    let mut motion = TreeEstimate {
        mechanism,
        knots: vec![knot(0.0, first)],
        step_s: 5e-4,
        residuals: outcome.estimate.trees[0].residuals.clone(),
        rate_sd_rad_s: 10.0,
    };
    let estimate = &mut outcome.estimate;
    for step in 1..=50 {
        let time_s = END_S * f64::from(step) / 50.0;
        let next = motion.state(&tree, &estimate.gravity_m_s2, time_s);
        motion.knots.push(knot(time_s, next));
    }
    estimate.trees = vec![motion];
    estimate.undetermined.clear();
    for (event, time_s) in estimate.events.iter_mut().zip([0.0, END_S]) {
        event.time_s = time_s;
    }
    Motion {
        scene,
        scene_toml,
        outcome,
    }
}

/// What a file says.
struct Said {
    robot: Option<Robot>,
    topic: String,
    /// Angles and rates by stamp and name.
    joints: BTreeMap<Stamp, BTreeMap<String, (f64, Option<f64>)>>,
    /// Parent, child and pose of transforms by stamp.
    transforms: BTreeMap<Stamp, Vec<(String, String, Isometry3<f64>)>>,
    /// Poses of bodies by stamp and frame.
    bodies: BTreeMap<Stamp, BTreeMap<String, Isometry3<f64>>>,
}

impl Said {
    fn robot(&self) -> &Robot {
        self.robot.as_ref().expect("a description")
    }
}

type RosJointState = (
    ((i32, u32), String),
    Vec<String>,
    Vec<f64>,
    Vec<f64>,
    Vec<f64>,
);

/// A recording with nothing in it.
fn nothing(profile: &str) -> Container {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = WriteOptions::new()
        .profile(profile)
        .create(&mut bytes)
        .expect("writer");
    writer.finish().expect("finish");
    drop(writer);
    Container::new(bytes.into_inner()).expect("MCAP")
}

/// What is said of a motion in an output of that profile.
fn written(folder: &TempDir, profile: &str, motion: &Motion) -> Said {
    let path = folder.path().join("out.mcap");
    let outcome = &motion.outcome;
    let written = write_estimate(
        &path,
        &EstimateFile {
            input: &nothing(profile),
            made_of: &[],
            of: Reported {
                scene: &motion.scene,
                inferred: &[],
                sketch: &outcome.sketch,
                counts: &outcome.counts,
                estimate: &outcome.estimate,
                verification: None,
                settled: outcome.settled.as_ref(),
                diagnoses: &[],
                seen: &[],
                freed: &[],
                rest: None,
            },
            scene_toml: motion.scene_toml.as_bytes(),
            provenance: None,
            world_frame: "map",
            log_offset_ns: 0,
            frame_rate_hz: 1000.0,
        },
    );
    written.expect("written");
    read(&path)
}

/// What a file says.
fn read(path: &Path) -> Said {
    let container = Container::new(fs::read(path).expect("read")).expect("MCAP");
    let mut said = Said {
        robot: None,
        topic: String::new(),
        joints: BTreeMap::new(),
        transforms: BTreeMap::new(),
        bodies: BTreeMap::new(),
    };
    let is_ours = |topic: &str| {
        let of = container.channels().values().find(|of| of.topic == topic);
        of.is_some_and(|of| of.metadata.contains_key("enact"))
    };
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        let schema = container.schema_of(channel).expect("schema");
        let mut joints = |stamp: i64, names: Vec<String>, angles: &[f64], rates: &[Option<f64>]| {
            let all = names
                .into_iter()
                .zip(angles.iter().copied().zip(rates.iter().copied()));
            said.joints.insert(Stamp(stamp), all.collect());
            said.topic.clone_from(&channel.topic);
        };
        match (schema.name.as_str(), channel.topic.as_str()) {
            ("foxglove.JointStates", _) => {
                let read = JointStates::decode(message.data).expect("joints");
                let at = read.timestamp.expect("stamped");
                let stamp = i64::from(at.sec()) * 1_000_000_000 + i64::from(at.nsec());
                let angles = read
                    .joints
                    .iter()
                    .map(|joint| joint.position.expect("an angle"));
                let rates = read.joints.iter().map(|joint| joint.velocity);
                let names = read.joints.iter().map(|joint| joint.name.clone());
                joints(
                    stamp,
                    names.collect(),
                    &angles.collect::<Vec<_>>(),
                    &rates.collect::<Vec<_>>(),
                );
            }
            ("sensor_msgs/msg/JointState", topic) if is_ours(topic) => {
                let (((sec, nanosec), _), names, angles, rates, efforts): RosJointState =
                    cdr::deserialize(message.data).expect("joints");
                assert!(efforts.is_empty() && [0, names.len()].contains(&rates.len()));
                let stamp = i64::from(sec) * 1_000_000_000 + i64::from(nanosec);
                let rates = (0..names.len()).map(|k| rates.get(k).copied());
                joints(stamp, names, &angles, &rates.collect::<Vec<_>>());
            }
            (_, topic) if topic.ends_with(topics::ROBOT_DESCRIPTION) && is_ours(topic) => {
                let text: String = cdr::deserialize(message.data).expect("text");
                said.robot = Some(Robot::read(&text));
            }
            (name, topic) if is_ours(topic) && !topic.starts_with("/sketch") => {
                let Some(format) = PoseFormat::of(name, &channel.message_encoding) else {
                    continue;
                };
                let mut found = Vec::new();
                format.decode(message.data, &mut found).expect("poses");
                for of in found {
                    let stamp = of.stamp.expect("stamped");
                    let sample = PoseSample::new(stamp, of.position_m, of.quaternion_xyzw);
                    let pose = pose_of(&sample);
                    if topic.ends_with("/tf") {
                        let all = said.transforms.entry(stamp).or_default();
                        all.push((of.parent, of.child, pose));
                    } else {
                        let body = topic["/estimate/".len()..].trim_end_matches("/pose");
                        let all = said.bodies.entry(stamp).or_default();
                        all.insert(estimate_frame(body), pose);
                    }
                }
            }
            _ => {}
        }
    }
    said
}

fn pose_of(sample: &PoseSample) -> Isometry3<f64> {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(sample.position_m), turn)
}

fn off(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let apart_m = (a.translation.vector - b.translation.vector).norm();
    apart_m.max(a.rotation.angle_to(&b.rotation))
}

/// Angles and poses of bases place, by the URDF alone, every frame where the transforms and the poses have it.
fn assert_one_robot(said: &Said, frames: usize) {
    assert_eq!(said.bodies.len(), frames);
    assert_eq!(said.joints.len(), frames);
    for (stamp, bodies) in &said.bodies {
        let joints = &said.joints[stamp];
        let angles: BTreeMap<String, f64> = joints
            .iter()
            .map(|(name, (angle, _))| (name.clone(), *angle))
            .collect();
        let placed = said.robot().placed(&angles, bodies);
        for (frame, pose) in bodies {
            let off = off(&placed[frame], pose);
            assert!(off < 1e-9, "{frame} {stamp:?}: {off}");
        }
        // The transforms make the same tree with the same poses; what was performed has frames of its own.
        let transforms = said.transforms[stamp].iter();
        let transforms: Vec<_> = transforms.filter(|of| !of.1.ends_with("_sketch")).collect();
        assert_eq!(transforms.len() + 1, said.robot().links.len());
        for (parent, child, pose) in transforms {
            let joint = said.robot().joint_of(child).expect("a link with a parent");
            assert_eq!(&joint.parent, parent);
            let expected = placed[parent].inverse() * placed[child];
            assert!(off(&expected, pose) < 1e-9, "{child} {stamp:?}");
        }
    }
}

#[test]
fn urdf_angles_and_bases_place_what_poses_and_transforms_place() {
    let folder = TempDir::new().expect("folder");
    for root in ROOTS {
        let motion = moving(root);
        for (profile, topic) in [("", "/estimate/joints"), ("ros2", "/joint_states")] {
            let said = written(&folder, profile, &motion);
            assert_eq!(said.topic, topic);
            assert_one_robot(&said, 501);
            let names: BTreeSet<&str> = said
                .joints
                .values()
                .next()
                .expect("joints")
                .keys()
                .map(String::as_str)
                .collect();
            let mut expected = BTreeSet::from([
                "hip_x_",
                "hip_y",
                "hip_z",
                "hip_x",
                "shoulder_1",
                "shoulder_2",
                "elbow",
            ]);
            if root.contains("nail") {
                expected.extend(["nail_x", "nail_y", "nail_z"]);
            }
            assert_eq!(names, expected);
        }
    }
}

/// Angles go on without jumps, and their rates are their derivatives, wherever a ball is not at a pole.
#[test]
fn rates_are_the_derivatives_of_angles_that_do_not_jump() {
    let folder = TempDir::new().expect("folder");
    let said = written(&folder, "", &moving(ROOTS[1]));
    let frames: Vec<_> = said.joints.values().collect();
    let names: Vec<&String> = frames[0].keys().collect();
    let middle = |name: &str| match name.split_once('_') {
        Some((ball @ ("hip" | "nail"), _)) if name != "hip_x" => Some(format!("{ball}_y")),
        _ => None,
    };
    let mut seen = 0;
    for five in frames.windows(5) {
        for &name in &names {
            let [first, before, now, after, last] = [0, 1, 2, 3, 4].map(|k| five[k][name]);
            let is_at_pole = |middle: String| five[2][&middle].0.cos().abs() < 0.2;
            if middle(name).is_some_and(is_at_pole) {
                continue;
            }
            let rate = now.1.expect("a rate");
            // Differences of fourth order.
            let by_time = (8.0 * (after.0 - before.0) - (last.0 - first.0)) / 12e-3;
            let allowed = 2e-3 * (1.0 + rate.abs());
            assert!((rate - by_time).abs() < allowed, "{name}: {rate} {by_time}");
            seen += 1;
        }
    }
    assert!(seen > 4000, "{seen}");
}

/// The words of the description: limits at both ends, damping, masses where there are any.
#[test]
fn the_description_has_limits_dampers_masses_and_places_of_joints() {
    let folder = TempDir::new().expect("folder");
    let motion = moving(ROOTS[0]);
    let said = written(&folder, "", &motion);
    let joint = |name: &str| {
        let mut joints = said.robot().joints.iter();
        joints.find(|joint| joint.name == name).expect("a joint")
    };
    let first = joint("shoulder_1");
    assert_eq!(first.kind, JointKind::Revolute);
    let [lower_rad, upper_rad] = first.limits_rad.expect("limits");
    assert!((upper_rad - 720_f64.to_radians()).abs() < 1e-12);
    assert!((lower_rad + 720_f64.to_radians()).abs() < 1e-12);
    for name in ["shoulder_2", "hip_y", "elbow"] {
        assert_eq!(joint(name).kind, JointKind::Continuous, "{name}");
    }
    let damping = |name: &str| joint(name).damping;
    assert_eq!((damping("hip_x"), damping("elbow")), (Some(0.01), None));
    assert_eq!(joint("trunk_estimate_joint").kind, JointKind::Floating);
    assert_eq!(joint("finger").kind, JointKind::Fixed);
    for link in &said.robot().links {
        let mut links = motion.scene.links.iter();
        let body = links.find(|of| estimate_frame(&of.name) == link.name);
        let mass_kg = body.map_or(0.0, |of| of.body.mass_kg());
        assert_eq!(link.mass_kg, mass_kg, "{}", link.name);
        let moments = body.map_or(Vector3::zeros(), |of| of.body.moments_kg_m2());
        assert_eq!(link.moments_kg_m2, [moments.x, moments.y, moments.z]);
        assert_eq!(link.visuals, usize::from(body.is_some()), "{}", link.name);
    }
}

/// The motion after its end as a simulation would give it: poses alone.
fn simulated(scene: &Scene, estimate: &Estimate, steps: usize) -> Settled {
    let (_, joined) = scene.joint_trees().next().expect("a tree");
    let tree = scene.tree_model(joined);
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    let mut settled = Settled {
        from_s: END_S,
        interval_s: 0.004,
        links: scene
            .links
            .iter()
            .map(|_| SettledLink { poses: Vec::new() })
            .collect(),
        at_rest: false,
        is_predicted: false,
        spread: None,
        largest_speed_m_s: 1.0,
    };
    for step in 0..=steps {
        let time_s = settled.from_s + step as f64 * settled.interval_s;
        snapshot.set(&estimate.trees[0].state(&tree, &estimate.gravity_m_s2, time_s));
        for (link, of) in settled.links.iter_mut_enumerated() {
            let place = joined.place_of(link).expect("of the tree");
            of.poses.push(snapshot.world_from_link(place));
        }
    }
    settled
}

/// Angles of what is simulated come from its poses, go on where the estimate's end, and have no rates.
#[test]
fn angles_of_what_is_simulated_go_on_from_those_of_the_estimate() {
    const STEPS: usize = 20;
    let folder = TempDir::new().expect("folder");
    for root in ROOTS {
        let mut motion = moving(root);
        let estimate = &motion.outcome.estimate;
        motion.outcome.settled = Some(simulated(&motion.scene, estimate, STEPS));
        for profile in ["", "ros2"] {
            let said = written(&folder, profile, &motion);
            assert_one_robot(&said, 501 + STEPS);
            let frames: Vec<_> = said.joints.values().collect();
            for (index, frame) in frames.iter().enumerate() {
                let have_rates = index <= 500;
                assert!(frame.values().all(|(_, rate)| rate.is_some() == have_rates));
            }
            // Of hinges whose angles are coordinates none jumps: as far as its rate at the end leads.
            for name in ["hip_x", "shoulder_1", "shoulder_2", "elbow"] {
                for pair in frames[500..].windows(2) {
                    let step_rad = (pair[1][name].0 - pair[0][name].0).abs();
                    assert!(step_rad < 0.5, "{name}: {step_rad}");
                }
            }
        }
    }
}

/// What the recording itself has where viewers of ROS 2 look.
const OWN: [&str; 3] = [
    topics::TRANSFORMS,
    topics::ROBOT_DESCRIPTION,
    topics::ROS_JOINTS,
];

/// The chain of the repository as ROS 2 would have recorded it, with transforms, a robot and joints of its own.
fn ros_2_chain(path: &Path) {
    let (_, chain) = trees::kept();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = WriteOptions::new()
        .profile("ros2")
        .create(&mut bytes)
        .expect("writer");
    let mut channel = |topic: &str, kind: RosMessage| {
        let schema = kind.schema();
        let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data);
        let schema = schema.expect("schema");
        writer
            .add_channel(schema, topic, "cdr", &BTreeMap::new())
            .expect("channel")
    };
    let topic = &chain.scene.tracks.first().expect("a track").topic;
    let poses = channel(topic, RosMessage::PoseStamped);
    let marks = channel(&chain.scene.marks_topic, RosMessage::Header);
    let own = OWN.map(|topic| {
        let kind = match topic {
            topics::TRANSFORMS => RosMessage::TfMessage,
            topics::ROS_JOINTS => RosMessage::JointState,
            _ => RosMessage::String,
        };
        (kind, channel(topic, kind))
    });
    let first = chain.events.iter().find_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(*sample),
        TakeEvent::Mark(_) => None,
    });
    let first = first.expect("a pose");
    for (kind, channel_id) in own {
        let data = match kind {
            RosMessage::TfMessage => ros2::tf_message(&[Transform {
                parent: "map",
                child: "camera",
                sample: first,
            }]),
            RosMessage::JointState => ros2::joint_state(
                first.stamp,
                &[JointState {
                    name: "pan",
                    angle_rad: 0.5,
                    rate_rad_s: None,
                }],
            ),
            _ => Ok(ros2::string("<robot name=\"camera\"/>")),
        };
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: first.stamp.0 as u64,
            publish_time: first.stamp.0 as u64,
        };
        let written = writer.write_to_known_channel(&header, &data.expect("a message"));
        written.expect("write");
    }
    for event in &chain.events {
        let (channel_id, stamp, data) = match event {
            TakeEvent::Pose { sample, .. } => {
                (poses, sample.stamp, ros2::pose_stamped("map", sample))
            }
            TakeEvent::Mark(Mark { stamp, event }) => (
                marks,
                *stamp,
                ros2::header(*stamp, event.as_deref().unwrap_or_default()),
            ),
        };
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: stamp.0 as u64,
            publish_time: stamp.0 as u64,
        };
        let data = data.expect("a message");
        writer
            .write_to_known_channel(&header, &data)
            .expect("write");
    }
    writer.finish().expect("finish");
    drop(writer);
    fs::write(path, bytes.into_inner()).expect("write");
}

/// The export for ROS 2 has the robot of the estimate where RViz looks for one, kept for who comes later, and nothing
/// else there.
fn assert_opens_in_rviz(estimate: &Path, expected: &Said) {
    let export = estimate.with_extension("ros2.mcap");
    let ran = Command::new(ENACT.0)
        .args(["export", "--to", "ros2", "-o"])
        .args([&export, estimate])
        .output();
    let ran = ran.expect("it runs");
    assert!(ran.status.success(), "{ran:?}");
    let said = read(&export);
    assert_eq!(said.topic, topics::ROS_JOINTS);
    assert_eq!(said.joints, expected.joints);
    assert_eq!(said.transforms, expected.transforms);
    assert_eq!(said.robot().links.len(), expected.robot().links.len());
    for of in said.transforms.values().flatten() {
        let is_ours = |name: &str| name.ends_with("_estimate") || name.ends_with("_sketch");
        let is_link = said.robot().links.iter().any(|link| link.name == of.1);
        assert!(is_link || is_ours(&of.1), "{}", of.1);
    }
    let container = Container::new(fs::read(&export).expect("read")).expect("MCAP");
    for topic in OWN {
        let channels = container.channels().values();
        let of: Vec<_> = channels.filter(|channel| channel.topic == topic).collect();
        assert_eq!(of.len(), 1, "{topic}");
        let offered = &of[0].metadata["offered_qos_profiles"];
        // 1: transient local, 2: volatile.
        let durability = match topic {
            topics::ROBOT_DESCRIPTION => 1,
            _ => 2,
        };
        assert!(
            offered.contains(&format!("\n  durability: {durability}\n")),
            "{offered}"
        );
    }
    let mut channels = container.channels().values();
    assert!(channels.all(|of| !of.topic.starts_with("/estimate/tf")));
}

/// The chain through the program, from both kinds of recordings: one robot, whose joints are those of the scene.
#[test]
fn the_chain_comes_out_as_one_robot() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = TempDir::new().expect("folder");
    let (plain, ros) = (
        folder.path().join("chain.mcap"),
        folder.path().join("ros.mcap"),
    );
    fs::copy(root.join("recordings/chain.mcap"), &plain).expect("copy");
    ros_2_chain(&ros);
    let scene = root.join("config/chain.toml");
    let options = ["--scene", scene.to_str().expect("UTF-8")];
    for (recording, topic) in [(&plain, topics::JOINTS), (&ros, "/estimate/joint_states")] {
        let replayed = ENACT.report(recording, &options);
        assert_eq!(replayed.said["verdict"], "physical", "{}", replayed.said);
        let said = read(&replayed.output);
        assert_eq!(said.topic, topic);
        // 0.9 s at 240 frames a second, with both ends.
        assert_one_robot(&said, 217);
        let first = said.joints.values().next().expect("joints");
        for (name, asked_deg) in [
            ("joint 2_1", -21.75178617022326_f64),
            ("joint 2_2", -27.257251083243744),
            ("joint 3_1", -8.061042875962281),
            ("joint 3_2", -18.894725254175608),
        ] {
            let off_rad = first[name].0 - asked_deg.to_radians();
            assert!(off_rad.abs() < 1e-4, "{name}: {off_rad}");
        }
        assert_opens_in_rviz(&replayed.output, &said);
    }
}
