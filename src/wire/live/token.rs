//! Who may direct takes: whoever knows the daemon's token.
//!
//! A daemon makes one at its start. It is in a file beside the daemon's lock that only the daemon's user can
//! read, for as long as the daemon runs, and in the link to the operator's page that it prints.

use std::fmt;
use std::fs::OpenOptions;
use std::io::{self, Read, Write};
use std::path::Path;

/// Bytes of a token: none guesses it.
pub const TOKEN_BYTES: usize = 16;

/// A longer file is no token \[bytes\].
const FILE_BYTES: u64 = 256;

/// What somebody must know to direct takes; it is written in hexadecimal digits and never printed by
/// `{:?}`.
#[derive(Clone, Copy)]
pub struct Token([u8; TOKEN_BYTES]);

impl Token {
    /// No daemon's token: for commands that change nothing.
    pub const NONE: Self = Self([0; TOKEN_BYTES]);

    /// A new one that nobody knows. Fails where the system has no random bytes.
    pub fn make() -> io::Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes))
    }

    /// The token in hexadecimal digits, with or without white space around; `None` for anything else.
    pub fn of_text(text: &str) -> Option<Self> {
        let text = text.trim();
        if text.len() != 2 * TOKEN_BYTES || !text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        let mut bytes = [0; TOKEN_BYTES];
        for (index, byte) in bytes.iter_mut().enumerate() {
            *byte = u8::from_str_radix(text.get(2 * index..2 * index + 2)?, 16).ok()?;
        }
        Some(Self(bytes))
    }

    /// In hexadecimal digits.
    pub fn text(&self) -> String {
        self.0.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// As a command carries it.
    pub fn bytes(&self) -> [u8; TOKEN_BYTES] {
        self.0
    }

    /// Whether a command carries this token; it takes as long for every wrong one. [`Token::NONE`] lets
    /// nobody in.
    pub fn lets_in(&self, carried: &[u8; TOKEN_BYTES]) -> bool {
        let pairs = self.0.iter().zip(carried);
        let difference = pairs.fold(0, |all, (ours, theirs)| all | (ours ^ theirs));
        let is_one = self.0.iter().fold(0, |all, byte| all | byte) != 0;
        difference == 0 && is_one
    }

    /// Writes it into a new file that only this user can read, in the place of one that an earlier daemon
    /// left. Fails where somebody else's file is in the way.
    pub(super) fn write(&self, path: &Path) -> io::Result<()> {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut file = options.open(path)?;
        writeln!(file, "{}", self.text())
    }

    /// Reads one from a regular file. Fails where it cannot be read or is none.
    pub fn read(path: &Path) -> io::Result<Self> {
        let file = super::super::regular::open(path)?;
        let mut text = String::new();
        file.take(FILE_BYTES).read_to_string(&mut text)?;
        Self::of_text(&text).ok_or_else(|| {
            let expected = format!("expected {} hexadecimal digits", 2 * TOKEN_BYTES);
            io::Error::new(io::ErrorKind::InvalidData, expected)
        })
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(…)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_goes_there_and_back_and_lets_nobody_else_in() {
        let token = Token::make().expect("random bytes");
        let other = Token::make().expect("random bytes");
        let read = Token::of_text(&format!("{}\n", token.text())).expect("a token");
        assert!(token.lets_in(&read.bytes()));
        assert!(!token.lets_in(&other.bytes()) && !token.lets_in(&Token::NONE.bytes()));
        assert!(!Token::NONE.lets_in(&Token::NONE.bytes()));
        assert!(!format!("{token:?}").contains(&token.text()));
        let digits = token.text();
        for wrong in [
            "",
            &digits[1..],
            "+0+0+0+0+0+0+0+0+0+0+0+0+0+0+0+0",
            &"ü".repeat(16),
            &format!("{digits}0"),
        ] {
            assert!(Token::of_text(wrong).is_none(), "{wrong}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn only_the_user_can_read_its_file_whoever_wrote_there_before() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("folder");
        let (path, other) = (folder.path().join("token"), folder.path().join("other"));
        // A link that was left there is not followed.
        std::fs::write(&other, "kept").expect("write");
        std::os::unix::fs::symlink(&other, &path).expect("link");
        let token = Token::make().expect("random bytes");
        token.write(&path).expect("written");
        assert_eq!(std::fs::read_to_string(&other).expect("there"), "kept");
        let mode = std::fs::symlink_metadata(&path)
            .expect("there")
            .permissions();
        assert_eq!(mode.mode() & 0o7777, 0o600);
        let read = Token::read(&path).expect("a token");
        assert!(token.lets_in(&read.bytes()));
        assert!(Token::read(&other).is_err() && Token::read(folder.path()).is_err());
    }
}
