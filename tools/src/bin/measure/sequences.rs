//! Whether what touches is inferred rightly, and what that costs: scenes that name no contact, and
//! cubes of whose bounces only the number is known, searched and as sampled simulations propose them.

mod particles;
mod proposals;
mod recordings;
mod search;

use anyhow::Result;

use crate::options::Options;
use crate::record::Record;
use crate::table::{Table, share};
use enact_tools::perform::Acting;

/// Performances of a row.
const SEEDS: u64 = 40;
/// Bounces and distortions; proposals are asked about some.
const BOUNCES: [usize; 5] = [2, 4, 6, 12, 20];
const PROPOSED: [usize; 3] = [6, 12, 20];
const DISTORTIONS: [f64; 2] = [0.25, 1.0];
/// Objectives this near are one \[relative\].
const SAME: f64 = 1e-6;

/// A kind of performance.
struct Kind {
    bounces: usize,
    timing: &'static str,
    acting: Acting,
}

impl Kind {
    fn name(&self) -> String {
        self.cells().join(", ")
    }

    /// The head of a row.
    fn cells(&self) -> Vec<String> {
        vec![
            self.bounces.to_string(),
            self.timing.to_owned(),
            format!("{}×", self.acting.distortion),
        ]
    }
}

/// Each number of bounces with its timing known and unknown, little distorted and more.
fn kinds(options: &Options) -> Vec<Kind> {
    let mut all = Vec::new();
    let (known, unknown) = (Acting::timing_known(), Acting::default());
    for bounces in options.either(&BOUNCES[..3], &BOUNCES[..]) {
        for (timing, timed) in [("known", known), ("unknown", unknown)] {
            for distortion in DISTORTIONS {
                all.push(Kind {
                    bounces: *bounces,
                    timing,
                    acting: Acting {
                        distortion,
                        ..timed
                    },
                });
            }
        }
    }
    all.retain(|kind| options.wants(&kind.name()));
    all
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    record.table(recordings::table()?);
    let title = "Sequences of a cube's bounces, searched";
    let mut searches = Table::new("searches", title, &search::HEADER);
    let title = "Sequences of a cube's bounces as sampled simulations propose them";
    let mut proposals = Table::new("proposals", title, &proposals::HEADER);
    let (mut searched, mut proposed) = (Vec::new(), Vec::new());
    for kind in kinds(options) {
        let seeds = options
            .seeds(SEEDS)
            .filter_map(|seed| search::searched(&kind, seed));
        let block: Vec<search::Row> = seeds.collect();
        searches.row(search::cells(&kind, &block));
        searched.extend(block);
        if PROPOSED.contains(&kind.bounces) {
            let seeds = options
                .seeds(SEEDS)
                .filter_map(|seed| proposals::proposed(&kind, seed));
            let block: Vec<proposals::Row> = seeds.collect();
            proposals.row(proposals::cells(&kind, &block));
            proposed.extend(block);
        }
        eprintln!("  {}", kind.name());
    }
    record.table(searches);
    record.table(proposals);
    record.say(format!(
        "Where scenes name no corner, {} of {} searches find a motion as good as that of the true sequence or better.",
        share(&searched, |row| row.is_as_good),
        searched.len()
    ));
    record.numbers("searches", &searched)?;
    record.numbers("proposals", &proposed)
}
