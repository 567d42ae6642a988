//! A table and figures of the peers.

use anyhow::Result;

use super::account::{ALL, Measured, OWN, Row, WHOLE};
use crate::Book;
use crate::figure::{Axis, Curve, Figure, Mark, Sheet};
use crate::table::{number, percent};

/// Makes them.
pub fn present(measured: &Measured, book: &mut Book) -> Result<()> {
    book.tabulate(sheet(measured))?;
    for figure in figures(measured) {
        book.keep(figure)?;
    }
    Ok(())
}

/// Values of a column, each once, in order.
fn distinct(rows: &[Row], of: fn(&Row) -> &String) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for row in rows {
        if !all.contains(of(row)) {
            all.push(of(row).clone());
        }
    }
    all
}

/// A scene's line: ours in milliseconds, the others by success and by time over ours.
fn sheet(measured: &Measured) -> Sheet {
    let rows = &measured.rows;
    let solvers = distinct(rows, |row| &row.solver);
    let peers: Vec<&String> = solvers
        .iter()
        .filter(|s| *s != OWN && *s != WHOLE)
        .collect();
    let own = ["scene", "problems", "enact", "whole estimate"];
    let header = own.iter().map(|cell| (*cell).to_owned());
    let lines = distinct(rows, |row| &row.scene).into_iter().map(|scene| {
        let of = |solver: &str| {
            let mut here = rows.iter().filter(|row| row.scene == scene);
            here.find(|row| row.solver == solver)
        };
        let own = |solver: &str| {
            of(solver).map_or("–".into(), |row| {
                let share = percent(row.succeeds, row.problems);
                format!("{share}, {} ms", shown(1e3 * row.seconds))
            })
        };
        let problems = of(OWN).map_or(0, |row| row.problems).to_string();
        let mut line = vec![scene.clone(), problems, own(OWN), own(WHOLE)];
        line.extend(peers.iter().map(|peer| {
            of(peer).map_or("–".into(), |row| {
                let share = percent(row.succeeds, row.problems);
                format!("{share}, × {}", shown(row.ratio[1]))
            })
        }));
        line
    });
    Sheet {
        name: "peers".to_owned(),
        title: "Share that ends at the best known optimum, of whole estimates share that is physical (of the \
                die plausible); ours: median time of those; peers: median of the time over ours, where both \
                succeed."
            .to_owned(),
        header: header.chain(peers.iter().map(|peer| (*peer).clone())).collect(),
        rows: lines.collect(),
    }
}

fn shown(value: f64) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else {
        number(value)
    }
}

fn figures(measured: &Measured) -> Vec<Figure> {
    let rows = &measured.rows;
    let solvers = distinct(rows, |row| &row.solver);
    let scenes: Vec<String> = distinct(rows, |row| &row.scene);
    let scenes = scenes.into_iter().filter(|scene| scene != ALL);
    let parts: Vec<(String, String, String)> = scenes
        .filter_map(|scene| {
            let (what, distortion) = scene.rsplit_once(' ')?;
            let what = what.trim_end_matches(',').to_owned();
            Some((scene.clone(), what, distortion.to_owned()))
        })
        .collect();
    let note = format!(
        "{} problems a scene; least of {} solves, a solve longer than {} s has failed; derivatives \
         compiled, compiling not counted. Timing known where nothing is said.",
        rows.iter().map(|row| row.problems).min().unwrap_or(0),
        measured.repeats,
        measured.limit_s,
    );
    let figure = |name: String, title: String, x: Axis, y: Axis, curves| Figure {
        name,
        title,
        note: note.clone(),
        x,
        y,
        curves,
    };
    let mut figures = Vec::new();
    let mut distortions: Vec<&String> = parts.iter().map(|(_, _, distortion)| distortion).collect();
    distortions.dedup();
    for distortion in distortions {
        let here = || parts.iter().filter(|(_, _, of)| of == distortion);
        let at = |row: &Row| {
            here()
                .position(|(scene, ..)| *scene == row.scene)
                .map(|at| at as f64)
        };
        let axis = || Axis::named("scene", here().map(|(_, what, _)| what.clone()).collect());
        let file = distortion.replace('×', "x");
        figures.push(figure(
            format!("peers_ratio_{file}"),
            format!(
                "How many times as long as enact general solvers take from the same start, \
                 {distortion} distortion"
            ),
            axis(),
            Axis::logarithmic("time over enact's"),
            curves(&solvers[1..], rows, at, |row| {
                ratio_mark(row, measured.limit_s)
            }),
        ));
        figures.push(figure(
            format!("peers_success_{file}"),
            format!("How often the best known optimum is found, {distortion} distortion"),
            axis(),
            Axis::linear("best optimum found, %"),
            curves(&solvers, rows, at, success_mark),
        ));
    }
    let bounces = |row: &Row| {
        let rest = row.scene.strip_prefix("cube, ")?;
        rest.strip_suffix(" bounces, 1×")?.parse::<f64>().ok()
    };
    figures.push(figure(
        "peers_bounces_time".to_owned(),
        "Time to the best known optimum as a cube bounces more often".to_owned(),
        Axis::logarithmic("bounces"),
        Axis::logarithmic("time, s"),
        curves(&solvers, rows, bounces, |row| {
            time_mark(row, measured.limit_s)
        }),
    ));
    figures
}

fn curves(
    solvers: &[String],
    rows: &[Row],
    x: impl Fn(&Row) -> Option<f64>,
    y: impl Fn(&Row) -> Mark,
) -> Vec<Curve> {
    let of = |solver: &String| {
        let rows = rows.iter().filter(|row| row.solver == *solver);
        let points = rows.filter_map(|row| {
            Some(Mark {
                x: x(row)?,
                ..y(row)
            })
        });
        let points = points.collect();
        if solver == OWN {
            Curve::ours(solver, points)
        } else {
            Curve::new(solver, points)
        }
    };
    solvers.iter().map(of).collect()
}

/// A solver that succeeded nowhere has taken the limit at least.
fn ratio_mark(row: &Row, limit_s: f64) -> Mark {
    let [low, middle, high] = row.ratio;
    if middle.is_nan() {
        return Mark {
            y: limit_s / row.own_seconds,
            failed: true,
            ..Mark::default()
        };
    }
    Mark {
        y: middle,
        spread: Some([low, high]),
        ..Mark::default()
    }
}

fn time_mark(row: &Row, limit_s: f64) -> Mark {
    Mark {
        y: if row.seconds.is_nan() {
            limit_s
        } else {
            row.seconds
        },
        failed: row.seconds.is_nan(),
        ..Mark::default()
    }
}

fn success_mark(row: &Row) -> Mark {
    Mark {
        y: 100.0 * row.succeeds as f64 / row.problems.max(1) as f64,
        failed: row.succeeds == 0,
        ..Mark::default()
    }
}
