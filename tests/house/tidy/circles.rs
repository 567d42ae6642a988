//! Files that import each other in a loop.

use std::collections::{BTreeMap, BTreeSet};

use super::uses::Use;

/// A file under `src`, and what it brings in.
pub struct Importer {
    /// From the crate's root, with slashes.
    pub path: String,
    pub uses: Vec<Use>,
}

/// Every set of files of which each imports each other, be it through others; names that a module hands on
/// count as those of the file they come from.
pub fn circles(files: &[Importer]) -> Vec<Vec<String>> {
    let modules: BTreeMap<Vec<String>, usize> = files
        .iter()
        .enumerate()
        .map(|(index, file)| (module(&file.path), index))
        .collect();
    let house = House { files, modules };
    let count = files.len();
    let mut reaches = vec![vec![false; count]; count];
    for from in 0..count {
        for to in house.imported(from) {
            reaches[from][to] = to != from;
        }
    }
    for over in 0..count {
        for from in 0..count {
            if reaches[from][over] {
                let row = reaches[over].clone();
                let ways = reaches[from].iter_mut().zip(row);
                ways.for_each(|(way, beyond)| *way |= beyond);
            }
        }
    }
    let circle = |file: usize| -> BTreeSet<usize> {
        let others = (0..count).filter(|other| reaches[file][*other] && reaches[*other][file]);
        others.collect()
    };
    let all: BTreeSet<BTreeSet<usize>> = (0..count).map(circle).collect();
    let all = all.into_iter().filter(|circle| !circle.is_empty());
    let path = |index: usize| files[index].path.clone();
    all.map(|circle| circle.into_iter().map(path).collect())
        .collect()
}

struct House<'a> {
    files: &'a [Importer],
    modules: BTreeMap<Vec<String>, usize>,
}

impl House<'_> {
    fn imported(&self, from: usize) -> Vec<usize> {
        let here = module(&self.files[from].path);
        let uses = self.files[from].uses.iter();
        uses.filter_map(|used| self.origin(&self.absolute(&here, &used.path)?, 0))
            .collect()
    }

    /// The path from the crate's root; `None` of another crate's.
    fn absolute(&self, here: &[String], path: &[String]) -> Option<Vec<String>> {
        let (first, rest) = path.split_first()?;
        let supers = path.iter().take_while(|part| *part == "super").count();
        let below = |module: &[String], rest: &[String]| [module, rest].concat();
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some(below(here, rest)),
            "super" => {
                let above = here.len().checked_sub(supers)?;
                Some(below(&here[..above], &path[supers..]))
            }
            _ => {
                let child = below(here, &path[..1]);
                self.modules.contains_key(&child).then(|| below(here, path))
            }
        }
    }

    /// The file in which something of that path is defined.
    fn origin(&self, path: &[String], handed_on: usize) -> Option<usize> {
        let lengths = (1..=path.len()).rev();
        let mut known = lengths.filter_map(|length| {
            let file = self.modules.get(&path[..length])?;
            Some((length, *file))
        });
        let (length, file) = known.next()?;
        let module = &path[..length];
        let Some(name) = path.get(length).filter(|_| handed_on < 8) else {
            return Some(file);
        };
        // Only what a module of its own hands on to others stands for another file.
        let mut uses = self.files[file].uses.iter();
        let handing_on = uses.find(|used| used.is_public && used.name() == name);
        let from = handing_on.and_then(|used| {
            let mut from = self.absolute(module, &used.path)?;
            from.extend_from_slice(&path[length + 1..]);
            self.origin(&from, handed_on + 1)
        });
        from.or(Some(file))
    }
}

/// `src/a/b.rs` → `a::b`, `src/a/mod.rs` → `a`, `src/lib.rs` → the root.
fn module(path: &str) -> Vec<String> {
    let inside = super::inside(path);
    let inside = inside.strip_suffix(".rs").unwrap_or(inside);
    let mut parts: Vec<String> = inside.split('/').map(str::to_owned).collect();
    if parts
        .last()
        .is_some_and(|last| last == "mod" || last == "lib")
    {
        parts.pop();
    }
    parts
}
