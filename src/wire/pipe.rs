//! The name that is none: `-`, from which stdin is read and to which stdout is written.

use std::io::Read as _;
use std::path::Path;

use super::regular;

/// Whether a name stands for stdin, or of an output for stdout.
pub fn is_pipe(path: &Path) -> bool {
    path == Path::new("-")
}

/// The bytes of a file, or of stdin.
pub fn read_whole(path: &Path) -> std::io::Result<Vec<u8>> {
    if !is_pipe(path) {
        return regular::read(path);
    }
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes)?;
    Ok(bytes)
}
