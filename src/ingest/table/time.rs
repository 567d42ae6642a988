//! Times of rows as integer nanoseconds.

use super::layout::{HeadMark, TableFault, TableLayout, TimeColumns, fault, shown};
use super::missing::is_absent;
use super::said::{Said, listed};
use super::stamp::{nanoseconds, text_time};
use super::text::{Line, number};
use super::units::TimeUnit;

/// Rates of which nobody doubts that they are a tracker's \[Hz\],
const USUAL_HZ: [f64; 2] = [20.0, 1100.0];
/// those that may be one's,
const POSSIBLE_HZ: [f64; 2] = [0.4, 4000.0];
/// and those beyond which a unit that is stated is doubted.
const STATED_HZ: [f64; 2] = [0.02, 20_000.0];

/// Units that have no neighbour within a factor of a thousand, with the greatest interval between samples that they
/// are taken for where nothing is usual, in the unit itself.
const UNITS: [(TimeUnit, f64); 4] = [
    (TimeUnit::Second, 0.4),
    (TimeUnit::Millisecond, 200.0),
    (TimeUnit::Microsecond, 200_000.0),
    (TimeUnit::Nanosecond, f64::INFINITY),
];

/// A clock that counts since a date, by the size of its numbers in this century.
struct Epoch {
    unit: TimeUnit,
    sizes: [f64; 2],
    since: &'static str,
    /// Its number at the beginning of 1970.
    zero: i64,
}

const fn epoch(unit: TimeUnit, per_s: f64) -> Epoch {
    Epoch {
        unit,
        sizes: [9e8 * per_s, 4.2e9 * per_s],
        since: "1970",
        zero: 0,
    }
}

const EPOCHS: [Epoch; 7] = [
    epoch(TimeUnit::Second, 1.0),
    epoch(TimeUnit::Millisecond, 1e3),
    epoch(TimeUnit::Microsecond, 1e6),
    epoch(TimeUnit::Tick, 1e7),
    epoch(TimeUnit::Nanosecond, 1e9),
    Epoch {
        unit: TimeUnit::Tick,
        sizes: [6.2e17, 6.7e17],
        since: "the year 1, as .NET counts",
        zero: 621_355_968_000_000_000,
    },
    Epoch {
        unit: TimeUnit::Tick,
        sizes: [1.1e17, 1.6e17],
        since: "1601, as Windows counts",
        zero: 116_444_736_000_000_000,
    },
];

/// How the rows are stamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Clock {
    /// By a column in a unit.
    Column { column: usize, power: i32 },
    /// By ticks of 100 ns since a number of them.
    Ticks { column: usize, zero: i64 },
    /// By dates or times of day.
    Text { column: usize },
    /// By whole seconds and the nanoseconds past them.
    Parts { whole: usize, rest: usize },
    /// By the number of the frame.
    Frames { column: usize, rate_hz: f64 },
    /// By the place of the row.
    Rows { rate_hz: f64 },
}

/// The clock that the layout, the options and the rows give; says what it takes for granted.
pub(super) fn clock(
    layout: &TableLayout,
    rows: &[Line],
    unit: Option<TimeUnit>,
    rate_hz: Option<f64>,
    said: &mut Said,
) -> Result<Clock, TableFault> {
    let rate_or = |what: &str, line: usize| match rate_hz.or(layout.rate_hz) {
        Some(rate_hz) => Ok(rate_hz),
        None => fault(
            line,
            format!("{what}, expected --rate HZ, so many a second"),
        ),
    };
    let rate_said = |rate_hz: f64| match layout.rate_hz == Some(rate_hz) {
        true => format!("{rate_hz} a second, as the file says"),
        false => format!("{rate_hz} a second, as --rate says"),
    };
    let line = rows.first().map_or(0, |row| row.number);
    let (column, stated) = match layout.time {
        TimeColumns::Two(whole, rest) if rate_hz.is_none() => {
            said.note(
                "times are seconds and the nanoseconds past them, as their columns are named",
            );
            return Ok(Clock::Parts { whole, rest });
        }
        TimeColumns::One(column, stated) => (column, unit.or(stated)),
        TimeColumns::Two(..) | TimeColumns::Row => {
            let rate_hz = rate_or("no column of times", line)?;
            said.note(format!("rows are {}", rate_said(rate_hz)));
            return Ok(Clock::Rows { rate_hz });
        }
    };
    if stated == Some(TimeUnit::Frame) {
        let rate_hz = rate_or("the times are numbers of frames", line)?;
        said.note(format!("frames are {}", rate_said(rate_hz)));
        return Ok(Clock::Frames { column, rate_hz });
    }
    // A rate that is asked for stamps by the place of the row: what a camera that counts means.
    if let Some(rate_hz) = rate_hz {
        said.note(format!(
            "rows are {}, whatever their times say",
            rate_said(rate_hz)
        ));
        return Ok(Clock::Rows { rate_hz });
    }
    let cells = || {
        rows.iter()
            .filter_map(|row| row.cells.get(column))
            .filter(|cell| !is_absent(cell))
    };
    if let Some(first) = cells().next()
        && number(first).is_none()
    {
        let Some(time) = text_time(first) else {
            return fault(
                line,
                format!(
                    "{} is no time, expected a number, 2026-01-05T10:00:00.000 or 10:00:00.000; or --rate HZ for rows \
                     whose times are not read",
                    shown(first)
                ),
            );
        };
        said.note(match time.has_date {
            true => "times are dates with times of day",
            false => "times are times of day; past midnight the next day begins",
        });
        return Ok(Clock::Text { column });
    }
    let times: Vec<f64> = cells().filter_map(|cell| number(cell)).collect();
    let found = match stated {
        Some(unit) => check(unit, &times, said),
        None => guessed(&times, line, &layout.other_times, said)?,
    };
    Ok(match found {
        (TimeUnit::Tick, zero) => Clock::Ticks { column, zero },
        (unit, _) => Clock::Column {
            column,
            power: unit.nanosecond_power().unwrap_or(0),
        },
    })
}

