//! Two criteria of what to set free: Schwarz's, by which `--free auto` chooses, and prediction of samples
//! that are held out.
//!
//! `--free auto` sets free one thing after another, of the suspects of the estimate so far; so does its
//! counterpart by hold-out, which tries each alone. Of everything, without the test that finds suspects,
//! each criterion sets free the one thing that it likes best, if it likes it better than nothing.

mod hold_out;

use std::time::Instant;

use enact::motion::{Quantity, Scene};
use enact_tools::case::estimated;
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::wrong::Wrong;
use serde::Serialize;

use self::hold_out::best;
use super::step::closed;
use super::throws::with_noise;
use crate::options::Options;
use crate::statistics::{mean, median};
use crate::table::{Table, number, percent};

/// Throws of a kind.
const SEEDS: u64 = 30;
/// Kinds of a quick run.
const QUICK: usize = 3;
/// Greatest number of things that are set free, as in `--free auto`.
const MOST: usize = 4;

/// What is set free together: a quantity, or the components of one thing.
type Thing = Vec<Quantity>;

/// What chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    Auto,
    HoldOut,
    SchwarzOfAll,
    HoldOutOfAll,
}

impl By {
    const ALL: [Self; 4] = [
        Self::Auto,
        Self::HoldOut,
        Self::SchwarzOfAll,
        Self::HoldOutOfAll,
    ];

    /// What it sets free in a take, in order.
    fn freed(self, asked: &Asked) -> Vec<Thing> {
        match self {
            Self::Auto => {
                let outcome = asked.freed();
                let freed = outcome.map_or_else(|_| Vec::new(), |outcome| outcome.freed);
                freed.iter().map(|one| thing(&one.values)).collect()
            }
            Self::HoldOut => by_hold_out(asked),
            Self::SchwarzOfAll | Self::HoldOutOfAll => {
                let values = |thing: &Thing| -> Vec<(Quantity, f64)> {
                    let given = thing.iter().map(|q| (*q, asked.scene.value_of(*q)));
                    given.collect()
                };
                let things = things(&asked.scene);
                let wider = things
                    .iter()
                    .map(|thing| asked.scene.with_free(&values(thing)));
                let wider: Vec<Scene> = wider.collect();
                let best = if self == Self::SchwarzOfAll {
                    best_by_schwarz(asked, &wider)
                } else {
                    best(asked, &wider)
                };
                best.map(|best| things[best].clone()).into_iter().collect()
            }
        }
    }
}

/// What one made of the throws of a kind.
#[derive(Clone, Debug, Default, Serialize)]
struct Chosen {
    /// The culprit alone, nothing, something else.
    freed: [usize; 3],
    /// How long it took, throw by throw \[ms\].
    times_ms: Vec<f64>,
}

impl Chosen {
    fn add(&mut self, wrong: Wrong, by: By, asked: &Asked) {
        let begin = Instant::now();
        let freed = by.freed(asked);
        self.times_ms.push(1e3 * begin.elapsed().as_secs_f64());
        let is_culprit = |thing: &Thing| thing.iter().any(|q| wrong.is_of(*q));
        let what = match &freed[..] {
            [] => 1,
            [one] if is_culprit(one) => 0,
            _ => 2,
        };
        self.freed[what] += 1;
    }
}

/// The throws of a kind, with what each made of them.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    wrong: &'static str,
    throws: usize,
    chosen: [Chosen; 4],
}

/// All kinds of scenes.
pub fn compare(options: &Options) -> Vec<Compared> {
    let all = [Wrong::Nothing].into_iter().chain(Wrong::ALL);
    let all = all.take(options.either(QUICK, usize::MAX));
    all.map(|wrong| {
        let mut compared = Compared {
            wrong: wrong.name(),
            throws: 0,
            chosen: Default::default(),
        };
        for seed in options.seeds(SEEDS) {
            if let Ok(asked) = wrong.asked(&with_noise(), seed) {
                compared.throws += 1;
                for (chosen, by) in compared.chosen.iter_mut().zip(By::ALL) {
                    chosen.add(wrong, by, &asked);
                }
            }
        }
        compared
    })
    .collect()
}

