//! A recording of which no estimate is possible, with what is likely mistaken.

use thiserror::Error;

use crate::motion::Observer;
use crate::pipeline::{Pipeline, PipelineError};
use crate::report::DiagnosisLine;

/// Why there is no estimate, and what would make one possible.
#[derive(Debug, Error)]
#[error("{error}{}", sentences(.diagnoses))]
pub struct Refusal {
    /// The pipeline's reason.
    pub error: PipelineError,
    /// Likely mistakes in what is said of the performance, that which explains most first.
    pub diagnoses: Vec<DiagnosisLine>,
}

impl Refusal {
    /// Looks for likely mistakes.
    pub(super) fn new(
        pipeline: &Pipeline,
        error: PipelineError,
        observer: &mut dyn Observer,
    ) -> Self {
        let diagnoses = pipeline.diagnose(observer);
        let lines = diagnoses
            .iter()
            .map(|diagnosis| DiagnosisLine::new(pipeline.scene(), diagnosis));
        Self {
            error,
            diagnoses: lines.collect(),
        }
    }
}

fn sentences(diagnoses: &[DiagnosisLine]) -> String {
    let sentences = diagnoses.iter();
    sentences
        .map(|line| format!("; likely: {}", line.sentence))
        .collect()
}
