//! `predict`: continues a motion from its flight until it rests.

use super::account::{Style, account};
use super::arguments::{Format, PredictArguments};
use super::exit::Exit;
use super::output;
use super::process::{RECORDING_SCHEMA, print_failure};
use crate::service::{self, PredictJob};

pub(super) fn run(arguments: PredictArguments, verbose: bool) -> anyhow::Result<Exit> {
    let recording = arguments.input.display().to_string();
    let job = PredictJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        until: arguments.until,
        limit_s: arguments.limit,
    };
    let report = match service::predict(&job) {
        Ok(report) => report,
        Err(error) => {
            print_failure(&recording, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json(RECORDING_SCHEMA, &report)?,
        Format::Text => output::print(&account(
            &report,
            Style {
                colours: output::colours_on_stdout(),
                verbose,
            },
        ))?,
    }
    Ok(if report.is_whole() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}
