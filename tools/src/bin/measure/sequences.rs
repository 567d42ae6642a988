//! Whether what touches is inferred rightly, and what that costs: scenes that name no contact,
//! and cubes of whose bounces only the number is known.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::ingest::{Recording, Source};
use enact::initialise::contact;
use enact::motion::{Scene, Touching, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use serde::Serialize;

use crate::results::Options;
use crate::statistics::median;
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed, another_leads, estimated};
use enact_tools::perform::{Acting, bounces};

/// Recordings that come with the project.
const RECORDINGS: [&str; 5] = [
    "pencil_tip",
    "pencil_eraser",
    "hat_box",
    "hat_box_bent",
    "die",
];
/// Runs of each; the fastest counts.
const RUNS: usize = 9;
/// Bounces and distortions.
const BOUNCES: [usize; 5] = [2, 4, 6, 12, 20];
const DISTORTIONS: [f64; 2] = [0.25, 1.0];
/// Objectives this near are one \[relative\].
const SAME: f64 = 1e-6;
/// Event times this near are one \[s\].
const SAME_S: f64 = 1e-4;

/// One searched performance.
#[derive(Serialize)]
struct Row {
    bounces: usize,
    distortion: f64,
    timing_known: bool,
    seed: u64,
    verdict: &'static str,
    is_true: bool,
    is_proven: bool,
    /// Objective over that of the true sequence. Marks count in it, and a mark far from its kink, which
    /// only a scene that says what touches lets be moved there, does not.
    relative: f64,
    /// Whether that is no greater, or the motion is the same one.
    is_as_good: bool,
    /// Whether the estimate of the true sequence is a motion in which no other corner leads.
    truth_holds: bool,
    /// Worst place of a true feature among those at its collision, by the fits; the likeliest
    /// has place 0.
    worst_place: usize,
    /// Whether every true feature is among the likely ones.
    is_likely: bool,
    is_searched: bool,
    sequences: f64,
    nodes: usize,
    bounds: usize,
    solves: usize,
    seconds: f64,
    named_seconds: f64,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    recordings(options)?;
    let mut rows = Vec::new();
    let mut table = Table::new(
        "Sequences of a cube's bounces",
        &[
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
        ],
    );
    for (count, _, acting) in performances(options, &BOUNCES) {
        let block: Vec<Row> = options
            .range()
            .filter_map(|seed| searched(count, &acting, seed))
            .collect();
        table.row(cells(&block));
        eprintln!("{}", cells(&block).join(" | "));
        rows.extend(block);
    }
    options.show(&table);
    match options.only {
        Some(_) => Ok(()),
        None => options.write_json("sequences", &rows),
    }
}

/// Kinds of performances of as many bounces: each with its timing known and unknown, little
/// distorted and more, those that are wanted.
pub fn performances(options: &Options, bounces: &[usize]) -> Vec<(usize, &'static str, Acting)> {
    let mut all = Vec::new();
    for count in bounces {
        for (timing, timed) in [
            ("known", Acting::timing_known()),
            ("unknown", Acting::default()),
        ] {
            for distortion in DISTORTIONS {
                if options.wants(&format!("{count} bounces, {timing}, {distortion}")) {
                    let acting = Acting {
                        distortion,
                        ..timed
                    };
                    all.push((*count, timing, acting));
                }
            }
        }
    }
    all
}

fn cells(block: &[Row]) -> Vec<String> {
    let of = |value: fn(&Row) -> f64| block.iter().map(value).collect::<Vec<f64>>();
    let share =
        |is: fn(&Row) -> bool| percent(block.iter().filter(|row| is(row)).count(), block.len());
    let first = &block[0];
    let most = of(|row| row.seconds).into_iter().fold(0.0, f64::max);
    vec![
        first.bounces.to_string(),
        if first.timing_known {
            "known"
        } else {
            "unknown"
        }
        .to_owned(),
        format!("{}×", first.distortion),
        share(|row| row.is_true),
        share(|row| row.is_as_good),
        share(|row| row.is_as_good || !row.truth_holds),
        share(|row| row.worst_place == 0),
        share(|row| row.is_likely),
        share(|row| row.is_searched),
        share(|row| row.is_searched && !row.is_proven),
        number(median(&of(|row| row.bounds as f64))),
        number(median(&of(|row| row.solves as f64))),
        number(first.sequences),
        number(median(&of(|row| row.seconds))),
        number(most),
        number(median(&of(|row| row.named_seconds))),
    ]
}

/// The scene with nothing said of what touches.
pub fn opened(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for event in 0..scene.events.len() {
        if scene.events[event].kind.collision().is_some() {
            let open = Touching {
                feature: None,
                other: None,
            };
            scene.set_contacts(event, &[open]);
        }
    }
    scene
}

fn searched(count: usize, acting: &Acting, seed: u64) -> Option<Row> {
    let truth = bounces(count, seed).ok()?;
    let case = Case::new(&truth, acting, seed);
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
        bounces: count,
        distortion: acting.distortion,
        timing_known: acting.is_timing_known(),
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
        sequences: 8f64.powi(count as i32),
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

fn recordings(options: &Options) -> Result<()> {
    let mut table = Table::new(
        "Scenes that name no contact",
        &[
            "recording",
            "inferred",
            "same estimate",
            "bounds",
            "solves",
            "named [ms]",
            "open [ms]",
            "ratio",
        ],
    );
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    for name in RECORDINGS {
        let path = root.join(format!("recordings/{name}.mcap"));
        let recording = Recording::open(&path)?;
        let text = std::str::from_utf8(recording.scene_toml().context("no scene")?)?;
        let (named, named_s) = timed(&recording, text)?;
        let (open, open_s) = match timed(&recording, &without_contacts(text)) {
            Ok(run) => run,
            Err(error) => {
                println!("{name}: {error}");
                continue;
            }
        };
        let work = open.search.unwrap_or_default();
        let words = open
            .inferred
            .iter()
            .filter_map(|event| open.scene.contact_words(*event));
        let is_same = open.estimate.arcs == named.estimate.arcs;
        table.row([
            name.to_owned(),
            words.collect::<Vec<_>>().join("; "),
            if is_same {
                "bit for bit".into()
            } else {
                format!(
                    "objective {} against {}",
                    open.estimate.objective, named.estimate.objective
                )
            },
            work.bounds.to_string(),
            work.solves.to_string(),
            number(1e3 * named_s),
            number(1e3 * open_s),
            number(open_s / named_s),
        ]);
    }
    options.show(&table);
    Ok(())
}

/// The scene file without what touches.
fn without_contacts(text: &str) -> String {
    let says = |line: &&str| {
        ["feature =", "surface =", "other_feature ="]
            .iter()
            .all(|key| !line.starts_with(key))
    };
    text.lines().filter(says).collect::<Vec<_>>().join("\n")
}

fn timed(recording: &Recording, text: &str) -> Result<(Outcome, f64)> {
    let mut pipeline = Pipeline::new(scene_from_toml(text)?);
    let scene = pipeline.scene().clone();
    let mut source = recording.source(&scene)?;
    while let Some((_, event)) = source.next()? {
        pipeline.push(event);
    }
    let mut fastest_s = f64::INFINITY;
    let mut outcome = None;
    for _ in 0..RUNS {
        let started = Instant::now();
        outcome = Some(pipeline.finish(&mut ())?);
        fastest_s = fastest_s.min(started.elapsed().as_secs_f64());
    }
    Ok((outcome.context("no run")?, fastest_s))
}
