//! What a signal leaves behind: no file that is not whole.

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
#[cfg(unix)]
use signal_hook::iterator::Signals;

use crate::service::remove_unfinished;

/// From now on the process ends at SIGINT, SIGTERM and SIGHUP as it would without, by the signal, but removes the
/// temporaries of what it is writing before. Not for `capture`, which ends its take in order.
#[cfg(unix)]
pub(super) fn clean_up_on_signals() -> std::io::Result<()> {
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            remove_unfinished(|| {
                // It fails for signals alone that do not end a process; those three do.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            });
        }
    });
    Ok(())
}

/// Elsewhere temporaries stay when a process is ended.
#[cfg(not(unix))]
pub(super) fn clean_up_on_signals() -> std::io::Result<()> {
    Ok(())
}
