//! The ladder on real tosses: through the first impacts, the later half of the flight after them held
//! out.

use anyhow::Result;
use enact::motion::{PoseSample, Scene, Stamp};
use enact_tools::case::estimated;
use enact_tools::nonsense::Asked;
use enact_tools::tosses::{self, RATES_HZ, Toss};

use super::rungs::Rung;
use super::split::Split;
use super::step::{Step, closed};
use super::throws::climb;
use crate::options::Options;
use crate::tosses::bounce::{Setting, impact_name};
use crate::tosses::contacts::{Touched, contacts, first_impacts, orders};

/// Rungs that such a scene has: the cameras report the cube's centre, in axes of the cube. What one impact
/// does not tell apart comes last.
pub const RUNGS: [Rung; 7] = [
    Rung::Restitution,
    Rung::Friction,
    Rung::Moments,
    Rung::Gravity,
    Rung::Drag,
    Rung::Centre,
    Rung::Table,
];
/// Moment of inertia [kg m²], as others measured it; radius of the corners \[m\].
const CUBE: (f64, f64) = (8.1e-4, 0.005);
/// Restitution and friction as the data's authors give them.
const LAW: (f64, f64) = (0.125, 0.165);
/// Least number of samples of the flight after the impacts, of which half are held out.
const LEAST: f64 = 8.0;
/// Tosses of a quick run.
const QUICK: usize = 2;

/// The steps, and how many tosses there are of which such a flight is a part; `None` without the data.
pub fn steps(options: &Options) -> Result<Option<(Vec<Step>, usize)>> {
    let Some((_, tosses)) = tosses::all()? else {
        return Ok(None);
    };
    let setting = Setting::new(CUBE.0, CUBE.1)?;
    let names = ["nothing"].into_iter().chain(RUNGS.map(Rung::name));
    let names = names.chain(["as `auto` does"]);
    let mut steps: Vec<Step> = names.map(|name| Step::new("real tosses", name)).collect();
    let splits = tosses.iter().filter_map(|toss| split(&setting, toss));
    for split in splits.take(options.either(QUICK, usize::MAX)) {
        climb(&RUNGS, &mut steps, &split, None);
    }
    Ok(Some((steps, tosses.len())))
}

/// The first flight, the impacts that follow closely, and the flight after them, of which the later
/// half is held out; `None` where that is shorter than [`LEAST`].
fn split(setting: &Setting, toss: &Toss) -> Option<Split> {
    let heights_m = toss.poses.iter().map(|pose| setting.heights_m(pose));
    let all = contacts(&heights_m.collect::<Vec<_>>());
    let (impacts, end) = first_impacts(&all, toss.poses.len())?;
    let last = impacts.last()?.place;
    if end - last < LEAST {
        return None;
    }
    let samples = (end.ceil() as usize).min(toss.poses.len());
    let half = 0.5 * (last + end);
    let is_held = move |sample: &PoseSample| {
        let place = sample.stamp.seconds_since(Stamp(0)) * RATES_HZ[0];
        place > half
    };
    let asked = |impacts: &[Touched]| asked(setting, toss, (impacts, samples));
    let splits = orders(&impacts).into_iter().filter_map(|order| {
        let (law_free, split) = asked(&order)?;
        let split = Split::of(&split, is_held);
        Some((law_free, split))
    });
    let mut splits: Vec<(Scene, Split)> = splits.collect();
    // Which corner came first where samples do not tell: as a motion is found with the law free.
    let is_found = |(scene, split): &(Scene, Split)| {
        closed(&estimated(scene, &split.kept.events, &mut ())).is_some()
    };
    let found = splits.iter().position(is_found)?;
    Some(splits.swap_remove(found).1)
}

/// The scene with its law free, and with the law of the data's authors.
fn asked(
    setting: &Setting,
    toss: &Toss,
    (impacts, samples): (&[Touched], usize),
) -> Option<(Scene, Asked)> {
    let law_free = setting.with_impacts(impacts).ok()?;
    let mut scene = law_free.clone();
    scene.parameters.clear();
    for law in &mut scene.contact_laws {
        (law.restitution, law.friction) = LAW;
    }
    let names: Vec<String> = (0..impacts.len()).map(impact_name).collect();
    let places = impacts.iter().map(|impact| impact.place);
    let mut marks: Vec<(f64, &str)> = places.zip(names.iter().map(String::as_str)).collect();
    marks.push((samples as f64 - 1.0, "end"));
    let events = toss.take(RATES_HZ[0], samples, &marks);
    Some((law_free, Asked { scene, events }))
}
