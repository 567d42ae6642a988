//! Tables and sentences.

use anyhow::Result;
use enact_tools::objects::scene::Trust;
use nalgebra::Vector3;

use super::answer::{Answer, Value};
use super::facts::Facts;
use super::judge::{Judged, against, is_so, said};
use super::told::{Asked, Proposed, Told};
use crate::record::Record;
use crate::statistics::{INTERVALS, median};
use crate::table::{Table, number, percent};

/// What all of it was measured with.
pub struct With<'a> {
    pub trust: &'a Trust,
    pub gravity_m_s2: &'a Vector3<f64>,
}

impl With<'_> {
    fn off_m_s2(&self, facts: &Facts) -> f64 {
        let acceleration = facts.acceleration_m_s2;
        acceleration.map_or(f64::NAN, |a| (a - self.gravity_m_s2).norm())
    }

    fn said(&self, answer: &Answer, facts: &Facts) -> String {
        said(answer, facts, self.trust, self.off_m_s2(facts))
    }
}

/// Shows it.
pub fn show(told: &[Told], with: &With, record: &mut Record) -> Result<()> {
    record.table(trust(with.trust));
    record.table(summary(told, with));
    record.table(words(told, with));
    record.table(flights(told, with));
    record.table(impacts(told, with));
    record.table(shapes(told));
    sentences(told, with, record);
    record.numbers("tosses", &told)
}

fn trust(trust: &Trust) -> Table {
    let title = "Standard deviations per axis, chosen on the first, third, … toss of the list";
    let header = ["position mm", "orientation °", "height of the table mm"];
    let mut table = Table::new("trust", title, &header);
    let numbers = [trust.position_mm, trust.orientation_deg, trust.table_mm];
    table.row(numbers.map(number));
    table
}

fn half(told: &Told) -> &'static str {
    if told.is_for_choosing {
        "choosing"
    } else {
        "reported"
    }
}

fn seen(told: &[Told]) -> impl Iterator<Item = (&Told, &Asked)> {
    told.iter()
        .filter_map(|told| Some((told, told.seen.as_ref()?)))
}

