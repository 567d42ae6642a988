//! The certificate with which other devices are served by HTTPS. Browsers give trackers to pages of the machine itself and
//! to HTTPS alone; nobody signs for a machine in a studio, so that it signs itself, once: who has looked at its
//! fingerprint knows it again.

use std::io::{ErrorKind, Write};
use std::net::{IpAddr, Ipv4Addr, UdpSocket};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, anyhow};
use tempfile::NamedTempFile;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};

use crate::ingest::read_text;
use crate::service::provenance::sha256;

/// The file of certificate and key.
const NAME: &str = "acting.pem";

/// What the server is known by.
pub(super) struct Certificate {
    pub(super) acceptor: TlsAcceptor,
    /// SHA-256 of the certificate, as browsers show it: bytes in hexadecimal, with colons.
    pub(super) fingerprint: String,
}

impl Certificate {
    /// The one that is kept among the user's data; made where there is none. Fails where it cannot be written or read.
    pub(super) fn kept() -> anyhow::Result<Self> {
        Self::kept_in(&folder().context("no folder for the certificate: set HOME")?)
    }

    fn kept_in(folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(NAME);
        if !path.exists() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
            make(&path).with_context(|| format!("{}: cannot make it", path.display()))?;
        }
        let pem = read_text(&path).with_context(|| path.display().to_string())?;
        Self::of(pem.as_bytes()).with_context(|| {
            format!(
                "{}: no certificate with its key, expected what was made at the first start: move it away, then \
                 another is made",
                path.display()
            )
        })
    }

    fn of(pem: &[u8]) -> anyhow::Result<Self> {
        let wrong = |error| anyhow!("{error}");
        let certificate = CertificateDer::from_pem_slice(pem).map_err(wrong)?;
        let key = PrivateKeyDer::from_pem_slice(pem).map_err(wrong)?;
        let digest = sha256(&certificate).to_ascii_uppercase();
        let bytes = digest.as_bytes().chunks(2).map(String::from_utf8_lossy);
        let fingerprint = bytes.collect::<Vec<_>>().join(":");
        let mut config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
            .with_safe_default_protocol_versions()?
            .with_no_client_auth()
            .with_single_cert(vec![certificate], key)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self {
            acceptor: TlsAcceptor::from(Arc::new(config)),
            fingerprint,
        })
    }
}

/// Writes a new one, for the user's eyes alone; leaves one alone that somebody else wrote meanwhile.
fn make(path: &Path) -> anyhow::Result<()> {
    let names = vec!["localhost".to_owned(), own_address().to_string()];
    let made = rcgen::generate_simple_self_signed(names)?;
    let text = format!("{}{}", made.cert.pem(), made.signing_key.serialize_pem());
    // Whole or not at all, and readable by the user alone where files have modes.
    let mut file = NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")))?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    match file.persist_noclobber(path) {
        Err(error) if error.error.kind() != ErrorKind::AlreadyExists => Err(error.error.into()),
        _ => Ok(()),
    }
}

/// The folder of the user's data for this program.
fn folder() -> Option<PathBuf> {
    let of = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let data = of("XDG_DATA_HOME").filter(|path| path.is_absolute());
    let data = data.or_else(|| Some(of("HOME")?.join(".local/share")))?;
    Some(data.join("enact"))
}

/// The address of this machine by which its network knows it: that from which it would send to another network.
pub(super) fn own_address() -> IpAddr {
    // A block for documents (RFC 5737); nothing is sent.
    let other = (Ipv4Addr::new(192, 0, 2, 1), 9);
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0));
    let address = socket.and_then(|socket| {
        socket.connect(other)?;
        socket.local_addr()
    });
    address.map_or(Ipv4Addr::LOCALHOST.into(), |address| address.ip())
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn it_is_made_once_and_for_the_user_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path().join("not there yet");
        let first = Certificate::kept_in(&folder).expect("one is made");
        let again = Certificate::kept_in(&folder).expect("it is read");
        assert_eq!(first.fingerprint, again.fingerprint);
        assert_eq!(first.fingerprint.len(), 32 * 3 - 1);
        let kept = folder.join(NAME).metadata().expect("a file");
        assert_eq!(kept.permissions().mode() & 0o777, 0o600);
        let other = tempfile::tempdir().expect("a folder");
        let other = Certificate::kept_in(other.path()).expect("one is made");
        assert_ne!(first.fingerprint, other.fingerprint);
    }

    #[test]
    fn one_that_is_damaged_is_left_and_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(NAME);
        std::fs::write(&path, "-----BEGIN CERTIFICATE-----\nxx").expect("write");
        let said = Certificate::kept_in(folder.path()).err().expect("refused");
        assert!(said.to_string().contains("move it away"), "{said}");
        let left = std::fs::read_to_string(&path).expect("read");
        assert_eq!(left, "-----BEGIN CERTIFICATE-----\nxx");
    }
}
