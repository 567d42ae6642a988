//! Whether sampled simulations propose the true sequence of a cube's bounces, and what that costs.

use std::time::Instant;

use anyhow::Result;
use enact::estimate::{self, Recipe};
use enact::initialise::contact;
use enact::motion::{Contacts, Scene, Verdict};
use enact::pipeline::Outcome;
use enact::verify;
use serde::Serialize;

use crate::proposal::Stage;
use crate::results::Options;
use crate::sequences::{opened, performances};
use crate::statistics::median;
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, bounces};

const BOUNCES: [usize; 3] = [6, 12, 20];
/// Proposals that are solved, each whole.
const SOLVED: usize = 3;
/// Objectives this near are one \[relative\].
const SAME: f64 = 1e-6;

#[derive(Serialize)]
struct Row {
    bounces: usize,
    distortion: f64,
    timing_known: bool,
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

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let mut rows = Vec::new();
    let mut table = Table::new(
        "Sequences of a cube's bounces as sampled simulations propose them",
        &[
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
        ],
    );
    for (count, timing, acting) in performances(options, &BOUNCES) {
        let block: Vec<Row> = options
            .range()
            .filter_map(|seed| proposed(count, &acting, seed))
            .collect();
        let cells = cells(&block, timing);
        eprintln!("{}", cells.join(" | "));
        table.row(cells);
        rows.extend(block);
    }
    options.show(&table);
    match options.only {
        Some(_) => Ok(()),
        None => options.write_json("proposals", &rows),
    }
}

fn cells(block: &[Row], timing: &str) -> Vec<String> {
    let of = |value: fn(&Row) -> f64| block.iter().map(value).collect::<Vec<f64>>();
    let most = |value| of(value).into_iter().fold(0.0, f64::max);
    let within = |places: usize| {
        let is = |row: &&Row| row.place.is_some_and(|place| place < places);
        percent(block.iter().filter(is).count(), block.len())
    };
    let is_good = |row: &&Row| row.relative.is_some_and(|r| r <= 1.0 + SAME);
    vec![
        block[0].bounces.to_string(),
        timing.to_owned(),
        format!("{}×", block[0].distortion),
        within(1),
        within(3),
        within(10),
        within(usize::MAX),
        percent(block.iter().filter(is_good).count(), block.len()),
        number(median(&of(|row| row.expected))),
        number(median(&of(|row| row.propose_seconds))),
        number(most(|row| row.propose_seconds)),
        number(median(&of(|row| row.solve_seconds))),
        number(most(|row| row.solve_seconds)),
    ]
}

fn proposed(count: usize, acting: &Acting, seed: u64) -> Option<Row> {
    let truth = bounces(count, seed).ok()?;
    let case = Case::new(&truth, acting, seed);
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
        bounces: count,
        distortion: acting.distortion,
        timing_known: acting.is_timing_known(),
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
