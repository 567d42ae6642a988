//! One answer from many takes: how near it is to the truth, how often its intervals hold, what it takes; and the real tosses of
//! a cube with half of them held out.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use enact::report::FitLine;
use enact::service::{FitInput, FitJob, FitStop, HoldOut, fit};
use enact_tools::elbow::{self, Reads};
use enact_tools::fits::BallTruth;
use enact_tools::perform::recording::write_events_of;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use tempfile::TempDir;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};
use crate::tosses::bounce::Setting;

/// Answers of a row.
const SEEDS: u64 = 25;
/// How much restitution differs over takes where it does.
const SPREAD: f64 = 0.04;
/// Moment of the cube [kg m²].
const MOMENT_KG_M2: f64 = 8.1e-4;

/// How flights of the elbow are read: moments as documented, and the hinge 10 mm off.
const HINGE_OFF: Reads = Reads {
    sees_both: true,
    moment_kg_m2: Some(6.167e-4),
    hinge_off_m: 0.01,
};
/// Least number of readings of such a flight.
const LEAST_READINGS: usize = 10;

/// All that is true of a ball.
const NAMES: [&str; 4] = [
    "ball.restitution",
    "ball.friction",
    "gravity",
    "ball.tracker",
];

/// A row of answers.
#[derive(Clone, Copy)]
struct Kind {
    name: &'static str,
    takes: usize,
    spread: f64,
    is_drawn: bool,
}

const KINDS: [Kind; 5] = [
    kind("all shared", 10, 0.0, false),
    kind("all shared", 40, 0.0, false),
    kind("restitution differs, shared", 20, SPREAD, false),
    kind("restitution drawn", 10, SPREAD, true),
    kind("restitution drawn", 40, SPREAD, true),
];

const fn kind(name: &'static str, takes: usize, spread: f64, is_drawn: bool) -> Kind {
    Kind {
        name,
        takes,
        spread,
        is_drawn,
    }
}

/// One number of one answer.
#[derive(Serialize)]
struct Number {
    name: String,
    off: f64,
    sd: Option<f64>,
    is_held: Option<bool>,
    /// Whether the interval of its spread holds.
    is_spread_held: Option<bool>,
}

/// One answer.
#[derive(Serialize)]
struct FitAnswer {
    seed: u64,
    /// None where there is no answer.
    numbers: Vec<Number>,
    left_out: usize,
    standing_out: usize,
    /// Wall time for each take \[s\].
    seconds: f64,
}

fn answer(kind: Kind, seed: u64) -> Result<FitAnswer> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut truth = BallTruth::drawn(&mut random);
    truth.restitution.sd = kind.spread;
    let folder = TempDir::new()?;
    let inputs = truth.write(kind.takes, seed ^ 0xf17, folder.path())?;
    // The first of them is drawn where it differs.
    let names = NAMES.map(str::to_owned);
    let (drawn, shared) = names.split_at(usize::from(kind.is_drawn));
    let begun = Instant::now();
    let fitted = fit(&FitJob {
        inputs: inputs.into_iter().map(FitInput::File).collect(),
        scene: None,
        shared: shared.to_vec(),
        drawn: drawn.to_vec(),
        hold_out: None,
        output: None,
        page: None,
        stop: FitStop::default(),
    });
    let seconds = begun.elapsed().as_secs_f64() / kind.takes as f64;
    let Ok(fitted) = fitted else {
        return Ok(FitAnswer {
            seed,
            numbers: Vec::new(),
            left_out: kind.takes,
            standing_out: 0,
            seconds,
        });
    };
    let values = truth.values();
    let numbers = fitted.line.parameters.iter().filter_map(|of| {
        let (_, value) = values.iter().find(|(name, _)| *name == of.name)?;
        let holds = |[lower, upper]: [f64; 2], value: f64| lower <= value && value <= upper;
        Some(Number {
            name: of.name.clone(),
            off: of.value - value,
            sd: of.sd,
            is_held: of.interval.map(|ends| holds(ends, *value)),
            is_spread_held: of.spread.map(|of| holds(of.interval, kind.spread)),
        })
    });
    let takes = fitted.takes.iter();
    Ok(FitAnswer {
        seed,
        numbers: numbers.collect(),
        left_out: fitted.line.left_out,
        standing_out: takes.filter(|of| !of.stands_out.is_empty()).count(),
        seconds,
    })
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "takes of a ball",
        "number",
        "answers",
        "none",
        "restitution off: median",
        "friction",
        "gravity, m/s²",
        "tracker, mm",
        "in 95 % intervals",
        "restitution in its",
        "spread in its",
        "takes left out",
        "time for a take, ms",
    ];
    let mut table = Table::new("fit", "", &header);
    let mut all = Vec::new();
    for kind in KINDS {
        let row = format!("{}, {}", kind.name, kind.takes);
        if !options.wants(&row) {
            continue;
        }
        let answers = options.seeds(SEEDS).map(|seed| answer(kind, seed));
        let answers: Vec<FitAnswer> = answers.collect::<Result<_>>()?;
        table.row(cells(kind, &answers));
        eprintln!("  {row}");
        all.push((row, answers));
    }
    record.table(table);
    record.numbers("fit", &all)?;
    workers(options, record)?;
    tosses(options, record)?;
    elbow(options, record)
}

