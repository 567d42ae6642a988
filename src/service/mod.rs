//! Drivers of the pipeline. [`replay`] plays one recording through it, event by event and, if
//! asked to, at the pace of the performance; [`predict()`] one only up to an event, [`process`] estimates many, as fast as possible. The
//! same recording gives the same bytes by both. `capture` runs it live. [`mark()`] proposes
//! marks, `sketch` makes recordings of keyframes that people write and the other way round, [`export()`] makes files for other programs of an estimate, `direct` sends commands to a running `capture`, [`from_urdf`] makes scenes of robots, [`calibrate()`] measures trackers and rooms and [`calibrate_scene`] puts that into scenes, [`recover_all`] recovers journals
//! after a crash, `doctor` checks what a capture needs.
//!
//! This room has the clock, the files and the threads. Results come back as a
//! [`RecordingReport`](crate::report::RecordingReport), to be printed by the caller.

mod calibrate;
#[cfg(feature = "live")]
pub mod capture;
#[cfg(feature = "live")]
mod direct;
#[cfg(feature = "live")]
mod doctor;
mod export;
mod finish;
mod from_urdf;
mod inspect;
mod mark;
mod predict;
mod process;
#[cfg(feature = "live")]
mod publish;
#[cfg(not(feature = "live"))]
#[path = "not_live.rs"]
mod publish;
mod recover;
mod refusal;
mod replay;
mod sketch;
mod stopwatch;
mod words;

pub use calibrate::{
    CalibrateChoice, CalibrateJob, CalibrateKind, CalibrateSceneJob, Calibrated, SceneCalibrated,
    TouchingPoint, calibrate, calibrate_scene,
};
#[cfg(feature = "live")]
pub use direct::{Answer, DirectJob, Direction, direct};
#[cfg(feature = "live")]
pub use doctor::{DoctorJob, Finding, Health, doctor};
pub use export::{DEFAULT_EXPORT_RATE_HZ, ExportFormat, ExportJob, ExportTo, Exported, export};
pub use from_urdf::{FromUrdfJob, UrdfImported, from_urdf};
pub use inspect::{Inspection, MarkLine, TopicLine, inspect};
pub use mark::{MarkJob, Marked, ProposalLine, mark};
pub use predict::{DEFAULT_PREDICTION_S, PredictJob, predict};
pub use process::{Failure, ProcessJob, process};
#[cfg(not(feature = "live"))]
pub use publish::NotLive;
pub use recover::{RecoveredLine, recover_all};
pub use refusal::Refusal;
pub use replay::{PublishJob, ReplayJob, replay};
pub use sketch::{Density, SketchJob, Sketched, sketch};
pub use words::words;

#[cfg(feature = "live")]
pub use crate::ingest::live::TakeState;
