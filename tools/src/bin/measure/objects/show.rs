//! Tables and sentences.

use anyhow::Result;
use enact_tools::objects::scene::Trust;

use super::answer::Answer;
use super::judge::{Judged, is_near, is_so};
use super::rows::{flights, impacts, shapes};
use super::told::{Asked, Told};
use super::with::{With, half, seen};
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};

/// Shows it.
pub fn show(told: &[Told], with: &With, record: &mut Record) -> Result<()> {
    record.table(trust(with.trust));
    record.table(summary(told, with));
    record.table(words(told, with));
    record.table(flights(told, with));
    record.table(impacts(told, with));
    record.table(shapes(told, with));
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

/// What is asked of a toss: its first flight, or through its first impact.
type Part = (&'static str, fn(&Asked) -> &Answer);
const PARTS: [Part; 3] = [
    ("first flight", |asked| &asked.flight),
    ("through the first impact", |asked| &asked.impact),
    ("the same with another shape", |asked| &asked.other),
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
        "physical, doubted here",
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
                judged(Judged::Doubted),
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

fn sentences(told: &[Told], with: &With, record: &mut Record) {
    for (what, answer) in PARTS {
        let answers: Vec<&Answer> = seen(told).map(|(_, asked)| answer(asked)).collect();
        let count = |judged: Judged| {
            let of = answers.iter();
            of.filter(|of| Judged::new(of, with.trust) == judged)
                .count()
        };
        record.say(format!(
            "Of {} real tosses of objects, {what}: {} are explained, {} named as what they are not, {} called physical \
             and doubted by a check without the program, {} neither; {} show no flight.",
            told.len(),
            count(Judged::Explained),
            count(Judged::Named),
            count(Judged::Doubted),
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
         samples went through; {} of them less than the standard deviation.",
        number(of(|flown| flown.0)),
        flown.len(),
        number(of(|flown| flown.1)),
        flown.iter().filter(|flown| is_near(flown.1, with.trust)).count()
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