/// What is asked of a toss: its first flight, or through its first impact.
type Part = (&'static str, fn(&Asked) -> &Answer);
const PARTS: [Part; 2] = [
    ("first flight", |asked| &asked.flight),
    ("through the first impact", |asked| &asked.impact),
];

fn summary(told: &[Told], with: &With) -> Table {
    let header = [
        "what",
        "tosses",
        "half",
        "asked",
        "physical",
        "plausible",
        "failed",
        "refused",
        "explained",
        "named",
        "physical and not so",
        "not named",
    ];
    let title = "What becomes of the tosses";
    let mut table = Table::new("summary", title, &header);
    for (what, answer) in PARTS {
        for of_half in ["choosing", "reported"] {
            let tosses = told.iter().filter(|told| half(told) == of_half).count();
            let answers: Vec<&Answer> = seen(told)
                .filter(|(told, _)| half(told) == of_half)
                .map(|(_, asked)| answer(asked))
                .collect();
            let is = |verdict: &str| answers.iter().filter(|of| of.verdict == verdict).count();
            let judged = |judged: Judged| {
                let of = answers.iter();
                of.filter(|of| Judged::new(of, with.trust) == judged)
                    .count()
            };
            let counts = [
                answers.len(),
                is("physical"),
                is("plausible"),
                is("failed"),
                is("refused"),
                judged(Judged::Explained),
                judged(Judged::Named),
                judged(Judged::Wrongly),
                judged(Judged::Unnamed),
            ];
            let head = [what.to_owned(), tosses.to_string(), of_half.to_owned()];
            table.row(
                head.into_iter()
                    .chain(counts.map(|count| count.to_string())),
            );
        }
    }
    table
}

/// How often each thing is said, and whether it is so.
fn words(told: &[Told], with: &With) -> Table {
    let header = ["what", "said", "times", "so", "not so", "not seen"];
    let title = "What is said of motions, and whether checks without the program bear it out";
    let mut table = Table::new("words", title, &header);
    for (what, answer) in PARTS {
        let mut all: Vec<(String, Option<bool>)> = Vec::new();
        for (_, asked) in seen(told) {
            let (answer, facts) = (answer(asked), &asked.facts);
            for word in &answer.said {
                let is = is_so(word, answer, facts, (with.trust, with.off_m_s2(facts)));
                all.push((kind(word), is));
            }
        }
        let mut kinds: Vec<&String> = all.iter().map(|(kind, _)| kind).collect();
        kinds.sort();
        kinds.dedup();
        for word in kinds {
            let count = |is: &dyn Fn(Option<bool>) -> bool| {
                all.iter()
                    .filter(|(of, so)| of == word && is(*so))
                    .count()
                    .to_string()
            };
            table.row([
                what.to_owned(),
                word.clone(),
                count(&|_| true),
                count(&|so| so == Some(true)),
                count(&|so| so == Some(false)),
                count(&|so| so.is_none()),
            ]);
        }
    }
    table
}

/// A suspect or an open quantity without its value.
fn kind(word: &str) -> String {
    match word.strip_prefix("suspect ") {
        Some(suspect) => {
            let name = suspect.split(' ').next().unwrap_or_default();
            format!("suspect {name}")
        }
        None => word.to_owned(),
    }
}

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

fn flights(told: &[Told], with: &With) -> Table {
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

fn impacts(told: &[Told], with: &With) -> Table {
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

fn shapes(told: &[Told]) -> Table {
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
        table.row([toss.name.clone()].into_iter().chain(one).chain(other));
    }
    table
}

fn sentences(told: &[Told], with: &With, record: &mut Record) {
    for (what, answer) in PARTS {
        let answers: Vec<&Answer> = seen(told).map(|(_, asked)| answer(asked)).collect();
        let count = |judged: Judged| {
            let of = answers.iter();
            of.filter(|of| Judged::new(of, with.trust) == judged)
                .count()
        };
        record.say(format!(
            "Of {} real tosses of objects, {what}: {} are explained, {} named as what they are not, {} called \
             physical against what is seen, {} neither; {} show no flight.",
            told.len(),
            count(Judged::Explained),
            count(Judged::Named),
            count(Judged::Wrongly),
            count(Judged::Unnamed),
            told.len() - answers.len()
        ));
    }
    let flown: Vec<(f64, f64)> = seen(told)
        .filter_map(|(_, asked)| {
            let found = asked.flight.checked?;
            Some((found.residual.0, found.filtered_mm?))
        })
        .collect();
    let of = |value: fn(&(f64, f64)) -> f64| median(&flown.iter().map(value).collect::<Vec<f64>>());
    record.say(format!(
        "First flights are {} mm from the samples (median of {}), and {} mm through the filter that the \
         samples went through.",
        number(of(|flown| flown.0)),
        flown.len(),
        number(of(|flown| flown.1))
    ));
    let late: Vec<f64> = seen(told)
        .filter_map(|(_, asked)| {
            Some(asked.proposed_in_all.as_ref().ok()?.place - asked.facts.impact())
        })
        .collect();
    let near = late.iter().filter(|late| late.abs() <= 1.0).count();
    let in_part = seen(told)
        .filter(|(_, asked)| asked.proposed.is_ok())
        .count();
    record.say(format!(
        "The mark that is proposed for one impact in all of a toss is within a sample of the first contact \
         by the spin in {near} of {}, and {} samples after it in the median; in the two flights alone one is proposed \
         in {in_part}.",
        late.len(),
        number(median(&late))
    ));
    let heights: Vec<f64> = told.iter().map(|told| told.last_height_m).collect();
    let shared = |height: &f64| heights.iter().filter(|other| *other == height).count();
    record.say(format!(
        "The last height is the same number to seven digits in {} of {} tosses.",
        heights.iter().map(shared).max().unwrap_or(0),
        heights.len()
    ));
    let with_mesh = seen(told).filter(|(told, _)| told.is_measured);
    let changes: Vec<bool> = with_mesh
        .map(|(_, asked)| asked.impact.verdict != asked.other.verdict)
        .collect();
    record.say(format!(
        "With the box about its mesh in place of the mesh the verdict of an impact changes in {} of {}.",
        percent(changes.iter().filter(|changes| **changes).count(), changes.len()),
        changes.len()
    ));
}
