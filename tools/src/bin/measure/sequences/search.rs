//! Sequences of a cube's bounces as the program searches them.

use std::time::Instant;

use enact::initialise::contact;
use enact::motion::{Scene, Verdict};
use enact::pipeline::Outcome;
use serde::Serialize;

use super::{Kind, SAME};
use crate::statistics::{largest, median};
use crate::table::{number, share};
use enact_tools::case::{Case, Posed, another_leads, estimated};
use enact_tools::open::opened;
use enact_tools::perform::bounces;

/// Event times this near are one \[s\].
const SAME_S: f64 = 1e-4;

/// One searched performance.
#[derive(Serialize)]
pub struct Row {
    kind: String,
    seed: u64,
    verdict: &'static str,
    is_true: bool,
    is_proven: bool,
    /// Objective over that of the true sequence. Marks count in it, and a mark far from its kink, which
    /// only a scene that says what touches lets be moved there, does not.
    relative: f64,
    /// Whether that is no greater, or the motion is the same one.
    pub is_as_good: bool,
    /// Whether the estimate of the true sequence is a motion in which no other corner leads.
    truth_holds: bool,
    /// Worst place of a true feature among those at its collision, by the fits; the likeliest
    /// has place 0.
    worst_place: usize,
    /// Whether every true feature is among the likely ones.
    is_likely: bool,
    is_searched: bool,
    nodes: usize,
    bounds: usize,
    solves: usize,
    seconds: f64,
    named_seconds: f64,
}

/// Header of the table.
pub const HEADER: [&str; 16] = [
    "bounces",
    "timing",
    "distortion",
    "true sequence found",
    "as good or better",
    "or the true one is no motion",
    "likeliest is true",
    "likely",
    "searched",
    "not proven",
    "bounds",
    "solves",
    "of",
    "time, median [s]",
    "max [s]",
    "named [s]",
];

/// A row of the table.
pub fn cells(kind: &Kind, block: &[Row]) -> Vec<String> {
    let of = |value: fn(&Row) -> f64| block.iter().map(value).collect::<Vec<f64>>();
    let mut cells = kind.cells();
    cells.extend([
        share(block, |row| row.is_true),
        share(block, |row| row.is_as_good),
        share(block, |row| row.is_as_good || !row.truth_holds),
        share(block, |row| row.worst_place == 0),
        share(block, |row| row.is_likely),
        share(block, |row| row.is_searched),
        share(block, |row| row.is_searched && !row.is_proven),
        number(median(&of(|row| row.bounds as f64))),
        number(median(&of(|row| row.solves as f64))),
        number(8f64.powi(kind.bounces as i32)),
        number(median(&of(|row| row.seconds))),
        number(largest(&of(|row| row.seconds))),
        number(median(&of(|row| row.named_seconds))),
    ]);
    cells
}

/// A performance, searched; `None` where there is no motion of that kind.
pub fn searched(kind: &Kind, seed: u64) -> Option<Row> {
    let truth = bounces(kind.bounces, seed).ok()?;
    let case = Case::new(&truth, &kind.acting, seed);
    let scene = opened(case.scene());
    let started = Instant::now();
    let named = case.estimated(&mut ()).ok()?;
    let named_seconds = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let found = estimated(&scene, &case.performance.events, &mut ()).ok()?;
    let seconds = started.elapsed().as_secs_f64();
    let work = found.search.unwrap_or_default();
    let (worst_place, is_likely) = places(&scene, &named);
    let is_true = found.scene.events == named.scene.events;
    let relative = found.estimate.objective / named.estimate.objective;
    let events = found.estimate.events.iter().zip(&named.estimate.events);
    let apart_s = events.map(|(own, named)| (own.time_s - named.time_s).abs());
    let is_same = is_true && apart_s.fold(0.0, f64::max) < SAME_S;
    Some(Row {
        kind: kind.name(),
        seed,
        verdict: found.estimate.verdict.as_str(),
        is_true,
        is_proven: work.is_proven,
        relative,
        is_as_good: relative <= 1.0 + SAME || is_same,
        truth_holds: named.estimate.verdict == Verdict::Physical && !another_leads(&named),
        worst_place,
        is_likely,
        is_searched: found.search.is_some(),
        nodes: work.nodes,
        bounds: work.bounds,
        solves: work.solves,
        seconds,
        named_seconds,
    })
}

/// Where the true features stand among the candidates, collision by collision: the worst place,
/// and whether all are likely.
fn places(open: &Scene, named: &Outcome) -> (usize, bool) {
    let posed = Posed::new(&named.scene, &named.sketch);
    let (mut worst, mut is_likely) = (0, true);
    for event in open.open_events() {
        let Some(collision) = named.scene.events[event].kind.collision() else {
            continue;
        };
        let guess = &posed.guesses[0];
        let ranking = contact::rank(open, &named.sketch, &posed.segments, guess, event);
        let mut reaches = ranking.candidates.iter();
        let place = reaches.position(|reach| reach.contacts == collision.contacts);
        let place = place.unwrap_or(ranking.candidates.len());
        worst = worst.max(place);
        is_likely &= place < ranking.likely().len();
    }
    (worst, is_likely)
}
