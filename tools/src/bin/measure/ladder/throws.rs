//! The ladder on throws whose truth is known.

use enact::math::Pose;
use enact::motion::{LinkIndex, Stamp, TrackIndex};
use enact_tools::case::estimated;
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::perform::{Acting, Truth};
use serde::Serialize;

use super::rungs::{Rung, freed};
use super::split::Split;
use super::step::Step;
use crate::options::Options;

/// Least number of samples of the last flight: half of them are held out.
const LEAST: usize = 12;
/// A hand's wander, in units of 20 mm and 8°.
const WANDER: f64 = 0.125;

/// What is wrong in the scenes: each is put right by another rung, or by none.
const WRONGS: [Wrong; 5] = [
    Wrong::Nothing,
    Wrong::Restitution,
    Wrong::Inertia,
    Wrong::TableHeight,
    Wrong::Drag,
];

/// What is held out, and how the throws are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Way {
    /// The later half of the last flight, seen with the tracker's noise;
    Later,
    /// the middle third of the first flight;
    Middle,
    /// the later half again, with a hand that wanders,
    Hand,
    /// and of throws with one bounce.
    Once,
}

impl Way {
    pub const ALL: [Self; 4] = [Self::Later, Self::Middle, Self::Hand, Self::Once];

    /// Of its table and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Later => "later",
            Self::Middle => "middle",
            Self::Hand => "hand",
            Self::Once => "once",
        }
    }

    /// Of its table.
    pub fn title(self) -> &'static str {
        match self {
            Self::Later => "The later half of the last flight held out",
            Self::Middle => "The middle third of the first flight held out",
            Self::Hand => "The later half held out, the hand wandering by 2.5 mm and 1°",
            Self::Once => "Throws with one bounce, the later half of the last flight held out",
        }
    }

    /// How many of a kind.
    fn throws(self) -> u64 {
        match self {
            Self::Later => 40,
            Self::Middle | Self::Hand => 24,
            Self::Once => 12,
        }
    }

    fn acting(self) -> Acting {
        Acting {
            distortion: if self == Self::Hand { WANDER } else { 0.0 },
            ..with_noise()
        }
    }

    fn split(self, asked: &Asked, truth: &Truth) -> Option<Split> {
        let arcs = [truth.arcs.first()?, truth.arcs.last()?];
        let [first, last] = arcs.map(|arc| (arc.start_s, arc.end_s));
        let rate_hz = self.acting().rate_hz;
        if (last.1 - last.0) * rate_hz < LEAST as f64 {
            return None;
        }
        let within = |(from_s, to_s): (f64, f64), share: f64| from_s + share * (to_s - from_s);
        Some(match self {
            Self::Later | Self::Hand | Self::Once => {
                Split::between(asked, within(last, 0.5), f64::INFINITY)
            }
            Self::Middle => {
                Split::between(asked, within(first, 1.0 / 3.0), within(first, 2.0 / 3.0))
            }
        })
    }
}

/// A throw seen with the tracker's noise alone: 0.5 mm and 0.29°.
pub fn with_noise() -> Acting {
    Acting {
        distortion: 0.0,
        noise_position_m: 0.0005,
        noise_orientation_rad: 0.29_f64.to_radians(),
        mark_error_s: 0.002,
        ..Acting::timing_known()
    }
}

/// The steps of all kinds of scenes: for each the rungs in their order, then what `--free auto` frees.
pub fn steps(way: Way, options: &Options) -> Vec<Vec<Step>> {
    let is_single = way == Way::Once || options.quick;
    let wrongs = WRONGS[..if is_single { 1 } else { WRONGS.len() }].iter();
    wrongs.map(|wrong| kind(*wrong, way, options)).collect()
}

fn kind(wrong: Wrong, way: Way, options: &Options) -> Vec<Step> {
    let kind = match wrong {
        Wrong::Nothing => "right",
        wrong => wrong.name(),
    };
    let names = ["nothing"].into_iter().chain(Rung::ALL.map(Rung::name));
    let names = names.chain(["as `auto` does"]);
    let mut steps: Vec<Step> = names.map(|name| Step::new(kind, name)).collect();
    let wanted = options.seeds(way.throws());
    let count = (wanted.end - wanted.start) as usize;
    let fitting = (wanted.start..).filter_map(|seed| throw(wrong, way, seed));
    for (truth, split) in fitting.take(count) {
        let zero = way.acting().start;
        let tracker = |stamp: Stamp| -> Pose {
            let body = truth.world_from_body(LinkIndex(0), stamp.seconds_since(zero));
            body * truth.scene.tracks[TrackIndex(0)].link_from_tracker
        };
        climb(&Rung::ALL, &mut steps, &split, Some(&tracker));
    }
    steps
}

/// The throw of a seed, if it has as many bounces as the way wants, and a long last flight.
fn throw(wrong: Wrong, way: Way, seed: u64) -> Option<(Truth, Split)> {
    let truth = wrong.truth(seed).ok()?;
    let bounces = if way == Way::Once { 1 } else { 2 };
    if truth.arcs.len() != bounces + 1 {
        return None;
    }
    let asked = wrong.asked(&way.acting(), seed).ok()?;
    let split = way.split(&asked, &truth)?;
    Some((truth, split))
}

/// Adds a take to every step: nothing free, one rung more each, and as `auto` does.
pub fn climb(
    rungs: &[Rung],
    steps: &mut [Step],
    split: &Split,
    truth: Option<&dyn Fn(Stamp) -> Pose>,
) {
    let kept = &split.kept;
    for (count, step) in (0..=rungs.len()).zip(steps.iter_mut()) {
        let scene = freed(&kept.scene, &rungs[..count]);
        step.add(split, &estimated(&scene, &kept.events, &mut ()), truth);
    }
    if let Some(last) = steps.last_mut() {
        last.add(split, &kept.freed(), truth);
    }
}
