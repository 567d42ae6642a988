//! What bad data do: outliers, positions in millimetres, marks that are off or absent.

use std::collections::BTreeSet;

use anyhow::Result;
use enact::motion::{DropReason, Scene, Stamp, TakeEvent, Verdict};
use enact::segment::clean::clean;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Outliers, Style, Truth, bounces};

/// Runs them all.
pub fn run(options: &Options) -> Result<()> {
    false_alarms(options)?;
    outliers(options)?;
    proposals(options)?;
    marks_off(options)?;
    marks_absent(options)?;
    units(options)
}

/// The motions that are damaged.
pub fn motions(seed: u64, cubes: &[usize]) -> Vec<(String, Truth)> {
    let mut motions: Vec<(String, Truth)> = Style::ALL
        .iter()
        .map(|style| (style.as_str().to_owned(), style.truth()))
        .collect();
    for count in cubes {
        if let Ok(truth) = bounces(*count, seed) {
            motions.push((format!("cube, {count} bounces"), truth));
        }
    }
    motions
}

/// How the hand is known to move: with stamps that are physical times, and without.
fn ways() -> [(&'static str, Acting); 2] {
    [
        ("known", Acting::timing_known()),
        ("unknown", Acting::default()),
    ]
}

/// Good samples that are left out of performances without outliers.
fn false_alarms(options: &Options) -> Result<()> {
    #[derive(Serialize)]
    struct Row {
        motion: String,
        timing: &'static str,
        distortion: f64,
        noise: bool,
        samples: usize,
        dropped: usize,
    }
    let mut rows: Vec<Row> = Vec::new();
    for seed in options.range() {
        for (motion, truth) in motions(seed, &[20]) {
            for (timing, acting) in ways() {
                for (distortion, noise) in [(1.0, false), (4.0, false), (8.0, false), (1.0, true)] {
                    let mut acting = Acting {
                        distortion,
                        ..acting
                    };
                    if noise {
                        acting.noise_position_m = 0.01;
                        acting.noise_orientation_rad = 3_f64.to_radians();
                    }
                    let case = Case::new(&truth, &acting, seed);
                    let Ok((_, counts)) = clean(case.scene(), &case.performance.events) else {
                        continue;
                    };
                    let dropped = counts.dropped.get(&DropReason::Outlier);
                    let key = (&motion, timing, distortion, noise);
                    let at = rows.iter().position(|row| {
                        (&row.motion, row.timing, row.distortion, row.noise) == key
                    });
                    let at = at.unwrap_or_else(|| {
                        rows.push(Row {
                            motion: motion.clone(),
                            timing,
                            distortion,
                            noise,
                            samples: 0,
                            dropped: 0,
                        });
                        rows.len() - 1
                    });
                    rows[at].samples += counts.read;
                    rows[at].dropped += dropped.copied().unwrap_or(0);
                }
            }
        }
    }
    let mut table = Table::new(
        "Good samples taken for outliers",
        &[
            "motion",
            "timing",
            "distortion",
            "noise",
            "samples",
            "dropped",
        ],
    );
    for row in &rows {
        table.row([
            row.motion.clone(),
            row.timing.to_owned(),
            format!("{}×", row.distortion),
            if row.noise {
                "10 mm, 3°"
            } else {
                "0.5 mm, 0.3°"
            }
            .to_owned(),
            row.samples.to_string(),
            row.dropped.to_string(),
        ]);
    }
    options.show(&table);
    options.write_json("damage_false_alarms", &rows)
}

/// What is found of outliers, and what the estimate becomes.
fn outliers(options: &Options) -> Result<()> {
    #[derive(Serialize, Default)]
    struct Row {
        motion: String,
        timing: &'static str,
        share: f64,
        good: usize,
        bad: usize,
        found: usize,
        false_alarms: usize,
        takes: usize,
        physical: usize,
        physical_without: usize,
        moved_mm: Vec<f64>,
        outliers_us: Vec<f64>,
    }
    let mut rows = Vec::new();
    for (timing, acting) in ways() {
        for share in [0.0, 0.01, 0.05, 0.2] {
            let mut of_motion: Vec<Row> = Vec::new();
            for seed in options.range() {
                for (index, (motion, truth)) in motions(seed, &[4]).into_iter().enumerate() {
                    if of_motion.len() <= index {
                        of_motion.push(Row {
                            motion,
                            timing,
                            share,
                            ..Row::default()
                        });
                    }
                    let row = &mut of_motion[index];
                    let good = Case::new(&truth, &acting, seed);
                    let damaged = Acting {
                        outliers: (share > 0.0).then(|| Outliers::of_share(share)),
                        ..acting
                    };
                    let case = Case::new(&truth, &damaged, seed);
                    let bad = differing(&good.performance.events, &case.performance.events);
                    let without = Scene {
                        timing: enact::motion::Timing::Edited,
                        ..case.scene().clone()
                    };
                    let events = &case.performance.events;
                    row.outliers_us
                        .push(clean_us(case.scene(), events) - clean_us(&without, events));
                    let Ok((sketch, counts)) = clean(case.scene(), &case.performance.events) else {
                        continue;
                    };
                    let kept: BTreeSet<Stamp> =
                        sketch.bodies[0].samples.iter().map(|s| s.stamp).collect();
                    let missed = bad.intersection(&kept).count();
                    let dropped = counts
                        .dropped
                        .get(&DropReason::Outlier)
                        .copied()
                        .unwrap_or(0);
                    // Before the start and after the end nothing is known of what was found.
                    let found = bad.len() - missed;
                    row.bad += bad.len();
                    row.good += counts.read - bad.len();
                    row.found += found;
                    row.false_alarms += dropped.saturating_sub(found);
                    let (Ok(with), Ok(without)) =
                        (case.estimated(&mut ()), good.estimated(&mut ()))
                    else {
                        row.takes += 1;
                        continue;
                    };
                    row.takes += 1;
                    row.physical += usize::from(with.estimate.verdict == Verdict::Physical);
                    row.physical_without +=
                        usize::from(without.estimate.verdict == Verdict::Physical);
                    let arcs = with.estimate.arcs.iter().zip(&without.estimate.arcs);
                    let moved = arcs.map(|(a, b)| {
                        let middle_s = 0.5 * (b.start_s + b.end_s);
                        let at = |arc: &enact::motion::ArcEstimate| {
                            enact::physics::flow::advance(
                                &case.scene().bodies[arc.body].body,
                                &with.estimate.gravity_m_s2,
                                &arc.state,
                                middle_s - arc.epoch_s,
                            )
                            .position_m
                        };
                        (at(a) - at(b)).norm()
                    });
                    row.moved_mm.push(1e3 * moved.fold(0.0, f64::max));
                }
            }
            rows.extend(of_motion);
        }
    }
    let mut table = Table::new(
        "Outliers: 5 cm to 3 m, 20° to 180°, in bursts of 1 to 3",
        &[
            "motion",
            "timing",
            "share",
            "found",
            "false alarms",
            "physical",
            "without",
            "moved, median [mm]",
            "95 % [mm]",
            "takes [µs]",
        ],
    );
    for row in &rows {
        table.row([
            row.motion.clone(),
            row.timing.to_owned(),
            format!("{} %", 100.0 * row.share),
            percent(row.found, row.bad),
            format!("{} of {}", row.false_alarms, row.good),
            percent(row.physical, row.takes),
            percent(row.physical_without, row.takes),
            number(median(&row.moved_mm)),
            number(quantile(&row.moved_mm, 0.95)),
            number(median(&row.outliers_us)),
        ]);
    }
    options.show(&table);
    options.write_json("damage_outliers", &rows)
}

/// The least time of some runs. An edited sketch is not searched for outliers.
fn clean_us(scene: &Scene, events: &[TakeEvent]) -> f64 {
    let run = |_| {
        let begun = std::time::Instant::now();
        let _ = std::hint::black_box(clean(scene, events));
        begun.elapsed().as_secs_f64() * 1e6
    };
    (0..15).map(run).fold(f64::INFINITY, f64::min)
}

/// Stamps at which the second take has another pose than the first.
fn differing(first: &[TakeEvent], second: &[TakeEvent]) -> BTreeSet<Stamp> {
    let pairs = first.iter().zip(second);
    pairs
        .filter_map(|pair| match pair {
            (TakeEvent::Pose { sample: a, .. }, TakeEvent::Pose { sample: b, .. })
                if a.position_m != b.position_m || a.quaternion_xyzw != b.quaternion_xyzw =>
            {
                Some(b.stamp)
            }
            _ => None,
        })
        .collect()
}

/// How near proposals are to the collisions, and how sure.
fn proposals(options: &Options) -> Result<()> {
    #[derive(Serialize, Default)]
    struct Row {
        motion: String,
        timing: &'static str,
        distortion: f64,
        variant: &'static str,
        collisions: usize,
        near: usize,
        takes: usize,
        all_near: usize,
        score_of_near: Vec<f64>,
        score_of_far: Vec<f64>,
        time_us: Vec<f64>,
    }
    let mut rows: Vec<Row> = Vec::new();
    for (timing, acting) in ways() {
        for distortion in [1.0, 2.0, 4.0] {
            for variant in VARIANTS {
                let first = rows.len();
                for seed in options.range() {
                    for (index, (motion, truth)) in
                        motions(seed, &[2, 4, 6]).into_iter().enumerate()
                    {
                        if rows.len() <= first + index {
                            rows.push(Row {
                                motion,
                                timing,
                                distortion,
                                variant,
                                ..Row::default()
                            });
                        }
                        let row = &mut rows[first + index];
                        let acting = Acting {
                            distortion,
                            ..acting
                        };
                        let case = Case::new(&truth, &acting, seed);
                        let sketch = case.performance.sketch();
                        let scene = varied(case.scene(), variant);
                        let begun = std::time::Instant::now();
                        let proposals = enact::segment::propose(&scene, &sketch, None);
                        row.time_us.push(begun.elapsed().as_secs_f64() * 1e6);
                        let mut all_near = true;
                        for proposal in &proposals {
                            let event = proposal.event.expect("of the scene");
                            let true_s = case.performance.tempo.acted_s(truth.event_times_s[event]);
                            let off = (proposal.acted_s - true_s).abs() * acting.rate_hz;
                            let is_near = off <= 8.5;
                            all_near &= is_near;
                            row.collisions += 1;
                            row.near += usize::from(is_near);
                            if is_near {
                                row.score_of_near.push(proposal.score);
                            } else {
                                row.score_of_far.push(proposal.score);
                            }
                        }
                        row.takes += 1;
                        row.all_near += usize::from(all_near);
                    }
                }
            }
        }
    }
    let mut table = Table::new(
        "Proposals without marks: within eight samples of the collision",
        &[
            "motion",
            "timing",
            "distortion",
            "variant",
            "near",
            "all near",
            "score near, 10 %",
            "50 %",
            "far, 50 %",
            "90 %",
            "time [µs]",
        ],
    );
    for row in &rows {
        table.row([
            row.motion.clone(),
            row.timing.to_owned(),
            format!("{}×", row.distortion),
            row.variant.to_owned(),
            percent(row.near, row.collisions),
            percent(row.all_near, row.takes),
            number(quantile(&row.score_of_near, 0.1)),
            number(median(&row.score_of_near)),
            number(median(&row.score_of_far)),
            number(quantile(&row.score_of_far, 0.9)),
            number(median(&row.time_us)),
        ]);
    }
    options.show(&table);
    options.write_json("damage_proposals", &rows)
}

/// What proposals may know.
const VARIANTS: [&str; 3] = ["all", "no touch", "no turns"];

fn varied(scene: &Scene, variant: &str) -> Scene {
    let mut scene = scene.clone();
    match variant {
        "no touch" => {
            for event in &mut scene.events {
                if let enact::motion::EventKind::Collision(collision) = &mut event.kind {
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
fn marks_off(options: &Options) -> Result<()> {
    #[derive(Serialize, Default)]
    struct Row {
        motion: String,
        timing: &'static str,
        distortion: f64,
        off: f64,
        takes: usize,
        refined: usize,
        relocated: usize,
        changed: usize,
        refine_us: Vec<f64>,
        relocate_us: Vec<f64>,
    }
    let mut rows: Vec<Row> = Vec::new();
    for (timing, acting) in ways() {
        for distortion in [1.0, 4.0] {
            for off in [0.0, 5.0, 20.0, 50.0] {
                let first = rows.len();
                for seed in options.range() {
                    for (index, (motion, truth)) in motions(seed, &[4]).into_iter().enumerate() {
                        if rows.len() <= first + index {
                            rows.push(Row {
                                motion,
                                timing,
                                distortion,
                                off,
                                ..Row::default()
                            });
                        }
                        let row = &mut rows[first + index];
                        let acting = Acting {
                            distortion,
                            ..acting
                        };
                        let case = Case::new(&truth, &acting, seed);
                        let scene = case.scene();
                        let mut sketch = case.performance.sketch();
                        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
                        let times_s: Vec<f64> = truth
                            .event_times_s
                            .iter()
                            .map(|time_s| case.performance.tempo.acted_s(*time_s))
                            .collect();
                        let last_s = sketch.bodies[0].samples.last().map_or(0.0, |s| s.acted_s);
                        for (event, time_s) in times_s.iter().enumerate() {
                            sketch.marks_s[event] = *time_s;
                            if scene.events[event].kind.collision().is_some() {
                                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                                let late_s = sign * off / acting.rate_hz;
                                sketch.marks_s[event] = (time_s + late_s).clamp(0.0, last_s);
                            }
                        }
                        let end = sketch.marks_s.len() - 1;
                        sketch.marks_s[..end].sort_by(f64::total_cmp);
                        let is_near = |sketch: &enact::motion::Sketch| {
                            sketch.marks_s[..end]
                                .iter()
                                .zip(&times_s)
                                .all(|(mark_s, time_s)| {
                                    (mark_s - time_s).abs() * acting.rate_hz <= 8.5
                                })
                        };
                        let begun = std::time::Instant::now();
                        enact::segment::refine(scene, &mut sketch);
                        row.refine_us.push(begun.elapsed().as_secs_f64() * 1e6);
                        row.refined += usize::from(is_near(&sketch));
                        let begun = std::time::Instant::now();
                        let moved = enact::segment::relocate_marks(scene, &mut sketch);
                        row.relocate_us.push(begun.elapsed().as_secs_f64() * 1e6);
                        if !moved.is_empty() {
                            enact::segment::refine(scene, &mut sketch);
                        }
                        row.changed += usize::from(!moved.is_empty());
                        row.relocated += usize::from(is_near(&sketch));
                        row.takes += 1;
                    }
                }
            }
        }
    }
    let mut table = Table::new(
        "Marks that are off: takes with all marks within eight samples",
        &[
            "motion",
            "timing",
            "distortion",
            "off by",
            "refined",
            "and relocated",
            "changed",
            "refine [µs]",
            "relocate [µs]",
        ],
    );
    for row in &rows {
        table.row([
            row.motion.clone(),
            row.timing.to_owned(),
            format!("{}×", row.distortion),
            format!("± {}", row.off),
            percent(row.refined, row.takes),
            percent(row.relocated, row.takes),
            row.changed.to_string(),
            number(median(&row.refine_us)),
            number(median(&row.relocate_us)),
        ]);
    }
    options.show(&table);
    options.write_json("damage_marks_off", &rows)
}

/// Takes through the pipeline without marks, with one less, with one more.
fn marks_absent(options: &Options) -> Result<()> {
    #[derive(Serialize)]
    struct Row {
        motion: String,
        timing: &'static str,
        distortion: f64,
        marks: &'static str,
        takes: usize,
        estimated: usize,
        near: usize,
        physical: usize,
    }
    let mut rows: Vec<Row> = Vec::new();
    for (timing, acting) in ways() {
        for distortion in [1.0, 4.0] {
            for marks in ["none", "one less", "one more"] {
                let first = rows.len();
                for seed in options.range() {
                    for (index, (motion, truth)) in motions(seed, &[4]).into_iter().enumerate() {
                        if rows.len() <= first + index {
                            rows.push(Row {
                                motion,
                                timing,
                                distortion,
                                marks,
                                takes: 0,
                                estimated: 0,
                                near: 0,
                                physical: 0,
                            });
                        }
                        let row = &mut rows[first + index];
                        let acting = Acting {
                            distortion,
                            ..acting
                        };
                        let mut case = Case::new(&truth, &acting, seed);
                        let duration_s = case.performance.tempo.acted_duration_s();
                        change_marks(&mut case.performance.events, marks, seed, duration_s);
                        row.takes += 1;
                        let Ok(outcome) = case.estimated(&mut ()) else {
                            continue;
                        };
                        row.estimated += 1;
                        row.physical += usize::from(outcome.estimate.verdict == Verdict::Physical);
                        let tempo = &case.performance.tempo;
                        let pairs = outcome.sketch.marks_s.iter().zip(&truth.event_times_s);
                        let collisions = truth.event_times_s.len() - 1;
                        row.near += usize::from(pairs.take(collisions).all(|(mark_s, time_s)| {
                            (mark_s - tempo.acted_s(*time_s)).abs() * acting.rate_hz <= 8.5
                        }));
                    }
                }
            }
        }
    }
    let mut table = Table::new(
        "Marks that are absent or too many",
        &[
            "motion",
            "timing",
            "distortion",
            "marks",
            "estimated",
            "all near",
            "physical",
        ],
    );
    for row in &rows {
        table.row([
            row.motion.clone(),
            row.timing.to_owned(),
            format!("{}×", row.distortion),
            row.marks.to_owned(),
            percent(row.estimated, row.takes),
            percent(row.near, row.takes),
            percent(row.physical, row.takes),
        ]);
    }
    options.show(&table);
    options.write_json("damage_marks_absent", &rows)
}

/// No marks; one of a collision left out; or one more, anywhere.
fn change_marks(events: &mut Vec<TakeEvent>, marks: &str, seed: u64, duration_s: f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(2000 + seed);
    let at: Vec<usize> = (0..events.len())
        .filter(|index| matches!(events[*index], TakeEvent::Mark(_)))
        .collect();
    match marks {
        "none" => events.retain(|event| !matches!(event, TakeEvent::Mark(_))),
        "one less" => {
            events.remove(at[rng.random_range(0..at.len() - 1)]);
        }
        _ => {
            let late_s = duration_s * rng.random_range(0.05..0.95);
            let stamp = Stamp(enact_tools::perform::acting::START.0 + (late_s * 1e9) as i64);
            events.push(TakeEvent::Mark(enact::motion::Mark { stamp, event: None }));
        }
    }
}

/// What becomes of positions in another unit.
fn units(options: &Options) -> Result<()> {
    let mut table = Table::new(
        "Positions times a factor",
        &[
            "motion", "timing", "factor", "refused", "failed", "physical", "error",
        ],
    );
    for (timing, acting) in ways() {
        for factor in [0.001, 0.01, 0.1, 10.0, 100.0, 1000.0] {
            let mut names: Vec<String> = Vec::new();
            let mut counts: Vec<[usize; 4]> = Vec::new();
            let mut errors: Vec<String> = Vec::new();
            for seed in options.range().take(20) {
                for (index, (motion, truth)) in motions(seed, &[4]).into_iter().enumerate() {
                    if names.len() <= index {
                        names.push(motion);
                        counts.push([0; 4]);
                        errors.push(String::new());
                    }
                    let mut case = Case::new(&truth, &acting, seed);
                    for event in &mut case.performance.events {
                        if let TakeEvent::Pose { sample, .. } = event {
                            sample.position_m *= factor;
                        }
                    }
                    counts[index][3] += 1;
                    match case.estimated(&mut ()) {
                        Err(error) => {
                            counts[index][0] += 1;
                            errors[index] = error.to_string();
                        }
                        Ok(outcome) => {
                            let is_physical = outcome.estimate.verdict == Verdict::Physical;
                            counts[index][if is_physical { 2 } else { 1 }] += 1;
                        }
                    }
                }
            }
            for ((name, count), error) in names.into_iter().zip(&counts).zip(errors) {
                table.row([
                    name,
                    timing.to_owned(),
                    factor.to_string(),
                    percent(count[0], count[3]),
                    percent(count[1], count[3]),
                    percent(count[2], count[3]),
                    error,
                ]);
            }
        }
    }
    options.show(&table);
    Ok(())
}
