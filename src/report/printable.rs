//! Names that come from files and from the wire, as they may be printed.
//!
//! A name may hold anything: line feeds that look like lines of ours, escape sequences that a
//! terminal obeys, characters that turn the direction of what follows.

use std::borrow::Cow;
use std::fmt::Write;

/// The sequences with which accounts are coloured.
const COLOURS: [&str; 4] = ["\u{1b}[0m", "\u{1b}[31m", "\u{1b}[32m", "\u{1b}[33m"];

/// A text on one line: every control character and every character that changes the direction of
/// text is escaped as in Rust, `\n`, `\u{1b}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |_| None)
}

/// The text of an account: [`printable`], but lines stay lines and colours stay colours.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |rest| {
        let colour = COLOURS.iter().find(|colour| rest.starts_with(**colour));
        colour
            .map(|colour| colour.len())
            .or(rest.starts_with('\n').then_some(1))
    })
}

/// Escapes all but what `kept` says is to be kept: how much of the rest of the text.
fn escaped(text: &str, kept: impl Fn(&str) -> Option<usize>) -> Cow<'_, str> {
    if !text.chars().any(is_escaped) {
        return Cow::Borrowed(text);
    }
    let (mut written, mut rest) = (String::with_capacity(text.len() + 16), text);
    while let Some(character) = rest.chars().next() {
        let length = if !is_escaped(character) {
            written.push(character);
            character.len_utf8()
        } else if let Some(length) = kept(rest) {
            written.push_str(&rest[..length]);
            length
        } else {
            // Writing to a String cannot fail.
            let _ = write!(written, "{}", character.escape_default());
            character.len_utf8()
        };
        rest = &rest[length..];
    }
    Cow::Owned(written)
}

fn is_escaped(character: char) -> bool {
    let turns = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    character.is_control() || turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown_instead() {
        for (name, shown) in [
            ("/tracker/mug/pose", "/tracker/mug/pose"),
            ("Stift ü €", "Stift ü €"),
            ("a\nerror: b", "a\\nerror: b"),
            ("\u{1b}[2J\u{1b}]0;x\u{7}", "\\u{1b}[2J\\u{1b}]0;x\\u{7}"),
            ("\u{9b}31m", "\\u{9b}31m"),
            ("\u{202e}txt", "\\u{202e}txt"),
            ("\u{1b}[31m", "\\u{1b}[31m"),
        ] {
            assert_eq!(printable(name), shown);
        }
        let account = "a\u{1b}[31mb\u{1b}[0m\nc\r\u{1b}[2J";
        assert_eq!(
            printable_lines(account),
            "a\u{1b}[31mb\u{1b}[0m\nc\\r\\u{1b}[2J"
        );
    }

    proptest::proptest! {
        #[test]
        fn nothing_is_left_that_is_not_printable(text in proptest::prelude::any::<String>()) {
            proptest::prop_assert!(!printable(&text).chars().any(is_escaped));
            let lines = printable_lines(&text);
            let left = COLOURS.iter().fold(lines.to_string(), |text, c| text.replace(c, ""));
            proptest::prop_assert!(!left.chars().any(|c| is_escaped(c) && c != '\n'));
        }
    }
}
