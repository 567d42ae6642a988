//! A folder for files that a target makes, emptied for each input.

use std::path::{Path, PathBuf};

/// A file with these bytes, alone in a folder of this process.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    thread_local! {
        static FOLDER: tempfile::TempDir = {
            // In memory, where there is such a place: files are synced.
            let memory = Path::new("/dev/shm");
            if memory.is_dir() {
                tempfile::tempdir_in(memory).expect("folder")
            } else {
                tempfile::tempdir().expect("folder")
            }
        };
    }
    FOLDER.with(|folder| {
        for entry in std::fs::read_dir(folder.path()).expect("list") {
            std::fs::remove_file(entry.expect("an entry").path()).expect("remove");
        }
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("write");
        path
    })
}
