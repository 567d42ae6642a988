//! The one door to files that are read: nothing is opened that is not a regular file.
//!
//! A pipe by name would be waited for, for good where nobody writes to it; a device may never end.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// Opens a file for reading; links are followed. Fails, at once, for what is no regular file.
pub fn open(path: &Path) -> io::Result<File> {
    open_with(OpenOptions::new().read(true), path)
}

/// Opens a file with these options, which must not make one. Fails, at once, for what is no regular file.
pub fn open_with(options: &OpenOptions, path: &Path) -> io::Result<File> {
    check(&std::fs::metadata(path)?)?;
    let file = options.open(path)?;
    // It may have been changed for another one meanwhile.
    check(&file.metadata()?)?;
    Ok(file)
}

/// The bytes of a regular file.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether there is a regular file.
pub fn is_there(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|of| of.is_file())
}

/// Opens a file for reading, or a pipe that this program was given open, as a shell gives `/dev/fd/63` for `<(...)`.
pub fn open_or_pipe(path: &Path) -> io::Result<File> {
    match is_open_pipe(path) {
        true => File::open(path),
        false => open(path),
    }
}

/// An open pipe has no path of its own; one on the disk has, and maybe nobody who writes to it.
fn is_open_pipe(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let is_pipe = std::fs::metadata(path).is_ok_and(|of| of.file_type().is_fifo());
        is_pipe && std::fs::canonicalize(path).is_err()
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

fn check(of: &Metadata) -> io::Result<()> {
    if of.is_file() {
        return Ok(());
    }
    let what = if of.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "it is a folder, expected a file",
        ));
    } else {
        "it is a pipe or a device, expected a regular file"
    };
    Err(io::Error::new(io::ErrorKind::InvalidInput, what))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_and_nothing_else_is_waited_for() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("a");
        std::fs::write(&file, "text").expect("write");
        assert_eq!(read(&file).expect("bytes"), b"text");
        assert!(is_there(&file) && !is_there(folder.path()));
        let error = open(folder.path()).expect_err("a folder");
        assert_eq!(error.kind(), io::ErrorKind::IsADirectory);
        let error = open(&folder.path().join("none")).expect_err("nothing");
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_through_links_too() {
        let folder = tempfile::tempdir().expect("folder");
        let (pipe, link) = (folder.path().join("pipe"), folder.path().join("link"));
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("mkfifo").success());
        std::os::unix::fs::symlink(&pipe, &link).expect("link");
        for path in [pipe.as_path(), &link, Path::new("/dev/zero")] {
            let error = read(path).expect_err("no file").to_string();
            assert!(error.contains("expected a regular file"), "{error}");
            assert!(!is_there(path));
        }
    }
}
