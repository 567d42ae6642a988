//! Drivers of the pipeline: [`replay`] plays one recording through it, event by event and, if
//! asked to, at the pace of the performance; [`process`] takes many, as fast as they come.
//! Both end in the same way, and the same recording gives the same bytes by both. [`mark()`]
//! says where marks would be. [`capture`] drives it live, [`direct()`] tells that what to do, [`recover_all`] saves what a crash of
//! that left, [`doctor()`] says what stands in its way.
//!
//! Here are the clock, the files and the threads. What happened comes back as a
//! [`RecordingReport`](crate::report::RecordingReport).

pub mod capture;
mod direct;
mod doctor;
mod finish;
mod inspect;
mod mark;
mod process;
mod publish;
mod recover;
mod replay;
mod stopwatch;
mod words;

pub use direct::{Answer, DirectJob, Direction, direct};
pub use doctor::{DoctorJob, Finding, Health, doctor};
pub use inspect::{Inspection, MarkLine, TopicLine, inspect};
pub use mark::{MarkJob, Marked, ProposalLine, mark};
pub use process::{Failure, ProcessJob, process};
pub use recover::{RecoveredLine, recover_all};
pub use replay::{PublishJob, ReplayJob, replay};
pub use words::words;

pub use crate::ingest::live::TakeState;
