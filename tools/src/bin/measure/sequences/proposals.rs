//! Sequences of a cube's bounces as sampled simulations propose them.

use std::time::Instant;

use enact::estimate::{self, Recipe};
use enact::initialise::contact;
use enact::motion::{Contacts, Scene, Verdict};
use enact::pipeline::Outcome;
use enact::verify;
use serde::Serialize;

use super::particles::Stage;
use super::{Kind, SAME};
use crate::statistics::{largest, median};
use crate::table::{number, share};
use enact_tools::case::{Case, Posed};
use enact_tools::open::opened;
use enact_tools::perform::bounces;

/// Proposals that are solved, each whole.
const SOLVED: usize = 3;

/// A performance and what is proposed of it.
#[derive(Serialize)]
pub struct Row {
    kind: String,
    seed: u64,
    /// Place of the true sequence among the proposals.
    place: Option<usize>,
    proposals: usize,
    /// Half the objective that the proposal expects, over that of the estimate.
    expected: f64,
    propose_seconds: f64,
    /// The best sound estimate of the first few over that of the true sequence.
    relative: Option<f64>,
    solve_seconds: f64,
}

/// Header of the table.
pub const HEADER: [&str; 13] = [
    "bounces",
    "timing",
    "distortion",
    "first",
    "first 3",
    "first 10",
    "any",
    "of the first 3 one is as good",
    "expected",
    "propose [s]",
    "max [s]",
    "solve 3 [s]",
    "max [s]",
];

/// A row of the table.
pub fn cells(kind: &Kind, block: &[Row]) -> Vec<String> {
    let of = |value: fn(&Row) -> f64| block.iter().map(value).collect::<Vec<f64>>();
    let within = |places: usize| share(block, |row| row.place.is_some_and(|place| place < places));
    let mut cells = kind.cells();
    cells.extend([
        within(1),
        within(3),
        within(10),
        within(usize::MAX),
        share(block, |row| row.relative.is_some_and(|r| r <= 1.0 + SAME)),
        number(median(&of(|row| row.expected))),
        number(median(&of(|row| row.propose_seconds))),
        number(largest(&of(|row| row.propose_seconds))),
        number(median(&of(|row| row.solve_seconds))),
        number(largest(&of(|row| row.solve_seconds))),
    ]);
    cells
}

/// A performance and its proposals; `None` where there is no motion of that kind.
pub fn proposed(kind: &Kind, seed: u64) -> Option<Row> {
    let truth = bounces(kind.bounces, seed).ok()?;
    let case = Case::new(&truth, &kind.acting, seed);
    let scene = opened(case.scene());
    let named = case.estimated(&mut ()).ok()?;
    let posed = Posed::new(&named.scene, &named.sketch);
    let started = Instant::now();
    let open = likely(&scene, &named, &posed);
    let stage = Stage::new(
        &scene,
        &named.sketch,
        &posed.segments,
        &posed.guesses,
        &open,
    )?;
    let particles = stage.propose();
    let propose_seconds = started.elapsed().as_secs_f64();
    let is_true = |choice: &[usize]| {
        let mut all = open.iter().zip(choice);
        all.all(|((event, candidates), chosen)| {
            let collision = named.scene.events[*event].kind.collision();
            collision.is_some_and(|collision| collision.contacts == candidates[*chosen])
        })
    };
    let place = particles
        .iter()
        .position(|particle| is_true(&particle.choice));
    let started = Instant::now();
    let mut relative = None;
    for particle in particles.iter().take(SOLVED) {
        let understood = with(&scene, &open, &particle.choice);
        let estimate = estimate::estimate(
            &understood,
            &named.sketch,
            &posed.segments,
            &posed.guesses,
            &Recipe::default(),
            &mut (),
        )
        .estimate;
        let is_sound = estimate.verdict == Verdict::Physical
            && !verify::touches(&understood, &estimate)
                .iter()
                .any(|touch| touch.is_wrong);
        let own = estimate.objective / named.estimate.objective;
        if is_sound && relative.is_none_or(|best| own < best) {
            relative = Some(own);
        }
    }
    Some(Row {
        kind: kind.name(),
        seed,
        place,
        proposals: particles.len(),
        expected: particles.first().map_or(f64::NAN, |p| 2.0 * p.cost) / named.estimate.objective,
        propose_seconds,
        relative,
        solve_seconds: started.elapsed().as_secs_f64(),
    })
}

/// Open collisions in order of time, each with what may touch as far as the fits tell.
fn likely(scene: &Scene, named: &Outcome, posed: &Posed) -> Vec<(usize, Vec<Contacts>)> {
    let events = scene.open_events().into_iter();
    let of = |event| {
        let guess = &posed.guesses[0];
        let ranking = contact::rank(scene, &named.sketch, &posed.segments, guess, event);
        let reaches = ranking.likely().iter();
        (event, reaches.map(|reach| reach.contacts.clone()).collect())
    };
    events.map(of).collect()
}

fn with(scene: &Scene, open: &[(usize, Vec<Contacts>)], choice: &[usize]) -> Scene {
    let mut scene = scene.clone();
    for ((event, candidates), chosen) in open.iter().zip(choice) {
        scene.set_contacts(*event, &candidates[*chosen]);
    }
    scene
}
