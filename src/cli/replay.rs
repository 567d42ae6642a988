//! `replay`: estimates one recording and prints its account.

use super::account::{Style, account};
use super::arguments::{Format, Free, ReplayArguments};
use super::exit::Exit;
use super::output;
use super::process::{RECORDING_SCHEMA, print_failure};
use crate::service::{self, PublishJob, ReplayJob, is_pipe};

pub(super) fn run(arguments: ReplayArguments, verbose: bool) -> anyhow::Result<Exit> {
    let recording = arguments.input.display().to_string();
    // Stdout has the recording then.
    let is_piped = arguments.output.as_deref().is_some_and(is_pipe);
    let job = ReplayJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        is_free_auto: arguments.free == Some(Free::Auto),
        rate: arguments.rate,
        publish: arguments.publish.then_some(PublishJob {
            iceoryx2: arguments.iceoryx2,
        }),
        deadline: arguments.limits.deadline,
    };
    let report = match service::replay(&job) {
        Ok(report) => report,
        Err(error) => {
            print_failure(&recording, &error, arguments.format.of_failure(is_piped))?;
            return Ok(Exit::Error);
        }
    };
    let style = |colours: bool| Style { colours, verbose };
    match (arguments.format, is_piped) {
        (Format::Ndjson, false) => output::print_json(RECORDING_SCHEMA, &report)?,
        (Format::Ndjson, true) => output::print_json_on_stderr(RECORDING_SCHEMA, &report)?,
        (Format::Text, false) => {
            output::print(&account(&report, style(output::colours_on_stdout())))?;
        }
        (Format::Text, true) => {
            output::print_on_stderr(&account(&report, style(output::colours_on_stderr())))?;
        }
    }
    Ok(if report.is_whole() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}
