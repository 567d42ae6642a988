//! Why a message cannot be decoded.

use thiserror::Error;

/// Why a message cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// It is longer than messages of its kind are.
    #[error("{length} bytes, at most {limit} are read")]
    Long {
        /// Its length.
        length: usize,
        /// The longest that is read.
        limit: usize,
    },
    /// Not a protobuf of its schema.
    #[error("not a protobuf message: {0}")]
    Protobuf(String),
    /// Not JSON of the form foxglove gives its messages.
    #[error("not such a JSON message: {0}")]
    Json(String),
    /// A message of ROS ends inside a field.
    #[error("the message ends at byte {length}, inside {field}")]
    RosShort {
        /// Size of the message.
        length: usize,
        /// The field that was being read.
        field: &'static str,
    },
    /// The encapsulation header names no plain CDR.
    #[error("encapsulation {0:#04x} is not plain CDR (0x00, 0x01)")]
    CdrEncapsulation(u8),
    /// A string is not UTF-8.
    #[error("{0} is not UTF-8")]
    RosText(&'static str),
    /// A part that a pose needs is absent.
    #[error("the message has no {0}")]
    Missing(&'static str),
    /// A stamp does not fit in 64 bits of nanoseconds.
    #[error("stamp of {0} s is out of range")]
    Stamp(i64),
}
