//! The scenes beyond the pencils: how often the best known optimum is found, and what it takes.

use std::time::Instant;

use anyhow::Result;
use enact::estimate::layout::Layout;
use enact::motion::{VelocityGaps, Verdict};
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Truth, bounces, die, flips, hat_box};
use enact_tools::starts::{is_best, lowest, starts};

/// A scene, acted in one way.
struct Scenario {
    name: String,
    acting: Acting,
    truth: Box<dyn Fn(u64) -> Truth>,
}

/// One performance.
#[derive(Serialize)]
struct Seed {
    scene: String,
    distortion: f64,
    seed: u64,
    verdict: &'static str,
    reason: String,
    objective: f64,
    lowest: Option<f64>,
    lowest_start: Option<String>,
    is_best: bool,
    iterations: usize,
    time_ms: f64,
}

fn scenarios() -> Vec<Scenario> {
    let mut all = Vec::new();
    for distortion in [1.0, 2.0, 4.0] {
        let acted = |acting: Acting| Acting {
            distortion,
            ..acting
        };
        let mut add = |name: String, acting: Acting, truth: Box<dyn Fn(u64) -> Truth>| {
            all.push(Scenario {
                name,
                acting: acted(acting),
                truth,
            });
        };
        let hat = || Box::new(|_| hat_box::truth());
        add(
            "hat and box, timing known".into(),
            Acting::timing_known(),
            hat(),
        );
        add("hat and box".into(), Acting::default(), hat());
        add(
            "die, edited".into(),
            Acting::edited(),
            Box::new(|_| die::reference()),
        );
        if distortion < 2.0 {
            for count in [1, 2, 4, 6, 8, 10, 12, 20] {
                let truth = move |seed| bounces(count, seed).expect("a bouncing cube");
                let name = format!("cube, {count} bounces, timing known");
                add(name, Acting::timing_known(), Box::new(truth));
            }
            for count in [1, 2, 4, 8] {
                let truth = move |seed| flips(count, seed).expect("a flipping brick");
                let name = format!("brick, {count} flips");
                add(
                    format!("{name}, timing known"),
                    Acting::timing_known(),
                    Box::new(truth),
                );
                add(name, Acting::default(), Box::new(truth));
            }
        }
    }
    all
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let title = "Scenes of several bodies and of many bounces";
    let header = [
        "scene",
        "distortion",
        "n",
        "physical",
        "plausible",
        "best known optimum",
        "iterations median (max)",
        "time ms median (max)",
    ];
    let mut table = Table::new(title, &header);
    let mut all = Vec::new();
    for scenario in scenarios() {
        if !options.wants(&scenario.name) {
            continue;
        }
        let seeds: Vec<Seed> = options
            .range()
            .map(|seed| judged(&scenario, seed))
            .collect();
        let count = |holds: &dyn Fn(&Seed) -> bool| {
            percent(seeds.iter().filter(|seed| holds(seed)).count(), seeds.len())
        };
        let both = |values: Vec<f64>| {
            format!("{} ({})", number(median(&values)), number(largest(&values)))
        };
        table.row([
            scenario.name.clone(),
            format!("{}×", scenario.acting.distortion),
            seeds.len().to_string(),
            count(&|seed| seed.verdict == "physical"),
            count(&|seed| seed.verdict == "plausible"),
            count(&|seed| seed.is_best),
            both(seeds.iter().map(|seed| seed.iterations as f64).collect()),
            both(seeds.iter().map(|seed| seed.time_ms).collect()),
        ]);
        all.extend(seeds);
    }
    options.show(&table);
    if options.only.is_some() {
        return Ok(());
    }
    options.write_json("scenes", &all)
}

fn judged(scenario: &Scenario, seed: u64) -> Seed {
    let case = Case::new(&(scenario.truth)(seed), &scenario.acting, seed);
    let mut result = Seed {
        scene: scenario.name.clone(),
        distortion: scenario.acting.distortion,
        seed,
        verdict: "refused",
        reason: String::new(),
        objective: f64::NAN,
        lowest: None,
        lowest_start: None,
        is_best: false,
        iterations: 0,
        time_ms: 0.0,
    };
    let pipeline = case.pipeline();
    let began = Instant::now();
    let outcome = match pipeline.estimate(&mut ()) {
        Ok(outcome) => outcome,
        Err(error) => {
            result.reason = error.to_string();
            return result;
        }
    };
    result.time_ms = began.elapsed().as_secs_f64() * 1e3;
    let estimate = &outcome.estimate;
    result.verdict = estimate.verdict.as_str();
    result.reason = enact::report::reason_text(&outcome.scene, &estimate.reason);
    result.objective = estimate.objective;
    result.iterations = estimate.counters.iterations;

    let mut posed = Posed::new(case.scene(), &outcome.sketch);
    let is_bent = case.scene().velocity_gaps == VelocityGaps::Always;
    let guess = if is_bent {
        // There is no true motion to start from.
        posed.problem = posed.problem.with_velocity_gaps();
        posed.layout = Layout::new(&posed.problem);
        posed.guesses[0].clone()
    } else {
        case.true_guess(&posed, &outcome.sketch)
    };
    let expected = if is_bent {
        Verdict::Plausible
    } else {
        Verdict::Physical
    };
    let found = lowest(&posed, &starts(&posed, &guess, seed));
    let is_it = estimate.verdict == expected;
    result.is_best = is_it
        && found
            .as_ref()
            .is_none_or(|best| is_best(estimate.objective, best.objective));
    if let Some(best) = found {
        result.lowest = Some(best.objective);
        result.lowest_start = Some(best.start);
    }
    result
}
