//! Marks that are off or absent: what is proposed in their place.

use std::time::Instant;

use anyhow::Result;
use enact::motion::{EventKind, Mark, Scene, Sketch, Stamp, TakeEvent, TrackIndex, Verdict};
use enact::segment::{propose, refine, relocate_marks};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::{HEAD, NEAR_SAMPLES, are_near, kinds};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use enact_tools::case::Case;
use enact_tools::perform::acting::START;

/// What proposals may know.
const VARIANTS: [&str; 3] = ["all", "no touch", "no turns"];

/// How near proposals are to the collisions, and how sure.
pub fn proposed(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        &HEAD[..],
        &[
            "variant",
            "near",
            "all near",
            "score near, 10 %",
            "50 %",
            "far, 50 %",
            "90 %",
            "time [µs]",
        ],
    ]
    .concat();
    let title = "Proposals without marks: within eight samples of the collision";
    let mut table = Table::new("proposals", title, &header);
    let mut numbers = Vec::new();
    for kind in kinds(&[2, 4, 6], &[1.0, 2.0, 4.0]) {
        for variant in VARIANTS {
            let (mut near, mut far, mut time_us) = (Vec::new(), Vec::new(), Vec::new());
            let (mut takes, mut all_near) = (0, 0);
            for (_, case) in kind.cases(options) {
                let sketch = case.performance.sketch();
                let scene = varied(case.scene(), variant);
                let begun = Instant::now();
                let proposals = propose(&scene, &sketch, None);
                time_us.push(begun.elapsed().as_secs_f64() * 1e6);
                let before = far.len();
                for proposal in &proposals {
                    let event = proposal.event.expect("of the scene");
                    let time_s = case.performance.truth.event_times_s[event];
                    let true_s = case.performance.tempo.acted_s(time_s);
                    let off = (proposal.acted_s - true_s).abs() * kind.acting.rate_hz;
                    let scores = if off <= NEAR_SAMPLES {
                        &mut near
                    } else {
                        &mut far
                    };
                    scores.push(proposal.score);
                }
                takes += 1;
                all_near += usize::from(far.len() == before);
            }
            table.row(kind.cells().into_iter().chain([
                variant.to_owned(),
                percent(near.len(), near.len() + far.len()),
                percent(all_near, takes),
                number(quantile(&near, 0.1)),
                number(median(&near)),
                number(median(&far)),
                number(quantile(&far, 0.9)),
                number(median(&time_us)),
            ]));
            numbers.push(json!({
                "kind": kind.cells(), "variant": variant, "takes": takes, "all_near": all_near,
                "score_of_near": near, "score_of_far": far, "time_us": time_us,
            }));
        }
    }
    record.table(table);
    record.numbers("proposals", &numbers)
}

fn varied(scene: &Scene, variant: &str) -> Scene {
    let mut scene = scene.clone();
    match variant {
        "no touch" => {
            for event in &mut scene.events {
                if let EventKind::Collision(collision) = &mut event.kind {
                    collision.contacts.clear();
                }
            }
        }
        "no turns" => scene.weights.orientation_rad = 1e9,
        _ => {}
    }
    scene
}

/// Marks that are off by so many samples, refined, and put elsewhere where that is clearly better.
pub fn off(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        &HEAD[..],
        &[
            "off by",
            "refined",
            "and relocated",
            "changed",
            "refine [µs]",
            "relocate [µs]",
        ],
    ]
    .concat();
    let title = "Marks that are off: takes with all marks within eight samples";
    let mut table = Table::new("marks_off", title, &header);
    let mut numbers = Vec::new();
    for kind in kinds(&[4], &[1.0, 4.0]) {
        for off in [0.0, 5.0, 20.0, 50.0] {
            let rate_hz = kind.acting.rate_hz;
            let (mut takes, mut refined, mut relocated, mut changed) = (0, 0, 0, 0);
            let (mut refine_us, mut relocate_us) = (Vec::new(), Vec::new());
            for (seed, case) in kind.cases(options) {
                let scene = case.scene();
                let mut sketch = marked_off(&case, off / rate_hz, seed);
                let begun = Instant::now();
                refine(scene, &mut sketch);
                refine_us.push(begun.elapsed().as_secs_f64() * 1e6);
                refined += usize::from(are_near(&case, &sketch.marks_s, rate_hz));
                let begun = Instant::now();
                let moved = relocate_marks(scene, &mut sketch);
                relocate_us.push(begun.elapsed().as_secs_f64() * 1e6);
                if !moved.is_empty() {
                    refine(scene, &mut sketch);
                }
                changed += usize::from(!moved.is_empty());
                relocated += usize::from(are_near(&case, &sketch.marks_s, rate_hz));
                takes += 1;
            }
            table.row(kind.cells().into_iter().chain([
                format!("± {off}"),
                percent(refined, takes),
                percent(relocated, takes),
                changed.to_string(),
                number(median(&refine_us)),
                number(median(&relocate_us)),
            ]));
            numbers.push(json!({
                "kind": kind.cells(), "off_by": off, "takes": takes, "refined": refined, "relocated": relocated,
                "changed": changed, "refine_us": refine_us, "relocate_us": relocate_us,
            }));
        }
    }
    record.table(table);
    record.numbers("marks_off", &numbers)
}

