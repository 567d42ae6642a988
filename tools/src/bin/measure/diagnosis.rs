//! How often a mistake in what is said of a performance is named, and how often one is named that
//! was not made.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::Result;
use enact::motion::{Remedy, Verdict};
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::slips::{self, Slip};

use crate::options::Options;
use crate::record::Record;
use crate::table::{Table, percent};

/// Right performances of a row.
const SEEDS: u64 = 22;

/// What was said of a row's takes.
#[derive(Default)]
struct Tally {
    takes: usize,
    refused: usize,
    physical: usize,
    named: usize,
    others: BTreeMap<String, usize>,
    seconds: f64,
}

impl Tally {
    fn add(&mut self, slip: Slip, asked: &Asked) {
        self.takes += 1;
        let begin = Instant::now();
        let (diagnoses, is_physical) = match asked.answered() {
            Ok(outcome) => (
                outcome.diagnoses,
                outcome.estimate.verdict == Verdict::Physical,
            ),
            Err(_) => {
                self.refused += 1;
                (asked.diagnosed(), false)
            }
        };
        self.seconds += begin.elapsed().as_secs_f64();
        self.physical += usize::from(is_physical);
        let Some(first) = diagnoses.first() else {
            return;
        };
        if slip.is_named_by(&first.remedy) {
            self.named += 1;
        } else {
            *self.others.entry(brief(&first.remedy)).or_default() += 1;
        }
    }

    fn wrong(&self) -> usize {
        self.others.values().sum()
    }

    fn cells(&self) -> [String; 7] {
        let silent = self.takes - self.named - self.wrong();
        let others = self.others.iter().map(|(name, n)| format!("{name} {n}"));
        [
            self.takes.to_string(),
            self.refused.to_string(),
            self.physical.to_string(),
            self.named.to_string(),
            self.wrong().to_string(),
            silent.to_string(),
            others.collect::<Vec<_>>().join(", "),
        ]
    }
}

fn brief(remedy: &Remedy) -> String {
    let text = format!("{remedy:?}");
    match remedy {
        Remedy::Mount { slip, .. } => format!("Mount({slip:?})"),
        Remedy::PositionUnit(_)
        | Remedy::SceneUnit(_)
        | Remedy::StreamQuaternions(_)
        | Remedy::GoalQuaternions(_) => text,
        _ => text.split([' ', '(']).next().unwrap_or_default().to_owned(),
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "mistake",
        "takes",
        "refused",
        "physical",
        "named",
        "named wrongly",
        "silent",
        "named instead",
    ];
    let mut by_slip = Table::new("slips", "Mistakes, over all performances", &header);
    let header = [
        "mistake",
        "performances",
        "takes",
        "refused",
        "physical",
        "named",
        "named wrongly",
        "silent",
        "named instead",
    ];
    let mut by_base = Table::new("performances", "The same, by kind of performance", &header);
    let bases = slips::bases();
    let (mut right, mut wrong) = ([0; 2], [0; 3]);
    for slip in [Slip::None].iter().chain(slips::ALL) {
        let mut whole = Tally::default();
        let mut rows = Vec::new();
        for base in &bases {
            let name = format!("{}: {}", base.name, slip.name());
            if !options.wants(&name) {
                continue;
            }
            let mut tally = Tally::default();
            for seed in options.seeds(if *slip == Slip::None {
                SEEDS
            } else {
                base.seeds
            }) {
                let Some(asked) = (base.make)(seed)
                    .ok()
                    .and_then(|asked| slip.put_into(asked))
                else {
                    continue;
                };
                tally.add(*slip, &asked);
            }
            if tally.takes == 0 {
                continue;
            }
            if options.rows.is_some() {
                eprintln!(
                    "{name}: {} {:.3} s",
                    tally.cells().join(" | "),
                    tally.seconds / tally.takes as f64
                );
            }
            rows.push((base.name.clone(), tally));
            // A quick run makes every mistake in the first performance that can have it.
            if options.quick {
                break;
            }
        }
        for (base, tally) in rows {
            let cells = [slip.name(), base].into_iter();
            by_base.row(cells.chain(tally.cells()));
            whole.takes += tally.takes;
            whole.refused += tally.refused;
            whole.physical += tally.physical;
            whole.named += tally.named;
            for (name, count) in tally.others {
                *whole.others.entry(name).or_default() += count;
            }
        }
        if whole.takes == 0 {
            continue;
        }
        by_slip.row([slip.name()].into_iter().chain(whole.cells()));
        if *slip == Slip::None {
            right = [whole.takes, whole.wrong()];
        } else {
            wrong[0] += whole.takes;
            wrong[1] += whole.named;
            wrong[2] += whole.wrong();
        }
    }
    record.table(by_slip);
    record.table(by_base);
    record.say(format!(
        "Of {} right takes {} are given a mistake.",
        right[0], right[1]
    ));
    record.say(format!(
        "Of {} takes with a mistake {} are named, {} are given another.",
        wrong[0],
        percent(wrong[1], wrong[0]),
        percent(wrong[2], wrong[0])
    ));
    Ok(())
}
