//! Which page is the tracker of which stream.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::ingest::live::Token;

/// For so long after a page has left, what came last on its stream may have been its own: a stream counts as sent on
/// for a second, and is looked at five times a second.
const OWN_LAST: Duration = Duration::from_millis(1500);

/// Who has a stream, or had it last.
#[derive(Clone, Copy, Debug)]
struct Claim {
    key: Token,
    session: u32,
    /// When its connection ended.
    left: Option<Instant>,
}

impl Claim {
    fn is_held(&self) -> bool {
        self.left.is_none()
    }

    /// Whether what is still seen of the stream may have come from the page that had it.
    fn has_just_left(&self, now: Instant) -> bool {
        let left = self.left;
        left.is_some_and(|left| now.saturating_duration_since(left) < OWN_LAST)
    }
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
    /// Fails, in words, where another page has it, or `is_sent` says that somebody sends on it, unless that was a page that
    /// has just left.
    pub(super) fn take(
        &self,
        stream: usize,
        key: Token,
        session: u32,
        is_sent: bool,
        now: Instant,
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
        if !is_own && claim.is_some_and(|of| of.is_held()) {
            return Err("another page acts with this tracker".to_owned());
        }
        let has_just_left = claim.is_some_and(|of| of.has_just_left(now));
        if !is_own && is_sent && !has_just_left {
            return Err("a tracker sends there already".to_owned());
        }
        *claim = Some(Claim {
            key,
            session,
            left: None,
        });
        Ok(())
    }

    /// Whether a connection has a stream.
    pub(super) fn has(&self, stream: usize, session: u32) -> bool {
        let claims = self.0.lock();
        let claim = claims.ok().and_then(|claims| *claims.get(stream)?);
        claim.is_some_and(|of| of.is_held() && of.session == session)
    }

    /// A connection has ended.
    pub(super) fn leave(&self, session: u32, now: Instant) {
        if let Ok(mut claims) = self.0.lock() {
            for claim in claims.iter_mut().flatten() {
                if claim.session == session {
                    claim.left.get_or_insert(now);
                }
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
        let mut now = Instant::now();
        assert!(claims.take(2, ours, 1, false, now).is_err());
        // A real tracker is not disturbed.
        assert!(claims.take(0, ours, 1, true, now).is_err() && !claims.has(0, 1));
        assert!(claims.take(0, ours, 1, false, now).is_ok());
        assert!(claims.has(0, 1) && !claims.has(1, 1));
        assert!(claims.take(0, theirs, 2, false, now).is_err());
        // Its own readings are still coming in when it is back; the earlier connection has it no more.
        assert!(claims.take(0, ours, 3, true, now).is_ok());
        assert!(claims.has(0, 3) && !claims.has(0, 1));
        claims.leave(1, now);
        assert!(claims.has(0, 3));
        claims.leave(3, now);
        assert!(!claims.has(0, 3));
        // What still comes after a while is a real tracker's.
        now += OWN_LAST;
        assert!(claims.take(0, theirs, 4, true, now).is_err());
        assert!(claims.take(0, theirs, 4, false, now).is_ok());
    }

    #[test]
    fn a_page_that_has_just_left_is_no_other_tracker() {
        let [ours, theirs] = [Token::make(), Token::make()].map(|key| key.expect("random"));
        let claims = Claims::new(1);
        let now = Instant::now();
        assert!(claims.take(0, ours, 1, false, now).is_ok());
        assert!(claims.take(0, theirs, 2, true, now).is_err());
        claims.leave(1, now);
        assert!(claims.take(0, theirs, 2, true, now + OWN_LAST / 2).is_ok());
        assert!(claims.has(0, 2));
    }
}
