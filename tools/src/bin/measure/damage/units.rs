//! What becomes of positions in another unit.

use enact::motion::{TakeEvent, Verdict};

use super::{HEAD, kinds};
use crate::options::Options;
use crate::record::Record;
use crate::table::{Table, percent};

/// Runs it.
pub fn run(options: &Options, record: &mut Record) {
    let header = [
        &HEAD[..],
        &["factor", "refused", "failed", "physical", "error"],
    ]
    .concat();
    let mut table = Table::new("units", "Positions times a factor", &header);
    for kind in kinds(&[4], &[1.0]) {
        for factor in [0.001, 0.01, 0.1, 10.0, 100.0, 1000.0] {
            let (mut takes, mut refused, mut failed, mut physical) = (0, 0, 0, 0);
            let mut last = String::new();
            for (_, mut case) in kind.cases(options) {
                for event in &mut case.performance.events {
                    if let TakeEvent::Pose { sample, .. } = event {
                        sample.position_m *= factor;
                    }
                }
                takes += 1;
                match case.estimated(&mut ()) {
                    Err(error) => {
                        refused += 1;
                        last = error.to_string();
                    }
                    Ok(outcome) if outcome.estimate.verdict == Verdict::Physical => physical += 1,
                    Ok(_) => failed += 1,
                }
            }
            let shares = [refused, failed, physical].map(|count| percent(count, takes));
            let cells = kind.cells().into_iter().chain([factor.to_string()]);
            table.row(cells.chain(shares).chain([last]));
        }
    }
    record.table(table);
}
