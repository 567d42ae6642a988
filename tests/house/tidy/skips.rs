//! Tests that do not run where they are are counted.

use super::File;

/// How a test would say that it does not run, but to `tests/support/skip.rs`.
const SKIPS: &[&str] = &["\"skipped", "\"not tested"];

/// Skips that nobody counts.
pub(super) fn check(file: &File, found: &mut Vec<String>) {
    if file.path.starts_with("tests/support/")
        || !file.path.contains("test")
        || file.path == "tests/house/tidy.rs"
        || file.path.starts_with("tests/house/tidy/")
    {
        return;
    }
    for (index, line) in file.text.lines().enumerate() {
        if SKIPS.iter().any(|said| line.contains(said)) {
            found.push(format!("{}:{}: an uncounted skip", file.path, index + 1));
        }
    }
}
