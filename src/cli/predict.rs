//! `predict`: continues a motion from its flight until it rests.

use super::account::{Style, account};
use super::arguments::PredictArguments;
use super::exit::Exit;
use super::output::Account;
use super::process::{RECORDING_SCHEMA, print_failure};
use crate::service::{self, PredictJob};

pub(super) fn run(arguments: PredictArguments, verbose: bool) -> anyhow::Result<Exit> {
    let recording = arguments.input.display().to_string();
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = PredictJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        until: arguments.until,
        limit_s: arguments.limit,
        is_diagnosing: arguments.diagnosing.is_wanted(),
        deadline: arguments.limits.deadline,
    };
    let report = match service::predict(&job) {
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
