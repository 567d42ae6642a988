//! Pieces of SVG and HTML as text.

use std::fmt::Write;

use crate::visual::Loop;

/// Text as markup has it, in elements and in attributes. Characters that XML cannot have, and those that
/// would turn the direction of what follows, become the sign for what cannot be shown.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\t' | '\n' | '\r' => escaped.push(' '),
            '\u{0}'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => {
                escaped.push('\u{fffd}');
            }
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                escaped.push('\u{fffd}');
            }
            _ => escaped.push(character),
        }
    }
    escaped
}

/// A sentence with names between grave accents, which become code.
pub(super) fn worded(sentence: &str) -> String {
    let parts: Vec<&str> = sentence.split('`').collect();
    let mut text = String::new();
    for (index, part) in parts.iter().enumerate() {
        // What is begun and not ended is no name.
        let is_name = index % 2 == 1 && index + 1 < parts.len();
        text += &match (is_name, index % 2) {
            (true, _) => format!("<code>{}</code>", escaped(part)),
            (false, 1) => format!("`{}", escaped(part)),
            (false, _) => escaped(part),
        };
    }
    text
}

/// A number of pixels to a tenth, the shortest way; zero of what is not finite.
pub(super) fn px(value: f64) -> String {
    if !value.is_finite() {
        return "0".to_owned();
    }
    let text = format!("{value:.1}");
    let text = text.strip_suffix(".0").unwrap_or(&text);
    match text {
        "-0" => "0".to_owned(),
        _ => text.to_owned(),
    }
}

/// A line through points as the data of a path.
pub(super) fn line(points: &[[f64; 2]]) -> String {
    let mut data = String::new();
    for (index, [x, y]) in points.iter().enumerate() {
        let command = if index == 0 { 'M' } else { 'L' };
        let _ = write!(data, "{command}{} {}", px(*x), px(*y));
    }
    data
}

/// Closed lines as the data of a path.
pub(super) fn loops(loops: &[Loop]) -> String {
    let each = loops.iter().map(|points| format!("{}Z", line(points)));
    each.collect()
}

/// A text at a place.
pub(super) fn text([x, y]: [f64; 2], attributes: &str, words: &str) -> String {
    format!(
        "<text x=\"{}\" y=\"{}\"{attributes}>{}</text>",
        px(x),
        px(y),
        escaped(words)
    )
}

/// About how wide a text is, in its own size: sans serif, whatever the font is.
pub(super) fn width_em(words: &str) -> f64 {
    let of = |c: char| match c {
        'i' | 'l' | 'j' | 'I' | '.' | ',' | ':' | ' ' | '|' | '\'' => 0.3,
        'm' | 'w' | 'M' | 'W' => 0.85,
        c if c.is_ascii() => 0.6,
        _ => 1.0,
    };
    words.chars().map(of).sum()
}

/// A text that is no longer than so many characters, its middle left out.
pub(super) fn shortened(words: &str, most: usize) -> String {
    let count = words.chars().count();
    if count <= most {
        return words.to_owned();
    }
    let begin = most / 2;
    let end = most - begin - 1;
    let first = words.chars().take(begin);
    let last = words.chars().skip(count - end);
    first.chain(['…']).chain(last).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.04, "0"),
            (12.0, "12"),
            (12.34, "12.3"),
            (-7.06, "-7.1"),
            (f64::NAN, "0"),
            (f64::INFINITY, "0"),
        ] {
            assert_eq!(px(value), text);
        }
        assert_eq!(line(&[[0.0, 1.0], [2.5, -3.0]]), "M0 1L2.5 -3");
        assert_eq!(
            loops(&[vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]),
            "M0 0L1 0L0 1Z"
        );
    }

    #[test]
    fn names_in_sentences_become_code() {
        assert_eq!(worded("at `a<b` it"), "at <code>a&lt;b</code> it");
        assert_eq!(
            worded("one ` alone & `x`"),
            "one <code> alone &amp; </code>x`"
        );
        assert_eq!(worded("none"), "none");
    }

    #[test]
    fn long_names_lose_their_middle() {
        assert_eq!(shortened("pencil", 6), "pencil");
        assert_eq!(shortened("a long name", 7), "a l…ame");
        assert_eq!(shortened("äöüß–äöüß", 5).chars().count(), 5);
    }

    proptest! {
        #[test]
        fn whatever_a_name_is_it_ends_no_element_and_no_attribute(name in "\\PC*|.*") {
            let attribute = escaped(&name);
            let is_plain = |c: char| !matches!(c, '<' | '>' | '"' | '\'') && !c.is_control();
            prop_assert!(attribute.chars().all(is_plain));
            // And every & begins one of ours; XML parsers agree and give the name back.
            let file = format!("<a b=\"{attribute}\">{attribute}</a>");
            let document = roxmltree::Document::parse(&file);
            let document = document.map_err(|error| TestCaseError::fail(error.to_string()))?;
            let root = document.root_element();
            let turned = |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
            if !name.contains(|c: char| c.is_control() || turned(c) || c >= '\u{fffe}') {
                prop_assert_eq!(root.text().unwrap_or_default(), name.as_str());
                prop_assert_eq!(root.attribute("b"), Some(name.as_str()));
            }
        }
    }
}
