//! The documents: every command of a user in them runs, every link leads somewhere, every page is in the table of contents.
//!
//! Commands are the lines of `console` blocks that begin with `$ enact`; each document has a folder of its own with the recordings and scenes of the
//! repository in it, and files of blocks that have a name, as `toml scene.toml`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Pages whose commands other tests run, with what the page says in words of its files.
const RUN_ELSEWHERE: [(&str, &str); 3] = [
    ("sketch.md", "tests/sketch/written.rs"),
    ("python.md", "tools/python/check.sh"),
    ("blender.md", "tools/blender/check.sh"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The documents, and the README.
fn pages() -> Vec<PathBuf> {
    let docs = fs::read_dir(root().join("docs")).expect("docs");
    let docs = docs.map(|entry| entry.expect("entry").path());
    let mut pages: Vec<PathBuf> = docs
        .filter(|path| path.extension().is_some_and(|of| of == "md"))
        .collect();
    pages.push(root().join("README.md"));
    pages.sort();
    pages
}

/// Blocks of code: the words after the fence, and the lines.
fn blocks(text: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let mut open: Option<(String, String)> = None;
    for line in text.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(words)) => open = Some((words.to_owned(), String::new())),
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some((_, lines)), None) => {
                lines.push_str(line);
                lines.push('\n');
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block has no end");
    blocks
}

/// Commands, with lines that end in a backslash joined.
fn commands(block: &str) -> Vec<String> {
    let joined = block.replace("\\\n", " ");
    let lines = joined.lines().filter_map(|line| line.strip_prefix("$ "));
    lines.map(str::to_owned).collect()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("folder");
    for entry in fs::read_dir(from).expect("list") {
        let path = entry.expect("entry").path();
        // What a run of the program has left beside a recording is none of the repository.
        let is_made = path.to_string_lossy().contains(".estimate.");
        if path.is_file() && !is_made {
            fs::copy(&path, to.join(path.file_name().expect("a name"))).expect("copy");
        }
    }
}

#[test]
fn commands_in_documents_run() {
    let mut count = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page");
        if let Some((_, test)) = RUN_ELSEWHERE.iter().find(|(name, _)| page.ends_with(name)) {
            assert!(root().join(test).exists(), "{test}");
            continue;
        }
        let folder = TempDir::new().expect("folder");
        for name in ["recordings", "config"] {
            copy(&root().join(name), &folder.path().join(name));
        }
        for (words, lines) in blocks(&text) {
            let words: Vec<&str> = words.split_whitespace().collect();
            match words.as_slice() {
                ["console"] => {}
                [_, name] => {
                    fs::write(folder.path().join(name), lines).expect("write");
                    continue;
                }
                _ => continue,
            }
            for command in commands(&lines) {
                assert!(command.starts_with("enact "), "{page:?}: {command}");
                let program = PathBuf::from(env!("CARGO_BIN_EXE_enact"));
                let line = format!(
                    "PATH=\"{}:$PATH\"; {command}",
                    program.parent().expect("a folder").display()
                );
                let ran = Command::new("sh")
                    .args(["-c", &line])
                    .current_dir(folder.path())
                    .output()
                    .expect("a shell");
                let said = String::from_utf8_lossy(&ran.stderr);
                assert!(ran.status.success(), "{page:?}: {command}: {said}");
                count += 1;
            }
        }
    }
    assert!(count > 12, "only {count} commands");
}

#[test]
fn links_lead_to_files_and_every_page_is_listed() {
    let mut listed = BTreeSet::new();
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page");
        let folder = page.parent().expect("a folder");
        for part in text.split("](").skip(1) {
            let target = part.split(')').next().expect("its end");
            if target.contains("://") || target.starts_with('#') {
                continue;
            }
            let file = target.split('#').next().expect("a file");
            assert!(
                folder.join(file).exists(),
                "{page:?}: {target} is not there"
            );
            // mdbook names pages `.html`, also those that are none of the book's.
            let is_of_book = folder.ends_with("docs") && file.ends_with(".md");
            assert!(
                !is_of_book || !file.contains("../"),
                "{page:?}: {target} is no page of the book"
            );
            if page.ends_with("SUMMARY.md") {
                listed.insert(folder.join(file));
            }
        }
    }
    for page in pages() {
        let is_inside = page.parent().is_some_and(|of| of.ends_with("docs"));
        if is_inside && !page.ends_with("SUMMARY.md") {
            assert!(listed.contains(&page), "{page:?} is not in docs/SUMMARY.md");
        }
    }
}
