//! Decodes ROS 2 messages in plain CDR of either byte order.
//!
//! Parsed here, not by the crate `cdr`: that allocates the length that a string claims before it
//! checks whether the bytes exist, so that one flipped bit costs 4 GB. Tests use it.

use nalgebra::Vector3;

use super::error::DecodeError;
use super::message::{FramedPose, RosPose, StampedMark, stamp};
use crate::motion::{Holds, Stamp};

/// Representation identifier and options before the message.
const ENCAPSULATION_BYTES: usize = 4;

/// The smallest `TransformStamped`: stamp, two empty strings, seven doubles.
const TRANSFORM_BYTES: usize = 8 + 4 + 4 + 7 * 8;

pub(super) fn poses(
    message: RosPose,
    data: &[u8],
    poses: &mut Vec<FramedPose>,
) -> Result<(), DecodeError> {
    let mut cdr = CdrReader::new(data)?;
    match message {
        RosPose::PoseStamped => {
            let (stamp, parent) = cdr.header()?;
            poses.push(cdr.pose(stamp, parent, String::new())?);
        }
        RosPose::PoseWithCovarianceStamped => {
            let (stamp, parent) = cdr.header()?;
            let pose = cdr.pose(stamp, parent, String::new())?;
            poses.push(pose.with_covariance(&cdr.covariance()?));
        }
        RosPose::Odometry => {
            let (stamp, parent) = cdr.header()?;
            let child = cdr.text("child_frame_id")?;
            let pose = cdr.pose(stamp, parent, child)?;
            poses.push(pose.with_covariance(&cdr.covariance()?));
        }
        RosPose::PointStamped | RosPose::Vector3Stamped => {
            let (stamp, parent) = cdr.header()?;
            let vector = cdr.vector("point")?;
            let holds = match message {
                RosPose::PointStamped => Holds::Position,
                _ => Holds::Direction,
            };
            poses.push(FramedPose::vector(parent, stamp, vector, holds));
        }
        RosPose::QuaternionStamped => {
            let (stamp, parent) = cdr.header()?;
            let frames = (parent, String::new());
            let quaternion_xyzw = cdr.quaternion()?;
            poses.push(FramedPose {
                holds: Holds::Orientation,
                ..FramedPose::new(frames, stamp, Vector3::zeros(), quaternion_xyzw)
            });
        }
        RosPose::TfMessage => {
            let count = cdr.u32("transforms")? as usize;
            if count > data.len() / TRANSFORM_BYTES {
                return Err(cdr.short("transforms"));
            }
            for _ in 0..count {
                let (stamp, parent) = cdr.header()?;
                let child = cdr.text("child_frame_id")?;
                poses.push(cdr.pose(stamp, parent, child)?);
            }
        }
    }
    Ok(())
}

pub(super) fn mark(data: &[u8]) -> Result<StampedMark, DecodeError> {
    let (stamp, event) = CdrReader::new(data)?.header()?;
    Ok(StampedMark {
        stamp,
        event: (!event.is_empty()).then_some(event),
    })
}

/// The text of a `std_msgs/msg/String`.
pub fn text(data: &[u8]) -> Result<String, DecodeError> {
    CdrReader::new(data)?.text("data")
}

struct CdrReader<'a> {
    /// The message after its encapsulation header; alignment counts from its first byte.
    data: &'a [u8],
    at: usize,
    is_big_endian: bool,
}

impl<'a> CdrReader<'a> {
    fn new(data: &'a [u8]) -> Result<Self, DecodeError> {
        let is_big_endian = match data {
            [0, 0, _, _, ..] => true,
            [0, 1, _, _, ..] => false,
            [_, kind, _, _, ..] => return Err(DecodeError::CdrEncapsulation(*kind)),
            _ => {
                return Err(DecodeError::CdrShort {
                    length: data.len(),
                    field: "encapsulation",
                });
            }
        };
        Ok(Self {
            data: &data[ENCAPSULATION_BYTES..],
            at: 0,
            is_big_endian,
        })
    }

    fn short(&self, field: &'static str) -> DecodeError {
        DecodeError::CdrShort {
            length: ENCAPSULATION_BYTES + self.data.len(),
            field,
        }
    }

