//! Chains and pendulums acted in slow motion whose tempo is not known: how often a motion is found, and how near its times
//! are to the true ones.

use anyhow::Result;
use enact::motion::{End, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::trees::{Jointed, Kind, TreeActing, perform};
use serde::Serialize;

use crate::core_time::{CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent, share};

/// Performances of a row.
const PERFORMANCES: u64 = 10;
/// After which an answer is told to stop \[s on a core\].
const LIMIT_S: f64 = 20.0;

/// One performance.
#[derive(Serialize)]
struct Performed {
    seed: u64,
    verdict: String,
    is_physical: bool,
    is_stopped: bool,
    /// Root mean square error of the samples' times \[ms\].
    off_ms: Option<f64>,
    /// Of the duration, as a share of the true one,
    duration_off: Option<f64>,
    /// and in its standard deviations.
    duration_deviations: Option<f64>,
    iterations: usize,
    evaluations: usize,
    seconds: f64,
}

impl Performed {
    fn of(kind: &Kind, acting: &TreeActing, seed: u64) -> Self {
        let performance = perform(kind, acting, seed);
        let events = performance.events.iter().cloned();
        let time = CoreTime::begin();
        let limit = &mut CoreLimit(&time, LIMIT_S);
        let outcome = Pipeline::of(performance.scene.clone(), events).finish(limit);
        let seconds = time.seconds();
        let estimate = outcome.expect("an estimate").estimate;
        let is_physical = estimate.verdict == Verdict::Physical;
        let lasting = estimate.duration;
        let off_s = lasting.duration_s - performance.duration_s;
        let told = |value: f64| is_physical.then_some(value);
        let times = estimate.sample_times.iter();
        let offs_s = times.zip(&performance.sample_times_s);
        let squares = offs_s.map(|(found, true_s)| (found.time_s - true_s).powi(2));
        let count = performance.sample_times_s.len() as f64;
        Self {
            seed,
            verdict: format!("{:?}", estimate.verdict).to_lowercase(),
            is_physical,
            is_stopped: matches!(estimate.reason.end, End::Stopped(_)),
            off_ms: told(1e3 * (squares.sum::<f64>() / count).sqrt()),
            duration_off: told(off_s.abs() / performance.duration_s),
            duration_deviations: lasting.sd_s.and_then(|sd_s| told(off_s.abs() / sd_s)),
            iterations: estimate.counters.iterations,
            evaluations: estimate.counters.evaluations,
            seconds,
        }
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "hand",
        "performances",
        "physical",
        "stopped",
        "times off, ms",
        "most, ms",
        "duration off, %",
        "within two deviations",
        "evaluations",
        "time, ms",
        "longest, ms",
    ];
    let mut table = Table::new("slowly", "", &header);
    let mut numbers = Vec::new();
    let (mut physical, mut stopped, mut count) = (0, 0, 0);
    for (name, kind) in [
        ("the chain", Kind::CHAIN),
        ("pendulum of 2, pins", Kind::pendulum(2, Jointed::Pin)),
        (
            "pendulum of 2, universal",
            Kind::pendulum(2, Jointed::Universal),
        ),
        ("pendulum of 2, balls", Kind::pendulum(2, Jointed::Ball)),
    ] {
        for (hand, distortion, slowly) in [
            ("none, twice as slow", 0.0, [2.0, 0.3]),
            ("usual", 1.0, [2.5, 0.3]),
        ] {
            if !options.wants(&format!("{name}, {hand}")) {
                continue;
            }
            let mut acting = TreeActing {
                asks_start: !kind.is_clamped,
                slowly: Some(slowly),
                ..TreeActing::of(distortion)
            };
            if distortion == 0.0 {
                acting.noise_m = 0.0;
            }
            let seeds = options.seeds(PERFORMANCES);
            let all: Vec<Performed> = seeds
                .map(|seed| Performed::of(&kind, &acting, seed))
                .collect();
            let of = |of: &dyn Fn(&Performed) -> Option<f64>| {
                all.iter().filter_map(of).collect::<Vec<f64>>()
            };
            let times_s = of(&|one| Some(one.seconds));
            let deviations = of(&|one| one.duration_deviations);
            table.row([
                name.to_owned(),
                hand.to_owned(),
                all.len().to_string(),
                share(&all, |one| one.is_physical),
                share(&all, |one| one.is_stopped),
                number(median(&of(&|one| one.off_ms))),
                number(largest(&of(&|one| one.off_ms))),
                number(100.0 * median(&of(&|one| one.duration_off))),
                share(&deviations, |of| *of < 2.0),
                number(median(&of(&|one| Some(one.evaluations as f64)))),
                number(1e3 * median(&times_s)),
                number(1e3 * largest(&times_s)),
            ]);
            eprintln!("  {name}, {hand}");
            if distortion > 0.0 {
                physical += all.iter().filter(|one| one.is_physical).count();
                stopped += all.iter().filter(|one| one.is_stopped).count();
                count += all.len();
            }
            numbers.push((name, hand, all));
        }
    }
    record.say(format!(
        "Chains and pendulums in slow motion whose tempo is not known, acted by a usual hand: {} are found, {} stopped after {LIMIT_S} s on a core.",
        percent(physical, count),
        percent(stopped, count)
    ));
    record.table(table);
    record.numbers("slowly", &numbers)
}