fn per_s(unit: TimeUnit) -> f64 {
    10_f64.powi(9 - unit.nanosecond_power().unwrap_or(0))
}

fn is_within(value: f64, [least, most]: [f64; 2]) -> bool {
    (least..=most).contains(&value)
}

/// The median of the intervals that are not zero, of times in any order.
fn median_interval(times: &[f64]) -> Option<f64> {
    let intervals = times.windows(2).map(|pair| pair[1] - pair[0]);
    let mut intervals: Vec<f64> = intervals.filter(|interval| *interval > 0.0).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return None;
    }
    Some(*intervals.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Whether the size of numbers is that of a clock that counts since a date.
fn epoch_of(unit: Option<TimeUnit>, times: &[f64]) -> Option<&'static Epoch> {
    let first = *times.first()?;
    let is_it = |epoch: &&Epoch| {
        unit.is_none_or(|unit| unit == epoch.unit) && is_within(first, epoch.sizes)
    };
    EPOCHS.iter().find(is_it)
}

/// A unit that is stated, against which sizes may speak; with the number at which 1970 begins.
fn check(unit: TimeUnit, times: &[f64], said: &mut Said) -> (TimeUnit, i64) {
    said.note(format!("times are in {}, as stated", unit.name()));
    if let Some(interval) = median_interval(times) {
        let rate_hz = per_s(unit) / interval;
        let other = epoch_of(None, times).filter(|other| other.unit != unit);
        if !is_within(rate_hz, STATED_HZ) {
            said.against(format!(
                "times in {} are {rate_hz:.3} rows a second{}; expected --time-unit for another unit, or --rate HZ",
                unit.name(),
                other.map_or(String::new(), |other| format!(
                    ", and as large as {} since {}",
                    other.unit.name(),
                    other.since
                ))
            ));
        }
    }
    let zero = epoch_of(Some(unit), times).map_or(0, |epoch| epoch.zero);
    (unit, zero)
}

/// The unit that the size of the numbers or a usual rate supports, and the number at which 1970 begins.
fn guessed(
    times: &[f64],
    line: usize,
    others: &[String],
    said: &mut Said,
) -> Result<(TimeUnit, i64), TableFault> {
    let Some(interval) = median_interval(times) else {
        let other = match others {
            [] => String::new(),
            others => format!(
                ", another column ({}) in their place of --columns",
                listed(others)
            ),
        };
        return fault(
            line,
            format!(
                "the times do not increase, so that their unit is not told; expected --time-unit{other}, or --rate HZ \
                 for rows without times"
            ),
        );
    };
    let rate_hz = |unit: TimeUnit| per_s(unit) / interval;
    if let Some(epoch) = epoch_of(None, times).filter(|of| is_within(rate_hz(of.unit), STATED_HZ)) {
        said.note(format!(
            "times are taken for {} since {}, by their size: {:.1} rows a second (--time-unit for others)",
            epoch.unit.name(),
            epoch.since,
            rate_hz(epoch.unit)
        ));
        return Ok((epoch.unit, epoch.zero));
    }
    let are_whole = times.iter().all(|time| time.fract() == 0.0);
    if interval == 1.0 && are_whole {
        return fault(
            line,
            "the times go up by 1: frames, or something else? Expected --time-unit frame with --rate HZ, \
             or another --time-unit",
        );
    }
    let guess = |unit: TimeUnit| {
        format!(
            "times are taken for {}: {:.1} rows a second (--time-unit for others)",
            unit.name(),
            rate_hz(unit)
        )
    };
    let usual = UNITS
        .iter()
        .find(|(unit, _)| is_within(rate_hz(*unit), USUAL_HZ));
    if let Some((unit, _)) = usual {
        said.note(guess(*unit));
        return Ok((*unit, 0));
    }
    let by_interval = UNITS.iter().find(|(_, most)| interval < *most);
    let by_interval = by_interval.map_or(TimeUnit::Nanosecond, |(unit, _)| *unit);
    let all = UNITS.iter().map(|(unit, _)| *unit).chain([TimeUnit::Tick]);
    let possible = all.filter(|unit| match unit {
        // Only where it is a usual rate and the usual unit makes none, as it is rare.
        TimeUnit::Tick => {
            let is_slow = by_interval == TimeUnit::Microsecond;
            is_slow && are_whole && is_within(rate_hz(*unit), USUAL_HZ)
        }
        unit => is_within(rate_hz(*unit), POSSIBLE_HZ),
    });
    let possible: Vec<TimeUnit> = possible.collect();
    let unit = match possible.contains(&TimeUnit::Tick) {
        true => TimeUnit::Tick,
        false => by_interval,
    };
    said.note(guess(unit));
    if possible != [unit] {
        let each = possible
            .iter()
            .map(|unit| format!("{} at {:.1} Hz", unit.name(), rate_hz(*unit)));
        let each: Vec<String> = each.collect();
        let candidates = match each.is_empty() {
            true => "no unit makes a tracker's rate of them".to_owned(),
            false => format!("they may be {}", each.join(" or ")),
        };
        said.against(format!(
            "nothing tells the unit of the times, which go up by {interval}: {candidates}; expected --time-unit, or --rate HZ"
        ));
    }
    Ok((unit, 0))
}

