//! Results on stdout.

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;

use serde::Serialize;

use super::arguments::Format;
use crate::report::{self, plain_json, plain_line};
use crate::service::{file_name, is_pipe};

/// Writes a text. A reader that has closed the pipe is no error.
pub(super) fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Adds a line to a text for people: names in it may be anything, and of any length ([`plain_line`]).
pub(super) fn push_line(text: &mut String, line: impl AsRef<str>) {
    text.push_str(&plain_line(line.as_ref()));
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

/// Prints what was lost, and what to know, on stderr where stdout has a file.
pub(super) fn print_notes(lost: &[String], warnings: &[String]) {
    lost.iter()
        .chain(warnings)
        .for_each(|note| print_note(note));
}

/// Where the account of a command that makes a file goes, and how: on stdout, or on stderr where stdout
/// carries the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Account {
    format: Format,
    is_piped: bool,
}

impl Account {
    /// That of a command whose file goes there, if anywhere.
    pub(super) fn new(format: Format, output: Option<&Path>) -> Self {
        let is_piped = output.is_some_and(is_pipe);
        Self { format, is_piped }
    }

    /// How a failure is said: of a file that would be on stdout nothing is there, for a pipe carries the file or nothing.
    pub(super) fn of_failure(self) -> Format {
        if self.is_piped {
            Format::Text
        } else {
            self.format
        }
    }

    /// Prints a value as a line for machines, or as a text, which is told whether colours are wanted.
    pub(super) fn print(
        self,
        schema: &str,
        value: &impl Serialize,
        text: impl FnOnce(bool) -> String,
    ) -> anyhow::Result<()> {
        let said = match (self.format, self.is_piped) {
            (Format::Ndjson, _) => json_line(schema, value)?,
            (Format::Text, false) => text(colours_on_stdout()),
            (Format::Text, true) => text(colours_on_stderr()),
        };
        if self.is_piped {
            io::stderr().write_all(said.as_bytes())?;
        } else {
            print(&said)?;
        }
        Ok(())
    }

    /// Whether stdout carries the file.
    pub(super) fn is_piped(self) -> bool {
        self.is_piped
    }
}

/// Writes one JSON object on a line of its own, the name and version of its schema first: `docs/ndjson.md` has them.
pub(super) fn print_json(schema: &str, value: &impl Serialize) -> anyhow::Result<()> {
    Ok(print(&json_line(schema, value)?)?)
}

fn json_line(schema: &str, value: &impl Serialize) -> serde_json::Result<String> {
    #[derive(Serialize)]
    struct OutputLine<'a, T> {
        schema: &'a str,
        #[serde(flatten)]
        value: &'a T,
    }
    let line = serde_json::to_string(&OutputLine { schema, value })?;
    let mut line = plain_json(&line).into_owned();
    line.push('\n');
    Ok(line)
}

/// Prints an error on stderr; a closed stderr is ignored.
pub(super) fn print_error(error: &str) {
    let _ = writeln!(io::stderr(), "error: {}", plain_line(error));
}

/// Prints a warning on stderr; a closed stderr is ignored.
#[cfg(feature = "live")]
pub(super) fn print_warning(warning: &str) {
    let _ = writeln!(io::stderr(), "warning: {}", plain_line(warning));
}

/// Prints a note on stderr, where stdout has another use.
pub(super) fn print_note(note: &str) {
    let _ = writeln!(io::stderr(), "note: {}", plain_line(note));
}

/// The program by its name, and its arguments as a shell takes them. Of files the names alone: where they lie on a
/// machine, and whose it is, is nobody's business who gets what was made.
pub(super) fn command_line() -> String {
    let arguments = std::env::args_os().skip(1);
    let arguments = arguments.map(|argument| without_folders(&argument.to_string_lossy()));
    let words: Vec<String> = ["enact".to_owned()].into_iter().chain(arguments).collect();
    report::command_line(&words)
}

/// `--out=a/b.csv` → `--out=b.csv`.
fn without_folders(argument: &str) -> String {
    let (option, value) = match argument.split_once('=') {
        Some((option, value)) if option.starts_with('-') => (Some(option), value),
        _ => (None, argument),
    };
    let name = file_name(Path::new(value));
    match option {
        Some(option) => format!("{option}={name}"),
        None => name,
    }
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

#[cfg(test)]
mod tests {
    use super::without_folders;

    #[test]
    fn of_files_the_names_alone_are_noted() {
        for (argument, noted) in [
            ("/home/user/takes/a b.mcap", "a b.mcap"),
            ("../a.mcap", "a.mcap"),
            ("a.mcap", "a.mcap"),
            ("--output=/tmp/x.glb", "--output=x.glb"),
            ("--fps", "--fps"),
            ("-", "-"),
            ("12,-5,40", "12,-5,40"),
            ("..", ".."),
        ] {
            assert_eq!(without_folders(argument), noted);
        }
    }
}
