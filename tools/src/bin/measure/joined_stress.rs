//! Where joined bodies are hard or wrong: what the program finds of such performances, and what it says.

mod show;

use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use anyhow::Result;
use enact::motion::{End, Estimate, Scene, Undetermined, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::joint_wrongs::Wrong;
use enact_tools::tree_stress::cases::all;
use enact_tools::tree_stress::check::{distances_m, finding, has_nan};
use enact_tools::tree_stress::{Hard, Performance};
use serde::Serialize;

use crate::core_time::{CoreLimit, CoreTime};
use crate::joined::{Solved, from_state};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::rms;

/// An objective within this of the best known one, relative, is as good.
const SAME: f64 = 1e-4;
/// After which an answer is told to stop \[s on a core\].
pub const LIMIT_S: f64 = 5.0;
/// Performances of a case at most,
const MOST: u64 = 100;
/// fewer where answers take long: no new one is begun after so long in a case \[s\], beyond so many.
const SPENT_S: f64 = 90.0;
const LEAST: u64 = 4;

/// How an answer ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Ended {
    /// A motion that nothing speaks against.
    Physical,
    /// A motion that meets the laws and the goals, and is doubted.
    Doubted,
    /// No motion.
    Failed,
    /// None when the time was over.
    Stopped,
    /// A bug.
    Panicked,
}

/// What came of one performance.
#[derive(Serialize)]
struct Answered {
    seed: u64,
    ended: Ended,
    /// Why, in a word.
    reason: String,
    doubts: Vec<String>,
    /// Parts of the motion of which the prior says more than the sketch.
    undetermined: Vec<String>,
    /// Whether it fits, where that was told.
    fits: Option<&'static str>,
    /// What is suspected first, and whether that is what is wrong.
    suspect: Option<String>,
    is_named: bool,
    objective: Option<f64>,
    /// From the true state, which nobody knows.
    from_truth: Option<Solved>,
    is_best: bool,
    is_best_from_truth: bool,
    /// Distances of rods' centres from the true ones at all samples \[m\]: root mean square, and greatest.
    off_m: Option<[f64; 2]>,
    growth: f64,
    /// What an independent look finds against what is called physical.
    finding: Option<String>,
    has_nan: bool,
    evaluations: usize,
    seconds: f64,
}

impl Answered {
    fn of(hard: &Hard, seed: u64) -> Self {
        let performance = hard.perform(seed);
        let time = CoreTime::begin();
        let scene = performance.said.clone();
        let events = performance.strike.events.iter().cloned();
        let answered = catch_unwind(AssertUnwindSafe(|| {
            Pipeline::of(scene, events).finish(&mut CoreLimit(&time, LIMIT_S))
        }));
        let seconds = time.seconds();
        let mut answer = Self::nothing(seed, performance.growth(), seconds);
        match answered {
            Ok(Ok(outcome)) => answer.take(hard.wrong, &performance, &outcome.estimate),
            Ok(Err(error)) => answer.reason = format!("refused: {error}"),
            Err(_) => answer.ended = Ended::Panicked,
        }
        answer.compare(&performance);
        answer
    }

    fn nothing(seed: u64, growth: f64, seconds: f64) -> Self {
        Self {
            seed,
            ended: Ended::Failed,
            reason: "panic".to_owned(),
            doubts: Vec::new(),
            undetermined: Vec::new(),
            fits: None,
            suspect: None,
            is_named: false,
            objective: None,
            from_truth: None,
            is_best: false,
            is_best_from_truth: false,
            off_m: None,
            growth,
            finding: None,
            has_nan: false,
            evaluations: 0,
            seconds,
        }
    }

    fn take(&mut self, wrong: Wrong, performance: &Performance, estimate: &Estimate) {
        let scene = &performance.said;
        let end = &estimate.reason.end;
        let is_motion = matches!(end, End::Converged(_));
        self.reason = end.as_str().to_owned();
        self.ended = match (is_motion, end, estimate.verdict) {
            (true, _, Verdict::Physical) => Ended::Physical,
            (true, ..) => Ended::Doubted,
            (_, End::Stopped(_), _) => Ended::Stopped,
            _ => Ended::Failed,
        };
        let doubts = estimate.doubts.iter().filter(|_| is_motion);
        let names = doubts.map(|doubt| doubt.about.as_str().to_owned());
        self.doubts = distinct(names);
        let open = estimate.undetermined.iter().filter(|_| is_motion);
        self.undetermined = distinct(open.map(|of| open_name(scene, of)));
        self.fits = estimate.fit.is_ok().then(|| estimate.fits().as_str());
        let first = estimate.suspects.first();
        let first = first.and_then(|of| of.values.first());
        self.suspect = first.map(|(quantity, _)| scene.name_of_quantity(*quantity));
        self.is_named = first.is_some_and(|(quantity, _)| wrong.is_of(scene, *quantity));
        self.evaluations = estimate.counters.evaluations;
        self.has_nan = is_motion && has_nan(estimate);
        if is_motion {
            self.objective = Some(estimate.objective);
            let distances_m = distances_m(performance, estimate);
            let most_m = distances_m.iter().copied().fold(0.0, f64::max);
            self.off_m = Some([rms(&distances_m), most_m]);
        }
        if self.ended == Ended::Physical {
            self.finding = finding(performance, estimate);
        }
    }

    /// The same from the true start.
    fn compare(&mut self, performance: &Performance) {
        let strike = &performance.strike;
        let truth = strike.states[0].clone();
        let take = (&performance.said, strike.events.as_slice());
        let time = CoreTime::begin();
        let solved = catch_unwind(AssertUnwindSafe(|| {
            from_state(take, truth, &mut CoreLimit(&time, LIMIT_S))
        }));
        let solved = solved.map(|estimate| Solved::of(estimate.as_ref(), time.seconds()));
        let Ok(solved) = solved else {
            self.reason += ", from the truth: panic";
            self.ended = Ended::Panicked;
            return;
        };
        let both = [self.objective, solved.best()];
        let best = both.into_iter().flatten().reduce(f64::min);
        let has = |found: Option<f64>| {
            found
                .zip(best)
                .is_some_and(|(found, best)| found <= best * (1.0 + SAME))
        };
        self.is_best = has(self.objective);
        self.is_best_from_truth = has(solved.best());
        self.from_truth = Some(solved);
    }
}

fn open_name(scene: &Scene, of: &Undetermined) -> String {
    match of {
        Undetermined::Link { link, part } => {
            format!("{} of {}", part.as_str(), scene.links[*link].name)
        }
        _ => "something else".to_owned(),
    }
}

fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    let counts: BTreeMap<String, ()> = names.map(|name| (name, ())).collect();
    counts.into_keys().collect()
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows: Vec<(String, Vec<Answered>)> = Vec::new();
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    for hard in all() {
        // A quick run leaves out what takes seconds each.
        if options.quick && hard.duration_s > 5.0 || !options.wants(&hard.name) {
            continue;
        }
        let begin = Instant::now();
        let mut answers: Vec<Answered> = Vec::new();
        for (count, seed) in options.seeds(MOST).enumerate() {
            if count as u64 >= LEAST && begin.elapsed().as_secs_f64() > SPENT_S {
                break;
            }
            answers.push(Answered::of(&hard, seed));
        }
        eprintln!("  {}: {}", hard.name, show::in_short(&answers));
        rows.push((hard.name.clone(), answers));
    }
    panic::set_hook(hook);
    show::show(&rows, record);
    record.numbers("joined_stress", &rows)
}
