//! Whether the intervals of what a scene may free hold the truth: in right scenes, and in one that is
//! wrong elsewhere.

use std::collections::BTreeMap;

use enact::motion::{Quantity, Scene, TrackIndex};
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::nonsense::{Asked, faults};
use enact_tools::perform::hat_box::HAT;

use super::Seen;
use crate::options::Options;
use crate::statistics::{median, rms};
use crate::table::{Table, number, percent};

/// Throws.
const SEEDS: u64 = 300;
/// Deviations within which an error is expected in 19 of 20.
const WITHIN: f64 = 1.96;

/// What only a motion of two bodies tells: of the hat's mass and its clock, beside those of the box.
const OF_TWO: [(&str, Quantity); 2] = [
    ("mass of one of two, factor", Quantity::Mass { link: HAT }),
    (
        "one of two clocks' offset, s",
        Quantity::ClockOffset {
            track: TrackIndex(0),
        },
    ),
];

/// Errors of a quantity over their deviations, and what became of the other throws.
#[derive(Default)]
struct Freed {
    ratios: Vec<f64>,
    sds: Vec<f64>,
    without: usize,
    at_bound: usize,
}

/// The table of the throws in which `wrong` is wrong: every quantity that such a scene may free, freed
/// with the others of its thing and nothing else. Where nothing is wrong, a hat and a box that meet
/// say how well what only two bodies tell is known.
pub fn table(wrong: Wrong, options: &Options) -> Table {
    let mut all: BTreeMap<&'static str, Freed> = BTreeMap::new();
    for seed in options.seeds(SEEDS) {
        if wrong == Wrong::Nothing {
            let right = faults::hat_and_box(&Seen::Noise(1.0).acting(), seed);
            for (kind, quantity) in OF_TWO {
                add(
                    all.entry(kind).or_default(),
                    &right,
                    &right.scene,
                    &[quantity],
                );
            }
        }
        let Ok(asked) = wrong.asked(&Seen::Noise(1.0).acting(), seed) else {
            continue;
        };
        // What is true is what the scene says where nothing is wrong.
        let Ok(right) = Wrong::Nothing.asked(&Seen::Noise(1.0).acting(), seed) else {
            continue;
        };
        for (kind, quantities) in things(&asked.scene, wrong) {
            add(
                all.entry(kind).or_default(),
                &asked,
                &right.scene,
                &quantities,
            );
        }
    }
    let header = [
        "freed",
        "estimates",
        "within 95 %",
        "rms error over sd",
        "median sd",
        "at a bound",
        "without a sd",
    ];
    let name = if wrong == Wrong::Nothing {
        "intervals"
    } else {
        "intervals_wrong"
    };
    let title = match wrong {
        Wrong::Nothing => "Intervals in right scenes".to_owned(),
        wrong => format!("Intervals where something else is wrong: {}", wrong.name()),
    };
    let mut table = Table::new(name, &title, &header);
    for (kind, freed) in all {
        let held = freed.ratios.iter().filter(|ratio| ratio.abs() <= WITHIN);
        table.row([
            kind.to_owned(),
            freed.ratios.len().to_string(),
            percent(held.count(), freed.ratios.len()),
            number(rms(&freed.ratios)),
            number(median(&freed.sds)),
            freed.at_bound.to_string(),
            freed.without.to_string(),
        ]);
    }
    table
}

fn add(freed: &mut Freed, asked: &Asked, right: &Scene, quantities: &[Quantity]) {
    let mut asked = asked.clone();
    let before = asked.scene.parameters.len();
    let given = quantities.iter().map(|q| (*q, asked.scene.value_of(*q)));
    asked.scene = asked.scene.with_free(&given.collect::<Vec<_>>());
    let Ok(outcome) = asked.answered() else {
        freed.without += quantities.len();
        return;
    };
    let found = outcome.estimate.parameters.iter().skip(before);
    for (found, quantity) in found.zip(quantities) {
        match found.sd {
            _ if found.at_bound.is_some() => freed.at_bound += 1,
            Some(sd) if sd > 0.0 => {
                let error = found.value - right.value_of(*quantity);
                freed.ratios.push(error / sd);
                freed.sds.push(sd);
            }
            _ => freed.without += 1,
        }
    }
}

/// What a scene may free beside what is wrong in it, component by component of one thing.
fn things(scene: &Scene, wrong: Wrong) -> Vec<(&'static str, Vec<Quantity>)> {
    let mut things: Vec<(&'static str, Vec<Quantity>)> = Vec::new();
    for quantity in scene.quantities() {
        let kind = match quantity {
            Quantity::Gravity { .. } => "gravity, m/s²",
            Quantity::Restitution { .. } => "restitution",
            Quantity::Friction { .. } => "friction",
            Quantity::Tilt { .. } => "tilt of an impact's normal, rad",
            Quantity::Force { .. } => "constant force, m/s²",
            Quantity::Moment { .. } => "moments, factor",
            Quantity::Centre { .. } => "centre of mass, m",
            Quantity::TrackerPosition { .. } => "tracker's position, m",
            Quantity::TrackerOrientation { .. } => "tracker's orientation, rad",
            Quantity::ClockRate { .. } => "clock's rate",
            Quantity::SurfaceHeight { .. } => "surface's height, m",
            Quantity::SurfaceTilt { .. } => "surface's tilt, rad",
            Quantity::LinearDrag { .. } => "linear drag, 1/s",
            Quantity::QuadraticDrag { .. } => "quadratic drag, 1/m",
            _ => continue,
        };
        if scene.untold(quantity).is_some() || wrong.is_of(quantity) {
            continue;
        }
        match things.iter_mut().find(|(other, _)| *other == kind) {
            Some((_, all)) => all.push(quantity),
            None => things.push((kind, vec![quantity])),
        }
    }
    things
}