impl Clock {
    /// Whether it counts frames or rows, of which several files have a common first.
    pub(super) fn counts(self) -> bool {
        matches!(self, Self::Frames { .. } | Self::Rows { .. })
    }

    /// Whether it is a time of day, which begins anew at midnight.
    pub(super) fn wraps(self) -> bool {
        matches!(self, Self::Text { .. })
    }

    /// The time of a mark of the head \[ns\].
    pub(super) fn of_mark(self, mark: &HeadMark) -> Option<i64> {
        let of_frame = |rate_hz: f64, first: f64| {
            let frame = number(&mark.frame)?;
            whole_ns((frame - first) / rate_hz * 1e9)
        };
        match self {
            Self::Frames { rate_hz, .. } => of_frame(rate_hz, 0.0),
            Self::Rows { rate_hz } => of_frame(rate_hz, 1.0),
            Self::Column { .. } | Self::Ticks { .. } | Self::Text { .. } | Self::Parts { .. } => {
                nanoseconds(&mark.time, 9)
            }
        }
        .filter(|ns| *ns >= 0)
    }

    /// The time of a row \[ns\], which is the `index`-th of its body. Fails where it says none.
    pub(super) fn of(self, row: &Line, index: usize) -> Result<i64, TableFault> {
        let cell = |column: usize| row.cells.get(column).map_or("", String::as_str);
        let (text, ns) = match self {
            Self::Column { column, power } => (cell(column), nanoseconds(cell(column), power)),
            Self::Ticks { column, zero } => {
                let ticks = nanoseconds(cell(column), 0).and_then(|of| of.checked_sub(zero));
                (cell(column), ticks.and_then(|of| of.checked_mul(100)))
            }
            Self::Text { column } => (cell(column), text_time(cell(column)).map(|of| of.ns)),
            Self::Parts { whole, rest } => {
                let (seconds, rest_ns) = (nanoseconds(cell(whole), 9), nanoseconds(cell(rest), 0));
                let sum = seconds.zip(rest_ns).and_then(|(a, b)| a.checked_add(b));
                (cell(whole), sum)
            }
            Self::Frames { column, rate_hz } => {
                let frame = number(cell(column));
                let ns = frame.and_then(|frame| whole_ns(frame / rate_hz * 1e9));
                (cell(column), ns)
            }
            Self::Rows { rate_hz } => ("", whole_ns(index as f64 / rate_hz * 1e9)),
        };
        match ns {
            Some(ns) if ns >= 0 => Ok(ns),
            Some(_) => fault(
                row.number,
                format!(
                    "a time of {text}, expected 0 or more; --rate HZ counts rows from 0 instead"
                ),
            ),
            None if number(text).is_some() => fault(
                row.number,
                format!(
                    "a time of {text} in this unit is more than 64 bits of nanoseconds hold: expected another --time-unit, \
                     or --rate HZ"
                ),
            ),
            None => fault(
                row.number,
                format!(
                    "{} is no time, expected a number; leave the row out, or part the file there",
                    shown(text)
                ),
            ),
        }
    }
}

fn whole_ns(ns: f64) -> Option<i64> {
    let is_in_range = ns.abs() < i64::MAX as f64;
    is_in_range.then_some(ns.round() as i64)
}
