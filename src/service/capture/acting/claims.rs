//! Which page is the tracker of which stream.

use std::sync::Mutex;

use crate::ingest::live::Token;

/// Who has a stream, or had it last.
#[derive(Clone, Copy, Debug)]
struct Claim {
    key: Token,
    session: u32,
    is_held: bool,
}

/// The streams.
#[derive(Debug)]
pub(super) struct Claims(Mutex<Vec<Option<Claim>>>);

impl Claims {
    /// Nobody has any of so many streams.
    pub(super) fn new(streams: usize) -> Self {
        Self(Mutex::new(vec![None; streams]))
    }

    /// A connection of the page with that key takes a stream, from itself where its earlier connection has it still.
    /// Fails, in words, where another page has it, or `is_sent` says that somebody else sends on it.
    pub(super) fn take(
        &self,
        stream: usize,
        key: Token,
        session: u32,
        is_sent: bool,
    ) -> Result<(), String> {
        let Ok(mut claims) = self.0.lock() else {
            return Err("no stream can be taken".to_owned());
        };
        let count = claims.len();
        let Some(claim) = claims.get_mut(stream) else {
            return Err(format!(
                "no stream {stream} in the scene, which has {count}"
            ));
        };
        let is_own = claim.is_some_and(|of| of.key.lets_in(&key.bytes()));
        if !is_own && claim.is_some_and(|of| of.is_held) {
            return Err("another page acts with this tracker".to_owned());
        }
        if !is_own && is_sent {
            return Err("a tracker sends there already".to_owned());
        }
        *claim = Some(Claim {
            key,
            session,
            is_held: true,
        });
        Ok(())
    }

    /// Whether a connection has a stream.
    pub(super) fn has(&self, stream: usize, session: u32) -> bool {
        let claims = self.0.lock();
        let claim = claims.ok().and_then(|claims| *claims.get(stream)?);
        claim.is_some_and(|of| of.is_held && of.session == session)
    }

    /// A connection has ended.
    pub(super) fn leave(&self, session: u32) {
        if let Ok(mut claims) = self.0.lock() {
            for claim in claims.iter_mut().flatten() {
                claim.is_held &= claim.session != session;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_has_one_page_and_a_page_comes_back_to_its_own() {
        let [ours, theirs] = [Token::make(), Token::make()].map(|key| key.expect("random"));
        let claims = Claims::new(2);
        assert!(claims.take(2, ours, 1, false).is_err());
        // A real tracker is not disturbed.
        assert!(claims.take(0, ours, 1, true).is_err() && !claims.has(0, 1));
        assert!(claims.take(0, ours, 1, false).is_ok());
        assert!(claims.has(0, 1) && !claims.has(1, 1));
        assert!(claims.take(0, theirs, 2, false).is_err());
        // Its own readings are still coming in when it is back; the earlier connection has it no more.
        assert!(claims.take(0, ours, 3, true).is_ok());
        assert!(claims.has(0, 3) && !claims.has(0, 1));
        claims.leave(1);
        assert!(claims.has(0, 3));
        claims.leave(3);
        assert!(!claims.has(0, 3));
        assert!(claims.take(0, theirs, 4, true).is_err());
        assert!(claims.take(0, theirs, 4, false).is_ok());
    }
}