/// Takes of the answer whose wall time is measured.
const TIMED_TAKES: usize = 1000;

/// Wall times of one answer by one and by two threads, and by more as these two tell it: a part that is serial, and one that
/// is divided (Amdahl).
fn workers(options: &Options, record: &mut Record) -> Result<()> {
    let takes = options.either(20, TIMED_TAKES);
    if !options.wants("workers") {
        return Ok(());
    }
    let truth = BallTruth::drawn(&mut ChaCha8Rng::seed_from_u64(options.seeds(1).start));
    let folder = TempDir::new()?;
    let inputs = truth.write(takes, 0xacc, folder.path())?;
    let job = FitJob {
        inputs: inputs.into_iter().map(FitInput::File).collect(),
        scene: None,
        shared: NAMES.map(str::to_owned).to_vec(),
        drawn: Vec::new(),
        hold_out: None,
        output: None,
        page: None,
        stop: FitStop::default(),
    };
    let mut measured_s = Vec::new();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let begun = Instant::now();
        pool.install(|| fit(&job))?;
        measured_s.push(begun.elapsed().as_secs_f64());
    }
    let serial_s = (2.0 * measured_s[1] - measured_s[0]).max(0.0);
    let divided_s = measured_s[0] - serial_s;
    let mut table = Table::new(
        "workers",
        "",
        &["workers", "takes", "wall time s", "how", "of it serial s"],
    );
    for workers in [1_usize, 2, 10, 100, 1000] {
        let (time_s, how) = match measured_s.get(workers - 1) {
            Some(time_s) => (*time_s, "measured"),
            None => (serial_s + divided_s / workers as f64, "by the model"),
        };
        table.row([
            workers.to_string(),
            takes.to_string(),
            number(time_s),
            how.to_owned(),
            number(serial_s),
        ]);
    }
    record.table(table);
    record.numbers("workers", &measured_s)
}

fn cells(kind: Kind, answers: &[FitAnswer]) -> Vec<String> {
    let numbers = || answers.iter().flat_map(|of| &of.numbers);
    let off = |part: &str, factor: f64| {
        let of = numbers().filter(|of| of.name.contains(part));
        number(median(
            &of.map(|of| of.off.abs() * factor).collect::<Vec<_>>(),
        ))
    };
    let held = |part: &str, of: fn(&Number) -> Option<bool>| {
        let all = numbers().filter(|of| of.name.contains(part));
        let all: Vec<bool> = all.filter_map(of).collect();
        percent(all.iter().filter(|held| **held).count(), all.len())
    };
    let left_out: usize = answers.iter().map(|of| of.left_out).sum();
    let seconds: Vec<f64> = answers.iter().map(|of| of.seconds * 1e3).collect();
    vec![
        kind.name.to_owned(),
        kind.takes.to_string(),
        answers.len().to_string(),
        answers
            .iter()
            .filter(|of| of.numbers.is_empty())
            .count()
            .to_string(),
        off("restitution", 1.0),
        off("friction", 1.0),
        off("gravity", 1.0),
        off("tracker", 1e3),
        held("", |of| of.is_held),
        held("restitution", |of| of.is_held),
        held("restitution", |of| of.is_spread_held),
        left_out.to_string(),
        number(median(&seconds)),
    ]
}

