//! The problems that peers are given: scenes, seeds, and what this program makes of them.

use std::time::Instant;

use enact::estimate::point::Point;
use enact::estimate::recipe::{self, Recipe, Solution};
use enact::motion::Verdict;

use serde::Serialize;

use crate::tasks::{is_bent, posed_with_truth};
use enact_tools::case::Case;
use enact_tools::export;
use enact_tools::perform::{Acting, Style, Truth, bounces, die, hat_box};
use enact_tools::starts::{lowest, starts};

/// A scene, acted in one way.
pub struct Scenario {
    /// For tables.
    pub name: String,
    /// How.
    pub acting: Acting,
    /// What, at a seed.
    pub truth: Box<dyn Fn(u64) -> Truth>,
}

/// Bounces of the cube at the default distortion, and at others.
const COUNTS: &[usize] = &[1, 2, 4, 6, 8, 12];
const FEWER_COUNTS: &[usize] = &[1, 4, 8];

/// Every scene at those distortions; timing is known but where it is said not to be.
pub fn all(distortions: &[f64]) -> Vec<Scenario> {
    let mut all = Vec::new();
    for distortion in distortions {
        let mut add = |name: String, acting: Acting, truth: Box<dyn Fn(u64) -> Truth>| {
            all.push(Scenario {
                name: format!("{name} {distortion}×"),
                acting: Acting {
                    distortion: *distortion,
                    ..acting
                },
                truth,
            });
        };
        for style in Style::ALL {
            for (timing, acting) in [
                ("", Acting::timing_known()),
                (" timing unknown,", Acting::default()),
            ] {
                let name = format!("pencil, {} first,{timing}", style.as_str());
                add(name, acting, Box::new(move |_| style.truth()));
            }
        }
        let known = Acting::timing_known;
        add(
            "hat and box,".into(),
            known(),
            Box::new(|_| hat_box::truth()),
        );
        add(
            "die,".into(),
            Acting::edited(),
            Box::new(|_| die::reference()),
        );
        let counts = if *distortion == 1.0 {
            COUNTS
        } else {
            FEWER_COUNTS
        };
        for count in counts.iter().copied() {
            let truth = move |seed| bounces(count, seed).expect("a bouncing cube");
            add(format!("cube, {count} bounces,"), known(), Box::new(truth));
        }
    }
    all
}

/// Our own results for one problem.
#[derive(Clone, Debug, Serialize)]
pub struct Own {
    /// Least and greatest time of [`recipe::solve`] from the start the peers are given \[s\].
    pub seconds: [f64; 2],
    /// Of the program's whole estimate, from poses and marks \[s\].
    pub whole_seconds: [f64; 2],
    /// Sum of squares and largest violation \[units\] of the former.
    pub objective: f64,
    pub violation: f64,
    pub iterations: usize,
    pub is_in_order: bool,
    /// Whether the latter has the verdict that the scene allows.
    pub whole_is_motion: bool,
    /// Lowest of some twenty starts, the truth among them.
    pub lowest: Option<f64>,
}

/// A problem for the peers and what is known of it.
pub struct Given {
    pub problem: export::Problem,
    pub own: Own,
}

/// Poses the problem of a performance, solves it, and exports it; `None` where the performance is
/// refused.
pub fn given(name: &str, case: &Case, seed: u64, repeats: usize) -> Option<Given> {
    let pipeline = case.pipeline();
    let (outcome, whole_seconds) = timed(repeats, || pipeline.clone().estimate(&mut ()));
    let outcome = outcome.ok()?;
    let (posed, true_guess) = posed_with_truth(case, &outcome);
    let is_bent = is_bent(&outcome);
    let mut others = Vec::new();
    let guess = &posed.guesses[0];
    let solve = || -> Solution {
        let recipe = Recipe::default();
        recipe::solve(&posed.problem, &posed.layout, guess, &recipe, &mut ())
    };
    let (solution, seconds) = timed(repeats, solve);
    others.push(("solution", solution.point.clone()));
    if !is_bent {
        others.push(("truth", Point::new(&posed.problem, &true_guess)));
    }
    let others: Vec<_> = others.iter().map(|(name, point)| (*name, point)).collect();
    let problem = export::problem(name, &posed.problem, &posed.layout, guess, &others);
    // A bent motion is none where velocities should be continuous.
    let expected = if is_bent {
        Verdict::Plausible
    } else {
        Verdict::Physical
    };
    let best = lowest(&posed, &starts(&posed, &true_guess, seed));
    Some(Given {
        problem,
        own: Own {
            seconds,
            whole_seconds,
            objective: 2.0 * solution.system.cost,
            violation: solution.system.violation(),
            iterations: solution.work.iterations,
            is_in_order: solution.point.event_times_s.is_sorted(),
            whole_is_motion: outcome.estimate.verdict == expected,
            lowest: best.map(|best| best.objective),
        },
    })
}

/// What a function gives, and its least and greatest time \[s\].
pub(super) fn timed<T>(repeats: usize, run: impl Fn() -> T) -> (T, [f64; 2]) {
    let mut seconds = [f64::INFINITY, 0.0];
    let mut last = None;
    for _ in 0..repeats.max(1) {
        let began = Instant::now();
        let result = run();
        let elapsed = began.elapsed().as_secs_f64();
        seconds = [seconds[0].min(elapsed), f64::max(seconds[1], elapsed)];
        last = Some(result);
    }
    (last.expect("at least one run"), seconds)
}
