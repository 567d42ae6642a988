//! Wrong scenes: whether it is seen that they do not fit, what is blamed, and what is set free; and
//! how often right ones are blamed.

mod intervals;

use std::collections::BTreeMap;

use anyhow::Result;
use enact::motion::{Fits, Performer, Suspect};
use enact::pipeline::Outcome;
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::perform::Acting;
use serde::Serialize;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::record::Record;
use crate::table::{Table, number, percent};

/// Throws of a cell, and right ones.
const SEEDS: u64 = 100;
const RIGHT_SEEDS: u64 = 1000;
/// The tracker's white noise, in units of 0.5 mm and 0.29°.
const NOISES: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
/// A hand's wander, in units of 20 mm and 8°.
const WANDERS: [f64; 6] = [0.03125, 0.0625, 0.125, 0.25, 0.5, 1.0];

/// How a throw is seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
enum Seen {
    Noise(f64),
    /// With the least noise, and the scene says that there was no hand.
    Measured,
    Wander(f64),
}

impl Seen {
    fn acting(self) -> Acting {
        let (noise, distortion) = match self {
            Seen::Noise(noise) => (noise, 0.0),
            Seen::Measured => (1.0, 0.0),
            Seen::Wander(distortion) => (1.0, distortion),
        };
        Acting {
            distortion,
            noise_position_m: 0.0005 * noise,
            noise_orientation_rad: 0.29_f64.to_radians() * noise,
            mark_error_s: 0.002,
            ..Acting::timing_known()
        }
    }

    fn name(self) -> String {
        match self {
            Seen::Noise(noise) => format!("noise {}×", number(noise)),
            Seen::Measured => "noise 1×, no hand".to_owned(),
            Seen::Wander(size) => format!("hand {}×", number(size)),
        }
    }
}

/// What was said of the throws of a cell.
#[derive(Clone, Debug, Serialize)]
struct Cell {
    wrong: &'static str,
    seen: Seen,
    takes: usize,
    /// Fits yes, unknown, no.
    fits: [usize; 3],
    /// The first suspect is the culprit.
    first: usize,
    /// The culprit is the first, or not told from it.
    among: usize,
    silent: usize,
    /// Setting free chose the culprit alone; nothing; something else.
    freed: [usize; 3],
    /// First suspects that are not the culprit.
    others: BTreeMap<String, usize>,
}

impl Cell {
    fn add(&mut self, wrong: Wrong, asked: &Asked) {
        let (Ok(outcome), Ok(freed)) = (asked.answered(), asked.freed()) else {
            return;
        };
        self.takes += 1;
        let estimate = &outcome.estimate;
        let fits = estimate.fit.as_ref().map_or(Fits::Unknown, |fit| fit.fits);
        self.fits[fits as usize] += 1;
        let is_culprit = |suspect: &Suspect| {
            let mut values = suspect.values.iter();
            values.any(|(quantity, _)| wrong.is_of(*quantity))
        };
        match estimate.suspects.split_first() {
            None => self.silent += 1,
            Some((first, others)) => {
                let is_first = is_culprit(first);
                let rivals = |other: &&Suspect| first.is_rivalled_by(other);
                let is_rival = others.iter().filter(rivals).any(is_culprit);
                self.first += usize::from(is_first);
                self.among += usize::from(is_first || is_rival);
                if !is_first {
                    *self.others.entry(named(&outcome, first)).or_default() += 1;
                }
            }
        }
        let what = match &freed.freed[..] {
            [] => 1,
            [one] if is_culprit(one) => 0,
            _ => 2,
        };
        self.freed[what] += 1;
    }
}

