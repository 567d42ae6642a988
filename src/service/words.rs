//! Errors in one line.

/// An error with its causes, each said once: some errors say their cause themselves.
pub fn words(error: &anyhow::Error) -> String {
    let mut words = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if words.is_empty() {
            words = cause;
        } else if !words.contains(&cause) {
            words = format!("{words}: {cause}");
        }
    }
    words
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
