//! The live contract over iceoryx2: services, their names, payloads and quality of service.
//!
//! Every service is publish–subscribe with one fixed-layout payload ([`payload`]): little-endian
//! words in the order given there, no padding, every bit pattern allowed. The type name ends in
//! the version of the layout; a peer with another layout cannot open the service.
//!
//! | service | payload | who publishes | what |
//! |---|---|---|---|
//! | `enact<topic>`, as in `enact/tracker/pencil/pose` | [`PoseRecord`] `enact.Pose.1` | a tracker's driver | poses of the body with that topic in the scene |
//! | `enact<marks_topic>`, as in `enact/marks` | [`MarkRecord`] `enact.Mark.1` | a foot pedal, a key | an event happens now |
//! | `enact/control` | [`ControlRecord`] `enact.Control.2` | a remote control that knows the daemon's [`token`] | start, stop or discard a take; ask how it stands, which wants no token |
//! | `enact/take` | [`TakeRecord`] `enact.Take.1` | `enact capture` | what became of the takes |
//! | `enact/label` | [`LabelRecord`] `enact.Label.1` | a remote control | name, note and rating of the take that runs |
//! | `enact/answer` | [`AnswerRecord`] `enact.Answer.1` | `enact capture` | what it says, as JSON in parts: answers to commands, trackers that fall silent, verdicts |
//! | `enact/estimate` | [`EstimateRecord`] `enact.Estimate.1` | `enact capture`, `enact replay` | verdict and numbers of an estimate |
//! | `enact/estimate/<body>/pose` | [`EstimatedPoseRecord`] `enact.EstimatedPose.1` | the same | its motion, frame by frame, after its `enact/estimate` |
//!
//! Names are ASCII: other bytes of a topic, and `%`, are written as `%C3` and so on ([`service_name`]).
//!
//! The process that creates a service fixes its quality of service ([`Quality`], [`CONTRACT`]);
//! start the daemon first. Nothing blocks: where a subscriber is too slow the oldest sample is
//! dropped, and the sequence number in every payload shows it. No service has a listener to wake:
//! subscribers poll, the daemon every 1 ms while samples come and every 5 ms while none do. Samples
//! that were not yet read are lost when their publisher ends: it should stay for 20 ms, or ask
//! (command 4) and wait for the answer, which comes after everything sent before the command was
//! taken.
//!
//! Who directs carries the daemon's [`Token`]: it is in a file beside the daemon's lock, which only the user can read
//! who runs the daemon ([`token_of_daemon`]); a command without it is refused. Marks and labels want none: the services
//! are files of that user, too.
//!
//! Every command is answered on `enact/take` by a record with its session and sequence number. A
//! client without an answer sends the same bytes again: a command is executed once.
//!
//! The iceoryx2 ports are opened by [`crate::ingest::live`] and [`crate::write::live`], both on a
//! [`Node`]; [`census`] lists nodes and services for `enact doctor`.

pub mod census;
mod daemon_lock;
mod error;
mod node;
pub mod payload;
pub mod token;

pub use daemon_lock::{DaemonLock, running_daemon, token_of_daemon};
pub use error::{DaemonProcess, LiveError};
pub use node::{
    ANSWER_SERVICE, CONTRACT, CONTROL_SERVICE, ESTIMATE_SERVICE, LABEL_SERVICE, LiveService, Node,
    Quality, Served, TAKE_SERVICE, service_name, topic_of_service,
};
pub use payload::{
    AnswerRecord, Command, ControlRecord, EstimateRecord, EstimatedPoseRecord, LabelRecord,
    MarkRecord, NO_TIME, POSE_BYTES, PoseRecord, TakeRecord, TakeState,
};
pub use token::Token;
