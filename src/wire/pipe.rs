//! What is read as a whole: files, open pipes, as a shell makes of `<(...)`, and stdin by the name that is none, `-`, by
//! which stdout is written.
//!
//! What has no end, or is larger than anything of its kind, is refused before memory is gone.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Seek};
use std::path::Path;

use super::regular;

/// Most bytes of what does not begin as a recording, or comes through a pipe: a gibibyte.
const UNKNOWN_BYTES: u64 = 1 << 30;

/// Most bytes of a text that people write: a scene, marks, a robot description.
const TEXT_BYTES: u64 = 64 << 20;

/// How MCAP begins.
const MAGIC: &[u8] = b"\x89MCAP";

/// Whether a name stands for stdin, or of an output for stdout.
pub fn is_pipe(path: &Path) -> bool {
    path == Path::new("-")
}

/// The bytes of a file or an open pipe, or of stdin.
///
/// Fails for devices, folders and pipes on the disk, and for more than a gibibyte from a pipe or of what does not begin as a recording.
pub fn read_whole(path: &Path) -> Result<Vec<u8>> {
    if is_pipe(path) {
        return read_all(std::io::stdin().lock(), 0, UNKNOWN_BYTES);
    }
    let (mut file, length) = opened(path)?;
    if length <= UNKNOWN_BYTES {
        return read_all(&file, length, UNKNOWN_BYTES);
    }
    // A recording may be as large as its file.
    let mut begin = Vec::new();
    (&file).take(MAGIC.len() as u64).read_to_end(&mut begin)?;
    file.rewind()?;
    match begin == MAGIC {
        true => read_all(&file, length, u64::MAX),
        false => Err(too_long(UNKNOWN_BYTES)),
    }
}

/// The text of a file or an open pipe.
///
/// Fails for devices, folders and pipes on the disk, for more than 64 MiB, and for what is no UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let (file, length) = opened(path)?;
    let bytes = read_all(&file, length.min(TEXT_BYTES), TEXT_BYTES)?;
    String::from_utf8(bytes).map_err(|_| Error::new(ErrorKind::InvalidData, "it is not UTF-8 text"))
}

/// The file or the open pipe, and how long it says it is.
fn opened(path: &Path) -> Result<(File, u64)> {
    let file = regular::open_or_pipe(path)?;
    let length = file.metadata()?.len();
    Ok((file, length))
}

/// All of it, for which so much is kept at first.
fn read_all(from: impl Read, expected: u64, limit: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let expected = usize::try_from(expected).unwrap_or(usize::MAX);
    bytes
        .try_reserve_exact(expected)
        .map_err(|_| Error::new(ErrorKind::OutOfMemory, "there is not enough memory for it"))?;
    from.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_long(limit));
    }
    Ok(bytes)
}

fn too_long(limit: u64) -> Error {
    let said = format!(
        "it is longer than {} MiB, expected a recording (MCAP) as a file, or less",
        limit >> 20
    );
    Error::new(ErrorKind::InvalidData, said)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What never ends.
    struct Zeros;

    impl Read for Zeros {
        fn read(&mut self, into: &mut [u8]) -> Result<usize> {
            into.fill(0);
            Ok(into.len())
        }
    }

    #[test]
    fn what_has_no_end_is_refused_and_what_is_at_the_limit_is_read() {
        let error = read_all(Zeros, 0, 1 << 20).expect_err("no end").to_string();
        assert!(error.contains("longer than 1 MiB"), "{error}");
        assert_eq!(read_all(&[7; 16][..], 3, 16).expect("read"), [7; 16]);
        read_all(&[7; 17][..], 17, 16).expect_err("one more");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused_by_what_they_are() {
        for read in [
            read_whole(Path::new("/dev/zero")).map(|_| ()),
            read_text(Path::new("/dev/zero")).map(|_| ()),
        ] {
            let error = read.expect_err("a device").to_string();
            assert!(error.contains("a device"), "{error}");
        }
    }

    #[test]
    fn a_file_is_read_whole_and_a_text_is_one() {
        let directory = tempfile::tempdir().expect("directory");
        let path = directory.path().join("file");
        std::fs::write(&path, b"caf\xe9").expect("write");
        assert_eq!(read_whole(&path).expect("read"), b"caf\xe9");
        let error = read_text(&path).expect_err("no UTF-8").to_string();
        assert!(error.contains("not UTF-8"), "{error}");
        std::fs::write(&path, "café").expect("write");
        assert_eq!(read_text(&path).expect("read"), "café");
    }

    /// It has no bytes on the disk, and would take all memory.
    #[test]
    fn a_file_that_is_too_long_for_what_it_is_is_not_read() {
        let directory = tempfile::tempdir().expect("directory");
        let path = directory.path().join("sparse.csv");
        let file = File::create(&path).expect("create");
        file.set_len(TEXT_BYTES + 1).expect("a hole");
        let error = read_text(&path).expect_err("too long").to_string();
        assert!(error.contains("longer than 64 MiB"), "{error}");
    }
}
