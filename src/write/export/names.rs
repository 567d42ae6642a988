//! Names that formats allow, each for one thing.

use std::collections::BTreeSet;

/// The name, with a number where it is taken; taken from here on.
pub(super) fn numbered(base: String, taken: &mut BTreeSet<String>) -> String {
    let mut name = base.clone();
    let mut number = 2;
    while !taken.insert(name.clone()) {
        name = format!("{base}_{number}");
        number += 1;
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taken_name_gets_the_next_free_number() {
        let mut taken = BTreeSet::from(["rod_2".to_owned()]);
        let names = [(); 3].map(|()| numbered("rod".to_owned(), &mut taken));
        assert_eq!(names, ["rod", "rod_3", "rod_4"]);
    }
}
