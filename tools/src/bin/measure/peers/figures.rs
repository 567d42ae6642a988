//! A table and figures of the peers.

use super::Settings;
use super::account::{Block, OWN, Row, WHOLE};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::table::{Table, number, percent};

/// A scene's line: ours in milliseconds, the others by success and by time over ours.
pub fn table(rows: &[Row], blocks: &[Block], solvers: &[&str]) -> Table {
    let header = [
        &["scene", "problems", "enact", "whole estimate"],
        &solvers[2..],
    ]
    .concat();
    let title = "Share that ends at the best known optimum, of whole estimates share that is physical (of the die \
                 plausible); ours: median time of those; peers: median of the time over ours, where both succeed";
    let mut table = Table::new("peers", title, &header);
    for (index, block) in blocks.iter().enumerate() {
        let own: Vec<&Row> = rows.iter().filter(|row| row.block == index).collect();
        let mut line = vec![block.name.clone(), own[0].problems.to_string()];
        line.extend(own.iter().map(|row| {
            let share = percent(row.succeeds, row.problems);
            let is_own = [OWN, WHOLE].contains(&row.solver.as_str());
            let late = match row.late {
                0 => String::new(),
                late => format!(", {late} late"),
            };
            if is_own {
                format!("{share}, {} ms", number(1e3 * row.seconds))
            } else {
                format!("{share}, × {}{late}", number(row.ratio[1]))
            }
        }));
        table.row(line);
    }
    table
}

/// All figures.
pub fn all(rows: &[Row], blocks: &[Block], solvers: &[&str], settings: &Settings) -> Vec<Figure> {
    let limit_s = settings.limit_s;
    let note = format!(
        "{} problems a scene; least of {} solves, a solve longer than {limit_s} s is stopped and has failed, which is \
         said beside it; derivatives compiled, compiling not counted. Timing known where nothing is said.",
        rows.iter().map(|row| row.problems).min().unwrap_or(0),
        settings.repeats,
    );
    let figure = |name: String, title: String, x: Axis, y: Axis, curves| Figure {
        name,
        title,
        note: note.clone(),
        x,
        y,
        curves,
    };
    let mut distortions: Vec<f64> = blocks.iter().filter_map(|block| block.distortion).collect();
    distortions.dedup();
    let mut figures = Vec::new();
    for distortion in distortions {
        let here = || {
            blocks
                .iter()
                .enumerate()
                .filter(|(_, block)| block.distortion == Some(distortion))
        };
        let at = |row: &Row| {
            here()
                .position(|(index, _)| index == row.block)
                .map(|at| at as f64)
        };
        let axis = || {
            Axis::named(
                "scene",
                here().map(|(_, block)| block.what.clone()).collect(),
            )
        };
        figures.push(figure(
            format!("peers_ratio_{distortion}x"),
            format!("How many times as long as enact general solvers take from the same start, {distortion}× distortion"),
            axis(),
            Axis::logarithmic("time over enact's"),
            curves(&solvers[1..], rows, at, |row| ratio_mark(row, limit_s)),
        ));
        figures.push(figure(
            format!("peers_success_{distortion}x"),
            format!("How often the best known optimum is found, {distortion}× distortion"),
            axis(),
            Axis::linear("best optimum found, %"),
            curves(solvers, rows, at, success_mark),
        ));
    }
    let bounces = |row: &Row| {
        let block = &blocks[row.block];
        block
            .bounces
            .filter(|_| block.distortion == Some(1.0))
            .map(|count| count as f64)
    };
    figures.push(figure(
        "peers_bounces_time".to_owned(),
        "Time to the best known optimum as a cube bounces more often".to_owned(),
        Axis::logarithmic("bounces"),
        Axis::logarithmic("time, s"),
        curves(solvers, rows, bounces, |row| time_mark(row, limit_s)),
    ));
    figures
}

fn curves(
    solvers: &[&str],
    rows: &[Row],
    x: impl Fn(&Row) -> Option<f64>,
    y: impl Fn(&Row) -> Mark,
) -> Vec<Curve> {
    let of = |solver: &&str| {
        let rows = rows.iter().filter(|row| row.solver == *solver);
        let points = rows
            .filter_map(|row| {
                Some(Mark {
                    x: x(row)?,
                    ..y(row)
                })
            })
            .collect();
        match *solver {
            OWN => Curve::ours(OWN, points),
            other => Curve::new(other, points),
        }
    };
    solvers.iter().map(of).collect()
}

/// How many the limit of time stopped.
fn late(row: &Row) -> Option<String> {
    (row.late > 0).then(|| format!("{} late", row.late))
}

/// A solver that succeeded nowhere has taken the limit at least.
fn ratio_mark(row: &Row, limit_s: f64) -> Mark {
    let [low, middle, high] = row.ratio;
    let failed = middle.is_nan();
    Mark {
        y: if failed {
            limit_s / row.own_seconds
        } else {
            middle
        },
        spread: (!failed).then_some([low, high]),
        setting: late(row),
        failed,
        ..Mark::default()
    }
}

fn time_mark(row: &Row, limit_s: f64) -> Mark {
    let failed = row.seconds.is_nan();
    Mark {
        y: if failed { limit_s } else { row.seconds },
        setting: late(row),
        failed,
        ..Mark::default()
    }
}

fn success_mark(row: &Row) -> Mark {
    Mark {
        y: 100.0 * row.succeeds as f64 / row.problems.max(1) as f64,
        setting: late(row),
        failed: row.succeeds == 0,
        ..Mark::default()
    }
}
