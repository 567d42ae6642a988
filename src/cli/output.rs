//! Results on stdout.

use std::io::{self, ErrorKind, IsTerminal, Write};

use serde::Serialize;

use crate::report::{plain, plain_json};

/// Writes a text. A reader that has closed the pipe is no error.
pub(super) fn print(text: &str) -> io::Result<()> {
    print_bytes(text.as_bytes())
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

/// Adds a line to a text for people: names in it may be anything ([`plain`]).
pub(super) fn push_line(text: &mut String, line: impl AsRef<str>) {
    text.push_str(&plain(line.as_ref()));
    text.push('\n');
}

/// Adds what was lost, and what to know, a line each.
pub(super) fn push_notes(text: &mut String, lost: &[String], warnings: &[String]) {
    for loss in lost {
        push_line(text, format!("  lost: {loss}"));
    }
    for warning in warnings {
        push_line(text, format!("  note: {warning}"));
    }
}

/// Writes one JSON object on a line of its own.
pub(super) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let line = serde_json::to_string(value)?;
    let mut line = plain_json(&line).into_owned();
    line.push('\n');
    Ok(print(&line)?)
}

/// Prints an error on stderr; a closed stderr is ignored.
pub(super) fn print_error(error: &str) {
    let _ = writeln!(io::stderr(), "error: {}", plain(error));
}

/// Prints a note on stderr, where stdout has another use.
pub(super) fn print_note(note: &str) {
    let _ = writeln!(io::stderr(), "note: {}", plain(note));
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
