//! What bad data do: outliers, positions in another unit, marks that are off or absent.

mod marks;
mod outliers;
mod units;

use anyhow::Result;

use crate::options::Options;
use crate::record::Record;
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, Truth, bounces};

/// Performances of a row.
const SEEDS: u64 = 20;
/// A mark is near its collision within so many samples.
const NEAR_SAMPLES: f64 = 8.5;

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    outliers::false_alarms(options, record)?;
    outliers::found(options, record)?;
    marks::proposed(options, record)?;
    marks::off(options, record)?;
    marks::absent(options, record)?;
    units::run(options, record);
    Ok(())
}

/// What is damaged.
#[derive(Clone, Copy)]
enum Motion {
    Pencil(Style),
    Cube(usize),
}

/// A motion, acted in one way.
#[derive(Clone, Copy)]
struct Kind {
    motion: Motion,
    timing: &'static str,
    acting: Acting,
}

/// Pencils and cubes with so many bounces, acted with stamps that are physical times and without,
/// each with these distortions.
fn kinds(cubes: &[usize], distortions: &[f64]) -> Vec<Kind> {
    let mut motions = Style::ALL.map(Motion::Pencil).to_vec();
    motions.extend(cubes.iter().map(|count| Motion::Cube(*count)));
    let mut kinds = Vec::new();
    for (timing, acting) in [
        ("known", Acting::timing_known()),
        ("unknown", Acting::default()),
    ] {
        for distortion in distortions.iter().copied() {
            let acting = Acting {
                distortion,
                ..acting
            };
            kinds.extend(motions.iter().map(|motion| Kind {
                motion: *motion,
                timing,
                acting,
            }));
        }
    }
    kinds
}

/// Head of the tables.
const HEAD: [&str; 3] = ["motion", "timing", "distortion"];

impl Kind {
    /// The head of a row.
    fn cells(&self) -> [String; 3] {
        let motion = match self.motion {
            Motion::Pencil(style) => style.as_str().to_owned(),
            Motion::Cube(count) => format!("cube, {count} bounces"),
        };
        [
            motion,
            self.timing.to_owned(),
            format!("{}×", self.acting.distortion),
        ]
    }

    fn truth(&self, seed: u64) -> Option<Truth> {
        match self.motion {
            Motion::Pencil(style) => Some(style.truth()),
            Motion::Cube(count) => bounces(count, seed).ok(),
        }
    }

    /// Performances of all seeds that have a motion.
    fn cases(self, options: &Options) -> impl Iterator<Item = (u64, Case)> {
        let seeds = options.seeds(SEEDS);
        seeds
            .filter_map(move |seed| Some((seed, Case::new(&self.truth(seed)?, &self.acting, seed))))
    }
}

/// Whether marks are within [`NEAR_SAMPLES`] of the collisions, in order.
fn are_near(case: &Case, marks_s: &[f64], rate_hz: f64) -> bool {
    let (truth, tempo) = (&case.performance.truth, &case.performance.tempo);
    let collisions = truth.event_times_s.len() - 1;
    let mut pairs = marks_s.iter().zip(&truth.event_times_s).take(collisions);
    pairs.all(|(mark_s, time_s)| (mark_s - tempo.acted_s(*time_s)).abs() * rate_hz <= NEAR_SAMPLES)
}
