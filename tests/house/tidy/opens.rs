//! One door for files that are read.

use super::tokens::Token;
use super::{File, matches};

/// How a file is opened that may be a pipe, which is waited for: everywhere but at the one door, and of files with a
/// reason of their own.
const OPENS: &[&[&str]] = &[
    &["fs", "::", "read", "("],
    &["fs", "::", "read_to_string", "("],
    &["File", "::", "open", "("],
];

/// The door, and those files: the system's random bytes, a spare descriptor, folders that are synced.
const MAY_OPEN: &[&str] = &[
    "src/wire/regular.rs",
    "src/wire/live/token.rs",
    "src/service/capture/gate.rs",
    "src/write/atomic.rs",
];

/// Files are opened through `src/wire/regular.rs`.
pub(super) fn check(file: &File, code: &[Token], found: &mut Vec<String>) {
    if MAY_OPEN.contains(&file.path.as_str()) {
        return;
    }
    for pattern in OPENS {
        for at in matches(code, pattern) {
            let (line, pattern) = (code[at].line, pattern[..3].concat());
            found.push(format!("{}:{line}: {pattern} past the door", file.path));
        }
    }
}
