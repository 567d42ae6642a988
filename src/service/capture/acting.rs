//! The acting page: a page in a browser that is a tracker.
//!
//! `--acting` serves it at `/act` of the HTTP port. It asks for one WebSocket, `/act/socket`, and says on it first the
//! six digits that the daemon printed ([`pairing`]). Its readings, marks and orders then go to the recorder through a
//! queue of their own, as those of other trackers and of the operator's page do ([`message`]).
//!
//! What a page may do to a take that runs is what a tracker may: nothing before it has said the code, and then as much
//! as [`stage`] allows; who sends more is sent away. One page at a time is the
//! tracker of a stream, and none of a stream on which a tracker sends already ([`claims`]). A page that answers no
//! ping is sent away, and what it was the tracker of is silent meanwhile, as any tracker.
//!
//! A page may ask for calibrations of takes, which it names by their numbers ([`calibration`]).

mod allowance;
mod calibration;
mod claims;
mod conversation;
mod device_clock;
mod greeting;
mod message;
pub(super) mod page;
pub(super) mod pairing;
mod stage;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

use super::gate::Waiting;
use conversation::PageConversation;
use message::MESSAGE_BYTES;

pub(super) use stage::{ActingParts, ActingStage};
pub(super) use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

/// A connection on which a WebSocket begins.
pub(super) struct Upgraded<S> {
    pub(super) stream: S,
    /// What came after the request.
    pub(super) rest: Vec<u8>,
    pub(super) waiting: Waiting,
}

/// Serves a page to the end of its connection.
pub(super) async fn serve<S>(stage: &ActingStage, upgraded: Upgraded<S>)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let config = WebSocketConfig::default()
        .read_buffer_size(8 << 10)
        .write_buffer_size(0)
        .max_frame_size(Some(MESSAGE_BYTES))
        .max_message_size(Some(MESSAGE_BYTES));
    let Upgraded {
        stream,
        rest,
        waiting,
    } = upgraded;
    let socket =
        WebSocketStream::from_partially_read(stream, rest, Role::Server, Some(config)).await;
    PageConversation::hold(stage, socket, waiting).await;
}
