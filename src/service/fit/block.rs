//! What one take says in one round, and where takes are asked next: what travels between processes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::config::SourceLine;
use crate::motion::TakeShare;

/// What one take says in one round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TakeBlock {
    /// Counts from zero: the round in which each take is asked at its own values.
    pub round: usize,
    /// Names of what all takes share,
    pub shared: Vec<String>,
    /// and of what each draws.
    pub drawn: Vec<String>,
    /// Where it was asked, SI; none in the first round.
    pub asked: Option<Vec<f64>>,
    /// What it says; none where it has no motion.
    pub share: Option<TakeShare>,
    /// Whether its motion is said not to explain its samples.
    pub is_misfit: bool,
    /// Why nothing can be asked of it.
    pub why: Option<String>,
    /// Whether that is as it should be: an output among the inputs.
    pub is_left_alone: bool,
    /// What was lost of it, and what to know.
    pub notes: Vec<String>,
    /// The recording.
    pub source: SourceLine,
    /// The text of its scene.
    pub scene_toml: String,
}

/// Where takes are asked next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitQuestion {
    /// The round.
    pub round: usize,
    /// Values at which each take is asked, SI, by the SHA-256 of its recording.
    pub asked: BTreeMap<String, Vec<f64>>,
}