/// The sketch with the marks of collisions early or late by that much, in order.
fn marked_off(case: &Case, off_s: f64, seed: u64) -> Sketch {
    let mut sketch = case.performance.sketch();
    let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
    let last_s = sketch.tracks[TrackIndex(0)]
        .samples
        .last()
        .map_or(0.0, |s| s.acted_s);
    for (event, time_s) in case.performance.truth.event_times_s.iter().enumerate() {
        let time_s = case.performance.tempo.acted_s(*time_s);
        sketch.marks_s[event] = time_s;
        if case.scene().events[event].kind.collision().is_some() {
            let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
            sketch.marks_s[event] = (time_s + sign * off_s).clamp(0.0, last_s);
        }
    }
    let end = sketch.marks_s.len() - 1;
    sketch.marks_s[..end].sort_by(f64::total_cmp);
    sketch
}

/// Takes through the pipeline without marks, with one less, with one more.
pub fn absent(options: &Options, record: &mut Record) -> Result<()> {
    let header = [&HEAD[..], &["marks", "estimated", "all near", "physical"]].concat();
    let title = "Marks that are absent or too many";
    let mut table = Table::new("marks_absent", title, &header);
    let mut numbers = Vec::new();
    for kind in kinds(&[4], &[1.0, 4.0]) {
        for marks in ["none", "one less", "one more"] {
            let (mut takes, mut estimated, mut near, mut physical) = (0, 0, 0, 0);
            for (seed, mut case) in kind.cases(options) {
                change_marks(&mut case, marks, seed);
                takes += 1;
                let Ok(outcome) = case.estimated(&mut ()) else {
                    continue;
                };
                estimated += 1;
                physical += usize::from(outcome.estimate.verdict == Verdict::Physical);
                let marks_s = &outcome.sketch.marks_s;
                near += usize::from(are_near(&case, marks_s, kind.acting.rate_hz));
            }
            let shares = [estimated, near, physical].map(|count| percent(count, takes));
            table.row(
                kind.cells()
                    .into_iter()
                    .chain([marks.to_owned()])
                    .chain(shares),
            );
            numbers.push(json!({
                "kind": kind.cells(), "marks": marks, "takes": takes, "estimated": estimated, "near": near,
                "physical": physical,
            }));
        }
    }
    record.table(table);
    record.numbers("marks_absent", &numbers)
}

/// No marks; one of a collision left out; or one more, anywhere.
fn change_marks(case: &mut Case, marks: &str, seed: u64) {
    let duration_s = case.performance.tempo.acted_duration_s();
    let events = &mut case.performance.events;
    let mut rng = ChaCha8Rng::seed_from_u64(2000 + seed);
    let is_mark = |event: &TakeEvent| matches!(event, TakeEvent::Mark(_));
    match marks {
        "none" => events.retain(|event| !is_mark(event)),
        "one less" => {
            let at: Vec<usize> = (0..events.len())
                .filter(|index| is_mark(&events[*index]))
                .collect();
            events.remove(at[rng.random_range(0..at.len() - 1)]);
        }
        _ => {
            let late_s = duration_s * rng.random_range(0.05..0.95);
            let stamp = Stamp(START.0 + (late_s * 1e9) as i64);
            events.push(TakeEvent::Mark(Mark { stamp, event: None }));
        }
    }
}
