//! Inputs are never changed: what a command reads is not what it writes.

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

use anyhow::bail;

use crate::ingest::is_pipe;
use crate::write::atomic::target_of;

/// Device and number of a file: one file may have several names.
type FileId = (u64, u64);

/// The files that a command reads, of which it writes none.
#[derive(Debug, Default)]
pub(super) struct Inputs {
    by_name: BTreeMap<PathBuf, PathBuf>,
    by_place: BTreeMap<PathBuf, PathBuf>,
    by_id: BTreeMap<FileId, PathBuf>,
}

impl Inputs {
    /// All of them, whether they are there or not; `-` is the file to which stdin is connected.
    pub(super) fn of<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Self {
        let mut inputs = Self::default();
        for path in paths {
            inputs.add(path);
        }
        inputs
    }

    fn add(&mut self, path: &Path) {
        let shown = path.to_owned();
        let found = match is_pipe(path) {
            true => stdin_metadata(),
            false => {
                self.by_name.insert(shown.clone(), shown.clone());
                if let Ok(place) = path.canonicalize() {
                    self.by_place.insert(place, shown.clone());
                }
                std::fs::metadata(path).ok()
            }
        };
        if let Some(id) = found.as_ref().and_then(file_id) {
            self.by_id.insert(id, shown);
        }
    }

    /// Refuses an output that is one of them, by whatever name or link, or that is no regular file; before the work is
    /// done.
    pub(super) fn keep_from(&self, output: &Path) -> anyhow::Result<()> {
        target_of(output)?;
        if is_pipe(output) {
            return Ok(());
        }
        let place = output.canonicalize().ok();
        let id = std::fs::metadata(output).ok().as_ref().and_then(file_id);
        let of_place = place.and_then(|place| self.by_place.get(&place));
        let of_id = id.and_then(|id| self.by_id.get(&id));
        let Some(input) = self.by_name.get(output).or(of_place).or(of_id) else {
            return Ok(());
        };
        let output = output.display();
        let what = match is_pipe(input) {
            true => "stdin is read from it".to_owned(),
            false if input.as_os_str() == output.to_string().as_str() => {
                "the command reads it".to_owned()
            }
            false => format!("the command reads it as {}", input.display()),
        };
        bail!("{output}: the output would replace an input, {what}; expected another name: -o FILE")
    }
}

#[cfg(unix)]
fn file_id(found: &Metadata) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt;
    found.is_file().then(|| (found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn file_id(_: &Metadata) -> Option<FileId> {
    None
}

#[cfg(unix)]
fn stdin_metadata() -> Option<Metadata> {
    use std::os::fd::AsFd;
    let stdin = std::io::stdin();
    let own = stdin.as_fd().try_clone_to_owned().ok()?;
    std::fs::File::from(own).metadata().ok()
}

#[cfg(not(unix))]
fn stdin_metadata() -> Option<Metadata> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_of_an_input_is_an_output() {
        let directory = tempfile::tempdir().expect("directory");
        let inside = |name: &str| directory.path().join(name);
        std::fs::write(inside("scene.toml"), b"scene").expect("write");
        let scene = inside("scene.toml");
        let missing = inside("missing.mcap");
        let inputs = Inputs::of([scene.as_path(), missing.as_path()]);
        let mut names = vec![
            scene.clone(),
            missing.clone(),
            directory.path().join(".").join("scene.toml"),
        ];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&scene, inside("link")).expect("link");
            std::fs::hard_link(&scene, inside("hard")).expect("hard link");
            std::os::unix::fs::symlink(directory.path(), inside("folder")).expect("link");
            names.extend([inside("link"), inside("hard"), inside("folder/scene.toml")]);
        }
        for name in names {
            let error = inputs.keep_from(&name).expect_err("an input").to_string();
            assert!(error.contains("would replace an input"), "{error}");
        }
        inputs.keep_from(&inside("other")).expect("no input");
        inputs.keep_from(Path::new("-")).expect("stdout");
    }
}
