//! Rust as words and signs: enough of a lexer to leave out comments, texts and test code.

/// A word or a sign, with its line from 1. `::` is one sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    pub line: usize,
    pub text: String,
}

/// The tokens of a file, without comments and with texts and characters as `""`.
pub fn tokens(text: &str) -> Vec<Token> {
    let chars: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let (mut at, mut line) = (0, 1);
    while at < chars.len() {
        let begin = at;
        let end = skipped(&chars, at).or_else(|| literal(&chars, at));
        let is_text = skipped(&chars, at).is_none() && end.is_some();
        at = end.unwrap_or_else(|| word_or_sign(&chars, at));
        if is_text {
            tokens.push(Token {
                line,
                text: "\"\"".into(),
            });
        } else if end.is_none() && !chars[begin].is_whitespace() {
            tokens.push(Token {
                line,
                text: chars[begin..at].iter().collect(),
            });
        }
        line += chars[begin..at].iter().filter(|c| **c == '\n').count();
    }
    tokens
}

/// End of the comment that begins here.
fn skipped(chars: &[char], at: usize) -> Option<usize> {
    let pair = |at: usize| (chars.get(at).copied(), chars.get(at + 1).copied());
    match pair(at) {
        (Some('/'), Some('/')) => {
            let length = chars[at..].iter().position(|c| *c == '\n');
            Some(length.map_or(chars.len(), |length| at + length))
        }
        (Some('/'), Some('*')) => {
            let (mut end, mut level) = (at + 2, 1);
            while level > 0 && end < chars.len() {
                match pair(end) {
                    (Some('/'), Some('*')) => (level, end) = (level + 1, end + 2),
                    (Some('*'), Some('/')) => (level, end) = (level - 1, end + 2),
                    _ => end += 1,
                }
            }
            Some(end)
        }
        _ => None,
    }
}

/// End of the text or character that begins here, prefixes `b`, `c`, `r` included.
fn literal(chars: &[char], at: usize) -> Option<usize> {
    let after_word = at > 0 && is_word(chars[at - 1]);
    let mut begin = at;
    while !after_word && begin < at + 2 && matches!(chars.get(begin), Some('b' | 'c' | 'r')) {
        begin += 1;
    }
    let raw = begin > at && chars[begin - 1] == 'r';
    let hashes = chars[begin..].iter().take_while(|c| **c == '#').count();
    match chars.get(begin + if raw { hashes } else { 0 })? {
        '"' if raw => {
            let mut end = begin + hashes + 1;
            while end < chars.len() {
                let closes = chars[end] == '"'
                    && chars[end + 1..].iter().take_while(|c| **c == '#').count() >= hashes;
                end += 1;
                if closes {
                    return Some(end + hashes);
                }
            }
            Some(end)
        }
        '"' => Some(quoted_end(chars, begin, '"')),
        '\'' => {
            // A lifetime has no quote after its first letter; `'\''` begins with a backslash.
            let is_char =
                chars.get(begin + 1) == Some(&'\\') || chars.get(begin + 2) == Some(&'\'');
            is_char.then(|| quoted_end(chars, begin, '\''))
        }
        _ => None,
    }
}

fn quoted_end(chars: &[char], begin: usize, quote: char) -> usize {
    let mut end = begin + 1;
    while end < chars.len() && chars[end] != quote {
        end += if chars[end] == '\\' { 2 } else { 1 };
    }
    (end + 1).min(chars.len())
}

fn word_or_sign(chars: &[char], at: usize) -> usize {
    if is_word(chars[at]) {
        let length = chars[at..].iter().take_while(|c| is_word(**c)).count();
        at + length
    } else if chars[at] == ':' && chars.get(at + 1) == Some(&':') {
        at + 2
    } else {
        at + 1
    }
}

/// Whether a name may contain it.
pub fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Index after the bracketed group that begins here.
pub fn after_group(code: &[Token], begin: usize) -> usize {
    let mut level = 0;
    for (at, token) in code.iter().enumerate().skip(begin) {
        match token.text.as_str() {
            "(" | "[" | "{" => level += 1,
            ")" | "]" | "}" => level -= 1,
            _ => {}
        }
        if level <= 0 {
            return at + 1;
        }
    }
    code.len()
}

const CFG_TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];

fn is_cfg_test(code: &[Token], at: usize) -> bool {
    CFG_TEST
        .iter()
        .enumerate()
        .all(|(offset, text)| code.get(at + offset).is_some_and(|t| t.text == *text))
}

/// Index after the item that begins here, further attributes included.
fn after_item(code: &[Token], begin: usize) -> usize {
    let mut at = begin;
    while at < code.len() {
        match code[at].text.as_str() {
            ";" => return at + 1,
            "{" => return after_group(code, at),
            "(" | "[" => at = after_group(code, at),
            _ => at += 1,
        }
    }
    at
}

/// The code that is there when it does not test.
pub fn without_tests(code: &[Token]) -> Vec<Token> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < code.len() {
        if is_cfg_test(code, at) {
            at = after_item(code, at + CFG_TEST.len());
        } else {
            kept.push(code[at].clone());
            at += 1;
        }
    }
    kept
}

/// Paths, without `.rs`, of the modules that a file declares for tests only.
pub fn out_of_line_tests(path: &str, text: &str) -> Vec<String> {
    let folder = match path.strip_suffix("/mod.rs") {
        Some(folder) => folder.to_owned(),
        None => {
            let root = path
                .strip_suffix("/lib.rs")
                .or_else(|| path.strip_suffix("/main.rs"));
            root.unwrap_or(path.trim_end_matches(".rs")).to_owned()
        }
    };
    let code = tokens(text);
    let mut modules = Vec::new();
    for at in 0..code.len() {
        if !is_cfg_test(&code, at) {
            continue;
        }
        let item = &code[at + CFG_TEST.len()..after_item(&code, at + CFG_TEST.len())];
        let [.., module, name, end] = item else {
            continue;
        };
        if module.text == "mod" && end.text == ";" {
            modules.push(format!("{folder}/{}", name.text));
        }
    }
    modules
}
