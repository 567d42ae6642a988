//! BVH and ROS 2: read back with readers of their own.

use enact::wire::{Container, PoseFormat};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::{Made, Poses, Stamp, enact};

/// The name of a joint, and its six numbers a frame.
type Joint = (String, Vec<[f64; 6]>);

/// Frames a second, and the joints.
fn parsed(bvh: &str) -> (f64, Vec<Joint>) {
    let (tree, motion) = bvh.split_once("MOTION\n").expect("a motion");
    let words: Vec<&str> = tree.split_whitespace().collect();
    let mut names = Vec::new();
    let (mut depth, mut channels) = (0, 0);
    for (at, word) in words.iter().enumerate() {
        match *word {
            "{" => depth += 1,
            "}" => depth -= 1,
            "ROOT" | "JOINT" => names.push(words[at + 1].to_owned()),
            "CHANNELS" => {
                let order = [
                    "Xposition",
                    "Yposition",
                    "Zposition",
                    "Xrotation",
                    "Yrotation",
                    "Zrotation",
                ];
                assert_eq!(words[at + 1..at + 8], [&["6"][..], &order].concat());
                channels += 1;
            }
            _ => {}
        }
    }
    assert_eq!((depth, channels), (0, names.len()));
    let mut lines = motion.lines();
    let frames = lines.next().and_then(|line| line.strip_prefix("Frames: "));
    let frames: usize = frames.expect("frames").parse().expect("a number");
    let time_s = lines
        .next()
        .and_then(|line| line.strip_prefix("Frame Time: "));
    let time_s: f64 = time_s.expect("a time").parse().expect("a number");
    let mut joints: Vec<Joint> = names.into_iter().map(|name| (name, Vec::new())).collect();
    for line in lines {
        let numbers: Vec<f64> = line
            .split(' ')
            .map(|of| of.parse().expect("a number"))
            .collect();
        assert_eq!(numbers.len(), 6 * joints.len());
        for ((_, column), six) in joints.iter_mut().zip(numbers.chunks(6)) {
            column.push(six.try_into().expect("six"));
        }
    }
    assert!(joints.iter().all(|(_, column)| column.len() == frames));
    (time_s.recip(), joints)
}

#[test]
fn joints_of_a_bvh_are_where_the_poses_are_with_y_up() {
    for (recording, bodies) in [("hat_box.mcap", 2), ("chain.mcap", 3)] {
        let made = Made::of(recording);
        let text = made.exported("x.bvh", &["--to", "bvh", "--fps", "30"]);
        let (rate_hz, joints) = parsed(&String::from_utf8(text).expect("UTF-8"));
        assert!((rate_hz - 30.0).abs() < 1e-9);
        assert_eq!(joints.len(), 1 + bodies);
        assert!(joints[0].0 == "world" && joints[0].1.iter().all(|six| *six == [0.0; 6]));
        let upright = Rotation3::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
        for (name, column) in &joints[1..] {
            // Blanks end names in a BVH.
            let body = name.replace('_', " ");
            let poses = made.poses(&format!("/estimate/{body}/pose"));
            let zero = zero_of(&made);
            let mut seen = 0;
            let mut before: Option<[f64; 3]> = None;
            for (frame, six) in column.iter().enumerate() {
                let [a, b, c] = [3, 4, 5].map(|of| six[of].to_radians());
                let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), a)
                    * Rotation3::from_axis_angle(&Vector3::y_axis(), b)
                    * Rotation3::from_axis_angle(&Vector3::z_axis(), c);
                // No jump by a turn: programs interpolate.
                let jump =
                    before.map_or(0.0, |of: [f64; 3]| (of[2] - c).abs().max((of[1] - b).abs()));
                assert!(jump < 3.2, "{name} frame {frame}: {jump}");
                before = Some([a, b, c]);
                let Some((place, [x, y, z, w])) = near(&poses, zero + frame_ns(frame, rate_hz))
                else {
                    continue;
                };
                seen += 1;
                let expected = upright * Vector3::from(*place);
                assert!(
                    (expected - Vector3::new(six[0], six[1], six[2])).norm() < 1e-12,
                    "{name}"
                );
                let of = UnitQuaternion::new_normalize(Quaternion::new(*w, *x, *y, *z));
                let turn = UnitQuaternion::from_rotation_matrix(&turn);
                let off = (UnitQuaternion::from_rotation_matrix(&upright) * of).angle_to(&turn);
                assert!(off < 1e-7, "{name} frame {frame}: {off}");
            }
            assert!(seen > 15, "{name}: {seen}");
        }
        let origin = std::fs::read_to_string(made.folder.path().join("x.bvh.provenance.txt"));
        let estimate = made.estimate.to_str().expect("UTF-8");
        let name = made.estimate.file_name().and_then(|of| of.to_str());
        assert!(origin.expect("a text").contains(name.expect("a name")));
        let ran = enact(&["export", estimate, "--to", "bvh", "--ghost", "-o", "-"]);
        assert_eq!(ran.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&ran.stderr).contains("expected glb, csv or tum"));
    }
}

