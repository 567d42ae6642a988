//! How often the intervals of calibrated clocks hold.

use anyhow::{Result, anyhow};
use enact::calibrate::{ClockFit, Measured, Stream, clock};
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};

#[path = "../../../../tests/calibrate/performed.rs"]
mod performed;

use performed::{Hand, OFFSET_S, RATE, turned};

/// Motions of each hand.
const SEEDS: u64 = 100;
const SECONDS: f64 = 15.0;

/// What was found of one motion.
#[derive(Serialize)]
struct Found {
    seed: u64,
    offset_error_s: f64,
    offset_half_s: f64,
    offset_holds: bool,
    rate_error: f64,
    rate_half: f64,
    rate_holds: bool,
}

/// Error, half of the interval, and whether that holds the truth.
fn judged(of: &Measured, truth: f64) -> (f64, f64, bool) {
    (of.value[0] - truth, of.half[0], of.covers(&[truth])[0])
}

fn fit(seed: u64, hand: Hand, wobble_rad: f64) -> Option<ClockFit> {
    let [first, second] = turned(seed, hand, wobble_rad, SECONDS);
    let first = Stream::of(&first, None, 2).ok()?;
    let second = Stream::of(&second, Some(first.origin), 2).ok()?;
    clock(&first, &second).ok()
}

fn found(seed: u64, hand: Hand, wobble_rad: f64) -> Option<Found> {
    let fit = fit(seed, hand, wobble_rad)?;
    let (offset_error_s, offset_half_s, offset_holds) = judged(&fit.offset_s, OFFSET_S);
    let (rate_error, rate_half, rate_holds) = judged(&fit.rate, RATE);
    Some(Found {
        seed,
        offset_error_s,
        offset_half_s,
        offset_holds,
        rate_error,
        rate_half,
        rate_holds,
    })
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut table = Table::new(
        "clocks",
        "Two trackers on one object",
        &[
            "noise",
            "motions",
            "offset within its 95 % interval",
            "half of it, median",
            "drift within its 95 % interval",
            "half of it, median",
        ],
    );
    let hands = [
        ("white, 0.05°", Hand::None, 0.0),
        (
            "and a mount that wanders, 2 mrad, 0.2 s",
            Hand::Wanders(0.2),
            2e-3,
        ),
        (
            "and one that vibrates, 1 mrad, 5 Hz",
            Hand::Vibrates(5.0),
            1e-3,
        ),
    ];
    let (mut hold, mut all) = (0, 0);
    for (what, hand, wobble_rad) in hands {
        if !options.wants(what) {
            continue;
        }
        let seeds = options.seeds(SEEDS);
        let of = seeds.map(|seed| {
            found(seed, hand, wobble_rad).ok_or_else(|| anyhow!("{what}, seed {seed}: no interval"))
        });
        let of: Vec<Found> = of.collect::<Result<_>>()?;
        let offsets = of.iter().filter(|of| of.offset_holds).count();
        let rates = of.iter().filter(|of| of.rate_holds).count();
        let halves = |half: fn(&Found) -> f64| median(&of.iter().map(half).collect::<Vec<f64>>());
        table.row([
            what.to_owned(),
            of.len().to_string(),
            percent(offsets, of.len()),
            format!("{} ms", number(1e3 * halves(|of| of.offset_half_s))),
            percent(rates, of.len()),
            format!("{} ppm", number(1e6 * halves(|of| of.rate_half))),
        ]);
        hold += offsets + rates;
        all += 2 * of.len();
        record.numbers(what, &of)?;
    }
    record.say(format!(
        "Of two trackers on one object, 95 % intervals of the second clock's offset and drift hold the truth in {} of {all}.",
        percent(hold, all)
    ));
    record.table(table);
    Ok(())
}
