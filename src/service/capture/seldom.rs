//! Log lines that others can cause as often as they like are written seldom.

use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Least interval of one kind of line.
const PAUSE: Duration = Duration::from_secs(10);

/// One kind of log line.
#[derive(Debug, Default)]
pub(super) struct Seldom(Mutex<(Option<Instant>, u64)>);

impl Seldom {
    /// `Some` if the line is to be written now: how often it was not since the last time.
    pub(super) fn due(&self, now: Instant) -> Option<u64> {
        let mut state = self.0.lock().ok()?;
        let (last, kept) = &mut *state;
        if last.is_some_and(|last| now.saturating_duration_since(last) < PAUSE) {
            *kept += 1;
            return None;
        }
        *last = Some(now);
        Some(std::mem::take(kept))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_written_once_in_a_while_with_how_often_it_was_not() {
        let (seldom, begun) = (Seldom::default(), Instant::now());
        assert_eq!(seldom.due(begun), Some(0));
        for ms in 1..1000 {
            assert_eq!(seldom.due(begun + Duration::from_millis(ms)), None);
        }
        assert_eq!(seldom.due(begun + PAUSE), Some(999));
        assert_eq!(seldom.due(begun + 2 * PAUSE), Some(0));
    }
}
