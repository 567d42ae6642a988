//! Errors of iceoryx2.

use std::path::PathBuf;

use thiserror::Error;

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
