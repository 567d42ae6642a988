//! Tables with a row for every toss.

use super::answer::{Answer, Value};
use super::judge::{Judged, against};
use super::told::{Proposed, Told};
use super::with::{With, half, seen};
use crate::statistics::INTERVALS;
use crate::table::{Table, number};

fn range([first, last]: [usize; 2]) -> String {
    format!("{first}–{last}")
}

fn pair(values: Option<(f64, f64)>) -> String {
    values.map_or("–".into(), |(a, b)| {
        format!("{}, {}", number(a), number(b))
    })
}

fn optional(value: Option<f64>) -> String {
    value.map_or("–".into(), number)
}

pub fn flights(told: &[Told], with: &With) -> Table {
    let header = [
        "toss",
        "half",
        "samples",
        "filter: order, window",
        "first flight",
        "parabola off gravity m/s²",
        "verdict",
        "residual mm, °",
        "through the filter mm",
        "left-out sample mm, °",
        "gravity free: off m/s²",
        "what it is",
        "said",
        "speaks against it",
        "seen",
    ];
    let title = "First flights: ✓ what is said is so, ✗ it is not, ? not seen";
    let mut table = Table::new("flights", title, &header);
    for toss in told {
        let Some(asked) = &toss.seen else {
            let mut row = vec![toss.name.clone(), half(toss).to_owned()];
            row.resize(header.len() - 4, "–".to_owned());
            row.extend(
                [
                    "not asked",
                    "",
                    "",
                    "no flight: the spin never stays for four samples",
                ]
                .map(str::to_owned),
            );
            table.row(row);
            continue;
        };
        let (facts, answer) = (&asked.facts, &asked.flight);
        let found = answer.checked;
        table.row([
            toss.name.clone(),
            half(toss).to_owned(),
            facts.samples.to_string(),
            facts
                .filter
                .map_or("–".into(), |of| format!("{}, {}", of.order, of.window)),
            range(facts.first),
            number(with.off_m_s2(facts)),
            answer.verdict.to_owned(),
            pair(found.map(|found| found.residual)),
            optional(found.and_then(|found| found.filtered_mm)),
            pair(answer.left_out),
            optional(asked.gravity_off_m_s2),
            Judged::new(answer, with.trust).as_str().to_owned(),
            with.said(answer, facts),
            against(answer, with.trust).join(", "),
            facts.is_not().join(", "),
        ]);
    }
    table
}

fn interval(value: Option<Value>) -> String {
    let Some(value) = value else {
        return "–".to_owned();
    };
    let spread = value.sd.map_or(" (not determined)".to_owned(), |sd| {
        format!(" ± {}", number(INTERVALS[2].1 * sd))
    });
    let bound = value.at_bound.map_or("", |_| ", at its bound");
    // Rounding of the bound.
    let near = if value.value.abs() < 1e-6 {
        0.0
    } else {
        value.value
    };
    format!("{}{spread}{bound}", number(near))
}

fn proposal(proposed: &Result<Proposed, String>) -> String {
    match proposed {
        Ok(proposed) => format!("{:.1} (score {})", proposed.place, number(proposed.score)),
        Err(why) => why.clone(),
    }
}

pub fn impacts(told: &[Told], with: &With) -> Table {
    let header = [
        "toss",
        "half",
        "shape",
        "contact by the spin",
        "proposed mark",
        "in all of the toss",
        "samples after",
        "verdict",
        "fits",
        "touches",
        "gap mm, m/s",
        "restitution, 95 %",
        "residual mm, °",
        "through the filter mm",
        "depth mm",
        "energy after / before",
        "left-out sample mm, °",
        "what it is",
        "said",
        "speaks against it",
    ];
    let title = "Through the first impact, the law and the height of the table free";
    let mut table = Table::new("impacts", title, &header);
    for (toss, asked) in seen(told) {
        let (facts, answer) = (&asked.facts, &asked.impact);
        let found = answer.checked;
        let after = range(facts.second);
        table.row([
            toss.name.clone(),
            half(toss).to_owned(),
            toss.shape.clone(),
            facts.impact().to_string(),
            proposal(&asked.proposed),
            proposal(&asked.proposed_in_all),
            if facts.second_is_seen {
                after
            } else {
                format!("{after}, no flight seen")
            },
            answer.verdict.to_owned(),
            answer.fits.to_owned(),
            answer.feature.clone().unwrap_or("–".into()),
            pair(
                answer
                    .gap
                    .map(|(position_m, velocity_m_s)| (1e3 * position_m, velocity_m_s)),
            ),
            interval(answer.restitution),
            pair(found.map(|found| found.residual)),
            optional(found.and_then(|found| found.filtered_mm)),
            optional(found.and_then(|found| found.depth_mm)),
            optional(found.and_then(|found| found.energy_ratio)),
            pair(answer.left_out),
            Judged::new(answer, with.trust).as_str().to_owned(),
            with.said(answer, facts),
            against(answer, with.trust).join(", "),
        ]);
    }
    table
}

pub fn shapes(told: &[Told], with: &With) -> Table {
    let header = [
        "toss",
        "shape",
        "verdict",
        "restitution, 95 %",
        "residual mm, °",
        "other shape",
        "verdict",
        "restitution, 95 %",
        "residual mm, °",
        "what it is",
        "speaks against it",
    ];
    let title = "The same impacts with another shape";
    let mut table = Table::new("shapes", title, &header);
    for (toss, asked) in seen(told) {
        let cells = |shape: &str, answer: &Answer| {
            [
                shape.to_owned(),
                answer.verdict.to_owned(),
                interval(answer.restitution),
                pair(answer.checked.map(|found| found.residual)),
            ]
        };
        let one = cells(&toss.shape, &asked.impact);
        let other = cells(&asked.other_shape, &asked.other);
        let is = Judged::new(&asked.other, with.trust).as_str().to_owned();
        let last = [is, against(&asked.other, with.trust).join(", ")];
        let cells = one.into_iter().chain(other).chain(last);
        table.row([toss.name.clone()].into_iter().chain(cells));
    }
    table
}
