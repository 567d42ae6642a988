//! Times of rows as integer nanoseconds.

use super::layout::{Fault, Layout, TimeColumns, fault};
use super::stamp::nanoseconds;
use super::text::{Line, number};
use super::units::TimeUnit;

/// Units with the greatest interval between samples that they are taken for, in the unit itself: trackers
/// give 5 to 2500 samples a second.
const INTERVALS: [(TimeUnit, f64); 4] = [
    (TimeUnit::Second, 0.4),
    (TimeUnit::Millisecond, 200.0),
    (TimeUnit::Microsecond, 200_000.0),
    (TimeUnit::Nanosecond, f64::INFINITY),
];

/// How the rows are stamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Clock {
    /// By a column in a unit.
    Column { column: usize, power: i32 },
    /// By whole seconds and the nanoseconds past them.
    Parts { whole: usize, rest: usize },
    /// By the number of the frame, from the first on.
    Frames {
        column: usize,
        rate_hz: f64,
        first: f64,
    },
    /// By the place of the row.
    Rows { rate_hz: f64 },
}

/// The clock that the layout, the options and the rows give; says what it guesses.
pub(super) fn clock(
    layout: &Layout,
    rows: &[Line],
    unit: Option<TimeUnit>,
    rate_hz: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Clock, Fault> {
    let rate_or = |what: &str, line: usize| match rate_hz.or(layout.rate_hz) {
        Some(rate_hz) => Ok(rate_hz),
        None => fault(
            line,
            format!("{what}, expected --rate HZ, so many a second"),
        ),
    };
    let line = rows.first().map_or(0, |row| row.number);
    let (column, stated) = match layout.time {
        TimeColumns::Two(whole, rest) if rate_hz.is_none() => {
            return Ok(Clock::Parts { whole, rest });
        }
        TimeColumns::One(column, stated) => (column, unit.or(stated)),
        TimeColumns::Two(..) | TimeColumns::Row => {
            let rate_hz = rate_or("no column of times", line)?;
            return Ok(Clock::Rows { rate_hz });
        }
    };
    if stated == Some(TimeUnit::Frame) {
        let rate_hz = rate_or("the times are numbers of frames", line)?;
        let cell = rows.first().and_then(|row| row.cells.get(column));
        let Some(first) = cell.and_then(|cell| number(cell)) else {
            return fault(line, "no number of a frame in the first row, expected one");
        };
        return Ok(Clock::Frames {
            column,
            rate_hz,
            first,
        });
    }
    // A rate that is asked for stamps by the place of the row: what a camera that counts means.
    if let Some(rate_hz) = rate_hz {
        return Ok(Clock::Rows { rate_hz });
    }
    let unit = match stated {
        Some(unit) => unit,
        None => guessed(column, rows, line, notes)?,
    };
    let power = unit.nanosecond_power().unwrap_or(0);
    Ok(Clock::Column { column, power })
}

/// The unit in which the median interval is that of a tracker.
fn guessed(
    column: usize,
    rows: &[Line],
    line: usize,
    notes: &mut Vec<String>,
) -> Result<TimeUnit, Fault> {
    let times = rows.iter().filter_map(|row| number(row.cells.get(column)?));
    let times: Vec<f64> = times.collect();
    let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.retain(|interval| *interval > 0.0);
    intervals.sort_by(f64::total_cmp);
    let Some(median) = intervals.get(intervals.len() / 2).copied() else {
        return fault(
            line,
            "the times do not increase, so that their unit is not told; expected --time-unit, or --rate \
             HZ for rows without times",
        );
    };
    if intervals.iter().all(|interval| interval.fract() == 0.0) && median == 1.0 {
        return fault(
            line,
            "the times go up by 1: frames, or something else? Expected --time-unit frame with --rate HZ, \
             or another --time-unit",
        );
    }
    let found = INTERVALS.iter().find(|(_, most)| median < *most);
    let unit = found.map_or(TimeUnit::Nanosecond, |(unit, _)| *unit);
    let per_s = 10_f64.powi(unit.nanosecond_power().unwrap_or(0) - 9);
    notes.push(format!(
        "times are taken for {}: {:.1} rows a second (--time-unit for others)",
        unit.name(),
        1.0 / (median * per_s)
    ));
    Ok(unit)
}

impl Clock {
    /// The time of a row \[ns\], which is the `index`-th of its body. `None` where it says none.
    pub(super) fn of(self, row: &Line, index: usize) -> Result<i64, Fault> {
        let cell = |column: usize| row.cells.get(column).map_or("", String::as_str);
        let whole = |ns: f64| {
            let is_in_range = ns.abs() < i64::MAX as f64;
            is_in_range.then_some(ns.round() as i64)
        };
        let (shown, ns) = match self {
            Self::Column { column, power } => (cell(column), nanoseconds(cell(column), power)),
            Self::Parts { whole, rest } => {
                let (seconds, rest_ns) = (nanoseconds(cell(whole), 9), nanoseconds(cell(rest), 0));
                let sum = seconds.zip(rest_ns).and_then(|(a, b)| a.checked_add(b));
                (cell(whole), sum)
            }
            Self::Frames {
                column,
                rate_hz,
                first,
            } => {
                let frame = number(cell(column));
                let ns = frame.and_then(|frame| whole((frame - first) / rate_hz * 1e9));
                (cell(column), ns)
            }
            Self::Rows { rate_hz } => ("", whole(index as f64 / rate_hz * 1e9)),
        };
        match ns {
            Some(ns) if ns >= 0 => Ok(ns),
            Some(_) => fault(
                row.number,
                format!(
                    "a time of {shown}, expected 0 or more; --rate HZ counts rows from 0 instead"
                ),
            ),
            None => fault(
                row.number,
                format!("{shown:?} is no time, expected a number"),
            ),
        }
    }
}
