//! What is said of the peers: a table, figures, raw numbers.

use std::fs;
use std::ops::Range;

use anyhow::Result;
use serde::Serialize;
use serde_json::json;

use super::scenes::Own;
use super::{Answer, FEASIBLE, Report, Settings};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::starts::is_best;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use crate::{Book, Options};

/// What this program is called beside its peers.
const OWN: &str = "enact";
const WHOLE: &str = "enact, whole estimate";
/// Every scene together.
const ALL: &str = "all";

/// One solver on one problem.
#[derive(Clone, Debug, Serialize)]
struct Cell {
    seconds: [f64; 2],
    /// Without what is spent in Python callbacks.
    solver_seconds: f64,
    objective: Option<f64>,
    succeeds: bool,
    is_late: bool,
}

/// One solver on all problems of a scene.
#[derive(Clone, Debug, Serialize)]
struct Row {
    scene: String,
    solver: String,
    problems: usize,
    succeeds: usize,
    late: usize,
    /// Median time, of those that succeed [s].
    seconds: f64,
    /// Median time of ours, of all [s].
    own_seconds: f64,
    /// Time over ours, where both succeed: quartile, median, quartile.
    ratio: [f64; 3],
    /// Median of the same without Python callbacks.
    solver_ratio: f64,
    /// Median of greatest over least time of the repeats, of those that succeed.
    spread: f64,
    /// Median of the objective over the lowest known, of all motions.
    objective: f64,
}

/// Prints the table, keeps figures and raw numbers.
pub fn show(
    scenes: &[(String, Range<usize>)],
    owns: &[Own],
    report: &Report,
    settings: &Settings,
    (options, book): (&Options, &mut Book),
) -> Result<()> {
    let agreements = &report.agreements;
    let worst = |of: fn(&super::Agreement) -> f64| agreements.iter().map(of).fold(0.0, f64::max);
    println!(
        "peers: on {} problems, at every start and solution, objectives agree to {:.1e} of them, \
         constraints to {:.1e} units, derivatives with difference quotients to {:.1e}; {} refused",
        agreements.len(),
        worst(|a| a.objective),
        worst(|a| a.constraint),
        worst(|a| a.derivative),
        agreements.iter().filter(|a| a.refused.is_some()).count(),
    );
    for agreement in agreements.iter().filter(|a| a.refused.is_some()) {
        println!("  problem {}: {:?}", agreement.problem, agreement.refused);
    }
    let own_names = [OWN, WHOLE].map(str::to_owned);
    let names: Vec<String> = own_names.into_iter().chain(peers(report)).collect();
    let cells: Vec<Vec<Option<Cell>>> = (0..owns.len())
        .map(|problem| cells(problem, &names, &owns[problem], report))
        .collect();
    let all = (ALL.to_owned(), 0..owns.len());
    let rows: Vec<Row> = scenes
        .iter()
        .chain([&all])
        .flat_map(|(scene, range)| {
            let cells = &cells[range.clone()];
            (0..names.len()).map(move |solver| (scene, solver, cells))
        })
        .map(|(scene, solver, cells)| row(scene, &names[solver], solver, cells))
        .collect();
    println!("{}", table(&rows));
    for figure in figures(scenes, &names, &rows, settings) {
        book.keep(figure)?;
    }
    let raw = json!({
        "versions": report.versions,
        "limit_s": settings.limit_s,
        "repeats": settings.repeats,
        "rows": rows,
        "own": owns,
        "agreements": report.agreements,
        "answers": report.answers,
    });
    fs::create_dir_all(&options.folder)?;
    fs::write(options.folder.join("peers_raw.json"), format!("{raw}\n"))?;
    Ok(())
}

/// Prints how many motions the peers find from the truth.
pub fn show_control(problems: usize, report: &Report) {
    println!(
        "From the truth, of {problems} problems, one of each scene that has one, a motion is found by"
    );
    for name in peers(report) {
        let answers = report.answers.iter().filter(|answer| answer.peer == name);
        let motions = answers.filter(|answer| answer.is_motion()).count();
        println!("  {name}: {motions}");
    }
}

