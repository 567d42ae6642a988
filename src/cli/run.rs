//! Parses the arguments, runs the command, returns the exit code.

use std::process::ExitCode;

use clap::Parser;
use tracing_subscriber::EnvFilter;

use super::arguments::{Arguments, Command};
use super::exit::Exit;
#[cfg(feature = "live")]
use super::{capture, doctor, take};
use super::{
    completion, export, import, inspect, mark, output, process, recover, replay, scene, sketch,
};
use crate::service;

/// Runs the command that the process was started with.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    log_to_stderr(arguments.verbose);
    let verbose = arguments.verbose > 0;
    let result = match arguments.command {
        #[cfg(feature = "live")]
        Command::Capture(arguments) => capture::run(arguments, verbose),
        #[cfg(feature = "live")]
        Command::Take(arguments) => take::run(arguments),
        Command::Recover(arguments) => recover::run(arguments),
        #[cfg(feature = "live")]
        Command::Doctor(arguments) => doctor::run(arguments),
        #[cfg(not(feature = "live"))]
        Command::Capture(_) | Command::Take(_) | Command::Doctor(_) => Err(service::NotLive.into()),
        Command::Replay(arguments) => replay::run(arguments, verbose),
        Command::Process(arguments) => process::run(arguments, verbose),
        Command::Import(arguments) => import::run(arguments),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Mark(arguments) => mark::run(arguments),
        Command::Sketch(arguments) => sketch::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Scene { command } => scene::run(command),
        Command::Completion { shell } => completion::run(shell),
    };
    match result {
        Ok(exit) => exit.into(),
        Err(error) => {
            output::print_error(&service::words(&error));
            Exit::Error.into()
        }
    }
}

/// Starts logging to stderr. The level is that of the flag, else of the environment, else the
/// default.
fn log_to_stderr(verbose: u8) {
    let filter = match verbose {
        0 => EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn")),
        1 => EnvFilter::new("warn,enact=info"),
        _ => EnvFilter::new("warn,enact=debug"),
    };
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(output::colours_on_stderr())
        .init();
}
