//! `process`: estimates many recordings and prints one account each.

use serde::Serialize;

use super::account::{Style, account};
use super::arguments::{Format, Free, ProcessArguments};
use super::exit::Exit;
use super::output;
use crate::report::DiagnosisLine;
use crate::service::{self, ProcessJob, Refusal};

pub(super) fn run(arguments: ProcessArguments, verbose: bool) -> anyhow::Result<Exit> {
    let job = ProcessJob {
        inputs: arguments.inputs,
        output: arguments.output,
        scene: arguments.scene,
        is_free_auto: arguments.free == Some(Free::Auto),
        time_limit: arguments.limits.time_limit,
    };
    let style = Style {
        colours: output::colours_on_stdout(),
        verbose,
    };
    let format = arguments.format;
    let mut exit = Exit::Done;
    let mut first = true;
    service::process(&job, |result| {
        let of_one = match result {
            Ok(report) => {
                match format {
                    Format::Ndjson => output::print_json(&report)?,
                    Format::Text if first => output::print(&account(&report, style))?,
                    Format::Text => output::print(&format!("\n{}", account(&report, style)))?,
                }
                first = false;
                if report.is_whole() {
                    Exit::Done
                } else {
                    Exit::NotWhole
                }
            }
            Err(failure) => {
                print_failure(&failure.recording, &failure.error, format)?;
                Exit::Error
            }
        };
        exit = exit.max(of_one);
        Ok(())
    })?;
    Ok(exit)
}

/// A recording without an estimate: a line on stdout for machines, on stderr for people.
pub(super) fn print_failure(
    recording: &str,
    error: &anyhow::Error,
    format: Format,
) -> anyhow::Result<()> {
    #[derive(Serialize)]
    struct FailureLine<'a> {
        recording: &'a str,
        error: String,
        diagnoses: &'a [DiagnosisLine],
    }
    let refusal = error.downcast_ref::<Refusal>();
    let diagnoses = refusal.map_or(&[][..], |refusal| &refusal.diagnoses);
    let error = service::words(error);
    output::print_error(&error);
    if format == Format::Ndjson {
        output::print_json(&FailureLine {
            recording,
            error,
            diagnoses,
        })?;
    }
    Ok(())
}