/// Names of the peers in the order in which they answered.
fn peers(report: &Report) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for answer in &report.answers {
        if !names.contains(&answer.peer) {
            names.push(answer.peer.clone());
        }
    }
    names
}

/// What every solver made of a problem; `None` of those that were not given it.
fn cells(problem: usize, names: &[String], own: &Own, report: &Report) -> Vec<Option<Cell>> {
    let answers = || report.answers.iter().filter(|a| a.problem == problem);
    let motions = answers().filter(|answer| answer.is_motion());
    let own_is_motion = own.violation < FEASIBLE && own.is_in_order;
    let lowest = motions
        .filter_map(|answer| answer.objective)
        .chain(own.lowest)
        .chain(own_is_motion.then_some(own.objective))
        .fold(f64::INFINITY, f64::min);
    let of_peer = |answer: &Answer| Cell {
        seconds: answer.seconds,
        solver_seconds: answer.seconds[0] - answer.callback_seconds.unwrap_or(0.0),
        objective: answer
            .objective
            .filter(|_| answer.is_motion())
            .map(|o| o / lowest),
        succeeds: answer.is_success(lowest),
        is_late: answer.status == "over the limit",
    };
    let of_own = |seconds: [f64; 2], objective: f64, is_motion: bool| Cell {
        seconds,
        solver_seconds: seconds[0],
        objective: is_motion.then_some(objective / lowest),
        succeeds: is_motion && is_best(objective, lowest),
        is_late: false,
    };
    names
        .iter()
        .map(|name| match name.as_str() {
            OWN => Some(of_own(own.seconds, own.objective, own_is_motion)),
            WHOLE => Some(of_own(
                own.whole_seconds,
                own.whole_objective,
                own.whole_is_motion,
            )),
            name => answers().find(|answer| answer.peer == name).map(of_peer),
        })
        .collect()
}

fn row(scene: &str, name: &str, solver: usize, cells: &[Vec<Option<Cell>>]) -> Row {
    let all = || cells.iter().filter_map(|cells| cells[solver].as_ref());
    let good = || all().filter(|cell| cell.succeeds);
    let both = || {
        cells.iter().filter_map(|cells| {
            let (own, other) = (cells[0].as_ref()?, cells[solver].as_ref()?);
            (own.succeeds && other.succeeds).then_some((own, other))
        })
    };
    let ratios: Vec<f64> = both()
        .map(|(own, o)| o.seconds[0] / own.seconds[0])
        .collect();
    let solver_ratios: Vec<f64> = both()
        .map(|(own, o)| o.solver_seconds / own.seconds[0])
        .collect();
    let own_seconds: Vec<f64> = cells
        .iter()
        .filter_map(|cells| Some(cells[0].as_ref()?.seconds[0]))
        .collect();
    let of_good = |value: fn(&Cell) -> f64| median(&good().map(value).collect::<Vec<f64>>());
    Row {
        scene: scene.to_owned(),
        solver: name.to_owned(),
        problems: all().count(),
        succeeds: good().count(),
        late: all().filter(|cell| cell.is_late).count(),
        seconds: of_good(|cell| cell.seconds[0]),
        own_seconds: median(&own_seconds),
        ratio: [0.25, 0.5, 0.75].map(|share| quantile(&ratios, share)),
        solver_ratio: median(&solver_ratios),
        spread: of_good(|cell| cell.seconds[1] / cell.seconds[0]),
        objective: median(
            &all()
                .filter_map(|cell| cell.objective)
                .collect::<Vec<f64>>(),
        ),
    }
}

