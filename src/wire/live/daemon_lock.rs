//! One daemon per iceoryx2: two would both obey one command, and both record.
//!
//! The lock is on a file beside iceoryx2's own; it goes with the process, however that ends. What is
//! in the file says who holds it.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::error::{DaemonProcess, LiveError};
use super::node::{Node, config, place};

/// Attempts, and the pause between them: who only looks holds the lock for a moment.
const ATTEMPTS: usize = 5;
const PAUSE: Duration = Duration::from_millis(20);

/// Held for as long as a daemon runs.
#[derive(Debug)]
pub struct DaemonLock {
    _file: File,
}

impl DaemonLock {
    /// Fails with [`LiveError::Taken`] where a daemon runs on this iceoryx2.
    pub fn take(node: &Node, scene: &Path) -> Result<Self, LiveError> {
        let (path, error) = of_place(node.place());
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(&error)?;
        for attempt in 1.. {
            match file.try_lock() {
                Ok(()) => break,
                Err(TryLockError::WouldBlock) if attempt < ATTEMPTS => std::thread::sleep(PAUSE),
                Err(TryLockError::WouldBlock) => {
                    let daemon = read(&mut file);
                    return Err(LiveError::Taken { daemon });
                }
                Err(TryLockError::Error(reason)) => return Err(error(reason)),
            }
        }
        let daemon = DaemonProcess {
            process: std::process::id(),
            scene: scene.display().to_string(),
        };
        let text = serde_json::to_vec(&daemon).map_err(|reason| error(reason.into()))?;
        file.set_len(0).map_err(&error)?;
        file.rewind().map_err(&error)?;
        file.write_all(&text).map_err(&error)?;
        Ok(Self { _file: file })
    }
}

/// The daemon that runs on this iceoryx2, if one does; unknown fields are empty where it does not
/// say who it is.
pub fn running_daemon(config_file: Option<&Path>) -> Result<Option<DaemonProcess>, LiveError> {
    let (path, error) = of_place(place(&config(config_file)?));
    let mut file = match File::open(&path) {
        Ok(file) => file,
        Err(missing) if missing.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(reason) => return Err(error(reason)),
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(None),
        Err(TryLockError::WouldBlock) => Ok(Some(read(&mut file).unwrap_or(DaemonProcess {
            process: 0,
            scene: String::new(),
        }))),
        Err(TryLockError::Error(reason)) => Err(error(reason)),
    }
}

fn of_place((root, prefix): (PathBuf, String)) -> (PathBuf, impl Fn(std::io::Error) -> LiveError) {
    let path = root.join(format!("{prefix}enact_capture.lock"));
    let root = root.display().to_string();
    let error = move |reason: std::io::Error| LiveError::Node {
        root: root.clone(),
        reason: format!("the daemon's lock: {reason}"),
    };
    (path, error)
}

fn read(file: &mut File) -> Option<DaemonProcess> {
    let mut text = String::new();
    file.rewind().ok()?;
    file.take(1 << 16).read_to_string(&mut text).ok()?;
    serde_json::from_str(&text).ok()
}
