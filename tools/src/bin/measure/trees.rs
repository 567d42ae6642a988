//! Integrators of trees: work against precision, drift of the energy, and what derivatives cost.

mod cases;
mod collocation;
mod library;
mod lie;
mod methods;
mod show;
mod system;

use std::hint::black_box;

use anyhow::Result;
use enact::physics::tree::tableau::{BUTCHER, DORMAND_PRINCE, Tableau};
use enact::physics::tree::{Flow, TreeState};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::flow::time_s;
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use cases::{Case, Kinds};
use methods::{METHODS, Ready, Setting, Way};
use show::Cost;

/// Motions of each kind.
const SEEDS: u64 = 5;
/// Steps of the reference, and of an implicit method that says how good it is.
const REFERENCE: usize = 16384;
const CHECK: usize = 4096;
/// Samples per second that the estimator stops at, and its longest turn in a step \[rad\].
const SAMPLES_HZ: f64 = 120.0;
const STEP_RAD: f64 = 0.25;
/// How often plain flows and those with derivatives are timed.
const TURNS: usize = 3;
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

/// A method of the program in the steps that the estimator makes: medians.
#[derive(Serialize)]
pub struct Steps {
    error: f64,
    drift: f64,
    plain_s: f64,
    derived_s: f64,
    /// Of the two times, seed by seed.
    ratio: f64,
}

/// Both that the estimator has.
#[derive(Serialize)]
pub struct Derived {
    order_8: Steps,
    order_6: Steps,
}

/// What was measured of a kind.
#[derive(Serialize)]
pub struct Measured {
    name: String,
    title: String,
    duration_s: f64,
    /// Greatest difference of the two references.
    reference: f64,
    /// Median.
    steps: f64,
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
        let Derived { order_8, order_6 } = &chain.derived;
        record.say(format!(
            "The chain's flow with its {} directions costs {:.1} plain integrations with the method of order 8 and {:.1} with that of order 6.",
            chain.directions,
            order_8.ratio, order_6.ratio,
        ));
    }
    record.table(show::program(&all));
    record.table(show::reach(&all, 1e-6, "reach_6"));
    record.table(show::reach(&all, 1e-10, "reach_10"));
    record.numbers("trees", &all)
}

fn flown(case: &Case, tableau: Tableau, steps: usize) -> TreeState {
    let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, tableau);
    flow.begin(&case.start, false);
    flow.advance(case.duration_s, steps, 0.0);
    flow.state()
}

/// How many steps the estimator makes: from sample to sample, none longer than its rule says.
fn steps(case: &Case) -> usize {
    let samples = (case.duration_s * SAMPLES_HZ).round() as usize;
    let flight = case.tree.freedoms() - case.tree.angular_freedoms();
    let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, DORMAND_PRINCE);
    flow.begin(&case.start, false);
    let mut fastest_rad_s = 0.0_f64;
    for _ in 0..=samples {
        let state = flow.state();
        let rates = state.rates[flight..].iter();
        fastest_rad_s = rates.fold(fastest_rad_s, |most, rate| most.max(rate.abs()));
        flow.advance(1.0 / SAMPLES_HZ, 8, 0.0);
    }
    samples * (fastest_rad_s / SAMPLES_HZ / STEP_RAD).ceil().max(1.0) as usize
}

/// A motion with its reference.
struct Known {
    case: Case,
    end: TreeState,
    uncertain: f64,
    steps: usize,
    energy_j: [f64; 2],
}

impl Known {
    fn of(case: Case) -> Self {
        let end = flown(&case, DORMAND_PRINCE, REFERENCE);
        let half = flown(&case, DORMAND_PRINCE, REFERENCE / 2);
        let mut check = Ready::new(&case, Way::Gauss(4));
        let check = check.run(Setting::Steps(CHECK)).map(|(end, _)| end);
        let others = [Some(half), check].into_iter().flatten();
        let uncertain = others.fold(0.0, |most, other| case.apart(&other, &end).max(most));
        let (steps, energy_j) = (steps(&case), case.energy_j(&case.start));
        Self {
            case,
            end,
            uncertain,
            steps,
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
        steps: median(&all(&|one| one.steps as f64)),
        directions: 2 * known[0].case.tree.freedoms() + 1,
        derived: Derived {
            order_8: derived(&known, DORMAND_PRINCE, options.quick),
            order_6: derived(&known, BUTCHER, options.quick),
        },
        points,
    }
}

fn point(name: &str, way: Way, setting: Setting, known: &[Known], quick: bool) -> Point {
    let mut of = [(); 4].map(|()| Vec::new());
    for one in known {
        let mut ready = Ready::new(&one.case, way);
        let Some((end, right_sides)) = ready.run(setting) else {
            continue;
        };
        let [fastest_s, _] = time_s(quick, || {
            black_box(ready.run(black_box(setting)));
        });
        let error = one.case.apart(&end, &one.end);
        let numbers = [error, one.drift(&end), right_sides as f64, fastest_s];
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
        failures: known.len() - of[0].len(),
    }
}

fn derived(known: &[Known], tableau: Tableau, quick: bool) -> Steps {
    let mut of = [(); 5].map(|()| Vec::new());
    for one in known {
        let case = &one.case;
        let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, tableau);
        let size = 2 * case.tree.freedoms();
        let mut jacobian = DMatrix::zeros(size, size + 1);
        let mut timed = |has_derivatives: bool| {
            time_s(quick, || {
                flow.begin(black_box(&case.start), has_derivatives);
                flow.advance(case.duration_s, one.steps, f64::from(has_derivatives));
                black_box(flow.state());
                if has_derivatives {
                    flow.jacobian(&mut jacobian);
                    black_box(&jacobian);
                }
            })[0]
        };
        // In turns, for what else the machine does.
        let (mut plain_s, mut derived_s) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..TURNS {
            plain_s = plain_s.min(timed(false));
            derived_s = derived_s.min(timed(true));
        }
        let end = flown(case, tableau, one.steps);
        let numbers = [
            case.apart(&end, &one.end),
            one.drift(&end),
            plain_s,
            derived_s,
            derived_s / plain_s,
        ];
        for (to, number) in of.iter_mut().zip(numbers) {
            to.push(number);
        }
    }
    let [error, drift, plain_s, derived_s, ratio] = of.each_ref().map(|numbers| median(numbers));
    Steps {
        error,
        drift,
        plain_s,
        derived_s,
        ratio,
    }
}
