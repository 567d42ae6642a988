//! Recordings whose scenes name no contact.

use std::time::Instant;

use anyhow::{Context, Result};
use enact::pipeline::Outcome;

use crate::table::{Table, number};
use enact_tools::open::{RECORDINGS, recorded, without_contacts};

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
    for name in RECORDINGS {
        let (named, named_s) = timed(name, str::to_owned)?;
        let (open, open_s) = match timed(name, without_contacts) {
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

fn timed(name: &str, edit: fn(&str) -> String) -> Result<(Outcome, f64)> {
    let pipeline = recorded(name, edit)?;
    let mut fastest_s = f64::INFINITY;
    let mut outcome = None;
    for _ in 0..RUNS {
        let started = Instant::now();
        outcome = Some(pipeline.finish(&mut ())?);
        fastest_s = fastest_s.min(started.elapsed().as_secs_f64());
    }
    Ok((outcome.context("no run")?, fastest_s))
}
