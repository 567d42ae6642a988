//! Notifies the service manager: `sd_notify` by a datagram.

use std::os::unix::net::UnixDatagram;

/// Sends a state to the service manager that the environment names, if there is one.
pub(super) fn tell(state: &str) {
    let Some(socket) = std::env::var_os("NOTIFY_SOCKET") else {
        return;
    };
    if let Err(error) = send(socket.as_encoded_bytes(), state) {
        tracing::warn!(%error, state, "the service manager cannot be told");
    }
}

fn send(socket: &[u8], state: &str) -> std::io::Result<()> {
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::net::SocketAddr;
    let datagram = UnixDatagram::unbound()?;
    // A leading @ stands for a zero: the abstract namespace.
    let address = match socket.strip_prefix(b"@") {
        #[cfg(target_os = "linux")]
        Some(name) => <SocketAddr as std::os::linux::net::SocketAddrExt>::from_abstract_name(name)?,
        _ => SocketAddr::from_pathname(std::ffi::OsStr::from_bytes(socket))?,
    };
    datagram.send_to_addr(state.as_bytes(), &address)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_manager_hears_by_file_and_by_abstract_name() {
        use std::os::linux::net::SocketAddrExt;
        use std::os::unix::net::SocketAddr;
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("notify");
        let by_file = UnixDatagram::bind(&path).expect("bind");
        let name = format!("enact-test-{}", std::process::id());
        let address = SocketAddr::from_abstract_name(&name).expect("name");
        let by_name = UnixDatagram::bind_addr(&address).expect("bind");
        let named = format!("@{name}");
        for (manager, socket) in [
            (by_file, path.as_os_str().as_encoded_bytes()),
            (by_name, named.as_bytes()),
        ] {
            send(socket, "READY=1").expect("send");
            let mut heard = [0; 32];
            let length = manager.recv(&mut heard).expect("receive");
            assert_eq!(&heard[..length], b"READY=1");
        }
        assert!(send(b"/no/such/socket", "READY=1").is_err());
    }
}
