//! Errors of a scene file: place, and what was expected there.

use std::ops::Range;

use thiserror::Error;

use super::keys;

/// A scene that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}:{line}:{column}: {message}", .file.as_deref().unwrap_or("scene"))]
pub struct SceneError {
    /// The file, or another name of the text, if known.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong and what was expected.
    pub message: String,
}

impl SceneError {
    /// The error with the name of its file.
    pub fn in_file(mut self, file: impl Into<String>) -> Self {
        self.file = Some(file.into());
        self
    }

    pub(super) fn from_fault(text: &str, fault: Fault) -> Self {
        let (line, column) = line_and_column(text, fault.span.start);
        Self {
            file: None,
            line,
            column,
            message: fault.message,
        }
    }

    pub(super) fn from_toml(text: &str, error: &toml::de::Error) -> Self {
        let span = error.span().unwrap_or(0..0);
        Self::from_fault(
            text,
            Fault {
                span,
                message: keys::explain(error.message()),
            },
        )
    }
}

/// An error at a place of the text, as a range of bytes; [`SceneError`] has line and column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) span: Range<usize>,
    pub(super) message: String,
}

/// A [`Fault`] as an error.
pub(super) fn fault<T>(span: Range<usize>, message: impl Into<String>) -> Result<T, Fault> {
    Err(Fault {
        span,
        message: message.into(),
    })
}

fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}
