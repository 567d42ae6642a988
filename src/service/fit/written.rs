//! An answer, written where it is wanted.

use std::path::Path;

use super::job::{FitInput, FitJob};
use super::tell::ToldFit;
use crate::page::fit_page;
use crate::report::{FitLine, FitTakeLine};
use crate::service::output::{write_file_of, write_new_file};

/// The result of [`fit`](super::fit()).
#[derive(Clone, Debug)]
pub struct FittedTakes {
    /// The answer.
    pub line: FitLine,
    /// What became of each take, in the order of the inputs.
    pub takes: Vec<FitTakeLine>,
    /// The answer as a calibration.
    pub toml: String,
}

/// The answer, written where it is wanted.
pub(super) fn written(job: &FitJob, told: ToldFit) -> anyhow::Result<FittedTakes> {
    let toml = told.calibration.to_toml()?;
    let made_of = made_of(job);
    if let Some(output) = &job.output {
        write_new_file(output, toml.as_bytes(), &made_of)?;
    }
    if let Some(page) = &job.page {
        let html = fit_page(&told.line, &told.takes);
        write_file_of(page, html.as_bytes(), &made_of)?;
    }
    Ok(FittedTakes {
        line: told.line,
        takes: told.takes,
        toml,
    })
}

fn made_of(job: &FitJob) -> Vec<&Path> {
    let inputs = job.inputs.iter().map(FitInput::name);
    inputs.chain(job.scene.as_deref()).collect()
}
