//! Files that are whole or not there.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use super::error::WriteError;
use super::unfinished::Unfinished;
use crate::wire::is_pipe;

/// A mebibyte: the MCAP writer makes many small writes.
const BUFFER_BYTES: usize = 1 << 20;

/// A file under a temporary name in the directory of its final one. [`AtomicFile::commit`]
/// makes it durable and gives it its name; dropping it removes it. What goes to
/// [stdout](is_pipe) goes there whole, at the end.
#[derive(Debug)]
pub struct AtomicFile {
    /// As it was given.
    path: PathBuf,
    /// Where that leads: another path if it is a link.
    target: PathBuf,
    /// Whether it takes the place of a file that has its name.
    replaces: bool,
    writer: BufWriter<NamedTempFile>,
    unfinished: Unfinished,
}

impl AtomicFile {
    /// Opens a temporary beside `path`, or beside the file that it links to; it will replace the
    /// file that has that name. Fails where the directory does not exist or may not be written,
    /// and where [`target_of`] does.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        Self::create_of(path, &[])
    }

    /// [`AtomicFile::create`] of what is made of other files: nobody may read it who may not read one of these. A file
    /// that is replaced keeps who may read it.
    pub fn create_of(path: &Path, made_of: &[&Path]) -> Result<Self, WriteError> {
        let target = target_of(path)?;
        let mode = mode_of(&target, made_of);
        let file = Self::open(path, target, builder(), true, mode.at_first)?;
        file.allow(mode.in_the_end)?;
        Ok(file)
    }

    /// [`AtomicFile::create`] of a file that will replace none: [`AtomicFile::commit`] fails where
    /// the name is taken by then by anything but a file of the same bytes.
    pub fn create_fresh(path: &Path) -> Result<Self, WriteError> {
        Self::create_fresh_of(path, &[])
    }

    /// [`AtomicFile::create_fresh`] of what is made of other files, as [`AtomicFile::create_of`].
    pub fn create_fresh_of(path: &Path, made_of: &[&Path]) -> Result<Self, WriteError> {
        let mode = ORDINARY & least_of(made_of);
        Self::open(path, path.to_owned(), builder(), false, mode)
    }

    /// [`AtomicFile::create_fresh`] with a temporary of the same name each time, so that one that a
    /// killed process left is removed; the caller makes sure that no other process writes it. Nobody may read it who may
    /// not read what it is made of.
    pub(super) fn create_new(path: &Path, made_of: &Path) -> Result<Self, WriteError> {
        let mut name = OsString::from(".");
        name.push(path.file_name().unwrap_or_default());
        name.push(".writing");
        match std::fs::remove_file(path.with_file_name(&name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(WriteError::io(
                    path,
                    "remove an old temporary file beside it",
                )(error));
            }
            _ => {}
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(&name).rand_bytes(0);
        let mode = ORDINARY & least_of(&[made_of]);
        Self::open(path, path.to_owned(), builder, false, mode)
    }

    fn open(
        path: &Path,
        target: PathBuf,
        mut builder: tempfile::Builder,
        replaces: bool,
        mode: u32,
    ) -> Result<Self, WriteError> {
        let elsewhere = std::env::temp_dir();
        let directory = match is_pipe(path) {
            true => &elsewhere,
            false => directory_of(&target),
        };
        // Temporaries are private by default; this one becomes an ordinary file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
        #[cfg(not(unix))]
        let _ = (mode, &mut builder);
        let (temporary, unfinished) = Unfinished::create(&builder, directory)
            .map_err(WriteError::io(path, "create a temporary file beside it"))?;
        Ok(Self {
            path: path.to_owned(),
            target,
            replaces,
            writer: BufWriter::with_capacity(BUFFER_BYTES, temporary),
            unfinished,
        })
    }

    /// Lets those read it that may read what it replaces, whatever is usual.
    #[cfg(unix)]
    fn allow(&self, mode: Option<u32>) -> Result<(), WriteError> {
        let Some(mode) = mode else {
            return Ok(());
        };
        let permissions = std::os::unix::fs::PermissionsExt::from_mode(mode);
        let file = self.writer.get_ref().as_file();
        file.set_permissions(permissions)
            .map_err(WriteError::io(&self.path, "set who may read it"))
    }

    /// Nothing is known of who may read it here.
    #[cfg(not(unix))]
    fn allow(&self, _: Option<u32>) -> Result<(), WriteError> {
        Ok(())
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
        let Self {
            path,
            target,
            replaces,
            writer,
            unfinished,
        } = self;
        let mut temporary = writer
            .into_inner()
            .map_err(|error| WriteError::io(&path, "write")(error.into_error()))?;
        if is_pipe(&path) {
            return pass_on(&mut temporary).map_err(WriteError::io(&path, "write to stdout"));
        }
        let renamed = if replaces {
            temporary.persist(&target)
        } else {
            temporary.persist_noclobber(&target)
        };
        match renamed {
            Err(error) if !replaces && error.error.kind() == io::ErrorKind::AlreadyExists => {
                if !are_same(error.file.path(), &target) {
                    return Err(WriteError::Exists { path });
                }
            }
            Err(error) => {
                return Err(WriteError::io(&path, "rename the temporary file to it")(
                    error.error,
                ));
            }
            Ok(_) => {}
        }
        drop(unfinished);
        sync_directory_of(&target);
        Ok(())
    }
}

