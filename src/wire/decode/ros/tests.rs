//! What other encoders write is read, in either byte order, and by ROS 1 too.

use ::cdr::{CdrBe, CdrLe, Infinite};
use serde::Serialize;

use super::*;
use crate::motion::Stamp;

/// The messages as crate `cdr` writes them: an independent encoder.
#[derive(Serialize)]
struct Header(i32, u32, &'static str);
type Seven = ([f64; 3], [f64; 4]);
/// More entries than the crate's arrays may have.
type Covariance = ([f64; 18], [f64; 18]);
#[derive(Serialize)]
struct PoseStamped(Header, Seven);
#[derive(Serialize)]
struct Odometry(Header, &'static str, Seven, Covariance);
#[derive(Serialize)]
struct PoseWithCovariance(Header, Seven, Covariance);
#[derive(Serialize)]
struct Stamped<const N: usize>(Header, Fixed<N>);
#[derive(Serialize)]
struct TfMessage(Vec<(Header, &'static str, Seven)>);

/// Numbers one after the other, without a length.
struct Fixed<const N: usize>([f64; N]);

impl<const N: usize> Serialize for Fixed<N> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = to.serialize_tuple(N)?;
        for number in self.0 {
            tuple.serialize_element(&number)?;
        }
        tuple.end()
    }
}

const SEVEN: Seven = ([0.1, -0.2, 0.3], [0.5, 0.5, -0.5, 0.5]);

fn both_orders<T: Serialize>(message: &T) -> [Vec<u8>; 2] {
    [
        ::cdr::serialize::<_, _, CdrLe>(message, Infinite).expect("little endian"),
        ::cdr::serialize::<_, _, CdrBe>(message, Infinite).expect("big endian"),
    ]
}

fn decoded(message: RosPose, data: &[u8]) -> Vec<FramedPose> {
    let mut found = Vec::new();
    cdr_poses(message, data, &mut found).expect("decode");
    found
}

fn expected(parent: &str, child: &str, stamp: Option<Stamp>) -> FramedPose {
    FramedPose::new(
        parent.to_owned(),
        child.to_owned(),
        stamp,
        SEVEN.0.into(),
        SEVEN.1,
    )
}

#[test]
fn texts_are_read_in_either_byte_order() {
    let said = "{\"verdict\":\"physical\"}";
    for bytes in [
        ::cdr::serialize::<_, _, CdrLe>(&said, Infinite).unwrap(),
        ::cdr::serialize::<_, _, CdrBe>(&said, Infinite).unwrap(),
    ] {
        assert_eq!(text(&bytes), Ok(said.to_owned()));
        let length = bytes.len() - 2;
        let short = DecodeError::RosShort {
            length,
            field: "data",
        };
        assert_eq!(text(&bytes[..length]), Err(short));
    }
}

#[test]
fn stamped_poses_of_both_byte_orders() {
    // Frame ids of every length modulo eight, for the padding before the doubles.
    for frame in ["", "m", "ma", "map", "odom", "world", "camera", "tracker"] {
        for data in both_orders(&PoseStamped(Header(12, 34, frame), SEVEN)) {
            assert_eq!(
                decoded(RosPose::PoseStamped, &data),
                [expected(frame, "", Some(Stamp(12_000_000_034)))]
            );
        }
    }
}

#[test]
fn odometry_has_a_child_and_trailing_fields() {
    let mut data = both_orders(&Odometry(Header(0, 0, "odom"), "base", SEVEN, UNKNOWN));
    for data in &mut data {
        data.extend([7; 48]);
        assert_eq!(
            decoded(RosPose::Odometry, data),
            [expected("odom", "base", None)]
        );
    }
}

const UNKNOWN: Covariance = ([0.0; 18], [0.0; 18]);

#[test]
fn covariances_are_read_row_by_row_and_zeros_are_none() {
    let header = || Header(1, 0, "map");
    for data in both_orders(&PoseWithCovariance(header(), SEVEN, UNKNOWN)) {
        let found = decoded(RosPose::PoseWithCovarianceStamped, &data);
        assert_eq!(found[0].covariance, None);
    }
    let entry = |row: usize, column: usize| (1 + row * column) as f64;
    let rows = |from: usize| std::array::from_fn(|at| entry((from + at) / 6, (from + at) % 6));
    for data in both_orders(&PoseWithCovariance(header(), SEVEN, (rows(0), rows(18)))) {
        let found = decoded(RosPose::PoseWithCovarianceStamped, &data);
        let matrix = found[0].covariance.expect("a covariance").matrix();
        for row in 0..6 {
            for column in 0..6 {
                assert_eq!(matrix[(row, column)], entry(row, column));
            }
        }
    }
}

#[test]
fn parts_of_poses_say_what_they_hold() {
    let header = || Header(1, 0, "map");
    for data in both_orders(&Stamped(header(), Fixed([1.0, 2.0, 3.0]))) {
        for (message, holds) in [
            (RosPose::PointStamped, Holds::Position),
            (RosPose::Vector3Stamped, Holds::Direction),
        ] {
            let found = &decoded(message, &data)[0];
            assert_eq!(found.holds, holds);
            assert_eq!(found.position_m, Vector3::new(1.0, 2.0, 3.0));
        }
    }
    for data in both_orders(&Stamped(header(), Fixed(SEVEN.1))) {
        let found = &decoded(RosPose::QuaternionStamped, &data)[0];
        assert_eq!(found.holds, Holds::Orientation);
        assert_eq!(found.quaternion_xyzw, SEVEN.1);
    }
}

#[test]
fn transforms_come_in_order() {
    let message = TfMessage(vec![
        (Header(1, 0, "map"), "hat", SEVEN),
        (Header(-1, 0, "map"), "box7", SEVEN),
    ]);
    for data in both_orders(&message) {
        assert_eq!(
            decoded(RosPose::TfMessage, &data),
            [
                expected("map", "hat", Some(Stamp(1_000_000_000))),
                expected("map", "box7", Some(Stamp(-1_000_000_000))),
            ]
        );
    }
}

#[test]
fn every_cut_is_an_error_and_no_length_is_believed() {
    let [data, _] = both_orders(&TfMessage(vec![(Header(1, 0, "map"), "hat", SEVEN)]));
    for length in 0..data.len() {
        let mut found = Vec::new();
        cdr_poses(RosPose::TfMessage, &data[..length], &mut found).expect_err("cut");
    }
    for bit in 0..data.len() * 8 {
        let mut flipped = data.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        // Neither a panic nor four gigabytes.
        let _ = cdr_poses(RosPose::TfMessage, &flipped, &mut Vec::new());
    }
}

#[test]
fn a_header_is_a_mark() {
    for data in both_orders(&Header(3, 5, "bounce")) {
        let mark = cdr_mark(&data).expect("decode");
        assert_eq!(mark.stamp, Some(Stamp(3_000_000_005)));
        assert_eq!(mark.event.as_deref(), Some("bounce"));
    }
    for data in both_orders(&Header(3, 5, "")) {
        assert_eq!(cdr_mark(&data).expect("decode").event, None);
    }
}

#[test]
fn other_encapsulations_are_refused_by_number() {
    assert_eq!(
        cdr_mark(&[0, 7, 0, 0, 0, 0]),
        Err(DecodeError::CdrEncapsulation(7))
    );
}

#[derive(Serialize)]
struct PoseArray(Header, Vec<Seven>);
#[derive(Serialize)]
struct NamedPoseArray(Header, Vec<(&'static str, Seven)>);
type Marker = (i8, i32, &'static str, [f64; 3]);
#[derive(Serialize)]
struct RigidBodies(Header, u32, Vec<(&'static str, Vec<Marker>, Seven)>);

#[test]
fn poses_of_motion_capture_drivers_bear_their_names() {
    let header = || Header(1, 0, "map");
    let at = Some(Stamp(1_000_000_000));
    // Names of every length modulo eight, for the padding before the doubles.
    for name in ["", "m", "ma", "hat", "hats", "hat_2", "pencil", "pencil1"] {
        let expected = [expected("map", name, at), expected("map", "other", at)];
        for data in both_orders(&NamedPoseArray(
            header(),
            vec![(name, SEVEN), ("other", SEVEN)],
        )) {
            assert_eq!(decoded(RosPose::NamedPoseArray, &data), expected);
        }
        let markers = || vec![(0, -1, name, [1.0; 3]), (2, 7, "", [2.0; 3])];
        let bodies = vec![(name, markers(), SEVEN), ("other", vec![], SEVEN)];
        for data in both_orders(&RigidBodies(header(), 9, bodies)) {
            assert_eq!(decoded(RosPose::RigidBodies, &data), expected);
        }
    }
}

#[test]
fn arrays_are_numbered_and_single_transforms_named() {
    for data in both_orders(&PoseArray(Header(0, 0, "map"), vec![SEVEN; 2])) {
        assert_eq!(
            decoded(RosPose::PoseArray, &data),
            [expected("map", "0", None), expected("map", "1", None)]
        );
    }
    for data in both_orders(&(Header(0, 7, "map"), "die", SEVEN)) {
        assert_eq!(
            decoded(RosPose::TransformStamped, &data),
            [expected("map", "die", Some(Stamp(7)))]
        );
    }
    for data in both_orders(&SEVEN) {
        assert_eq!(decoded(RosPose::Pose, &data), [expected("", "", None)]);
    }
}

/// A message as ROS 1 writes it: field after field.
#[derive(Default)]
struct Ros1(Vec<u8>);

impl Ros1 {
    fn word(mut self, word: u32) -> Self {
        self.0.extend(word.to_le_bytes());
        self
    }

    fn text(self, text: &str) -> Self {
        let mut with = self.word(text.len() as u32);
        with.0.extend(text.as_bytes());
        with
    }

    fn header(self, (seconds, nanoseconds): (u32, u32), frame: &str) -> Self {
        let numbered = self.word(77).word(seconds).word(nanoseconds);
        numbered.text(frame)
    }

    fn seven(mut self) -> Self {
        let doubles = SEVEN.0.iter().chain(&SEVEN.1);
        self.0.extend(doubles.flat_map(|of| of.to_le_bytes()));
        self
    }
}

#[test]
fn messages_of_ros_1_have_no_padding_and_a_number() {
    for (name, message, data, expected) in [
        (
            "geometry_msgs/PoseStamped",
            RosPose::PoseStamped,
            Ros1::default().header((12, 34), "map").seven(),
            vec![expected("map", "", Some(Stamp(12_000_000_034)))],
        ),
        (
            "geometry_msgs/TransformStamped",
            RosPose::TransformStamped,
            Ros1::default().header((0, 0), "world").text("hat").seven(),
            vec![expected("world", "hat", None)],
        ),
        (
            "tf/tfMessage",
            RosPose::TfMessage,
            Ros1::default()
                .word(2)
                .header((1, 0), "map")
                .text("a")
                .seven()
                .header((4_000_000_000, 0), "a")
                .text("b")
                .seven(),
            vec![
                expected("map", "a", Some(Stamp(1_000_000_000))),
                // Its seconds have no sign.
                expected("a", "b", Some(Stamp(4_000_000_000_000_000_000))),
            ],
        ),
        (
            "geometry_msgs/PoseArray",
            RosPose::PoseArray,
            Ros1::default().header((1, 0), "map").word(1).seven(),
            vec![expected("map", "0", Some(Stamp(1_000_000_000)))],
        ),
    ] {
        let (package, named) = name.split_once('/').expect("two parts");
        assert_eq!(RosPose::named(package, named), Some(message), "{name}");
        let mut found = Vec::new();
        ros1_poses(message, &data.0, &mut found).expect("decode");
        assert_eq!(found, expected, "{name}");
        for length in 0..data.0.len() {
            ros1_poses(message, &data.0[..length], &mut found).expect_err("cut");
        }
    }
    let mark = ros1_mark(&Ros1::default().header((3, 5), "bounce").0).expect("decode");
    assert_eq!(mark.stamp, Some(Stamp(3_000_000_005)));
    assert_eq!(mark.event.as_deref(), Some("bounce"));
}

#[test]
fn flipped_bits_of_lists_are_errors_or_other_poses() {
    let header = || Header(1, 0, "map");
    let marker = (1, 5, "left", [1.0; 3]);
    let [bodies, _] = both_orders(&RigidBodies(
        header(),
        9,
        vec![("hat", vec![marker], SEVEN)],
    ));
    let [named, _] = both_orders(&NamedPoseArray(header(), vec![("hat", SEVEN)]));
    let [array, _] = both_orders(&PoseArray(header(), vec![SEVEN]));
    for (message, data) in [
        (RosPose::RigidBodies, bodies),
        (RosPose::NamedPoseArray, named),
        (RosPose::PoseArray, array),
    ] {
        for length in 0..data.len() {
            cdr_poses(message, &data[..length], &mut Vec::new()).expect_err("cut");
        }
        for bit in 0..data.len() * 8 {
            let mut flipped = data.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let mut found = Vec::new();
            let _ = cdr_poses(message, &flipped, &mut found);
            let _ = ros1_poses(message, &flipped, &mut found);
            assert!(found.len() <= 4, "{}", found.len());
        }
    }
}

#[test]
fn names_without_end_are_refused() {
    let data = Ros1::default().header((1, 0), &"a".repeat(1 << 20)).seven();
    let error = ros1_poses(RosPose::PoseStamped, &data.0, &mut Vec::new());
    let (length, limit) = (1 << 20, 1 << 10);
    assert_eq!(error, Err(DecodeError::Long { length, limit }));
}
