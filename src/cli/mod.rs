//! The commands: arguments → a job for [`service`](crate::service) → an account of it.
//!
//! Results go to stdout, diagnostics and progress to stderr. The exit code says how a command
//! ended:
//!
//! | code | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | error: nothing was written for at least one recording |
//! | 2 | usage: the arguments are invalid |
//! | 3 | finished, but data were lost or the estimate is not physical |

mod account;
mod arguments;
mod calibrate;
#[cfg(feature = "live")]
mod capture;
mod completion;
#[cfg(feature = "live")]
mod doctor;
mod exit;
mod export;
mod fit;
mod import;
mod inspect;
mod interrupt;
mod manual;
mod mark;
mod output;
mod predict;
mod process;
mod recover;
mod replay;
mod report;
mod run;
mod scene;
mod sketch;
mod summary;
mod table;
#[cfg(feature = "live")]
mod take;

pub use run::run;
