//! Decodes ROS 2 messages in plain CDR of either byte order.
//!
//! Parsed here, not by the crate `cdr`: that allocates the length that a string claims before it
//! checks whether the bytes exist, so that one flipped bit costs 4 GB. Tests use it.

use nalgebra::Vector3;

use super::error::DecodeError;
use super::message::{FramedPose, RosPose, StampedMark, stamp};
use crate::motion::Stamp;

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
        RosPose::Odometry => {
            let (stamp, parent) = cdr.header()?;
            let child = cdr.text("child_frame_id")?;
            poses.push(cdr.pose(stamp, parent, child)?);
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
        let mut position_m = Vector3::zeros();
        for coordinate in position_m.iter_mut() {
            *coordinate = self.f64("position")?;
        }
        let mut quaternion_xyzw = [0.0; 4];
        for component in &mut quaternion_xyzw {
            *component = self.f64("orientation")?;
        }
        Ok(FramedPose {
            parent,
            child,
            stamp,
            position_m,
            quaternion_xyzw,
        })
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
    #[derive(Serialize)]
    struct PoseStamped(Header, Seven);
    #[derive(Serialize)]
    struct Odometry(Header, &'static str, Seven, [f64; 32]);
    #[derive(Serialize)]
    struct TfMessage(Vec<(Header, &'static str, Seven)>);

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
        FramedPose {
            parent: parent.to_owned(),
            child: child.to_owned(),
            stamp,
            position_m: SEVEN.0.into(),
            quaternion_xyzw: SEVEN.1,
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
        for data in both_orders(&Odometry(Header(0, 0, "odom"), "base", SEVEN, [9.0; 32])) {
            assert_eq!(
                decoded(RosPose::Odometry, &data),
                [expected("odom", "base", None)]
            );
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
