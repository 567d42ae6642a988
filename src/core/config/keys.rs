//! Messages of the TOML reader, rewritten in the terms of the scene format.

/// Keys that replace one another: an error about one names all.
const ALTERNATIVES: &[&[&str]] = &[&["mass_g", "mass_kg", "density_kg_m3"]];

/// Rewrites a message of the deserialiser.
pub(super) fn explain(message: &str) -> String {
    if message.starts_with("unknown field `") {
        let mut names = message.split('`').skip(1).step_by(2);
        let unknown = names.next().unwrap_or_default();
        return unknown_key(unknown, &names.collect::<Vec<_>>());
    }
    if let Some(rest) = message.strip_prefix("missing field ") {
        return format!("missing key {rest}");
    }
    if message == "invalid type: map, expected a sequence" {
        return "expected a list of tables: write `[[name]]` in place of `[name]`".into();
    }
    message
        .trim_end()
        .replace("expected f64", "expected a number")
        .replace("expected a string", "expected a text in quotes")
        .replace('\n', "; ")
}

fn unknown_key(unknown: &str, accepted: &[&str]) -> String {
    let related = related(unknown, accepted);
    match related.as_slice() {
        [] => {}
        [one] => return format!("unknown key `{unknown}`, expected {one}"),
        many => {
            return format!(
                "unknown key `{unknown}`, expected one of {}",
                many.join(", ")
            );
        }
    }
    let all = accepted.join(", ");
    match nearest(unknown, accepted) {
        Some(name) => {
            format!("unknown key `{unknown}`, did you mean {name}? Expected one of {all}")
        }
        None => format!("unknown key `{unknown}`, expected one of {all}"),
    }
}

/// The accepted word nearest to an unknown one, if it is near: two letters off, or a third of them.
pub(super) fn nearest<'a>(unknown: &str, accepted: &[&'a str]) -> Option<&'a str> {
    let distances = accepted
        .iter()
        .map(|name| (edit_distance(unknown, name), *name));
    let (distance, name) = distances.min()?;
    (distance <= 2.max(unknown.chars().count() / 3)).then_some(name)
}

/// Accepted keys that begin with the same word, and their alternatives.
fn related<'a>(unknown: &str, accepted: &[&'a str]) -> Vec<&'a str> {
    let stem = |name: &str| name.split('_').next().unwrap_or_default().to_owned();
    let mut related: Vec<&str> = accepted
        .iter()
        .copied()
        .filter(|name| stem(name) == stem(unknown))
        .collect();
    for group in ALTERNATIVES {
        if related.iter().any(|name| group.contains(name)) {
            related.extend(group.iter().filter(|name| accepted.contains(name)));
        }
    }
    let mut seen = std::collections::BTreeSet::new();
    related.retain(|name| seen.insert(*name));
    related
}

/// Levenshtein distance: the least number of insertions, deletions and replacements that turn one
/// word into the other.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_edits() {
        assert_eq!(edit_distance("surface", "surface"), 0);
        assert_eq!(edit_distance("surfce", "surface"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn wrong_units_are_answered_with_the_right_ones() {
        assert_eq!(
            explain(
                "unknown field `mass_lb`, expected one of `name`, `mass_g`, `mass_kg`, `density_kg_m3`"
            ),
            "unknown key `mass_lb`, expected one of mass_g, mass_kg, density_kg_m3"
        );
        assert_eq!(
            explain("unknown field `surfce`, expected one of `name`, `surface`"),
            "unknown key `surfce`, did you mean surface? Expected one of name, surface"
        );
        assert_eq!(
            explain("unknown field `colour`, expected `name` or `kind`"),
            "unknown key `colour`, expected one of name, kind"
        );
        assert_eq!(explain("missing field `kind`"), "missing key `kind`");
    }
}