/// Restitution and friction of the first impact of the real tosses, half of them held out; nothing where they are not there.
fn tosses(options: &Options, record: &mut Record) -> Result<()> {
    let Some((_, mut tosses)) = enact_tools::tosses::all()? else {
        return Ok(());
    };
    if options.quick {
        tosses.truncate(12);
    }
    let setting = Setting::new(MOMENT_KG_M2, 0.0)?;
    let folder = TempDir::new()?;
    let mut inputs = Vec::new();
    for toss in &tosses {
        let Some((toml, scene, events)) = setting.first_impact(toss) else {
            continue;
        };
        let path = folder.path().join(format!("toss_{:03}.mcap", toss.number));
        write_events_of(&scene, &toml, &events, &path)?;
        inputs.push(path);
    }
    let laws = ["cube.restitution".to_owned(), "cube.friction".to_owned()];
    let asked = [(laws.to_vec(), Vec::new()), (Vec::new(), laws.to_vec())];
    held_out("tosses", &inputs, &asked, record)
}

/// Flights of the real elbow, of which the scene says that the hinge is elsewhere, half of them held out; nothing where they are
/// not there. The same tosses as in `elbow`.
fn elbow(options: &Options, record: &mut Record) -> Result<()> {
    let files = elbow::files();
    let folder = TempDir::new()?;
    let mut inputs = Vec::new();
    for (at, file) in files.iter().step_by(options.either(8, 2)).enumerate() {
        let flight = elbow::flight(file);
        if flight.len() < LEAST_READINGS {
            continue;
        }
        let path = folder.path().join(format!("elbow_{at:03}.mcap"));
        elbow::write(&flight, &HINGE_OFF, &path)?;
        inputs.push(path);
    }
    if inputs.is_empty() {
        return Ok(());
    }
    let names = ["gravity", "hinge.parent"].map(str::to_owned);
    held_out("elbow", &inputs, &[(names.to_vec(), Vec::new())], record)
}

/// Answers to what is asked, shared and drawn, with half of the takes held out, as a table.
fn held_out(
    name: &'static str,
    inputs: &[PathBuf],
    asked: &[(Vec<String>, Vec<String>)],
    record: &mut Record,
) -> Result<()> {
    let header = [
        "what is asked",
        "value",
        "95 %",
        "spread over tosses",
        "tosses fitted",
        "left out",
        "held out: residual",
        "with the scene's values",
        "nearer in",
        "time for a toss, ms",
    ];
    let mut table = Table::new(name, "", &header);
    let mut said: Vec<FitLine> = Vec::new();
    for (shared, drawn) in asked.iter().cloned() {
        let begun = Instant::now();
        let fitted = fit(&FitJob {
            inputs: inputs.iter().cloned().map(FitInput::File).collect(),
            scene: None,
            shared,
            drawn,
            hold_out: Some(HoldOut::Share(0.5)),
            output: None,
            page: None,
            stop: FitStop::default(),
        })?;
        let each_ms = 1e3 * begun.elapsed().as_secs_f64() / inputs.len() as f64;
        let line = fitted.line;
        let held = line.held_out.unwrap_or_default();
        for of in &line.parameters {
            let ends = of.interval.map_or("–".to_owned(), |[lower, upper]| {
                format!("{} to {}", number(lower), number(upper))
            });
            let spread = of.spread.map_or("–".to_owned(), |of| number(of.sd));
            let kind = if of.is_drawn { "drawn" } else { "shared" };
            table.row([
                format!("{}, {kind}", of.name),
                number(of.value),
                ends,
                spread,
                line.takes.to_string(),
                line.left_out.to_string(),
                held.by_fit.words(),
                held.by_scene.words(),
                format!("{} of {}", held.better, held.takes),
                number(each_ms),
            ]);
        }
        said.push(line);
    }
    record.table(table);
    record.numbers(name, &said)
}