/// The table of two that choose in the same way.
pub fn table((name, title): (&str, &str), all: &[Compared], two: [usize; 2]) -> Table {
    let header = [
        "wrong",
        "throws",
        "Schwarz: the culprit alone",
        "nothing",
        "other",
        "median ms",
        "hold-out: the culprit alone",
        "nothing",
        "other",
        "median ms",
    ];
    let mut table = Table::new(name, title, &header);
    for compared in all {
        let head = [compared.wrong.to_owned(), compared.throws.to_string()];
        let cells = two.map(|by| {
            let chosen = &compared.chosen[by];
            let shares = chosen.freed.map(|count| percent(count, compared.throws));
            let time = number(median(&chosen.times_ms));
            shares.into_iter().chain([time])
        });
        table.row(head.into_iter().chain(cells.into_iter().flatten()));
    }
    table
}

/// How often two free the culprit alone, and something in right scenes; and their times.
pub fn verdict(what: &str, all: &[Compared], two: [usize; 2]) -> String {
    let is_right = |of: &&Compared| of.wrong == Wrong::Nothing.name();
    let (right, wrong): (Vec<&Compared>, Vec<&Compared>) = all.iter().partition(is_right);
    let throws = |of: &[&Compared]| of.iter().map(|of| of.throws).sum::<usize>();
    let freed = |of: &[&Compared], by: usize, what: usize| {
        let counts = of.iter().map(|of| of.chosen[by].freed[what]);
        percent(counts.sum(), throws(of))
    };
    let [schwarz, held] = two;
    let times = two.map(|by| {
        let times = all.iter().flat_map(|of| of.chosen[by].times_ms.iter());
        mean(&times.copied().collect::<Vec<f64>>())
    });
    format!(
        "{what}, of {} throws with one thing wrong, Schwarz's criterion frees the culprit alone in {} and something else in {}, \
         hold-out in {} and {}; of {} right ones, something is freed in {} and {}. Hold-out takes {} times as long.",
        throws(&wrong),
        freed(&wrong, schwarz, 0),
        freed(&wrong, schwarz, 2),
        freed(&wrong, held, 0),
        freed(&wrong, held, 2),
        throws(&right),
        freed(&right, schwarz, 2),
        freed(&right, held, 2),
        number(times[1] / times[0]),
    )
}

/// What hold-out sets free, in order.
fn by_hold_out(asked: &Asked) -> Vec<Thing> {
    let mut asked = asked.clone();
    let mut freed = Vec::new();
    while freed.len() < MOST {
        let Ok(outcome) = asked.answered() else { break };
        let suspects = &outcome.estimate.suspects;
        let wider = suspects
            .iter()
            .map(|suspect| asked.scene.with_free(&suspect.values));
        let mut wider: Vec<Scene> = wider.collect();
        let Some(best) = best(&asked, &wider) else {
            break;
        };
        freed.push(thing(&suspects[best].values));
        asked.scene = wider.swap_remove(best);
    }
    freed
}

/// The scene whose motion has the least criterion, if that is less than that of the take's own: `n ln J +
/// k ln n` with the objective `J`, `n` numbers in the samples and `k` free quantities.
fn best_by_schwarz(asked: &Asked, scenes: &[Scene]) -> Option<usize> {
    let criterion = |scene: &Scene| {
        let found = estimated(scene, &asked.events, &mut ());
        let outcome = closed(&found)?;
        let data = 6.0 * outcome.estimate.sample_times.len() as f64;
        let free = scene.parameters.len() as f64;
        Some(data * outcome.estimate.objective.ln() + free * data.ln())
    };
    let own = criterion(&asked.scene)?;
    let others = scenes.iter().enumerate();
    let better = others.filter_map(|(index, scene)| Some((index, criterion(scene)?)));
    let better = better.filter(|(_, value)| *value < own);
    better
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

fn thing(values: &[(Quantity, f64)]) -> Thing {
    values.iter().map(|(quantity, _)| *quantity).collect()
}

/// Everything that a performance of the scene can tell, the components of one thing together.
fn things(scene: &Scene) -> Vec<Thing> {
    // Of one body, a force is gravity.
    let is_told = |quantity: &Quantity| {
        let wider = scene.with_free(&[(*quantity, scene.value_of(*quantity))]);
        let mut events = 0..scene.events.len();
        let is_supported = events.all(|event| wider.contact_set(event).is_ok());
        let is_gravity = matches!(quantity, Quantity::Force { .. });
        scene.untold(*quantity).is_none() && is_supported && !is_gravity
    };
    Quantity::by_thing(scene.quantities().into_iter().filter(is_told))
}
