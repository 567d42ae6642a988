//! Which page is the tracker of which stream.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::ingest::live::Token;

/// What was seen of a stream is known so much later at most: it is looked at five times a second.
const LATE: Duration = Duration::from_millis(500);

/// Who has a stream, or had it last.
#[derive(Clone, Copy, Debug)]
struct Claim {
    key: Token,
    session: u32,
    is_held: bool,
    /// When the last reading of a page came.
    read: Option<Instant>,
}

impl Claim {
    /// Whether what was seen so long ago came from the page.
    fn has_sent(&self, seen: Duration, now: Instant) -> bool {
        let ago = |read| now.saturating_duration_since(read);
        self.read.is_some_and(|read| ago(read) <= seen + LATE)
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
    /// Fails, in words, where another page has it, or where a tracker sends: the last of it was seen so long ago, and
    /// came from no page.
    pub(super) fn take(
        &self,
        stream: usize,
        key: Token,
        session: u32,
        seen: Option<Duration>,
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
        if !is_own && claim.is_some_and(|of| of.is_held) {
            return Err("another page acts with this tracker".to_owned());
        }
        let is_page = |seen| claim.is_some_and(|of| of.has_sent(seen, now));
        if !is_own && seen.is_some_and(|seen| !is_page(seen)) {
            return Err("a tracker sends there already".to_owned());
        }
        *claim = Some(Claim {
            key,
            session,
            is_held: true,
            read: claim.and_then(|of| of.read),
        });
        Ok(())
    }

    /// Whether a connection has a stream, on which a reading has come from it.
    pub(super) fn read(&self, stream: usize, session: u32, now: Instant) -> bool {
        let Ok(mut claims) = self.0.lock() else {
            return false;
        };
        let claim = claims.get_mut(stream).and_then(Option::as_mut);
        let claim = claim.filter(|of| of.is_held && of.session == session);
        claim.is_some_and(|of| {
            of.read = Some(now);
            true
        })
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

    /// A tracker's sample was seen just now.
    const SEEN: Option<Duration> = Some(Duration::from_millis(10));

    #[test]
    fn a_stream_has_one_page_and_a_page_comes_back_to_its_own() {
        let [ours, theirs] = [Token::make(), Token::make()].map(|key| key.expect("random"));
        let claims = Claims::new(2);
        let now = Instant::now();
        assert!(claims.take(2, ours, 1, None, now).is_err());
        // A real tracker is not disturbed.
        assert!(claims.take(0, ours, 1, SEEN, now).is_err() && !claims.read(0, 1, now));
        assert!(claims.take(0, ours, 1, None, now).is_ok());
        assert!(claims.read(0, 1, now) && !claims.read(1, 1, now));
        assert!(claims.take(0, theirs, 2, None, now).is_err());
        // Its own readings are still coming in when it is back; the earlier connection has it no more.
        assert!(claims.take(0, ours, 3, SEEN, now).is_ok());
        assert!(claims.read(0, 3, now) && !claims.read(0, 1, now));
        claims.leave(1);
        assert!(claims.read(0, 3, now));
        claims.leave(3);
        assert!(!claims.read(0, 3, now));
        assert!(claims.take(0, theirs, 4, None, now).is_ok());
    }

    #[test]
    fn a_page_that_has_left_is_no_tracker_that_sends() {
        let [ours, theirs] = [Token::make(), Token::make()].map(|key| key.expect("random"));
        let claims = Claims::new(1);
        let begun = Instant::now();
        assert!(claims.take(0, ours, 1, None, begun).is_ok());
        assert!(claims.read(0, 1, begun));
        assert!(claims.take(0, theirs, 2, SEEN, begun).is_err());
        claims.leave(1);
        // What was seen last is its own; what came later is not.
        let now = begun + 2 * LATE;
        assert!(claims.take(0, theirs, 2, SEEN, now).is_err());
        assert!(claims.take(0, theirs, 2, Some(LATE), now).is_ok());
        assert!(claims.read(0, 2, now));
    }

    #[test]
    fn who_has_a_stream_and_says_nothing_on_it_makes_no_way_beside_a_tracker() {
        let [ours, theirs] = [Token::make(), Token::make()].map(|key| key.expect("random"));
        let claims = Claims::new(1);
        let now = Instant::now();
        assert!(claims.take(0, ours, 1, None, now).is_ok());
        claims.leave(1);
        assert!(claims.take(0, theirs, 2, SEEN, now).is_err());
    }
}
