//! `process`: estimates many recordings, prints one account each and a summary.

use serde::Serialize;

use super::account::{Style, account};
use super::arguments::{Format, Free, ProcessArguments};
use super::exit::Exit;
use super::output;
use super::summary::Summary;
use crate::report::DiagnosisLine;
use crate::service::{self, ProcessJob, Processed, Refusal};

/// Schema of the line of a recording: what became of its estimation.
pub(super) const RECORDING_SCHEMA: &str = "enact.recording/1";

/// Recordings of which each has an account; of more there is a line each, unless all is asked for.
const TOLD: usize = 3;

pub(super) fn run(arguments: ProcessArguments, verbose: bool) -> anyhow::Result<Exit> {
    let job = ProcessJob {
        inputs: service::recordings_in(&arguments.inputs)?,
        output: arguments.output,
        scene: arguments.scene,
        is_free_auto: arguments.free == Some(Free::Auto),
        is_diagnosing: arguments.diagnosing.is_wanted(),
        deadline: arguments.limits.deadline,
        is_resuming: arguments.resume,
    };
    let tells_all = verbose || job.inputs.len() <= TOLD;
    let style = Style {
        colours: output::colours_on_stdout(),
        verbose,
    };
    let format = arguments.format;
    let mut exit = Exit::Done;
    let mut summary = Summary::default();
    service::process(&job, |result| {
        let of_one = match result {
            Ok(Processed::Estimated(report)) => {
                match format {
                    Format::Ndjson => output::print_json(RECORDING_SCHEMA, &report)?,
                    Format::Text if tells_all => {
                        output::print(&format!("{}\n", account(&report, style)))?;
                    }
                    Format::Text => {}
                }
                summary.estimated(&report);
                if report.is_whole() {
                    Exit::Done
                } else {
                    Exit::NotWhole
                }
            }
            Ok(Processed::Present {
                recording,
                report,
                ended_early,
            }) => {
                if format == Format::Ndjson {
                    let why = match ended_early {
                        true => "its estimate is there, ended at its deadline",
                        false => "its estimate is there",
                    };
                    print_left_alone(&recording, why)?;
                }
                summary.present(&recording, &report, ended_early);
                match report.is_undoubted() && !ended_early {
                    true => Exit::Done,
                    false => Exit::NotWhole,
                }
            }
            Ok(Processed::LeftAlone { recording }) => {
                if format == Format::Ndjson {
                    print_left_alone(&recording, "has an estimate already")?;
                }
                summary.left_alone(&recording);
                Exit::Done
            }
            Err(failure) => {
                print_failure(&failure.recording, &failure.error, format)?;
                summary.failed(&failure.recording);
                Exit::Error
            }
        };
        exit = exit.max(of_one);
        Ok(())
    })?;
    if format == Format::Text {
        output::print(&summary.text())?;
        if !tells_all {
            output::print_note(
                "-v prints the account of each recording; `enact report` draws an estimate",
            );
        }
    }
    Ok(exit)
}

/// A recording that has an estimate: a line for machines.
fn print_left_alone(recording: &str, why: &str) -> anyhow::Result<()> {
    #[derive(Serialize)]
    struct LeftLine<'a> {
        recording: &'a str,
        why: &'a str,
    }
    output::print_json("enact.left_alone/1", &LeftLine { recording, why })
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
        output::print_json(
            "enact.failure/1",
            &FailureLine {
                recording,
                error,
                diagnoses,
            },
        )?;
    }
    Ok(())
}
