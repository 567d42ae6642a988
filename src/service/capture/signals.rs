//! What tells the daemon to end, from system to system.

use std::io;

#[cfg(unix)]
use tokio::signal::unix::{
    Signal as Hangup, Signal as Interrupt, Signal as Terminate, SignalKind, signal,
};
#[cfg(windows)]
use tokio::signal::windows::{
    CtrlBreak as Terminate, CtrlC as Interrupt, CtrlClose as Hangup, ctrl_break, ctrl_c, ctrl_close,
};

/// Signals from now on.
pub(super) struct EndSignals {
    terminate: Terminate,
    interrupt: Interrupt,
    hangup: Hangup,
}

impl EndSignals {
    pub(super) fn begin() -> io::Result<Self> {
        #[cfg(unix)]
        let signals = Self {
            terminate: signal(SignalKind::terminate())?,
            interrupt: signal(SignalKind::interrupt())?,
            hangup: signal(SignalKind::hangup())?,
        };
        #[cfg(windows)]
        let signals = Self {
            terminate: ctrl_break()?,
            interrupt: ctrl_c()?,
            hangup: ctrl_close()?,
        };
        Ok(signals)
    }

    /// The next one; whether it may be a second one. A terminal that is closed may say so twice.
    pub(super) async fn next(&mut self) -> bool {
        tokio::select! {
            _ = self.terminate.recv() => true,
            _ = self.interrupt.recv() => true,
            _ = self.hangup.recv() => false,
        }
    }
}