fn table(rows: &[Row]) -> Table {
    let title = "The same problems from the same start";
    let header = [
        "scene",
        "solver",
        "n",
        "best optimum",
        "over the limit",
        "ms, median",
        "times ours (quartiles)",
        "without callbacks",
        "greatest over least",
        "objective over the lowest",
    ];
    let mut table = Table::new(title, &header);
    let shown = |value: f64| {
        if value.is_nan() {
            "–".to_owned()
        } else {
            number(value)
        }
    };
    for row in rows {
        let [low, middle, high] = row.ratio.map(shown);
        table.row([
            row.scene.clone(),
            row.solver.clone(),
            row.problems.to_string(),
            percent(row.succeeds, row.problems),
            percent(row.late, row.problems),
            shown(1e3 * row.seconds),
            format!("{middle} ({low}–{high})"),
            shown(row.solver_ratio),
            shown(row.spread),
            if row.objective.is_nan() {
                "–".into()
            } else {
                format!("{:.5}", row.objective)
            },
        ]);
    }
    table
}

fn figures(
    scenes: &[(String, Range<usize>)],
    names: &[String],
    rows: &[Row],
    settings: &Settings,
) -> Vec<Figure> {
    let note = format!(
        "{} problems a scene; least of {} solves, a solve longer than {} s has failed; \
         derivatives compiled, compiling not counted.",
        scenes
            .iter()
            .map(|(_, range)| range.len())
            .max()
            .unwrap_or(0),
        settings.repeats,
        settings.limit_s,
    );
    // Scenes in their order, and those of the cube at the default distortion by their bounces.
    let by_scene = |row: &Row| {
        let at = scenes.iter().position(|(name, _)| *name == row.scene)?;
        Some(at as f64)
    };
    let by_bounces = |row: &Row| {
        let text = row
            .scene
            .strip_prefix("cube, ")?
            .strip_suffix(" bounces, 1×")?;
        text.parse::<f64>().ok()
    };
    let scene_names = || scenes.iter().map(|(name, _)| name.clone()).collect();
    let scene_axis = || Axis::named("scene", scene_names());
    let bounce_axis = || Axis::logarithmic("bounces");
    let figure = |name: &str, title: &str, note: String, x: Axis, y: Axis, curves| Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        note,
        x,
        y,
        curves,
    };
    let ratio = |row: &Row| ratio_mark(row, settings);
    vec![
        figure(
            "peers_ratio",
            "How many times as long general solvers take for the same problem from the same start",
            note.clone(),
            scene_axis(),
            Axis::logarithmic("time over enact's"),
            curves(&names[1..], rows, by_scene, ratio),
        ),
        figure(
            "peers_success",
            "How often the best known optimum is found",
            note.clone(),
            scene_axis(),
            Axis::linear("best optimum found, %"),
            curves(names, rows, by_scene, success_mark),
        ),
        figure(
            "peers_bounces_time",
            "Time to the best known optimum as a cube bounces more often",
            note.clone(),
            bounce_axis(),
            Axis::logarithmic("time, s"),
            curves(names, rows, by_bounces, |row| time_mark(row, settings)),
        ),
        figure(
            "peers_bounces_success",
            "How often the best known optimum is found as a cube bounces more often",
            note,
            bounce_axis(),
            Axis::linear("best optimum found, %"),
            curves(names, rows, by_bounces, success_mark),
        ),
    ]
}

fn curves(
    names: &[String],
    rows: &[Row],
    x: impl Fn(&Row) -> Option<f64>,
    y: impl Fn(&Row) -> Mark,
) -> Vec<Curve> {
    let of = |name: &String| {
        let rows = rows.iter().filter(|row| row.solver == *name);
        let points = rows.filter_map(|row| {
            Some(Mark {
                x: x(row)?,
                setting: Some(row.scene.clone()),
                ..y(row)
            })
        });
        let points = points.collect();
        if name == OWN {
            Curve::ours(name, points)
        } else {
            Curve::new(name, points)
        }
    };
    names.iter().map(of).collect()
}

/// A solver that succeeded nowhere has taken the limit at least.
fn ratio_mark(row: &Row, settings: &Settings) -> Mark {
    let [low, middle, high] = row.ratio;
    if middle.is_nan() {
        return Mark {
            y: settings.limit_s / row.own_seconds,
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

fn time_mark(row: &Row, settings: &Settings) -> Mark {
    Mark {
        y: if row.seconds.is_nan() {
            settings.limit_s
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
