//! What makes code hard to follow, counted: parameters packed into tuples, and names that stand for several things.

use std::collections::BTreeMap;

use super::tokens::{Token, is_word};

/// Greatest number of functions that take a tuple apart in their parameters: a few pairs that are obvious.
const TUPLES: usize = 20;

/// Greatest number of names of types that are defined in several files.
const NAMES: usize = 40;

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
                "fn" if takes_apart(&code[at + 1..]) => {
                    self.tuples.push(format!("{path}:{} {name}", token.line));
                }
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

/// Whether the function of this name and on has a parameter whose pattern is a tuple.
fn takes_apart(code: &[Token]) -> bool {
    let mut levels = 0;
    // A pattern follows the bracket or a comma, perhaps with a `&`.
    let mut may_begin = false;
    // A type of functions has no name.
    let is_named = code
        .first()
        .is_some_and(|name| name.text.chars().all(is_word));
    if !is_named {
        return false;
    }
    for token in &code[1 + generics(&code[1..])..] {
        let text = token.text.as_str();
        match text {
            "(" if may_begin => return true,
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
        may_begin = levels == 1 && (matches!(text, "(" | ",") || may_begin && text == "&");
    }
    false
}

/// How many tokens the generic parameters take that begin here, in which types of functions have brackets of their own.
fn generics(code: &[Token]) -> usize {
    let mut levels = 0;
    let mut before = "";
    for (at, token) in code.iter().enumerate() {
        match token.text.as_str() {
            "<" => levels += 1,
            ">" if !matches!(before, "-" | "=") => levels -= 1,
            _ => {}
        }
        if levels == 0 {
            return if at == 0 { 0 } else { at + 1 };
        }
        before = &token.text;
    }
    code.len()
}

#[cfg(test)]
mod tests {
    use super::super::tokens::tokens;
    use super::*;

    #[test]
    fn tuples_of_parameters_are_seen_and_types_are_not() {
        let is_seen = |code: &str| {
            let mut dialect = Dialect::default();
            dialect.add("a.rs", &tokens(code));
            !dialect.tuples.is_empty()
        };
        assert!(is_seen("fn f((a, b): (A, B)) {}"));
        assert!(is_seen("fn f(&self, x: X, &(a, b): &(A, B)) {}"));
        assert!(is_seen("fn f<F: Fn(u8) -> u8>(g: F, (a, b): (A, B)) {}"));
        assert!(!is_seen(
            "fn f(a: &(dyn A + Send), b: Vec<(A, B)>) -> (A, B) {}"
        ));
        assert!(!is_seen("struct S { f: fn(A, (B, C)) -> D }"));
    }
}
