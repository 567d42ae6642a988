//! Exit codes; the table is in the prose of [`cli`](crate::cli).

use std::process::ExitCode;

/// How a command ended. The greater of two, in the order of declaration, is the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Exit {
    Done,
    NotWhole,
    Error,
}

impl Exit {
    fn code(self) -> u8 {
        match self {
            Exit::Done => 0,
            Exit::Error => 1,
            // 2 is usage, and clap's.
            Exit::NotWhole => 3,
        }
    }

    /// Ends the process, whatever other threads do.
    pub(super) fn end(self) -> ! {
        std::process::exit(self.code().into())
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit.code())
    }
}
