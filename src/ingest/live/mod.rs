//! The live door: samples from iceoryx2, polled.
//!
//! [`Listening`] holds the subscribers of a scene and takes from them whatever has come.
//! [`Stream`] is the pure rest: one tracker's samples counted ([`Tally`]) and stamped
//! ([`super::clock`]), with no clock of its own.

mod listening;
mod stream;
mod tally;

pub use listening::{Arrival, Arrived, Listening, StreamTopic, TakeListener, stream_topics};
pub use stream::{Stream, Streamed, stamp_mark};
pub use tally::{Fate, Tally, TallyCounts};

/// The contract, for those who drive this door.
pub use crate::wire::live::{
    CONTROL_SERVICE, Command, ControlRecord, ESTIMATE_SERVICE, LiveError, MarkRecord, NO_TIME,
    Node, PoseRecord, Quality, TAKE_SERVICE, TakeRecord, TakeState, census, service_name,
};
