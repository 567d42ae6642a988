//! Names that somebody else chose, as text that only prints.
//!
//! A topic, an attachment, a body may be called anything: with control characters a name moves the
//! cursor of a terminal, changes its title or forges a line of an account; with overrides of the
//! writing direction it reads as another. What people read passes through [`plain`].

use std::borrow::Cow;
use std::fmt::Write;

/// The text on one line, with every character that does not print escaped as in Rust
/// (`\n`, `\u{1b}`): control characters, line and paragraph separators, what is invisible or
/// changes the direction of writing.
pub fn plain(text: &str) -> Cow<'_, str> {
    if text.chars().all(prints) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if prints(character) {
            plain.push(character);
        } else {
            plain.extend(character.escape_default());
        }
    }
    Cow::Owned(plain)
}

/// Characters of a line that people read, of which the middle may be left out.
const LINE: usize = 4000;

/// Characters after those that are left out.
const LINE_END: usize = 1000;

/// The text, of which the middle is left out where it is longer than anybody reads: what is wrong may be a cell of
/// ten megabytes, and it is said by whoever found it.
pub fn brief(text: &str) -> Cow<'_, str> {
    // Every character has a byte.
    if text.len() <= LINE || text.chars().nth(LINE).is_none() {
        return Cow::Borrowed(text);
    }
    let count = text.chars().count();
    let place = |at: usize| {
        text.char_indices()
            .nth(at)
            .map_or(text.len(), |(place, _)| place)
    };
    let (begin, end) = (place(LINE - LINE_END), place(count - LINE_END));
    let left_out = count - LINE;
    Cow::Owned(format!(
        "{} [… {left_out} characters …] {}",
        &text[..begin],
        &text[end..]
    ))
}

/// [`plain`] of what may be very long: [`brief`] before and after.
pub fn plain_line(text: &str) -> String {
    brief(&plain(&brief(text))).into_owned()
}

/// The same for a line of JSON, as its own escapes: it says the same to whoever parses it.
pub fn plain_json(json: &str) -> Cow<'_, str> {
    if json.chars().all(prints) {
        return Cow::Borrowed(json);
    }
    let mut plain = String::with_capacity(json.len() + 16);
    for character in json.chars() {
        if prints(character) {
            plain.push(character);
        } else {
            for unit in character.encode_utf16(&mut [0; 2]) {
                // Writing to a String cannot fail.
                let _ = write!(plain, "\\u{unit:04x}");
            }
        }
    }
    Cow::Owned(plain)
}

/// Whether a character takes its place on the line and does nothing else. The others are of the
/// categories Cc, Cf, Zl and Zp of Unicode.
pub fn prints(character: char) -> bool {
    !character.is_control()
        && !matches!(character,
            '\u{ad}' | '\u{600}'..='\u{605}' | '\u{61c}' | '\u{6dd}' | '\u{70f}'
            | '\u{890}' | '\u{891}' | '\u{8e2}' | '\u{180e}' | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}' | '\u{110bd}' | '\u{110cd}' | '\u{13430}'..='\u{1343f}'
            | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}' | '\u{e0000}'..='\u{e007f}')
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

    use super::*;

    #[test]
    fn names_that_print_are_left_as_they_are() {
        for name in [
            "/tracker/pencil/pose",
            "Würfel 3",
            "鉛筆",
            "a\\b \"c\"",
            "± 7.0 ms",
            "",
        ] {
            assert!(matches!(plain(name), Cow::Borrowed(same) if same == name));
        }
    }

    #[test]
    fn what_moves_the_cursor_or_turns_the_text_is_escaped() {
        for (name, escaped) in [
            ("a\x1b[2J\x1b]0;t\x07", "a\\u{1b}[2J\\u{1b}]0;t\\u{7}"),
            ("a\n  written   b\r", "a\\n  written   b\\r"),
            ("c\u{9b}31m\u{7f}", "c\\u{9b}31m\\u{7f}"),
            ("user\u{202e}gpj.exe", "user\\u{202e}gpj.exe"),
            (
                "\u{2066}x\u{2069}\u{2028}\u{feff}",
                "\\u{2066}x\\u{2069}\\u{2028}\\u{feff}",
            ),
        ] {
            assert_eq!(plain(name), escaped);
        }
    }

    #[test]
    fn of_what_is_very_long_begin_and_end_are_said() {
        let long = format!("bad.csv:3: {} is no number", "\0".repeat(10_000_000));
        let line = plain_line(&long);
        assert!(line.starts_with("bad.csv:3: \\u{0}"), "{}", &line[..40]);
        assert!(line.ends_with("is no number"));
        assert!(line.chars().count() < LINE + 60);
        let short = "ä".repeat(LINE);
        assert!(matches!(brief(&short), Cow::Borrowed(same) if same == short));
        let longer = "ä".repeat(LINE + 7);
        assert!(brief(&longer).contains("[… 7 characters …]"));
    }

    #[test]
    fn any_text_becomes_one_line_that_prints_and_json_says_the_same() {
        let config = Config::with_cases(2000);
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[3; 32]);
        let texts = prop_oneof![
            any::<String>(),
            prop::collection::vec(any::<char>(), 0..40)
                .prop_map(|characters| characters.into_iter().collect::<String>())
        ];
        let checked = TestRunner::new_with_rng(config, rng).run(&texts, |text| {
            prop_assert!(plain(&text).chars().all(prints));
            let json = serde_json::to_string(&text).expect("JSON");
            let json = plain_json(&json);
            prop_assert!(json.chars().all(prints));
            let parsed: String = serde_json::from_str(&json).expect("JSON");
            prop_assert_eq!(parsed, text);
            Ok(())
        });
        checked.expect("one line, and the same text");
    }
}
