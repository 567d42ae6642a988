//! Many starts for one problem: what the best known optimum is.

use enact::estimate::schedule::recipe::{self, Recipe};
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::optimise::Schedule;
use enact::physics::state::{StateTangent, part};
use enact::pipeline::Outcome;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::case::{Case, Posed};

/// Objectives closer than this, relative to the lower, are one optimum.
pub const SAME: f64 = 2e-5;
/// An objective below this is rounding: an exact performance.
pub const NO_COST: f64 = 1e-12;
/// Shaken versions of each start.
const SHAKEN: usize = 6;

/// Standard deviations of a shake of size one: position \[m\], orientation \[rad\], velocity [m/s],
/// angular velocity [rad/s]; event times \[s\]; logarithm of the tempo.
mod shake {
    pub const STATE: [f64; 4] = [0.03, 0.3, 0.3, 3.0];
    pub const EVENT_S: f64 = 0.01;
    pub const LOG_TEMPO: f64 = 0.1;
}

/// Where a solve starts, and how it goes on.
pub struct Start {
    /// For the account.
    pub name: String,
    /// From where.
    pub guess: Guess,
    /// How.
    pub recipe: Recipe,
}

/// An optimum.
pub struct Optimum {
    /// Sum of squared residuals.
    pub objective: f64,
    /// Which start led to it.
    pub start: String,
}

/// From the truth without the sweep: straight to the optimum it belongs to.
pub fn from_truth(true_guess: &Guess) -> Start {
    Start {
        name: "truth".into(),
        guess: true_guess.clone(),
        recipe: Recipe::of(Schedule {
            sweep_weights: Vec::new(),
            ..Schedule::default()
        }),
    }
}

/// The program's own starts; the truth with and without the sweep; both shaken; other sweeps.
pub fn starts(posed: &Posed, true_guess: &Guess, seed: u64) -> Vec<Start> {
    let start = |name: String, guess: &Guess, recipe: Recipe| Start {
        name,
        guess: guess.clone(),
        recipe,
    };
    let mut starts = vec![
        from_truth(true_guess),
        start("truth, swept".into(), true_guess, Recipe::default()),
    ];
    for (index, guess) in posed.guesses.iter().enumerate() {
        starts.push(start(format!("own {index}"), guess, Recipe::default()));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for (name, guess) in [("truth", true_guess), ("own", &posed.guesses[0])] {
        for index in 0..SHAKEN {
            let size = 0.5 * (1 + index) as f64;
            let guess = shaken(guess, size, posed.problem.times_are_unknown(), &mut rng);
            starts.push(start(
                format!("{name}, shaken {index}"),
                &guess,
                Recipe::default(),
            ));
        }
    }
    for (name, sweep_weights) in [
        ("no sweep", Vec::new()),
        ("coarse sweep", vec![1.0, 100.0]),
        ("slow sweep", vec![0.1, 1.0, 10.0, 100.0]),
        (
            "fine sweep",
            (0..9)
                .map(|k| 0.03 * 10f64.powf(0.5 * f64::from(k)))
                .collect(),
        ),
    ] {
        starts.push(start(
            format!("own, {name}"),
            &posed.guesses[0],
            patient(sweep_weights),
        ));
    }
    let slow = patient(vec![0.1, 1.0, 10.0, 100.0]);
    starts.push(start("truth, slow sweep".into(), true_guess, slow));
    starts
}

/// A recipe that spares no steps.
fn patient(sweep_weights: Vec<f64>) -> Recipe {
    Recipe {
        orientations_per_arc: usize::MAX,
        ..Recipe::of(Schedule {
            sweep_weights,
            sweep_steps: 30,
            gain: 1e-4,
            multiplier_weight: 100.0,
            finish_below: 0.02,
            ..Schedule::default()
        })
    }
}

/// A guess with everything a little off.
fn shaken(guess: &Guess, size: f64, times_are_unknown: bool, rng: &mut ChaCha8Rng) -> Guess {
    let mut normal = || -> f64 { StandardNormal.sample(rng) };
    let mut shaken = guess.clone();
    // A slower tempo about the first sample slows every speed.
    let factor = if times_are_unknown {
        (size * shake::LOG_TEMPO * normal()).exp()
    } else {
        1.0
    };
    let zero_s = guess.arcs[0].sample_times_s[0];
    let slowed = |time_s: f64| zero_s + factor * (time_s - zero_s);
    for arc in &mut shaken.arcs {
        let mut delta = StateTangent::zeros();
        for (block, sd) in shake::STATE.into_iter().enumerate() {
            for axis in 0..3 {
                delta[3 * block + axis] = size * sd * normal();
            }
        }
        arc.epoch_s = slowed(arc.epoch_s);
        arc.sample_times_s
            .iter_mut()
            .for_each(|time_s| *time_s = slowed(*time_s));
        delta.rows_mut(part::VELOCITY, 6).scale_mut(1.0 / factor);
        arc.state.velocity_m_s /= factor;
        arc.state.angular_velocity_rad_s /= factor;
        arc.state = arc.state.retract(&delta);
    }
    for time_s in &mut shaken.event_times_s {
        *time_s = slowed(*time_s) + size * shake::EVENT_S * normal();
    }
    shaken
}

/// Where a start ends, if that is an optimum whose events are in order.
pub fn optimum(posed: &Posed, start: &Start) -> Option<Optimum> {
    let solution = recipe::solve(
        &posed.problem,
        &posed.layout,
        &start.guess,
        &start.recipe,
        &mut (),
    );
    let in_order = solution.point.event_times_s.is_sorted() && is_forward(posed, &solution.point);
    (solution.finished.converged && in_order).then(|| Optimum {
        objective: 2.0 * solution.system.cost,
        start: start.name.clone(),
    })
}

/// Whether no flight ends before it begins; one that no event begins or ends has its samples'
/// extent.
fn is_forward(posed: &Posed, point: &Point) -> bool {
    posed.problem.arcs.iter().all(|arc| {
        let times_s = || arc.samples().map(|s| s.time_s(&point.node_times_s));
        let at = |event: usize| point.event_times_s[event];
        let start_s = arc
            .start
            .map_or_else(|| times_s().fold(f64::INFINITY, f64::min), at);
        let end_s = arc
            .end
            .map_or_else(|| times_s().fold(f64::NEG_INFINITY, f64::max), at);
        start_s <= end_s
    })
}

/// The optimum that the truth leads to, of the problem that an outcome's sketch poses.
pub fn optimum_from_truth(case: &Case, outcome: &Outcome) -> Option<Optimum> {
    let (posed, truth) = case.posed(outcome);
    optimum(&posed, &from_truth(&truth))
}

/// The lowest of all.
pub fn lowest(posed: &Posed, starts: &[Start]) -> Option<Optimum> {
    let found = starts.iter().filter_map(|start| optimum(posed, start));
    found.min_by(|a, b| a.objective.total_cmp(&b.objective))
}

/// Whether an objective is no worse than the lowest known.
pub fn is_best(objective: f64, lowest: f64) -> bool {
    objective <= lowest * (1.0 + SAME) + NO_COST
}
