//! Drivers of the pipeline. [`replay`] plays one recording through it, event by event and, if
//! asked to, at the pace of the performance; [`predict()`] one only up to an event, [`process`] estimates many, as fast as possible. The
//! same recording gives the same bytes by both. `capture` runs it live. [`mark()`] lists, proposes
//! and changes marks, [`import()`] makes recordings of tables of poses, `sketch` makes recordings of keyframes that people write and the other way round, [`export()`] makes files for other programs of an estimate, [`report()`] a page for people, `direct` sends commands to a running `capture`, `takes` lists what it recorded, [`from_urdf`] makes scenes of robots, [`make_scene`] of objects and meshes, [`calibrate()`] measures trackers and rooms, [`fit()`] finds what many takes share and [`calibrate_scene`] puts that into scenes, [`recover_all`] recovers journals
//! after a crash, `doctor` checks what a capture needs. [`TakeInMemory`] is for programs that call this one: what `replay` does, step by step.
//!
//! This room has the clock, the files and the threads. Results come back as a
//! [`RecordingReport`](crate::report::RecordingReport), to be printed by the caller.

mod as_read;
mod calibrate;
#[cfg(feature = "live")]
pub mod capture;
mod deadline;
#[cfg(feature = "live")]
mod direct;
#[cfg(feature = "live")]
mod doctor;
mod export;
mod finish;
mod fit;
mod folders;
mod from_urdf;
mod guard;
mod import;
mod inspect;
mod mark;
mod memory;
mod output;
mod panics;
mod predict;
mod process;
mod provenance;
#[cfg(feature = "live")]
mod publish;
#[cfg(not(feature = "live"))]
#[path = "not_live.rs"]
mod publish;
mod read_back;
mod recover;
mod refusal;
mod replay;
mod report;
mod scene;
mod sketch;
mod stopwatch;
#[cfg(feature = "live")]
mod takes;
mod words;
mod working;

pub use crate::ingest::is_pipe;
pub use crate::page::View;
pub use crate::write::remove_unfinished;
pub use calibrate::{
    CalibrateChoice, CalibrateJob, CalibrateKind, CalibrateSceneJob, Calibrated, SceneCalibrated,
    TouchingPoint, calibrate, calibrate_scene,
};
pub use deadline::leeway;
#[cfg(feature = "live")]
pub use direct::{DaemonAnswer, DirectJob, Direction, Label, direct};
#[cfg(feature = "live")]
pub use doctor::{DoctorJob, Finding, Health, doctor};
pub use export::{DEFAULT_EXPORT_RATE_HZ, ExportFormat, ExportJob, Exported, export};
pub use finish::beside;
pub use fit::{
    AskedNames, FitInput, FitJob, FitQuestion, FitStop, FittedTakes, HoldOut, JoinedBlocks,
    ReduceJob, ReducedLine, SolveJob, TakeBlock, fit, join, reduce, reduce_files, solve_files,
};
pub use folders::{beside_each, recordings_in};
pub use from_urdf::{FromUrdfJob, UrdfImported, from_urdf};
pub use import::{BodyLine, FlightLine, ImportJob, Imported, InputLine, import};
pub use inspect::{Inspection, MarkLine, PoseLine, TopicLine, inspect};
pub use mark::{
    MarkEdits, MarkJob, Marked, PhaseProposals, ProposalLine, ProposedPhase, mark, proposed_phases,
};
pub use memory::{EstimateInMemory, SceneInMemory, TakeInMemory};
pub use output::write_file;
pub use predict::{DEFAULT_PREDICTION_S, PredictJob, predict};
pub use process::{Failure, ProcessJob, Processed, process};
pub(crate) use provenance::file_name;
#[cfg(not(feature = "live"))]
pub use publish::NotLive;
pub use recover::{RecoveredLine, recover_all};
pub use refusal::Refusal;
pub use replay::{PublishJob, ReplayJob, replay};
pub use report::{ReportJob, ReportMade, report};
pub use scene::{NewSceneJob, NewSceneMade, look_at_scene, made_scene, make_scene};
pub use sketch::{Density, SketchJob, Sketched, sketch};
#[cfg(feature = "live")]
pub use takes::{TakeEntry, takes};
pub use words::words;

pub use crate::ingest::table::{
    AngleUnit, MarkColumn, PRESETS, Preset, QuaternionOrder, TURNS, TableOptions, TimeUnit, Turn,
    length_unit,
};
pub use crate::ingest::{ListedMark, MarkTime};
