//! Parse, run, one exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    enact::cli::run()
}
