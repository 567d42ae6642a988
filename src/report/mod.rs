//! What an estimate says of itself, with the scene's names in place of indices.
//!
//! Every noun has one definition and one set of field names: [`EstimateReport`] is made of them, and
//! both the message of a file ([`EstimateMessage`], with a JSON schema) and the JSON object of a
//! recording ([`RecordingReport`]) contain it, each with what it alone knows. The account in the
//! terminal reads the latter. Sentences are made here: [`reason_text`] says why an estimation ended,
//! [`DoubtLine`] what speaks against its motion, [`DiagnosisLine`] what is likely mistaken in the scene or the
//! stream.
//!
//! Names are as they are in files and on the wire; who prints them does so through [`plain()`].
//!
//! Numbers are SI unless a name says otherwise. Numbers that are not finite (a bound that does not
//! bind, a deviation that nothing determines) are `null` in JSON. [`EstimateMessage::read`] reads it back, of any
//! version.

mod along;
pub mod certainty;
pub mod checks;
pub mod diagnoses;
pub mod doubts;
pub mod estimate;
mod fit;
pub mod goals;
pub mod held;
mod impacts;
pub mod joint;
pub mod message;
pub mod motion;
pub mod plain;
pub mod provenance;
mod read;
pub mod reason;
pub mod recording;
pub mod reported;
pub mod rest;
pub mod samples;
pub mod seen;
pub mod spent;
pub mod spread;
pub mod suspects;
#[cfg(test)]
mod tests;
pub mod time_map;
pub mod units;

pub use along::AlongLine;
pub use certainty::{CertaintyLine, DEVIATION_SCHEMA, DeviationMessage};
pub use checks::{BalanceLine, CheckLine, DeviationLine, OverlapLine, ShotLine, TouchLine};
pub use diagnoses::DiagnosisLine;
pub use doubts::{DoubtLine, gravest};
pub use estimate::EstimateReport;
pub use fit::fit_words;
pub use goals::GoalLine;
pub use held::HeldLine;
pub use impacts::ImpactLine;
pub use joint::{
    FitLine, FitTakeLine, FittedLine, HeldOutLine, InfluenceLine, OwnLine, ResidualLine,
    TakeSpreadLine,
};
pub use message::{ArcLine, EstimateMessage, REPORT_SCHEMA, json};
pub use motion::{DurationLine, EventLine, ParameterLine, SegmentLine};
pub use plain::{brief, plain, plain_json, plain_line, prints};
pub use provenance::{ExportProvenance, Provenance, command_line};
pub use reason::{MeasuredLine, TerminationLine, reason_text};
pub use recording::{Circumstances, RecordingReport};
pub use reported::Reported;
pub use rest::{LieLine, RestLine};
pub use samples::{CounterLine, Ordered, SampleLine, SettledLine};
pub use seen::{SeenPhaseLine, hint};
pub use spent::Spent;
pub use spread::{BodySpreadLine, SpreadLine, UpLine};
pub use suspects::SuspectLine;
pub use time_map::{BodyTimes, EventTimeLine, TIME_MAP_SCHEMA, Time, TimeMapMessage};