    fn take(&mut self, count: usize, field: &'static str) -> Result<&'a [u8], DecodeError> {
        let bytes = self
            .at
            .checked_add(count)
            .and_then(|end| self.data.get(self.at..end))
            .ok_or_else(|| self.short(field))?;
        self.at += count;
        Ok(bytes)
    }

    /// A primitive of `N` bytes, aligned to its size, in little-endian order.
    fn primitive<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], DecodeError> {
        self.at = self.at.next_multiple_of(N);
        let bytes = self.data.get(self.at..).and_then(|rest| rest.first_chunk());
        let mut bytes: [u8; N] = *bytes.ok_or_else(|| self.short(field))?;
        self.at += N;
        if self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn u32(&mut self, field: &'static str) -> Result<u32, DecodeError> {
        self.primitive(field).map(u32::from_le_bytes)
    }

    fn f64(&mut self, field: &'static str) -> Result<f64, DecodeError> {
        self.primitive(field).map(f64::from_le_bytes)
    }

    fn text(&mut self, field: &'static str) -> Result<String, DecodeError> {
        let length = self.u32(field)? as usize;
        let bytes = self.take(length, field)?;
        // The length includes a closing zero; some writers omit it for empty strings.
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(bytes.to_vec()).map_err(|_| DecodeError::CdrText(field))
    }

    /// A `std_msgs/msg/Header`: stamp and frame id.
    fn header(&mut self) -> Result<(Option<Stamp>, String), DecodeError> {
        let seconds = self.primitive("header.stamp").map(i32::from_le_bytes)?;
        let nanoseconds = self.u32("header.stamp")?;
        let frame_id = self.text("header.frame_id")?;
        Ok((stamp(i64::from(seconds), nanoseconds)?, frame_id))
    }

    /// A `geometry_msgs/msg/Pose` or `Transform`: the same seven doubles.
    fn pose(
        &mut self,
        stamp: Option<Stamp>,
        parent: String,
        child: String,
    ) -> Result<FramedPose, DecodeError> {
        let position_m = self.vector("position")?;
        let frames = (parent, child);
        Ok(FramedPose::new(
            frames,
            stamp,
            position_m,
            self.quaternion()?,
        ))
    }

    fn vector(&mut self, field: &'static str) -> Result<Vector3<f64>, DecodeError> {
        let mut vector = Vector3::zeros();
        for coordinate in vector.iter_mut() {
            *coordinate = self.f64(field)?;
        }
        Ok(vector)
    }

    fn quaternion(&mut self) -> Result<[f64; 4], DecodeError> {
        let mut quaternion_xyzw = [0.0; 4];
        for component in &mut quaternion_xyzw {
            *component = self.f64("orientation")?;
        }
        Ok(quaternion_xyzw)
    }

    /// A `float64[36]`.
    fn covariance(&mut self) -> Result<[f64; 36], DecodeError> {
        let mut rows = [0.0; 36];
        for entry in &mut rows {
            *entry = self.f64("covariance")?;
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use ::cdr::{CdrBe, CdrLe, Infinite};
    use serde::Serialize;

    use super::*;

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
        poses(message, data, &mut found).expect("decode");
        found
    }

    fn expected(parent: &str, child: &str, stamp: Option<Stamp>) -> FramedPose {
        let frames = (parent.to_owned(), child.to_owned());
        FramedPose::new(frames, stamp, SEVEN.0.into(), SEVEN.1)
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
            let short = DecodeError::CdrShort {
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
            poses(RosPose::TfMessage, &data[..length], &mut found).expect_err("cut");
        }
        for bit in 0..data.len() * 8 {
            let mut flipped = data.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            // Neither a panic nor four gigabytes.
            let _ = poses(RosPose::TfMessage, &flipped, &mut Vec::new());
        }
    }

    #[test]
    fn a_header_is_a_mark() {
        for data in both_orders(&Header(3, 5, "bounce")) {
            let mark = mark(&data).expect("decode");
            assert_eq!(mark.stamp, Some(Stamp(3_000_000_005)));
            assert_eq!(mark.event.as_deref(), Some("bounce"));
        }
        for data in both_orders(&Header(3, 5, "")) {
            assert_eq!(mark(&data).expect("decode").event, None);
        }
    }

    #[test]
    fn other_encapsulations_are_refused_by_number() {
        assert_eq!(
            mark(&[0, 7, 0, 0, 0, 0]),
            Err(DecodeError::CdrEncapsulation(7))
        );
    }
}
