//! What `use` brings in, one path at a time.

use super::tokens::Token;

/// One path of a `use`, groups taken apart and `self` at its end left out.
#[derive(Debug, PartialEq)]
pub struct Use {
    pub line: usize,
    pub path: Vec<String>,
    /// The name it gets, where that is another one.
    pub alias: Option<String>,
    /// Whether it is handed on (`pub use`, and `pub(…) use`).
    pub is_public: bool,
}

impl Use {
    /// The name by which it is known then.
    pub fn name(&self) -> &str {
        let last = self.path.last().map_or("", String::as_str);
        self.alias.as_deref().unwrap_or(last)
    }
}

/// Everything that is brought in.
pub fn uses(code: &[Token]) -> Vec<Use> {
    let mut uses = Vec::new();
    for at in 0..code.len() {
        // `impl Trait + use<'a>` brings in nothing.
        if code[at].text == "use" && text(code, at + 1) != "<" {
            let from = uses.len();
            tree(code, at + 1, &[], &mut uses);
            let before = at.checked_sub(1).map_or("", |before| text(code, before));
            let is_public = matches!(before, "pub" | ")");
            uses[from..]
                .iter_mut()
                .for_each(|used| used.is_public = is_public);
        }
    }
    uses
}

fn text(code: &[Token], at: usize) -> &str {
    code.get(at).map_or("", |token| token.text.as_str())
}

/// Takes apart what begins here, below a path; where it ends.
fn tree(code: &[Token], begin: usize, above: &[String], uses: &mut Vec<Use>) -> usize {
    let mut at = begin + usize::from(text(code, begin) == "::");
    let mut path = above.to_vec();
    while at < code.len() {
        if text(code, at) == "{" {
            at += 1;
            while !matches!(text(code, at), "}" | ";" | "") {
                at = tree(code, at, &path, uses);
                at += usize::from(text(code, at) == ",");
            }
            return at + 1;
        }
        let line = code[at].line;
        path.push(text(code, at).to_owned());
        at += 1;
        if text(code, at) == "::" {
            at += 1;
            continue;
        }
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let alias = (text(code, at) == "as").then(|| text(code, at + 1).to_owned());
        let end = at + if alias.is_some() { 2 } else { 0 };
        uses.push(Use {
            line,
            path,
            alias,
            is_public: false,
        });
        return end;
    }
    at
}
