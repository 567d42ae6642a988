//! Which file the acting page is: sources are in `tools/acting`, what is made of them comes with releases.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::ingest::read_text;

/// Which file the acting page is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ActingPage {
    /// `acting.html` beside the program, or what was made in the sources of which the program was built.
    Found,
    /// This one.
    File(PathBuf),
}

const NAME: &str = "acting.html";

const MADE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tools/acting/dist/acting.html");

/// The page. Fails where there is none, and says how to get it.
pub(in super::super) fn page_text(page: &ActingPage) -> anyhow::Result<String> {
    let path = match page {
        ActingPage::File(path) => path.clone(),
        ActingPage::Found => match places().into_iter().find(|path| path.is_file()) {
            Some(path) => path,
            None => bail!(
                "the acting page is not there: `npm ci --prefix tools/acting && npm run build --prefix tools/acting` in \
                 the sources makes it, with Node 20; or put `{NAME}` of a release beside the program, or say where it \
                 is by --acting=FILE. The operator's page needs none of that: leave --acting out"
            ),
        },
    };
    let text = read_text(&path)
        .with_context(|| format!("{}: cannot read the acting page", path.display()))?;
    if !is_page(&text) {
        bail!(
            "{}: is no page, expected the {NAME} that `npm run build` makes in tools/acting",
            path.display()
        );
    }
    Ok(text)
}

fn places() -> Vec<PathBuf> {
    let program = std::env::current_exe().ok();
    let beside = program.as_deref().and_then(Path::parent);
    let beside = beside.map(|folder| folder.join(NAME));
    beside.into_iter().chain([PathBuf::from(MADE)]).collect()
}

/// Whether a text may be the page: it begins as HTML does.
fn is_page(text: &str) -> bool {
    let begin = text.trim_start().get(..15);
    begin.is_some_and(|begin| begin.eq_ignore_ascii_case("<!doctype html>"))
}