/// Who may read and write an ordinary file, but for what the system takes away.
const ORDINARY: u32 = 0o666;

/// Who may read a new file.
struct Mode {
    /// While it is written; the system takes some away.
    at_first: u32,
    /// Then; none: as it is.
    in_the_end: Option<u32>,
}

/// Who may read a file that takes the place of another, if one is there, and is made of others.
fn mode_of(target: &Path, made_of: &[&Path]) -> Mode {
    let least = least_of(made_of);
    match permissions_of(target) {
        Some(replaced) => Mode {
            at_first: replaced & least & 0o600,
            in_the_end: Some(replaced & least),
        },
        None => Mode {
            at_first: ORDINARY & least,
            in_the_end: None,
        },
    }
}

/// What all of these files allow; what is no file forbids nothing, and its owner may always.
fn least_of(files: &[&Path]) -> u32 {
    let permissions = files.iter().filter_map(|file| permissions_of(file));
    permissions.fold(0o777, |least, of| least & (of | 0o600))
}

#[cfg(unix)]
fn permissions_of(path: &Path) -> Option<u32> {
    use std::os::unix::fs::PermissionsExt;
    let found = std::fs::metadata(path).ok()?;
    found.is_file().then(|| found.permissions().mode() & 0o777)
}

#[cfg(not(unix))]
fn permissions_of(_: &Path) -> Option<u32> {
    None
}

/// Temporaries with names that nobody else has.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".enact-").suffix(".part");
    builder
}

