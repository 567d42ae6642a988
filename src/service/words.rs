//! Errors in one line.

use crate::report::brief;

/// An error with its causes, each said once: some errors say their cause themselves. What is in them may be of any length
/// ([`brief`]).
pub fn words(error: &anyhow::Error) -> String {
    let mut words = String::new();
    for cause in error.chain().map(ToString::to_string) {
        let cause = brief(&cause).into_owned();
        if words.is_empty() {
            words = cause;
        } else if !words.contains(&cause) {
            words = format!("{words}: {cause}");
        }
    }
    brief(&words).into_owned()
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn causes_are_said_once() {
        let error = anyhow::anyhow!("disk full")
            .context("x.mcap: cannot write: disk full")
            .context("toss 3");
        assert_eq!(words(&error), "toss 3: x.mcap: cannot write: disk full");
    }
}
