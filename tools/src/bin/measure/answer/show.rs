//! Tables of answers.

use super::{Block, Judged};
use crate::statistics::{largest, median, rms};
use crate::table::{Table, number, share};
use enact_tools::starts::is_best;

impl Block {
    /// Of those that have an estimate.
    fn of(&self, value: impl Fn(&Judged) -> f64) -> Vec<f64> {
        let estimated = self.seeds.iter().filter(|seed| seed.verdict != "refused");
        estimated.map(value).collect()
    }

    /// Largest of the physical ones, of both parts of a gap.
    fn gap(&self, value: impl Fn(&Judged) -> (f64, f64)) -> String {
        let physical = self.seeds.iter().filter(|seed| seed.verdict == "physical");
        let (m, rad): (Vec<f64>, Vec<f64>) = physical.map(value).unzip();
        format!("{}, {}", number(largest(&m)), number(largest(&rad)))
    }

    fn share(&self, is: impl Fn(&Judged) -> bool) -> String {
        share(&self.seeds, is)
    }
}

/// A row for every block.
pub fn found(name: &str, title: &str, blocks: &[&Block]) -> Table {
    let header = [
        "performed",
        "n",
        "gaps closed",
        "physical",
        "plausible",
        "converged",
        "best known optimum",
        "largest goal gap m, rad",
        "the same simulated",
        "event error ms median (max)",
        "iterations median (max)",
        "time ms median (max)",
    ];
    let mut table = Table::new(name, title, &header);
    for block in blocks {
        let both = |value: fn(&Judged) -> f64| {
            let values = block.of(value);
            format!("{} ({})", number(median(&values)), number(largest(&values)))
        };
        table.row([
            block.name.clone(),
            block.seeds.len().to_string(),
            block.share(|seed| seed.verdict == "physical"),
            block.share(|seed| seed.checked == "physical"),
            block.share(|seed| seed.checked == "plausible"),
            block.share(|seed| seed.has_converged),
            block.share(|seed| seed.is_best),
            block.gap(|seed| seed.goal_gap),
            block.gap(|seed| seed.simulated_gap),
            both(|seed| seed.event_error_ms),
            both(|seed| seed.iterations as f64),
            both(|seed| seed.time_ms),
        ]);
    }
    table
}

/// How well sample times are recovered.
pub fn sample_times(blocks: &[Block]) -> Table {
    let header = [
        "performed",
        "rms ms",
        "rms ms, best offset taken off",
        "worst seed ms, offset taken off",
    ];
    let title = "Recovered sample times of pencils, error against the hidden ones";
    let mut table = Table::new("sample_times", title, &header);
    let is_told = |block: &&Block| block.table == "pencils" && !block.timing_known;
    for block in blocks.iter().filter(is_told) {
        let centred = block.of(|seed| seed.sample_times_ms.1);
        table.row([
            block.name.clone(),
            number(rms(&block.of(|seed| seed.sample_times_ms.0))),
            number(rms(&centred)),
            number(largest(&centred)),
        ]);
    }
    table
}

/// Seeds that are not at the best known optimum.
pub fn failures(blocks: &[Block]) -> Table {
    let header = [
        "performed",
        "without its verdict",
        "above the best (objective over lowest)",
    ];
    let title = "Seeds that do not end at the best known optimum";
    let mut table = Table::new("failures", title, &header);
    let list = |texts: Vec<String>| match texts.len().saturating_sub(12) {
        0 => texts.join(", "),
        more => format!("{}, {more} more", texts[..12].join(", ")),
    };
    for block in blocks {
        let (mut without, mut above) = (Vec::new(), Vec::new());
        for seed in block.seeds.iter().filter(|seed| !seed.is_best) {
            match &seed.lowest {
                Some((lowest, _)) if !is_best(seed.objective, *lowest) => {
                    above.push(format!("{} ({:.4})", seed.seed, seed.objective / lowest));
                }
                _ => without.push(seed.seed.to_string()),
            }
        }
        if !(without.is_empty() && above.is_empty()) {
            table.row([block.name.clone(), list(without), list(above)]);
        }
    }
    table
}
