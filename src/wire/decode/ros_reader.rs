//! Reads the fields of ROS messages: of ROS 2 in plain CDR of either byte order, of ROS 1 as they are, one after the
//! other.
//!
//! Parsed here, not by the crate `cdr`: that allocates the length that a string claims before it
//! checks whether the bytes exist, so that one flipped bit costs 4 GB. Tests use it.

use nalgebra::Vector3;

use super::error::DecodeError;
use super::message::{FramedPose, stamp};
use crate::motion::Stamp;

/// Representation identifier and options before a message of ROS 2.
const ENCAPSULATION_BYTES: usize = 4;

/// Longest name of a frame or body: every pose of a message keeps its own.
const NAME_BYTES: usize = 1 << 10;

/// How fields lie one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RosLayout {
    /// Aligned to their sizes.
    Cdr { is_big_endian: bool },
    /// Without padding, in little-endian order.
    Ros1,
}

/// Where a message is read.
pub(super) struct RosReader<'a> {
    /// The message after its encapsulation header; alignment counts from its first byte.
    data: &'a [u8],
    at: usize,
    layout: RosLayout,
    /// Bytes before `data`.
    before: usize,
}

/// What a message says of itself: when, and in which frame.
pub(super) type Header = (Option<Stamp>, String);

impl<'a> RosReader<'a> {
    /// Of a message of ROS 2.
    pub(super) fn cdr(data: &'a [u8]) -> Result<Self, DecodeError> {
        let is_big_endian = match data {
            [0, 0, _, _, ..] => true,
            [0, 1, _, _, ..] => false,
            [_, kind, _, _, ..] => return Err(DecodeError::CdrEncapsulation(*kind)),
            _ => {
                return Err(DecodeError::RosShort {
                    length: data.len(),
                    field: "encapsulation",
                });
            }
        };
        Ok(Self {
            data: &data[ENCAPSULATION_BYTES..],
            at: 0,
            layout: RosLayout::Cdr { is_big_endian },
            before: ENCAPSULATION_BYTES,
        })
    }

    /// Of a message of ROS 1.
    pub(super) fn ros1(data: &'a [u8]) -> Self {
        Self {
            data,
            at: 0,
            layout: RosLayout::Ros1,
            before: 0,
        }
    }

    fn short(&self, field: &'static str) -> DecodeError {
        DecodeError::RosShort {
            length: self.before + self.data.len(),
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

    /// A primitive of `N` bytes in little-endian order.
    fn primitive<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], DecodeError> {
        if self.layout != RosLayout::Ros1 {
            self.at = self.at.next_multiple_of(N);
        }
        let bytes = self.data.get(self.at..).and_then(|rest| rest.first_chunk());
        let mut bytes: [u8; N] = *bytes.ok_or_else(|| self.short(field))?;
        self.at += N;
        if self.layout
            == (RosLayout::Cdr {
                is_big_endian: true,
            })
        {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub(super) fn u8(&mut self, field: &'static str) -> Result<u8, DecodeError> {
        self.primitive(field).map(u8::from_le_bytes)
    }

    pub(super) fn u32(&mut self, field: &'static str) -> Result<u32, DecodeError> {
        self.primitive(field).map(u32::from_le_bytes)
    }

    fn f64(&mut self, field: &'static str) -> Result<f64, DecodeError> {
        self.primitive(field).map(f64::from_le_bytes)
    }

    /// How many items of a list follow, of which each takes so many bytes at least: no count is believed for which
    /// there are not enough.
    pub(super) fn count(
        &mut self,
        least_bytes: usize,
        field: &'static str,
    ) -> Result<usize, DecodeError> {
        let count = self.u32(field)? as usize;
        let left = self.data.len().saturating_sub(self.at);
        if count > left / least_bytes {
            return Err(self.short(field));
        }
        Ok(count)
    }

    pub(super) fn text(&mut self, field: &'static str) -> Result<String, DecodeError> {
        let length = self.u32(field)? as usize;
        let bytes = self.take(length, field)?;
        // In CDR the length includes a closing zero; some writers omit it for empty strings.
        let bytes = match self.layout {
            RosLayout::Cdr { .. } => bytes.strip_suffix(&[0]).unwrap_or(bytes),
            RosLayout::Ros1 => bytes,
        };
        String::from_utf8(bytes.to_vec()).map_err(|_| DecodeError::RosText(field))
    }

    /// A text that is a name.
    pub(super) fn name(&mut self, field: &'static str) -> Result<String, DecodeError> {
        let name = self.text(field)?;
        match name.len() {
            length if length > NAME_BYTES => Err(DecodeError::Long {
                length,
                limit: NAME_BYTES,
            }),
            _ => Ok(name),
        }
    }

    /// A header: stamp and frame id, before which ROS 1 has a number.
    pub(super) fn header(&mut self) -> Result<Header, DecodeError> {
        let seconds = match self.layout {
            RosLayout::Cdr { .. } => {
                i64::from(self.primitive("header.stamp").map(i32::from_le_bytes)?)
            }
            RosLayout::Ros1 => {
                self.u32("header.seq")?;
                i64::from(self.u32("header.stamp")?)
            }
        };
        let nanoseconds = self.u32("header.stamp")?;
        let frame_id = self.name("header.frame_id")?;
        Ok((stamp(seconds, nanoseconds)?, frame_id))
    }

    /// A `geometry_msgs/msg/Pose` or `Transform`: the same seven doubles.
    pub(super) fn pose(
        &mut self,
        (stamp, parent): Header,
        child: String,
    ) -> Result<FramedPose, DecodeError> {
        let position_m = self.vector("position")?;
        let quaternion_xyzw = self.quaternion()?;
        Ok(FramedPose::new(
            parent,
            child,
            stamp,
            position_m,
            quaternion_xyzw,
        ))
    }

    pub(super) fn vector(&mut self, field: &'static str) -> Result<Vector3<f64>, DecodeError> {
        let mut vector = Vector3::zeros();
        for coordinate in vector.iter_mut() {
            *coordinate = self.f64(field)?;
        }
        Ok(vector)
    }

    pub(super) fn quaternion(&mut self) -> Result<[f64; 4], DecodeError> {
        let mut quaternion_xyzw = [0.0; 4];
        for component in &mut quaternion_xyzw {
            *component = self.f64("orientation")?;
        }
        Ok(quaternion_xyzw)
    }

    /// A `float64[36]`.
    pub(super) fn covariance(&mut self) -> Result<[f64; 36], DecodeError> {
        let mut rows = [0.0; 36];
        for entry in &mut rows {
            *entry = self.f64("covariance")?;
        }
        Ok(rows)
    }
}
