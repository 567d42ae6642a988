//! Files that are whole or not there.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::error::WriteError;

/// A mebibyte: the MCAP writer makes many small writes.
const BUFFER_BYTES: usize = 1 << 20;

/// A file under a temporary name in the directory of its final one. [`AtomicFile::commit`]
/// makes it durable and gives it its name, replacing what had it; dropping it removes it.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    writer: BufWriter<NamedTempFile>,
}

impl AtomicFile {
    /// Opens a temporary beside `path`. Fails where the directory does not exist or may not be
    /// written.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        let directory = directory_of(path);
        let mut builder = tempfile::Builder::new();
        builder.prefix(".enact-").suffix(".part");
        // Temporaries are private by default; this one becomes an ordinary file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder
            .tempfile_in(directory)
            .map_err(WriteError::io(path, "create a temporary file beside it"))?;
        Ok(Self {
            path: path.to_owned(),
            writer: BufWriter::with_capacity(BUFFER_BYTES, temporary),
        })
    }

    /// The final name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes what is buffered and waits until it is on the disk.
    pub fn sync(&mut self) -> Result<(), WriteError> {
        self.writer
            .flush()
            .and_then(|()| self.writer.get_ref().as_file().sync_all())
            .map_err(WriteError::io(&self.path, "write"))
    }

    /// Makes the file durable and gives it its final name.
    pub fn commit(mut self) -> Result<(), WriteError> {
        self.sync()?;
        let Self { path, writer } = self;
        let temporary = writer
            .into_inner()
            .map_err(|error| WriteError::io(&path, "write")(error.into_error()))?;
        temporary.persist(&path).map_err(|error| {
            WriteError::io(&path, "rename the temporary file to it")(error.error)
        })?;
        sync_directory_of(&path);
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.writer.seek(to)
    }

    fn stream_position(&mut self) -> io::Result<u64> {
        // Unlike a seek, this leaves the buffer be.
        self.writer.stream_position()
    }
}

/// Makes a new name durable: it is only once its directory is. Some file systems have no such
/// call for directories, and the data are safe without it.
pub(super) fn sync_directory_of(path: &Path) {
    if let Ok(directory) = File::open(directory_of(path)) {
        let _ = directory.sync_all();
    }
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(directory)
            .expect("list")
            .map(|entry| {
                entry
                    .expect("entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_name_appears_at_commit_and_replaces_what_had_it() {
        let directory = tempfile::tempdir().expect("directory");
        let path = directory.path().join("out.bin");
        std::fs::write(&path, b"old").expect("old file");
        let mut file = AtomicFile::create(&path).expect("create");
        file.write_all(b"new").expect("write");
        assert_eq!(std::fs::read(&path).expect("read"), b"old");
        file.commit().expect("commit");
        assert_eq!(std::fs::read(&path).expect("read"), b"new");
        assert_eq!(names(directory.path()), ["out.bin"]);
    }

    #[test]
    fn dropped_without_commit_nothing_is_left() {
        let directory = tempfile::tempdir().expect("directory");
        let mut file = AtomicFile::create(&directory.path().join("out.bin")).expect("create");
        file.write_all(b"half").expect("write");
        drop(file);
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn a_missing_directory_is_named() {
        let error = AtomicFile::create(Path::new("/no/such/directory/out.bin"))
            .expect_err("there is no such directory");
        let text = error.to_string();
        assert!(
            text.starts_with("/no/such/directory/out.bin: cannot create"),
            "{text}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn the_file_is_an_ordinary_one() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().expect("directory");
        let (ours, plain) = (
            directory.path().join("ours"),
            directory.path().join("plain"),
        );
        AtomicFile::create(&ours)
            .expect("create")
            .commit()
            .expect("commit");
        std::fs::write(&plain, b"").expect("plain file");
        let mode = |path: &Path| {
            std::fs::metadata(path)
                .expect("metadata")
                .permissions()
                .mode()
        };
        assert_eq!(mode(&ours), mode(&plain));
    }
}
