//! Figures of sweeps.

use super::KINDS;
use super::bound::Level;
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::statistics::{INTERVALS, wilson};

/// Errors of the bounce's time beside their bound.
pub fn event_times(name: &str, what: &str, label: &str, note: &str, levels: &[Level]) -> Figure {
    let bounds = levels.iter().map(|l| Mark::at(l.x, 1e3 * l.event_s[1]));
    let errors = levels
        .iter()
        .map(|level| level.mark(1e3 * level.event_s[0]));
    Figure {
        name: format!("uncertainty_{name}"),
        title: format!(
            "How exactly the bounce is timed, against {what}, beside the least error any unbiased estimate can have"
        ),
        note: format!(
            "{note} Rms error; bars: 95 % of such an rms. Beside a point: how many gave a physical motion, where not all."
        ),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("rms error of the bounce's time [ms]"),
        curves: vec![
            Curve::ours("the program", errors.collect()),
            Curve::bound("Cramér–Rao bound", bounds.collect()),
        ],
    }
}

/// The same of every kind of unknown, as a ratio.
pub fn efficiency(name: &str, what: &str, label: &str, note: &str, levels: &[Level]) -> Figure {
    let of_kind = |kind: usize| {
        let marks = levels.iter().filter(|level| level.bounds[kind] > 0.0);
        let marks = marks.map(|level| Mark {
            setting: None,
            ..level.mark(level.errors[kind] / level.bounds[kind])
        });
        Curve::new(KINDS[kind], marks.collect())
    };
    let mut curves: Vec<Curve> = (0..5).map(of_kind).collect();
    curves.push(Curve::bound("the bound", ends(levels, 1.0)));
    Figure {
        name: format!("uncertainty_{name}_efficiency"),
        title: format!(
            "Errors of all unknowns over their Cramér–Rao bounds, against {what}: 1 is as good as can be"
        ),
        note: format!(
            "{note} Rms over all unknowns of a kind; bars: 95 % of the rms of as many independent errors."
        ),
        x: Axis::logarithmic(label),
        y: Axis::linear("rms error over its bound"),
        curves,
    }
}

/// Shares of intervals of event times that hold the truth.
pub fn coverage(name: &str, title: &str, label: &str, note: &str, levels: &[Level]) -> Figure {
    let mut curves = Vec::new();
    for (index, (share, _)) in INTERVALS.into_iter().enumerate() {
        let mark = |level: &Level| {
            let held = level.covered[index];
            Mark {
                spread: Some(wilson(held, level.events).map(|share| 100.0 * share)),
                failed: 2 * level.estimated < level.seeds,
                ..Mark::at(level.x, 100.0 * held as f64 / level.events as f64)
            }
        };
        let name = format!("{share} % intervals");
        curves.push(Curve::new(name, levels.iter().map(mark).collect()));
    }
    for (share, _) in INTERVALS {
        curves.push(Curve::bound("as they say", ends(levels, share)));
    }
    let seeds = levels.first().map_or(0, |level| level.seeds);
    Figure {
        name: format!("uncertainty_{name}"),
        title: title.to_owned(),
        note: format!(
            "{note} {seeds} performances per point, bounce and landing; bars: 95 % intervals of the share."
        ),
        x: Axis::logarithmic(label),
        y: Axis::linear("intervals that hold the truth [%]"),
        curves,
    }
}

/// A level line over all of them.
fn ends(levels: &[Level], y: f64) -> Vec<Mark> {
    let ends = [levels.first(), levels.last()].into_iter().flatten();
    ends.map(|level| Mark::at(level.x, y)).collect()
}
