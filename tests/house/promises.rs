//! What `docs/promises.md` promises is tested: each promise names tests, and they exist.

use std::collections::BTreeSet;
use std::path::Path;

/// Names of all functions below a folder that are tests.
fn tests_below(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("list") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            tests_below(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("read");
            for (at, _) in text.match_indices("#[test]") {
                let after = &text[at..];
                let name = after.split_once("fn ").map(|(_, name)| name);
                let name = name.and_then(|name| name.split_once('('));
                found.extend(name.map(|(name, _)| name.to_owned()));
            }
        }
    }
}

#[test]
fn every_promise_names_tests_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut tests = BTreeSet::new();
    tests_below(&root.join("src"), &mut tests);
    tests_below(&root.join("tests"), &mut tests);
    assert!(tests.contains("every_promise_names_tests_that_exist"));
    let text = std::fs::read_to_string(root.join("docs/promises.md")).expect("the document");
    let (promises, _) = text.split_once("## Not promised").expect("what is not");
    let mut count = 0;
    let is_name = |word: &&str| word.contains('_') && !word.contains(['/', '.', '-']);
    for line in promises
        .split("\n\n")
        .flat_map(|part| part.split_inclusive('\n'))
    {
        let begins = line.split_once(". ").is_some_and(|(number, _)| {
            number
                .parse::<usize>()
                .is_ok_and(|number| number == count + 1)
        });
        count += usize::from(begins);
        for name in line.split('`').skip(1).step_by(2).filter(is_name) {
            assert!(
                tests.contains(name),
                "promise {count}: there is no test {name}"
            );
        }
    }
    assert_eq!(count, 14, "promises are numbered");
    let of_one = promises.split_once("\n1. ").expect("the first").1;
    let mut rest = of_one;
    for number in 2..=count + 1 {
        let (promise, next) = rest
            .split_once(&format!("\n{number}. "))
            .unwrap_or((rest, ""));
        let names = promise
            .split('`')
            .skip(1)
            .step_by(2)
            .any(|word| is_name(&word));
        let refers = promise.contains("same test") || promise.contains("The test of");
        assert!(names || refers, "promise {} has no test", number - 1);
        rest = next;
    }
}
