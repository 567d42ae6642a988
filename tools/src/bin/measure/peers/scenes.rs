//! The problems that peers are given: scenes, seeds, and what this program makes of them.

use std::time::Instant;

use enact::estimate::schedule::recipe::{self, Recipe, Solution};
use enact::estimate::unknowns::point::Point;
use serde::Serialize;

use enact_tools::case::{Case, best_verdict, is_bent};
use enact_tools::export;
use enact_tools::perform::{Acting, Style, Truth, bounces, die, hat_box};
use enact_tools::starts::{lowest, starts};

/// Performances of a scene.
pub const SEEDS: u64 = 30;

/// A scene, acted in one way.
pub struct Scene {
    /// For tables.
    pub name: String,
    /// What is varied besides, in words, and bounces of a cube.
    pub what: String,
    pub bounces: Option<usize>,
    /// How.
    pub acting: Acting,
    /// What, at a seed.
    truth: Box<dyn Fn(u64) -> Truth>,
}

/// Bounces of the cube at the default distortion, and at others.
const COUNTS: &[usize] = &[1, 2, 4, 6, 8, 12];
const FEWER_COUNTS: &[usize] = &[1, 4, 8];

/// Every scene at those distortions; timing is known but where it is said not to be.
pub fn all(distortions: &[f64]) -> Vec<Scene> {
    let mut all = Vec::new();
    for distortion in distortions {
        type Make = Box<dyn Fn(u64) -> Truth>;
        let mut add = |what: String, bounces: Option<usize>, acting: Acting, truth: Make| {
            all.push(Scene {
                name: format!("{what}, {distortion}×"),
                what,
                bounces,
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
                (", timing unknown", Acting::default()),
            ] {
                let name = format!("pencil, {} first{timing}", style.as_str());
                add(name, None, acting, Box::new(move |_| style.truth()));
            }
        }
        let known = Acting::timing_known;
        let hat = Box::new(|_| hat_box::truth());
        add("hat and box".into(), None, known(), hat);
        let die = Box::new(|_| die::reference());
        add("die".into(), None, Acting::edited(), die);
        let counts = if *distortion == 1.0 {
            COUNTS
        } else {
            FEWER_COUNTS
        };
        for count in counts.iter().copied() {
            let truth = move |seed| bounces(count, seed).expect("a bouncing cube");
            let name = format!("cube, {count} bounces");
            add(name, Some(count), known(), Box::new(truth));
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

impl Scene {
    /// Poses the problem of a performance, solves it, and exports it; `None` where the performance
    /// is refused.
    pub fn given(&self, seed: u64, repeats: usize) -> Option<Given> {
        let case = Case::new(&(self.truth)(seed), &self.acting, seed).one_by_one();
        let pipeline = case.pipeline();
        let (outcome, whole_seconds) = timed(repeats, || pipeline.clone().estimate(&mut ()));
        let outcome = outcome.ok()?;
        let (posed, truth) = case.posed_without_marks(&outcome);
        let guess = &posed.guesses[0];
        let solve = || -> Solution {
            let recipe = Recipe::default();
            recipe::solve(&posed.problem, &posed.layout, guess, &recipe, &mut ())
        };
        let (solution, seconds) = timed(repeats, solve);
        let true_point = Point::new(&posed.problem, &truth);
        let mut others = vec![("solution", &solution.point)];
        if !is_bent(case.scene()) {
            others.push(("truth", &true_point));
        }
        let best = lowest(&posed, &starts(&posed, &truth, seed));
        Some(Given {
            problem: export::problem(&self.name, &posed.problem, &posed.layout, guess, &others),
            own: Own {
                seconds,
                whole_seconds,
                objective: 2.0 * solution.system.cost,
                violation: solution.system.violation(),
                iterations: solution.work.iterations,
                is_in_order: solution.point.event_times_s.is_sorted(),
                whole_is_motion: outcome.estimate.verdict == best_verdict(case.scene()),
                lowest: best.map(|best| best.objective),
            },
        })
    }
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
