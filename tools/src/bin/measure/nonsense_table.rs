//! How much nonsense is still called physical, and how much sense is not.
//!
//! The bounds were chosen on seeds below 16, and on the hovering vehicle's
//! windows from every eighth second on, where these begin four seconds later.

use std::collections::BTreeMap;

use anyhow::Result;
use enact::config::scene_from_toml;
use enact::estimate::outcome::PHYSICAL;
use enact::motion::{About, Gap, Verdict};

use crate::results::Options;
use crate::table::Table;
use crate::tosses;
use enact_tools::nonsense::{Asked, faults, real};

/// What became of a row's takes.
#[derive(Default)]
struct Tally {
    is_right: bool,
    takes: usize,
    unmade: usize,
    refused: usize,
    gaps_closed: usize,
    verdicts: [usize; 3],
    credible: usize,
    doubts: BTreeMap<&'static str, usize>,
}

impl Tally {
    fn new(is_right: bool) -> Self {
        Self {
            is_right,
            ..Self::default()
        }
    }

    fn add(&mut self, asked: &Asked) {
        self.takes += 1;
        let Ok(outcome) = asked.answered() else {
            self.refused += 1;
            return;
        };
        let closes = |gap: &Gap| gap.max(&PHYSICAL) == PHYSICAL;
        let is_closed = outcome
            .estimate
            .events
            .iter()
            .all(|event| closes(&event.gap));
        self.gaps_closed += usize::from(is_closed);
        let estimate = &outcome.estimate;
        self.verdicts[estimate.verdict as usize] += 1;
        let mut words: Vec<&str> = estimate.doubts.iter().map(|d| d.about.as_str()).collect();
        words.sort_unstable();
        words.dedup();
        for word in words {
            *self.doubts.entry(word).or_default() += 1;
        }
        let is_grave = |about: About| about.best() != Verdict::Physical;
        let is_of_shape = |about| matches!(about, About::Overlap | About::WrongFeature);
        let mut graves = estimate.doubts.iter().map(|d| d.about);
        let is_doubted = graves.any(|about| is_grave(about) && !is_of_shape(about));
        self.credible += usize::from(is_closed && !is_doubted);
    }

    fn said(&self) -> String {
        let words = self
            .doubts
            .iter()
            .map(|(word, count)| format!("{word} {count}"));
        words.collect::<Vec<_>>().join(", ")
    }
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let mut tallies: Vec<(String, Tally)> = Vec::new();
    for row in faults::rows() {
        if !options.wants(&row.name) {
            continue;
        }
        let mut tally = Tally::new(row.is_right);
        for seed in options.range() {
            match (row.make)(seed) {
                Ok(asked) => tally.add(&asked),
                Err(_) => tally.unmade += 1,
            }
        }
        tallies.push((row.name, tally));
    }
    if options.wants("real") {
        tallies.extend(of_real()?);
    }
    let mut table = Table::new(
        "Nonsense, and sense: doubts apart from overlap and wrong features take `physical` back",
        &[
            "takes of",
            "model",
            "takes",
            "refused",
            "gaps closed",
            "of these without a doubt",
            "physical",
            "plausible",
            "failed",
            "doubts",
        ],
    );
    let mut lines = Vec::new();
    for (name, tally) in &tallies {
        let [physical, plausible, failed] = tally.verdicts;
        let model = if tally.is_right { "right" } else { "wrong" };
        let numbers = [
            tally.takes,
            tally.refused,
            tally.gaps_closed,
            tally.credible,
            physical,
            plausible,
            failed,
        ];
        let numbers = numbers.map(|number| number.to_string());
        lines.push(format!(
            "{name:?},{model},{},{:?}",
            numbers.join(","),
            tally.said()
        ));
        let cells = [name.clone(), model.to_owned()].into_iter();
        table.row(cells.chain(numbers).chain([tally.said()]));
    }
    options.show(&table);
    let header =
        "takes_of,model,takes,refused,gaps_closed,credible,physical,plausible,failed,doubts";
    options.write_csv("nonsense", header, &lines)
}

fn of_real() -> Result<Vec<(String, Tally)>> {
    let Some(folder) = real::folder() else {
        return Ok(Vec::new());
    };
    let mut tallies = Vec::new();
    let mut add = |name: &str, is_right: bool, asked: &mut dyn Iterator<Item = Asked>| {
        let mut tally = Tally::new(is_right);
        asked.for_each(|asked| tally.add(&asked));
        tallies.push((name.to_owned(), tally));
    };
    let in_folder = |name: &str| real::files(&folder.join(name), "csv").into_iter();
    let mut elbows = in_folder("elbow").map(|file| real::elbow(&file));
    add(
        "real: two hinged boxes as one, gravity free",
        false,
        &mut elbows,
    );
    let scene = scene_from_toml(&tosses::scene_toml()?)?;
    if let Some(folder) = tosses::folder() {
        let found = tosses::read(&folder, &scene)?;
        let mut asked = found.iter().map(|toss| {
            let marks = [(toss.flight as f64 - 1.0, "impact")];
            Asked {
                scene: scene.clone(),
                events: tosses::take(toss, tosses::RATES_HZ[0], toss.flight, &marks),
            }
        });
        add(
            "real: first flight of a cube, gravity free",
            true,
            &mut asked,
        );
    }
    for (stamps, timing) in [("physical", "known"), ("tempo", "unknown")] {
        let mut objects = in_folder("objects").map(|file| real::object(&file, stamps, 8));
        let name = format!("real: objects, first eight smoothed poses, {timing}");
        add(&name, false, &mut objects);
        let file = folder.join("mcap/cub_stabilize_2025_11_13.mcap");
        let mut hovering = real::hovering(&file, stamps, 4.0).into_iter();
        add(
            &format!("real: a vehicle hovers, {timing}"),
            false,
            &mut hovering,
        );
    }
    let carried = real::files(&folder.join("not_throws"), "mcap").into_iter();
    let mut carried = carried.map(|file| real::carried(&file));
    add(
        "real: a camera carried by hand, unknown",
        false,
        &mut carried,
    );
    Ok(tallies)
}
