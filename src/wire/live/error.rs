//! Errors of iceoryx2.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A daemon that runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DaemonProcess {
    /// Its process id.
    pub process: u32,
    /// Its scene file.
    pub scene: String,
}

/// Why a live operation failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LiveError {
    /// The configuration file of iceoryx2 cannot be used.
    #[error("{}: no configuration of iceoryx2: {reason}", path.display())]
    Config {
        /// The file.
        path: PathBuf,
        /// What iceoryx2 says.
        reason: String,
    },
    /// iceoryx2 cannot be joined.
    #[error("cannot join iceoryx2 below {root}: {reason}")]
    Node {
        /// Folder of its files.
        root: String,
        /// What iceoryx2 says.
        reason: String,
    },
    /// Another daemon runs on the same services.
    #[error("another capture runs on these services: {}; stop it, or give one of them an iceoryx2 of its own (--iceoryx2)", named(daemon.as_ref()))]
    Taken {
        /// Which, if it says so.
        daemon: Option<DaemonProcess>,
    },
    /// The daemon's token cannot be read: only its user may direct it.
    #[error("{}: the daemon's token cannot be read: {reason}; who runs the daemon may direct it, or whom they give a copy (--token FILE)", path.display())]
    Token {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A topic gives no valid name of a service.
    #[error("{name:?} is no name of a service: {reason}")]
    Name {
        /// The refused name.
        name: String,
        /// What iceoryx2 says.
        reason: String,
    },
    /// A service can neither be made nor opened: it has another payload, or rights are lacking.
    #[error("service {service}: {reason}; `enact doctor` says more")]
    Service {
        /// Its name.
        service: String,
        /// What iceoryx2 says.
        reason: String,
    },
    /// A service has no room for one more publisher or subscriber.
    #[error("service {service}: no port: {reason}")]
    Port {
        /// Its name.
        service: String,
        /// What iceoryx2 says.
        reason: String,
    },
    /// A sample was not sent.
    #[error("service {service}: not sent: {reason}")]
    Send {
        /// Its name.
        service: String,
        /// What iceoryx2 says.
        reason: String,
    },
    /// Receiving failed.
    #[error("service {service}: cannot receive: {reason}")]
    Receive {
        /// Its name.
        service: String,
        /// What iceoryx2 says.
        reason: String,
    },
}

fn named(daemon: Option<&DaemonProcess>) -> String {
    daemon.map_or("it does not say which".to_owned(), |daemon| {
        format!("process {}, scene {:?}", daemon.process, daemon.scene)
    })
}
