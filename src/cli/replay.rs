//! `replay`: estimates one recording and prints its account.

use super::account::{Style, account};
use super::arguments::{Free, ReplayArguments};
use super::exit::Exit;
use super::output::Account;
use super::process::{RECORDING_SCHEMA, print_failure};
use crate::service::{self, PublishJob, ReplayJob};

pub(super) fn run(arguments: ReplayArguments, verbose: bool) -> anyhow::Result<Exit> {
    let recording = arguments.input.display().to_string();
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = ReplayJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        is_free_auto: arguments.free == Some(Free::Auto),
        rate: arguments.rate,
        publish: arguments.publish.then_some(PublishJob {
            iceoryx2: arguments.iceoryx2,
        }),
        is_diagnosing: arguments.diagnosing.is_wanted(),
        deadline: arguments.limits.deadline,
    };
    let report = match service::replay(&job) {
        Ok(report) => report,
        Err(error) => {
            print_failure(&recording, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    said.print(RECORDING_SCHEMA, &report, |colours| {
        account(&report, Style { colours, verbose })
    })?;
    Ok(if report.is_whole() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}
