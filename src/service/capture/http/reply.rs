//! What is answered by HTTP.

use std::sync::Arc;

/// What a browser may do with the page: nothing but what is in it, and talk to this server.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What it may do with the acting page: the same, and draw what it was sent.
pub(super) const ACTING_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                             connect-src 'self' blob:; img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; \
                             frame-ancestors 'none'";

/// What it may do with a picture: show it.
pub(super) const PICTURE_POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'";

/// The reply to a request.
pub(super) struct Reply {
    pub(super) status: &'static str,
    pub(super) kind: &'static str,
    pub(super) policy: &'static str,
    pub(super) body: Arc<[u8]>,
}

impl Reply {
    pub(super) fn text(status: &'static str, body: String) -> Self {
        Self {
            status,
            ..Self::ok(
                "text/plain; version=0.0.4; charset=utf-8",
                body.into_bytes(),
            )
        }
    }

    pub(super) fn ok(kind: &'static str, body: impl Into<Arc<[u8]>>) -> Self {
        Self {
            status: "200 OK",
            kind,
            policy: POLICY,
            body: body.into(),
        }
    }
}

/// A reply that says its status alone.
pub(super) fn refusal(status: &'static str) -> Reply {
    Reply::text(status, format!("{status}\n"))
}

/// The value of a header; `?` where it is there twice or is no text, which is nobody's name.
pub(super) fn the_header<'a>(headers: &[httparse::Header<'a>], name: &str) -> Option<&'a str> {
    let mut found = headers
        .iter()
        .filter(|header| header.name.eq_ignore_ascii_case(name));
    let first = found.next()?;
    match found.next() {
        None => Some(std::str::from_utf8(first.value).unwrap_or("?")),
        Some(_) => Some("?"),
    }
}
