//! Figures and tables of the flows.

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::table::Table;
use enact_tools::front::{Point, Task, Turning};

/// Which error stands across.
#[derive(Clone, Copy)]
pub enum Error {
    Rotation,
    Derivative,
}

/// The chart of a task.
pub fn figure(turning: &Turning, task: &Task, error: Error) -> Figure {
    let Turning {
        title,
        moments,
        omega,
        ..
    } = turning;
    let mut names: Vec<&str> = Vec::new();
    for point in &task.points {
        if !names.contains(&point.method.as_str()) {
            names.push(&point.method);
        }
    }
    let curve = |name: &&str| {
        let own = task.points.iter().filter(|point| point.method == *name);
        let mark = |point: &Point| Mark {
            x: match error {
                Error::Rotation => point.error_rad,
                Error::Derivative => point.derivative_error,
            }
            .map_or(f64::NAN, |error| error.max(1e-17)),
            y: point.fastest_s,
            spread: Some([point.fastest_s, point.median_s]),
            setting: (!point.setting.is_empty()).then(|| point.setting.clone()),
            failed: point.failed(),
        };
        let curve = Curve::new(*name, own.map(mark).collect());
        if *name == turning.chosen {
            Curve::ours(*name, curve.points)
        } else {
            curve
        }
    };
    let (duration_s, condition) = (task.duration_s, task.condition_rad);
    let (of, across, ending) = match error {
        Error::Rotation => (
            "Turn",
            format!("error of the orientation after {duration_s} s [rad]"),
            "",
        ),
        Error::Derivative => (
            "Derivative of the turn",
            format!(
                "error of the orientation's derivative by the first angular velocity after {duration_s} s, relative"
            ),
            "_derivative",
        ),
    };
    let (asked, suffix) = match task.samples {
        1 => ("asked for once".to_owned(), "once"),
        samples => (format!("asked for at {samples} samples"), "flight"),
    };
    Figure {
        name: format!("flow_{}_{duration_s}s_{suffix}{ending}", turning.name),
        title: format!(
            "{of} of {title} over {duration_s} s, {asked}: the further left the more exact, the further down the faster"
        ),
        note: format!(
            "Moments {moments:?}, first angular velocity {omega:?} rad/s. One point per tolerance or step. \
             Times: fastest run, bars to the median of all. Half a rounding of the first angular velocity \
             turns the end by {condition:.1e} rad."
        ),
        x: Axis::logarithmic(&across),
        y: Axis::logarithmic("time per evaluation with derivatives [s]"),
        curves: names.iter().map(curve).collect(),
    }
}

/// Whether anything is ahead of the program.
pub fn fronts(turnings: &[Turning]) -> Table {
    let header = [
        "body",
        "duration",
        "times asked for",
        "the program's, per time",
        "its error, rad",
        "its derivative's, relative",
        "fastest other that is exact to rounding",
        "its time over the program's",
        "as exact to rounding, and faster",
        "program on the front",
    ];
    let mut table = Table::new("fronts", "", &header);
    for turning in turnings {
        for task in &turning.tasks {
            let ours = task.ours();
            let other = task.fastest_exact_other();
            let faster = task.as_exact_and_faster().into_iter();
            let faster = faster.min_by(|a, b| a.fastest_s.total_cmp(&b.fastest_s));
            let named = |point: &Point| format!("{} {}", point.method, point.setting);
            let over = |other: &Point| format!("{:.2}", other.fastest_s / ours.fastest_s);
            let is_front = task.ahead_of_ours().is_empty();
            table.row([
                turning.title.clone(),
                format!("{} s", task.duration_s),
                task.samples.to_string(),
                format!("{:.3} µs", 1e6 * ours.fastest_s),
                format!("{:.0e}", ours.error_rad.unwrap_or(f64::NAN)),
                format!("{:.0e}", ours.derivative_error.unwrap_or(f64::NAN)),
                other.map_or("none".to_owned(), named),
                other.map_or("–".to_owned(), over),
                faster.map_or("nothing".to_owned(), named),
                if is_front { "yes" } else { "no" }.to_owned(),
            ]);
        }
    }
    table
}

/// How far two references are apart.
pub fn references(turnings: &[Turning]) -> Table {
    let header = [
        "body",
        "rotations differ by at most, rad",
        "derivatives, relative",
    ];
    let mut table = Table::new("references", "", &header);
    for turning in turnings {
        let worst = |index: usize| {
            let all = turning.tasks.iter().map(|task| task.reference[index]);
            format!("{:.0e}", all.fold(0.0, f64::max))
        };
        table.row([turning.title.clone(), worst(0), worst(1)]);
    }
    table
}
