//! Results on stdout.

use std::io::{self, ErrorKind, IsTerminal, Write};

use serde::Serialize;

pub(super) use crate::report::printable;
use crate::report::printable_lines;

/// Writes an account; control characters in it but line feeds and our own colours, which may be in
/// names from files and from the wire, are escaped. A reader that has closed the pipe is no error.
pub(super) fn print(text: &str) -> io::Result<()> {
    print_bytes(printable_lines(text).as_bytes())
}

/// [`print`] of what is not text.
pub(super) fn print_bytes(bytes: &[u8]) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    let written = stdout.write_all(bytes).and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Writes one JSON object on a line of its own.
pub(super) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let mut line = serde_json::to_string(value)?;
    line.push('\n');
    // JSON escapes what is not printable itself.
    Ok(print_bytes(line.as_bytes())?)
}

/// Prints an error on stderr; a closed stderr is ignored.
pub(super) fn print_error(error: &str) {
    let _ = writeln!(io::stderr(), "error: {}", printable(error));
}

/// Prints a warning on stderr; a closed stderr is ignored.
#[cfg(feature = "live")]
pub(super) fn print_warning(warning: &str) {
    let _ = writeln!(io::stderr(), "warning: {}", printable(warning));
}

/// Prints a note on stderr, where stdout has another use.
pub(super) fn print_note(note: &str) {
    let _ = writeln!(io::stderr(), "note: {}", printable(note));
}

/// Whether colours are wanted on stdout.
pub(super) fn colours_on_stdout() -> bool {
    io::stdout().is_terminal() && colours_allowed()
}

/// Whether colours are wanted on stderr.
pub(super) fn colours_on_stderr() -> bool {
    io::stderr().is_terminal() && colours_allowed()
}

/// The convention of <https://no-color.org>: any text but the empty one forbids colours.
fn colours_allowed() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