/// Copies a file to stdout. A reader that has closed the pipe wants no more.
fn pass_on(file: &mut NamedTempFile) -> io::Result<()> {
    file.rewind()?;
    let mut stdout = io::stdout().lock();
    let copied = io::copy(file, &mut stdout).and_then(|_| stdout.flush());
    match copied {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
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

/// Where an output of that name is put: there, or where it leads if it is a link to a file.
///
/// Fails where something has the name that is no file: a rename would put a file in the place of
/// a device, a pipe or a folder. A link that leads nowhere is refused too, for nobody can mean it.
pub fn target_of(path: &Path) -> Result<PathBuf, WriteError> {
    if is_pipe(path) {
        return Ok(path.to_owned());
    }
    let Ok(found) = std::fs::symlink_metadata(path) else {
        return Ok(path.to_owned());
    };
    if found.is_file() {
        return Ok(path.to_owned());
    }
    let refused = |what| WriteError::NotAFile {
        path: path.to_owned(),
        what,
    };
    let followed = std::fs::metadata(path).map_err(|_| refused("a link that leads nowhere"))?;
    if followed.is_dir() {
        return Err(refused("a folder"));
    }
    if !followed.is_file() {
        return Err(refused("a device, a pipe or a socket"));
    }
    std::fs::canonicalize(path).map_err(WriteError::io(path, "follow the link"))
}

/// Makes a new name durable: it is only once its directory is. Some file systems have no such
/// call for directories, and the data are safe without it.
pub(super) fn sync_directory_of(path: &Path) {
    if let Ok(directory) = File::open(directory_of(path)) {
        let _ = directory.sync_all();
    }
}

/// Gives a file another name that nothing else has; fails where one has it. File systems without
/// such a call give it both names for a moment; where a killed process left both, the first goes.
pub(super) fn rename_to_new(from: &Path, to: &Path) -> Result<(), WriteError> {
    let mut file = TempPath::try_from_path(from).map_err(WriteError::io(from, "find"))?;
    // Whatever happens, it is not removed.
    file.disable_cleanup(true);
    if let Err(error) = file.persist_noclobber(to) {
        if error.error.kind() != io::ErrorKind::AlreadyExists {
            return Err(WriteError::io(from, "rename")(error.error));
        }
        if !is_one_file(from, to) {
            let path = to.to_owned();
            return Err(WriteError::Exists { path });
        }
        std::fs::remove_file(from).map_err(WriteError::io(from, "remove the other name of it"))?;
    }
    sync_directory_of(to);
    Ok(())
}

/// Whether both names are those of one file: what one of them is removed from stays.
#[cfg(unix)]
pub(super) fn is_one_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let file = |path: &Path| {
        let found = std::fs::symlink_metadata(path).ok()?;
        found.is_file().then(|| (found.dev(), found.ino()))
    };
    file(a).is_some_and(|a| Some(a) == file(b))
}

/// Whether both names are those of one file: not known here.
#[cfg(not(unix))]
pub(super) fn is_one_file(_: &Path, _: &Path) -> bool {
    false
}

/// Whether both are files of the same bytes.
fn are_same(a: &Path, b: &Path) -> bool {
    let file = |path: &Path| {
        let found = std::fs::symlink_metadata(path).ok()?;
        found.is_file().then_some(found.len())
    };
    let have_one_length = file(a).is_some() && file(a) == file(b);
    have_one_length
        && match (std::fs::read(a), std::fs::read(b)) {
            (Ok(a), Ok(b)) => a == b,
            _ => false,
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
    fn a_fresh_file_leaves_one_that_came_meanwhile() {
        let directory = tempfile::tempdir().expect("directory");
        let path = directory.path().join("out.bin");
        for (theirs, is_refused) in [(&b"theirs"[..], true), (b"ours", false)] {
            let mut file = AtomicFile::create_fresh(&path).expect("create");
            file.write_all(b"ours").expect("write");
            std::fs::write(&path, theirs).expect("another file");
            let refused = matches!(file.commit(), Err(WriteError::Exists { .. }));
            assert_eq!(refused, is_refused);
            assert_eq!(std::fs::read(&path).expect("read"), theirs);
            assert_eq!(names(directory.path()), ["out.bin"]);
        }
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
    fn what_is_no_file_is_refused_and_left_as_it_is() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let directory = tempfile::tempdir().expect("directory");
        let inside = |name: &str| directory.path().join(name);
        let socket = std::os::unix::net::UnixListener::bind(inside("socket")).expect("socket");
        std::fs::create_dir(inside("folder")).expect("folder");
        symlink(inside("socket"), inside("to_socket")).expect("link");
        symlink("/dev/null", inside("to_device")).expect("link");
        symlink(inside("nothing"), inside("to_nothing")).expect("link");
        let names_before = names(directory.path());
        for (path, what) in [
            (Path::new("/dev/null"), "a device, a pipe or a socket"),
            (&inside("socket"), "a device, a pipe or a socket"),
            (&inside("to_socket"), "a device, a pipe or a socket"),
            (&inside("to_device"), "a device, a pipe or a socket"),
            (&inside("folder"), "a folder"),
            (&inside("to_nothing"), "a link that leads nowhere"),
        ] {
            let error = AtomicFile::create(path).expect_err("no file").to_string();
            let expected = format!("{}: is {what}", path.display());
            assert!(error.starts_with(&expected), "{error}");
        }
        assert_eq!(names(directory.path()), names_before);
        let kind = std::fs::metadata("/dev/null").expect("there").file_type();
        assert!(kind.is_char_device());
        drop(socket);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_file_stays_one_and_the_file_is_replaced() {
        let directory = tempfile::tempdir().expect("directory");
        let elsewhere = tempfile::tempdir().expect("directory");
        let (link, file) = (directory.path().join("link"), elsewhere.path().join("file"));
        std::fs::write(&file, b"old").expect("write");
        std::os::unix::fs::symlink(&file, &link).expect("link");
        let mut output = AtomicFile::create(&link).expect("create");
        output.write_all(b"new").expect("write");
        output.commit().expect("commit");
        assert_eq!(std::fs::read(&file).expect("read"), b"new");
        assert_eq!(std::fs::read_link(&link).expect("a link"), file);
        assert_eq!(names(elsewhere.path()), ["file"]);
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
