//! `replay`: estimates one recording and prints its account.

use super::account::{Style, account};
use super::arguments::{Format, Free, ReplayArguments};
use super::exit::Exit;
use super::output;
use super::process::print_failure;
use crate::service::{self, PublishJob, ReplayJob};

pub(super) fn run(arguments: ReplayArguments, verbose: bool) -> anyhow::Result<Exit> {
    let recording = arguments.input.display().to_string();
    let job = ReplayJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        is_free_auto: arguments.free == Some(Free::Auto),
        rate: arguments.rate,
        publish: arguments.publish.then_some(PublishJob {
            iceoryx2: arguments.iceoryx2,
        }),
        time_limit: arguments.limits.time_limit,
    };
    let report = match service::replay(&job) {
        Ok(report) => report,
        Err(error) => {
            print_failure(&recording, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json(&report)?,
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
