//! What is found of outliers, what is left out for nothing, and what the estimate becomes.

use std::collections::BTreeSet;
use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use enact::motion::{
    ArcEstimate, DropReason, Scene, Stamp, TakeEvent, Timing, TrackIndex, Verdict,
};
use enact::pipeline::Outcome;
use enact::segment::clean::clean;
use serde_json::json;

use super::{HEAD, Kind, kinds};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Outliers};

/// Good samples that are left out of performances without outliers.
pub fn false_alarms(options: &Options, record: &mut Record) -> Result<()> {
    let header = [&HEAD[..], &["noise", "samples", "dropped"]].concat();
    let mut table = Table::new("false_alarms", "Good samples taken for outliers", &header);
    let mut numbers = Vec::new();
    let noisy = kinds(&[20], &[1.0]).into_iter().map(|mut kind| {
        kind.acting.noise_position_m = 0.01;
        kind.acting.noise_orientation_rad = 3_f64.to_radians();
        ("10 mm, 3°", kind)
    });
    let quiet = kinds(&[20], &[1.0, 4.0, 8.0]).into_iter();
    for (noise, kind) in quiet.map(|kind| ("0.5 mm, 0.3°", kind)).chain(noisy) {
        let (mut samples, mut dropped) = (0, 0);
        for (_, case) in kind.cases(options) {
            if let Ok((_, counts)) = clean(case.scene(), &case.performance.events) {
                samples += counts.read;
                dropped += counts
                    .dropped
                    .get(&DropReason::Outlier)
                    .copied()
                    .unwrap_or(0);
            }
        }
        let cells = [noise.to_owned(), samples.to_string(), dropped.to_string()];
        table.row(kind.cells().into_iter().chain(cells));
        numbers.push(
            json!({"kind": kind.cells(), "noise": noise, "samples": samples, "dropped": dropped}),
        );
    }
    record.table(table);
    record.numbers("false_alarms", &numbers)
}

/// What became of the takes of a row.
#[derive(Default)]
struct Row {
    good: usize,
    bad: usize,
    found: usize,
    false_alarms: usize,
    takes: usize,
    /// With the outliers, and without.
    physical: [usize; 2],
    moved_mm: Vec<f64>,
    outliers_us: Vec<f64>,
}

/// What is found of outliers, and how far they move the estimate.
pub fn found(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        &HEAD[..],
        &[
            "share",
            "found",
            "false alarms",
            "physical",
            "without",
            "moved, median [mm]",
            "95 % [mm]",
            "takes [µs]",
        ],
    ]
    .concat();
    let title = "Outliers: 5 cm to 3 m, 20° to 180°, in bursts of 1 to 3";
    let mut table = Table::new("outliers", title, &header);
    let mut numbers = Vec::new();
    for share in [0.0, 0.01, 0.05, 0.2] {
        for kind in kinds(&[4], &[1.0]) {
            let row = row(kind, share, options);
            let shown = format!("{} %", 100.0 * share);
            table.row(kind.cells().into_iter().chain([
                shown,
                percent(row.found, row.bad),
                format!("{} of {}", row.false_alarms, row.good),
                percent(row.physical[0], row.takes),
                percent(row.physical[1], row.takes),
                number(median(&row.moved_mm)),
                number(quantile(&row.moved_mm, 0.95)),
                number(median(&row.outliers_us)),
            ]));
            numbers.push(json!({
                "kind": kind.cells(), "share": share, "good": row.good, "bad": row.bad, "found": row.found,
                "false_alarms": row.false_alarms, "takes": row.takes, "physical": row.physical,
                "moved_mm": row.moved_mm, "outliers_us": row.outliers_us,
            }));
        }
    }
    record.table(table);
    record.numbers("outliers", &numbers)
}

fn row(kind: Kind, share: f64, options: &Options) -> Row {
    let mut row = Row::default();
    let damaged = Acting {
        outliers: (share > 0.0).then(|| Outliers::of_share(share)),
        ..kind.acting
    };
    for (seed, good) in kind.cases(options) {
        let case = Case::new(&good.performance.truth, &damaged, seed);
        row.add(&good, &case);
    }
    row
}

impl Row {
    fn add(&mut self, good: &Case, case: &Case) {
        let events = &case.performance.events;
        let bad = differing(&good.performance.events, events);
        // An edited sketch is not searched for outliers.
        let unsearched = Scene {
            timing: Timing::Edited,
            ..case.scene().clone()
        };
        let us = |scene: &Scene| clean_us(scene, events);
        self.outliers_us.push(us(case.scene()) - us(&unsearched));
        let Ok((sketch, counts)) = clean(case.scene(), events) else {
            return;
        };
        let kept: BTreeSet<Stamp> = sketch.tracks[TrackIndex(0)]
            .samples
            .iter()
            .map(|s| s.stamp)
            .collect();
        let dropped = counts
            .dropped
            .get(&DropReason::Outlier)
            .copied()
            .unwrap_or(0);
        // Before the start and after the end nothing is known of what was found.
        let found = bad.len() - bad.intersection(&kept).count();
        self.bad += bad.len();
        self.good += counts.read - bad.len();
        self.found += found;
        self.false_alarms += dropped.saturating_sub(found);
        self.takes += 1;
        if let (Ok(with), Ok(without)) = (case.estimated(&mut ()), good.estimated(&mut ())) {
            let is_physical = |outcome: &Outcome| outcome.estimate.verdict == Verdict::Physical;
            self.physical[0] += usize::from(is_physical(&with));
            self.physical[1] += usize::from(is_physical(&without));
            self.moved_mm.push(1e3 * apart_m(case, &with, &without));
        }
    }
}

/// Largest distance of two estimates at the middle of the second's flights \[m\].
fn apart_m(case: &Case, with: &Outcome, without: &Outcome) -> f64 {
    let arcs = with.estimate.arcs.iter().zip(&without.estimate.arcs);
    let apart = arcs.map(|(a, b)| {
        let middle_s = 0.5 * (b.start_s + b.end_s);
        let at = |arc: &ArcEstimate| {
            let flown = case
                .scene()
                .flown(arc, &with.estimate.gravity_m_s2, middle_s);
            flown.position_m
        };
        (at(a) - at(b)).norm()
    });
    apart.fold(0.0, f64::max)
}

/// The least time of some runs.
fn clean_us(scene: &Scene, events: &[TakeEvent]) -> f64 {
    let run = |_| {
        let begun = Instant::now();
        let _ = black_box(clean(scene, events));
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
