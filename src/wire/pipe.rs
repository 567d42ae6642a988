//! The name that is none: `-`, from which stdin is read and to which stdout is written.

use std::path::Path;

/// Whether a name stands for stdin, or of an output for stdout.
pub fn is_pipe(path: &Path) -> bool {
    path == Path::new("-")
}
