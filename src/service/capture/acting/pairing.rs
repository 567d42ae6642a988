//! Who may act: whoever knows the six digits that the daemon prints at its start.
//!
//! A page that has said them is given a key, with which it comes back after its connection broke. Nobody tries all
//! digits: there is one try a second, and after [`WRONG_CODES`] wrong ones no more are looked at.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::ingest::live::Token;

/// Wrong codes after which none is looked at until the daemon is started anew: one in fifty thousand guesses right.
const WRONG_CODES: u32 = 20;

/// Time between two tries, whoever tries.
const BETWEEN: Duration = Duration::from_secs(1);

/// Pages that are remembered.
const KEYS: usize = 8;

const CODES: u32 = 1_000_000;

/// Why a page is not let in.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub(super) enum PairingError {
    /// Other digits.
    #[error("this is not the code that `enact capture` printed")]
    WrongCode,
    /// Somebody has just tried.
    #[error("codes are looked at once a second: try again")]
    TooSoon,
    /// Too many were wrong.
    #[error("too many codes were wrong: restart `enact capture` for another one")]
    Closed,
    /// A key of another daemon, or one that was forgotten.
    #[error("this daemon does not know this page: type the code that `enact capture` printed")]
    UnknownKey,
}

#[derive(Debug, Default)]
struct Tries {
    wrong: u32,
    last: Option<Instant>,
}

/// The code, and the pages that knew it.
#[derive(Debug)]
pub(in super::super) struct Pairing {
    code: String,
    tries: Mutex<Tries>,
    keys: Mutex<VecDeque<Token>>,
}

impl Pairing {
    /// With a code that nobody knows. Fails where the system has no random bytes.
    pub(in super::super) fn new() -> std::io::Result<Self> {
        let bytes = Token::make()?.bytes();
        let number = bytes.iter().take(8);
        let number = number.fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
        Ok(Self::with_code(format!("{:06}", number % u64::from(CODES))))
    }

    /// With that code.
    pub(in super::super) fn with_code(code: String) -> Self {
        Self {
            code,
            tries: Mutex::default(),
            keys: Mutex::default(),
        }
    }

    /// The digits.
    pub(super) fn code(&self) -> &str {
        &self.code
    }

    /// The key of a page that says this code; white space in it does not count.
    pub(super) fn pair(&self, code: &str, now: Instant) -> Result<Token, PairingError> {
        let mut tries = self.tries.lock().map_err(|_| PairingError::Closed)?;
        if tries.wrong >= WRONG_CODES {
            return Err(PairingError::Closed);
        }
        let is_soon = |last: Instant| now.saturating_duration_since(last) < BETWEEN;
        if tries.wrong > 0 && tries.last.is_some_and(is_soon) {
            return Err(PairingError::TooSoon);
        }
        let digits: String = code.chars().filter(|c| !c.is_whitespace()).collect();
        if digits != self.code {
            tries.wrong += 1;
            tries.last = Some(now);
            return Err(PairingError::WrongCode);
        }
        let key = Token::make().map_err(|_| PairingError::Closed)?;
        let mut keys = self.keys.lock().map_err(|_| PairingError::Closed)?;
        keys.truncate(KEYS - 1);
        keys.push_front(key);
        Ok(key)
    }

    /// The key of a page that was here before.
    pub(super) fn resume(&self, key: &str) -> Result<Token, PairingError> {
        let given = Token::of_text(key).ok_or(PairingError::UnknownKey)?;
        let keys = self.keys.lock().map_err(|_| PairingError::UnknownKey)?;
        let mut known = keys.iter().copied();
        known
            .find(|key| key.lets_in(&given.bytes()))
            .ok_or(PairingError::UnknownKey)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_six_digits_and_differ() {
        let codes: Vec<Pairing> = (0..4).map(|_| Pairing::new().expect("random")).collect();
        for of in &codes {
            assert!(of.code().len() == 6 && of.code().bytes().all(|byte| byte.is_ascii_digit()));
        }
        assert!(codes.iter().any(|of| of.code() != codes[0].code()));
    }

    #[test]
    fn who_guesses_is_slowed_and_then_shut_out_and_who_was_let_in_comes_back() {
        let pairing = Pairing::with_code("042137".to_owned());
        let mut now = Instant::now();
        let key = pairing.pair("042 137", now).expect("the code");
        for try_number in 0..WRONG_CODES {
            let guess = format!("{try_number:06}");
            assert_eq!(
                pairing.pair(&guess, now).err(),
                Some(PairingError::WrongCode)
            );
            let again = pairing.pair("042137", now).err();
            let expected = match try_number + 1 {
                WRONG_CODES => PairingError::Closed,
                _ => PairingError::TooSoon,
            };
            assert_eq!(again, Some(expected));
            now += BETWEEN;
        }
        assert_eq!(
            pairing.pair("042137", now).err(),
            Some(PairingError::Closed)
        );
        assert!(pairing.resume(&key.text()).is_ok());
        let stranger = Token::make().expect("random").text();
        for key in ["", "0", stranger.as_str(), &Token::NONE.text()] {
            assert_eq!(pairing.resume(key).err(), Some(PairingError::UnknownKey));
        }
    }
}
