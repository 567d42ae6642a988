//! Any bytes as what a peer of the daemon says at its ports: by HTTP, as a viewer's handshake, as a viewer, and as an acting
//! page before and after its code. It is answered or left, little of it is kept, and nothing of it stays.
#![no_main]

use enact::service::capture::peers::{
    ACTING_HANDSHAKE, CODE, HANDSHAKE, HANDSHAKE_BYTES, Ports, REQUEST_BYTES, page_frame,
};
use libfuzzer_sys::fuzz_target;

thread_local! {
    static PORTS: [Ports; 2] = [Ports::new(false), Ports::new(true)];
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else {
        return;
    };
    PORTS.with(|[idle, recording]| match first % 6 {
        0 | 1 => {
            let ports = if *first == 0 { idle } else { recording };
            let met = ports.asks(bytes);
            assert!(met.sent.starts_with(b"HTTP/1.1 "), "no answer");
            assert!(met.taken <= REQUEST_BYTES, "{} bytes were taken", met.taken);
        }
        2 => {
            let met = idle.watches(bytes, &[]);
            // Who has become a viewer may say more.
            let is_viewer = met.sent.starts_with(b"HTTP/1.1 101");
            assert!(
                is_viewer || met.taken <= HANDSHAKE_BYTES,
                "{} bytes",
                met.taken
            );
            assert!(idle.is_empty(), "something of a viewer is left");
        }
        4 => {
            let met = recording.acts(ACTING_HANDSHAKE, bytes);
            assert!(met.sent.starts_with(b"HTTP/1.1 101"), "no socket");
        }
        5 => {
            // A page that was let in, and has the scene's stream.
            let code = format!(r#"{{"say":"pair","code":"{CODE}"}}"#);
            let first = page_frame(1, code.as_bytes());
            let act = page_frame(1, br#"{"say":"act","stream":0}"#);
            let met = recording.acts(ACTING_HANDSHAKE, &[&first, &act, bytes].concat());
            assert!(met.sent.starts_with(b"HTTP/1.1 101"), "no socket");
        }
        _ => {
            let met = idle.watches(HANDSHAKE, bytes);
            assert!(met.sent.starts_with(b"HTTP/1.1 101"), "not served");
            assert!(idle.is_empty(), "something of a viewer is left");
        }
    });
});
