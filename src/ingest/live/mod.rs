//! Live input: samples from iceoryx2, polled.
//!
//! [`Listening`] holds the subscribers of a scene and takes everything that has arrived.
//! [`Stream`] is a pure state machine: one tracker's samples counted ([`SequenceCounts`]) and
//! stamped ([`super::clock`]), with no clock of its own.

mod answer_parts;
mod listening;
mod sequence_counts;
mod stream;

pub use answer_parts::Answered;
pub use listening::{
    AnswerListener, Arrival, Arrived, Listening, StreamTopic, TakeListener, stream_topics,
};
pub use sequence_counts::{Before, Fate, SequenceCounts, TallyCounts};
pub use stream::{Stream, Streamed, stamp_mark};

/// The contract, for the drivers of this module.
pub use crate::wire::live::{
    ANSWER_SERVICE, CONTROL_SERVICE, Command, ControlRecord, DaemonLock, DaemonProcess,
    ESTIMATE_SERVICE, LABEL_SERVICE, LabelRecord, LiveError, MarkRecord, NO_TIME, Node, POSE_BYTES,
    PoseRecord, Quality, TAKE_SERVICE, TakeRecord, TakeState, Token, census, running_daemon,
    service_name, token_of_daemon, topic_of_service,
};
