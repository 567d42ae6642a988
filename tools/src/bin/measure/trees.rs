//! Integrators of trees: work against precision, drift of the energy, and what derivatives cost.

mod cases;
mod collocation;
mod derived;
mod library;
mod lie;
mod methods;
mod show;
mod system;

use std::hint::black_box;

use anyhow::Result;
use enact::physics::tree::TreeState;
use enact::physics::tree::tableau::DORMAND_PRINCE;
use serde::Serialize;

use crate::flow::time_s;
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use cases::{Case, Kinds};
use derived::Derived;
use methods::{METHODS, Ready, Setting, Way};
use show::Cost;

/// Motions of each kind.
const SEEDS: u64 = 5;
/// Steps of the reference, and of an implicit method that says how good it is.
const REFERENCE: usize = 16384;
const CHECK: usize = 4096;
/// Error, and drift, of what is worse or does not end.
const WORST: f64 = 10.0;
/// Kinds that are drawn.
const DRAWN: [&str; 5] = [
    "chain",
    "universal_3",
    "ball_5",
    "chain_fast",
    "ball_3_fast",
];

/// A method in one setting: medians over the seeds.
#[derive(Serialize)]
pub struct Point {
    method: String,
    setting: String,
    error: f64,
    drift: f64,
    right_sides: f64,
    seconds: f64,
    /// Seeds at which it does not get to the end.
    failures: usize,
}

/// What was measured of a kind.
#[derive(Serialize)]
pub struct Measured {
    name: String,
    title: String,
    duration_s: f64,
    /// Greatest difference of the two references.
    reference: f64,
    directions: usize,
    derived: Derived,
    points: Vec<Point>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut all = Vec::new();
    for kinds in cases::all() {
        if !options.wants(kinds.title) {
            continue;
        }
        let measured = measured(&kinds, options);
        if DRAWN.contains(&kinds.name) {
            record.figure(show::precision(&measured, Cost::Time));
            record.figure(show::precision(&measured, Cost::RightSides));
            record.figure(show::drift(&measured));
        }
        eprintln!("  {}", kinds.title);
        all.push(measured);
    }
    if let Some(chain) = all.iter().find(|measured| measured.name == "chain") {
        let Derived { exact, rough } = &chain.derived;
        record.say(format!(
            "The chain's flow with its {} directions, told at every sample, costs {:.1} plain ones in the steps of what is kept and {:.1} in those on the way.",
            chain.directions, exact.ratio, rough.ratio,
        ));
    }
    record.table(show::program(&all));
    record.table(show::reach(&all, 1e-6, "reach_6"));
    record.table(show::reach(&all, 1e-10, "reach_10"));
    record.numbers("trees", &all)
}

/// A motion with its reference.
struct Known {
    case: Case,
    end: TreeState,
    uncertain: f64,
    energy_j: [f64; 2],
}

impl Known {
    fn of(case: Case) -> Self {
        let end = case.flown(DORMAND_PRINCE, REFERENCE);
        let half = case.flown(DORMAND_PRINCE, REFERENCE / 2);
        let mut check = Ready::new(&case, Way::Gauss(4));
        let check = check.run(Setting::Steps(CHECK)).0;
        let others = [Some(half), check].into_iter().flatten();
        let uncertain = others.fold(0.0, |most, other| case.apart(&other, &end).max(most));
        let energy_j = case.energy_j(&case.start);
        Self {
            case,
            end,
            uncertain,
            energy_j,
        }
    }

    fn drift(&self, end: &TreeState) -> f64 {
        let [energy_j, kinetic_j] = self.energy_j;
        (self.case.energy_j(end)[0] - energy_j).abs() / kinetic_j
    }
}

fn measured(kinds: &Kinds, options: &Options) -> Measured {
    let known: Vec<Known> = options
        .seeds(SEEDS)
        .map(|seed| Known::of(kinds.case(seed)))
        .collect();
    let mut points = Vec::new();
    for (name, way) in METHODS {
        for setting in way.settings(options.quick) {
            points.push(point(name, way, setting, &known, options.quick));
        }
    }
    let all = |of: &dyn Fn(&Known) -> f64| known.iter().map(of).collect::<Vec<f64>>();
    Measured {
        name: kinds.name.to_owned(),
        title: kinds.title.to_owned(),
        duration_s: known[0].case.duration_s,
        reference: largest(&all(&|one| one.uncertain)),
        directions: 2 * known[0].case.tree.freedoms(),
        derived: Derived::of(&known, options.quick),
        points,
    }
}

fn point(name: &str, way: Way, setting: Setting, known: &[Known], quick: bool) -> Point {
    let mut of = [(); 4].map(|()| Vec::new());
    let mut failures = 0;
    for one in known {
        let mut ready = Ready::new(&one.case, way);
        let (end, right_sides) = ready.run(setting);
        failures += usize::from(end.is_none());
        let [fastest_s, _] = time_s(quick, || {
            black_box(ready.run(black_box(setting)));
        });
        let off = |of: &dyn Fn(&TreeState) -> f64| end.as_ref().map_or(WORST, of).min(WORST);
        let numbers = [
            off(&|end| one.case.apart(end, &one.end)),
            off(&|end| one.drift(end)),
            right_sides as f64,
            fastest_s,
        ];
        for (to, number) in of.iter_mut().zip(numbers) {
            to.push(number);
        }
    }
    let [error, drift, right_sides, seconds] = of.each_ref().map(|numbers| median(numbers));
    Point {
        method: name.to_owned(),
        setting: setting.name(),
        error,
        drift,
        right_sides,
        seconds,
        failures,
    }
}