fn named(outcome: &Outcome, suspect: &Suspect) -> String {
    let (quantity, _) = suspect.values[0];
    outcome.given.name_of_quantity(quantity)
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let seen: Vec<Seen> = std::iter::once(Seen::Measured)
        .chain(NOISES.map(Seen::Noise))
        .chain(WANDERS.map(Seen::Wander))
        .collect();
    let mut cells = Vec::new();
    for seen in seen {
        for wrong in Wrong::ALL {
            if options.wants(&format!("{} {}", wrong.name(), seen.name())) {
                cells.push(cell(wrong, seen, options, SEEDS));
            }
        }
    }
    record.table(table(("faults", "Wrong scenes"), &cells));
    for (name, title, label, is_noise) in [
        (
            "adequacy_noise",
            "The culprit is named first, by the tracker's white noise",
            "noise, in units of 0.5 mm and 0.29°",
            true,
        ),
        (
            "adequacy_hand",
            "The culprit is named first, by the hand's wander",
            "wander, in units of 20 mm and 8°",
            false,
        ),
    ] {
        record.figure(figure((name, title, label), &cells, is_noise));
    }
    let seen = [Seen::Measured, Seen::Noise(1.0)].into_iter();
    let seen = seen.chain(WANDERS.map(Seen::Wander));
    let right: Vec<Cell> = seen
        .map(|seen| cell(Wrong::Nothing, seen, options, RIGHT_SEEDS))
        .collect();
    record.table(table(("right", "Right scenes"), &right));
    for wrong in [Wrong::Nothing, Wrong::Inertia] {
        if options.wants("intervals") {
            record.table(intervals::table(wrong, options));
        }
    }
    let of = |count: fn(&Cell) -> usize| right.iter().map(count).sum::<usize>();
    let (takes, blamed) = (of(|cell| cell.takes), of(|cell| cell.takes - cell.silent));
    let worst = right.iter().map(|cell| cell.takes - cell.silent).max();
    record.say(format!(
        "Of {takes} right throws, seen with a tracker's noise and hands of six sizes, {} are said not to \
         fit, {blamed} have a suspect ({}; of one size at most {}), and in {} something is set free.",
        of(|cell| cell.fits[2]),
        percent(blamed, takes),
        percent(worst.unwrap_or(0), RIGHT_SEEDS as usize),
        of(|cell| cell.freed[2]),
    ));
    record.numbers("faults", &cells)?;
    record.numbers("right", &right)
}

fn cell(wrong: Wrong, seen: Seen, options: &Options, seeds: u64) -> Cell {
    let mut cell = Cell {
        wrong: wrong.name(),
        seen,
        takes: 0,
        fits: [0; 3],
        first: 0,
        among: 0,
        silent: 0,
        freed: [0; 3],
        others: BTreeMap::new(),
    };
    for seed in options.seeds(seeds) {
        if let Ok(mut asked) = wrong.asked(&seen.acting(), seed) {
            if seen == Seen::Measured {
                asked.scene.performer = Performer::Nobody;
            }
            cell.add(wrong, &asked);
        }
    }
    cell
}

fn table((name, title): (&str, &str), cells: &[Cell]) -> Table {
    let header = [
        "wrong",
        "seen with",
        "throws",
        "does not fit",
        "beyond the noise",
        "fits",
        "culprit first",
        "first, or not told from it",
        "no suspect",
        "set free: the culprit alone",
        "nothing",
        "other",
        "named instead",
    ];
    let mut table = Table::new(name, title, &header);
    for cell in cells {
        let [yes, unknown, no] = cell.fits;
        let of = |count| percent(count, cell.takes);
        let others = cell.others.iter().map(|(name, n)| format!("{name} {n}"));
        let [culprit, nothing, other] = cell.freed;
        table.row([
            cell.wrong.to_owned(),
            cell.seen.name(),
            cell.takes.to_string(),
            of(no),
            of(unknown),
            of(yes),
            of(cell.first),
            of(cell.among),
            of(cell.silent),
            of(culprit),
            of(nothing),
            of(other),
            others.collect::<Vec<_>>().join(", "),
        ]);
    }
    table
}

fn figure((name, title, label): (&str, &str, &str), cells: &[Cell], is_noise: bool) -> Figure {
    let curve = |wrong: Wrong| {
        let of_it = cells.iter().filter(|cell| cell.wrong == wrong.name());
        let points = of_it.filter_map(|cell| {
            let x = match cell.seen {
                Seen::Noise(noise) if is_noise => noise,
                Seen::Wander(size) if !is_noise => size,
                _ => return None,
            };
            Some(Mark::at(x, cell.first as f64 / cell.takes.max(1) as f64))
        });
        Curve::new(wrong.name(), points.collect())
    };
    Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        note:
            "Share of the throws of a cube with one or two bounces whose first suspect is what is \
               wrong in the scene."
                .to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::linear("share of the throws"),
        curves: Wrong::ALL.into_iter().map(curve).collect(),
    }
}
