//! What a signal or a deadline leaves behind: no file that is not whole.

use std::time::Duration;

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
#[cfg(unix)]
use signal_hook::iterator::Signals;

use super::exit::Exit;
use super::output;
use crate::service::remove_unfinished;

/// So long after a deadline the process says that it is late and ends, with exit code 1, as a signal would end it.
pub(super) fn end_after(limit: Duration, leeway: Duration) {
    std::thread::spawn(move || {
        std::thread::sleep(limit.saturating_add(leeway));
        remove_unfinished(|| {
            let limit = humantime::format_duration(limit);
            output::print_error(&format!(
                "the deadline of {limit} was over before all was done; give it more by --deadline"
            ));
            Exit::Error.end();
        });
    });
}

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