fn frame_ns(frame: usize, rate_hz: f64) -> i64 {
    (frame as f64 / rate_hz * 1e9).round() as i64
}

fn near(poses: &Poses, at: i64) -> Option<&([f64; 3], [f64; 4])> {
    poses.range(at - 2..=at + 2).next().map(|(_, pose)| pose)
}

/// The stamp of physical time zero: the first of the motion.
fn zero_of(made: &Made) -> i64 {
    let csv = made.exported("zero.csv", &["--to", "csv"]);
    let csv = String::from_utf8(csv).expect("UTF-8");
    let row = csv
        .lines()
        .find(|line| line.starts_with("0,") || line.starts_with("0.0"));
    let cells: Vec<&str> = row.expect("a row at zero").split(',').collect();
    cells[1].parse().expect("a stamp")
}

#[test]
fn a_ros_2_export_has_that_profile_alone_and_the_same_poses() {
    for (recording, topics) in [
        (
            "pencil_tip.mcap",
            &["/estimate/pencil/pose", "/sketch/pencil/pose"][..],
        ),
        ("chain.mcap", &["/estimate/rod 1/pose"][..]),
    ] {
        let made = Made::of(recording);
        let bytes = made.exported("x.mcap", &["--to", "ros2"]);
        let again = made.exported("y.mcap", &["--to", "ros2"]);
        assert!(bytes.len() == again.len(), "of the same length");
        let container = Container::new(bytes).expect("MCAP");
        assert_eq!(container.profile(), "ros2");
        assert!(container.damages().first().is_empty());
        let mut names = Vec::new();
        for channel in container.channels().values() {
            assert_eq!(channel.message_encoding, "cdr");
            let schema = container.schema_of(channel).expect("a schema");
            assert_eq!(schema.encoding, "ros2msg");
            names.push(channel.topic.clone());
        }
        for topic in [
            "/tf",
            "/robot_description",
            "/estimate/report",
            "/estimate/events",
        ] {
            assert!(names.iter().any(|name| name == topic), "{topic}");
        }
        let has_joints = names.iter().any(|name| name == "/joint_states");
        assert_eq!(has_joints, recording == "chain.mcap");
        for topic in topics {
            let expected = made.poses(topic);
            let mut found = Poses::new();
            let mut walk = container.walk();
            while let Some(message) = walk.next_message() {
                let channel = &container.channels()[&message.channel_id];
                // No blanks in names of ROS.
                if channel.topic == topic.replace(' ', "_") {
                    let format = PoseFormat::of("geometry_msgs/msg/PoseStamped", "cdr");
                    let mut poses = Vec::new();
                    format
                        .expect("known")
                        .decode(message.data, &mut poses)
                        .expect("a pose");
                    let sample = poses[0].sample(Stamp(0));
                    found.insert(
                        sample.stamp.0,
                        (sample.position_m.into(), sample.quaternion_xyzw),
                    );
                }
            }
            assert_eq!(found, expected, "{topic}");
        }
    }
}
