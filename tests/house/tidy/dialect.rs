//! What makes code hard to follow, counted: parameters packed into tuples, and names that stand for several things.

use std::collections::BTreeMap;

use super::tokens::Token;

/// Greatest number of functions that take a tuple apart in their parameters: a few pairs that are obvious.
const TUPLES: usize = 20;

/// Greatest number of names of types that are defined in several files.
const NAMES: usize = 147;

/// What is counted over all files.
#[derive(Default)]
pub(super) struct Dialect {
    tuples: Vec<String>,
    defined: BTreeMap<String, Vec<String>>,
}

impl Dialect {
    /// Counts what a file says.
    pub(super) fn add(&mut self, path: &str, code: &[Token]) {
        for (at, token) in code.iter().enumerate() {
            let name = code.get(at + 1).map_or("", |name| name.text.as_str());
            match token.text.as_str() {
                "fn" if takes_apart(&code[at..]) => {
                    self.tuples.push(format!("{path}:{} {name}", token.line));
                }
                // What a trait asks to be named is not a name of ours.
                "struct" | "enum" | "trait" => {
                    let files = self.defined.entry(name.to_owned()).or_default();
                    files.push(path.to_owned());
                }
                _ => {}
            }
        }
    }

    /// What there is too much of.
    pub(super) fn excess(&self) -> Vec<String> {
        let mut found = Vec::new();
        if self.tuples.len() > TUPLES {
            let said = self.tuples.join("\n  ");
            found.push(format!(
                "more than {TUPLES} tuples of parameters:\n  {said}"
            ));
        }
        let several = self.defined.iter().filter(|(_, files)| files.len() > 1);
        let several: Vec<&String> = several.map(|(name, _)| name).collect();
        if several.len() > NAMES {
            found.push(format!(
                "{} names are defined in several files, at most {NAMES}: {several:?}",
                several.len()
            ));
        }
        found
    }
}

/// Whether the function that begins here has a parameter whose pattern is a tuple.
fn takes_apart(code: &[Token]) -> bool {
    let mut levels = 0;
    let mut before = "";
    for token in &code[2..] {
        let text = token.text.as_str();
        let begins = levels == 1 && matches!(before, "(" | "," | "&");
        match text {
            "(" if begins => return true,
            "(" | "[" | "<" | "{" => levels += usize::from(text != "<"),
            ")" | "]" | "}" => {
                levels -= 1;
                if levels == 0 {
                    return false;
                }
            }
            ";" if levels == 0 => return false,
            _ => {}
        }
        before = text;
    }
    false
}
