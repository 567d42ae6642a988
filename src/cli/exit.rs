//! Exit codes; the table is in the prose of [`cli`](crate::cli).

use std::process::ExitCode;

/// How a command ended. The greater of two, in the order of declaration, is the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Exit {
    Done,
    NotWhole,
    Error,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(match exit {
            Exit::Done => 0,
            Exit::Error => 1,
            // 2 is usage, and clap's.
            Exit::NotWhole => 3,
        })
    }
}
