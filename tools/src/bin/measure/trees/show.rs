//! Charts and tables of the integrators.

use super::methods::{METHODS, PROGRAM};
use super::{Derived, Measured, Point};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::table::{Table, number};

/// What stands up in a chart.
#[derive(Clone, Copy)]
pub enum Cost {
    Time,
    RightSides,
}

fn curves(measured: &Measured, mark: impl Fn(&Point) -> Mark) -> Vec<Curve> {
    let curve = |(name, _): &(&str, _)| {
        let own = measured.points.iter().filter(|point| point.method == *name);
        let marks = own.map(&mark).collect();
        match *name == PROGRAM {
            true => Curve::ours(*name, marks),
            false => Curve::new(*name, marks),
        }
    };
    METHODS.iter().map(curve).collect()
}

const NOTE: &str = "One point per number of steps or tolerance: medians over the seeds. Errors: the greatest of an angle [rad] or a rate, in \
     units of 7 rad/s, at the end.";

/// Error across, cost up.
pub fn precision(measured: &Measured, cost: Cost) -> Figure {
    let (suffix, label, of) = match cost {
        Cost::Time => ("time", "time of the whole motion [s]", "time"),
        Cost::RightSides => ("right_sides", "evaluations of the accelerations", "work"),
    };
    let mark = |point: &Point| Mark {
        x: point.error.max(1e-16),
        y: match cost {
            Cost::Time => point.seconds,
            Cost::RightSides => point.right_sides,
        },
        setting: Some(point.setting.clone()),
        failed: point.failures > 0,
        ..Mark::default()
    };
    Figure {
        name: format!("trees_{}_{suffix}", measured.name),
        title: format!(
            "Motion of {} over {} s, {of}: the further left the more exact, the further down the cheaper",
            measured.title, measured.duration_s
        ),
        note: NOTE.to_owned(),
        x: Axis::logarithmic("error at the end"),
        y: Axis::logarithmic(label),
        curves: curves(measured, mark),
    }
}

/// Work across, drift of the energy up.
pub fn drift(measured: &Measured) -> Figure {
    let mark = |point: &Point| Mark {
        x: point.right_sides,
        y: point.drift.max(1e-17),
        setting: Some(point.setting.clone()),
        failed: point.failures > 0,
        ..Mark::default()
    };
    Figure {
        name: format!("trees_{}_energy", measured.name),
        title: format!(
            "Drift of the energy of {} over {} s: the further down the better kept",
            measured.title, measured.duration_s
        ),
        note: format!("Relative to the kinetic energy at the start. {NOTE}"),
        x: Axis::logarithmic("evaluations of the accelerations"),
        y: Axis::logarithmic("change of the energy, relative"),
        curves: curves(measured, mark),
    }
}

/// Cost of an error, between points by a power law; none where no point is as exact.
fn cost_at(points: &[&Point], error: f64) -> Option<f64> {
    let at = points.iter().position(|point| point.error <= error)?;
    let fine = points[at];
    let Some(coarse) = at.checked_sub(1).map(|before| points[before]) else {
        return Some(fine.seconds);
    };
    if !(coarse.error.is_finite() && fine.error > 0.0) {
        return Some(fine.seconds);
    }
    let share = (coarse.error / error).ln() / (coarse.error / fine.error).ln();
    Some((coarse.seconds.ln() + share * (fine.seconds / coarse.seconds).ln()).exp())
}

/// Times to an error.
pub fn reach(all: &[Measured], error: f64, name: &str) -> Table {
    let mut header = vec!["µs per motion"];
    header.extend(METHODS.map(|(name, _)| name));
    let mut table = Table::new(name, "", &header);
    for measured in all {
        let mut cells = vec![measured.title.clone()];
        for (method, _) in METHODS {
            let own = measured
                .points
                .iter()
                .filter(|point| point.method == method);
            let own: Vec<&Point> = own.filter(|point| point.failures == 0).collect();
            let micros = cost_at(&own, error).map(|seconds| number(1e6 * seconds));
            cells.push(micros.unwrap_or("–".to_owned()));
        }
        table.row(cells);
    }
    table
}

/// What the program does.
pub fn program(all: &[Measured]) -> Table {
    let header = [
        "motion",
        "the reference is uncertain by",
        "directions",
        "steps",
        "error",
        "energy",
        "plain, µs",
        "with derivatives, µs",
        "ratio",
        "on the way: steps",
        "error",
        "energy",
        "plain, µs",
        "with derivatives, µs",
        "ratio",
    ];
    let mut table = Table::new("program", "", &header);
    for measured in all {
        let Derived { exact, rough } = &measured.derived;
        let mut cells = vec![
            measured.title.clone(),
            format!("{:.0e}", measured.reference),
            measured.directions.to_string(),
        ];
        for steps in [exact, rough] {
            cells.extend([
                number(steps.steps),
                format!("{:.0e}", steps.error),
                format!("{:.0e}", steps.drift),
                number(1e6 * steps.plain_s),
                number(1e6 * steps.derived_s),
                number(steps.ratio),
            ]);
        }
        table.row(cells);
    }
    table
}
