//! One daemon per iceoryx2: two would both obey one command, and both record.
//!
//! The lock is on a file beside iceoryx2's own; it goes with the process, however that ends. What is
//! in the file says who holds it. The daemon's token is beside it, in a file that only its user can read.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::super::regular;
use super::error::{DaemonProcess, LiveError};
use super::node::{IpcFiles, Node, config, place};
use super::token::Token;

/// Attempts, and the pause between them: who only looks holds the lock for a moment.
const ATTEMPTS: usize = 5;
const PAUSE: Duration = Duration::from_millis(20);

/// What the file of the token ends with, where that of the lock ends with `lock`.
const TOKEN_ENDING: &str = "token";

/// Held for as long as a daemon runs.
#[derive(Debug)]
pub struct DaemonLock {
    _file: File,
    token: Token,
    token_file: PathBuf,
}

impl DaemonLock {
    /// Makes the token of this daemon, too. Fails with [`LiveError::Taken`] where a daemon runs on this iceoryx2.
    pub fn take(node: &Node, scene: &Path) -> Result<Self, LiveError> {
        let (path, error) = of_place(&node.place());
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
        let token_file = path.with_extension(TOKEN_ENDING);
        let token = Token::make().map_err(&error)?;
        token
            .write(&token_file)
            .map_err(|reason| LiveError::Token {
                path: token_file.clone(),
                reason: reason.to_string(),
            })?;
        Ok(Self {
            _file: file,
            token,
            token_file,
        })
    }

    /// What who directs this daemon must know.
    pub fn token(&self) -> Token {
        self.token
    }
}

impl Drop for DaemonLock {
    /// The token is worth nothing any more.
    fn drop(&mut self) {
        // One that stays is replaced by the next daemon.
        let _ = std::fs::remove_file(&self.token_file);
    }
}

/// The token of the daemon on this iceoryx2; `None` where there is none on this machine. Fails where it is not
/// this user's.
pub fn token_of_daemon(config_file: Option<&Path>) -> Result<Option<Token>, LiveError> {
    let (path, _) = of_place(&place(&config(config_file)?));
    let path = path.with_extension(TOKEN_ENDING);
    match Token::read(&path) {
        Ok(token) => Ok(Some(token)),
        Err(missing) if missing.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(reason) => Err(LiveError::Token {
            path,
            reason: reason.to_string(),
        }),
    }
}

/// The daemon that runs on this iceoryx2, if one does; unknown fields are empty where it does not
/// say who it is.
pub fn running_daemon(config_file: Option<&Path>) -> Result<Option<DaemonProcess>, LiveError> {
    let (path, error) = of_place(&place(&config(config_file)?));
    let mut file = match regular::open(&path) {
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

fn of_place(place: &IpcFiles) -> (PathBuf, impl Fn(std::io::Error) -> LiveError + use<>) {
    let path = place
        .root
        .join(format!("{}enact_capture.lock", place.prefix));
    let root = place.root.display().to_string();
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
