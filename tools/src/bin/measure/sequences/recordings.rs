//! Recordings whose scenes name no contact.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::ingest::{Recording, Source};
use enact::pipeline::{Outcome, Pipeline};

use crate::table::{Table, number};

/// Recordings that come with the project.
const RECORDINGS: [&str; 5] = [
    "pencil_tip",
    "pencil_eraser",
    "hat_box",
    "hat_box_bent",
    "die",
];
/// Runs of each; the fastest counts.
const RUNS: usize = 9;
/// Every recording with and without what its scene names.
pub fn table() -> Result<Table> {
    let mut table = Table::new(
        "recordings",
        "Scenes that name no contact",
        &[
            "recording",
            "inferred",
            "same estimate",
            "bounds",
            "solves",
            "named [ms]",
            "open [ms]",
            "ratio",
        ],
    );
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    for name in RECORDINGS {
        let path = root.join(format!("recordings/{name}.mcap"));
        let recording = Recording::open(&path)?;
        let text = std::str::from_utf8(recording.scene_toml().context("no scene")?)?;
        let (named, named_s) = timed(&recording, text)?;
        let (open, open_s) = match timed(&recording, &without_contacts(text)) {
            Ok(run) => run,
            Err(error) => {
                println!("{name}: {error}");
                continue;
            }
        };
        let work = open.search.unwrap_or_default();
        let words = open
            .inferred
            .iter()
            .filter_map(|event| open.scene.contact_words(*event));
        let is_same = open.estimate.arcs == named.estimate.arcs;
        table.row([
            name.to_owned(),
            words.collect::<Vec<_>>().join("; "),
            if is_same {
                "bit for bit".into()
            } else {
                format!(
                    "objective {} against {}",
                    open.estimate.objective, named.estimate.objective
                )
            },
            work.bounds.to_string(),
            work.solves.to_string(),
            number(1e3 * named_s),
            number(1e3 * open_s),
            number(open_s / named_s),
        ]);
    }
    Ok(table)
}

/// The scene file without what touches.
fn without_contacts(text: &str) -> String {
    let says = |line: &&str| {
        ["feature =", "surface =", "other_feature ="]
            .iter()
            .all(|key| !line.starts_with(key))
    };
    text.lines().filter(says).collect::<Vec<_>>().join("\n")
}

fn timed(recording: &Recording, text: &str) -> Result<(Outcome, f64)> {
    let mut pipeline = Pipeline::new(scene_from_toml(text)?);
    let scene = pipeline.scene().clone();
    let mut source = recording.source(&scene)?;
    while let Some((_, event)) = source.next()? {
        pipeline.push(event);
    }
    let mut fastest_s = f64::INFINITY;
    let mut outcome = None;
    for _ in 0..RUNS {
        let started = Instant::now();
        outcome = Some(pipeline.finish(&mut ())?);
        fastest_s = fastest_s.min(started.elapsed().as_secs_f64());
    }
    Ok((outcome.context("no run")?, fastest_s))
}
