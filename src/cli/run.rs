//! Parses the arguments, runs the command, returns the exit code.

use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use tracing_subscriber::EnvFilter;

use super::arguments::{Arguments, Command};
use super::exit::Exit;
use super::{
    calibrate, completion, export, fit, import, inspect, interrupt, manual, mark, output, predict,
    process, recover, replay, report, scene, sketch,
};
#[cfg(feature = "live")]
use super::{capture, doctor, take};
use crate::service;

/// Runs the command that the process was started with.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    log_to_stderr(arguments.verbose);
    let verbose = arguments.verbose > 0;
    if !matches!(arguments.command, Command::Capture(_))
        && let Err(error) = interrupt::clean_up_on_signals()
    {
        tracing::warn!(%error, "signals cannot be caught: one may leave a temporary file");
    }
    if let Some(limit) = arguments.command.deadline() {
        interrupt::end_after(limit, Duration::ZERO);
    }
    if let Some(limit) = arguments.command.limit() {
        interrupt::end_after(limit, service::leeway(limit));
    }
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
        Command::Report(arguments) => report::run(arguments),
        Command::Predict(arguments) => predict::run(arguments, verbose),
        Command::Calibrate { command } => calibrate::run(command),
        Command::Fit(arguments) => fit::run(arguments),
        Command::Scene { command } => scene::run(command),
        Command::Completion { shell } => completion::run(shell),
        Command::Manual { output } => manual::run(&output),
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
        // Where stderr is gone there is nowhere to say so, and no reason to panic.
        .log_internal_errors(false)
        .init();
}
