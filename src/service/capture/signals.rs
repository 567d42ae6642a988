//! What tells the daemon to end, from system to system.

use std::io;

#[cfg(unix)]
use tokio::signal::unix::{Signal, SignalKind, signal};
#[cfg(windows)]
use tokio::signal::windows::{CtrlBreak, CtrlC, CtrlClose, ctrl_break, ctrl_c, ctrl_close};

/// Signals from now on.
#[cfg(unix)]
pub(super) struct EndSignals {
    terminate: Signal,
    interrupt: Signal,
    hangup: Signal,
}

#[cfg(unix)]
impl EndSignals {
    pub(super) fn begin() -> io::Result<Self> {
        Ok(Self {
            terminate: signal(SignalKind::terminate())?,
            interrupt: signal(SignalKind::interrupt())?,
            hangup: signal(SignalKind::hangup())?,
        })
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

/// Signals from now on.
#[cfg(windows)]
pub(super) struct EndSignals {
    interrupt: CtrlC,
    end: CtrlBreak,
    close: CtrlClose,
}

#[cfg(windows)]
impl EndSignals {
    pub(super) fn begin() -> io::Result<Self> {
        Ok(Self {
            interrupt: ctrl_c()?,
            end: ctrl_break()?,
            close: ctrl_close()?,
        })
    }

    /// The next one; whether it may be a second one. A terminal that is closed may say so twice.
    pub(super) async fn next(&mut self) -> bool {
        tokio::select! {
            _ = self.interrupt.recv() => true,
            _ = self.end.recv() => true,
            _ = self.close.recv() => false,
        }
    }
}
