//! Solves of one method, setting by setting.

use enact::optimise::finish::Tolerances;

use crate::figure::Mark;
use crate::posing::Posing;
use crate::statistics::quantile;
use enact_tools::methods::{Answer, Method};

/// What varies along a curve.
#[derive(Clone, Copy)]
pub struct Setting {
    pub method: Method,
    pub tolerances: Tolerances,
}

/// One solve.
pub struct Point {
    pub error: f64,
    /// From the true motion; none where no motion is true \[mm\].
    pub off_mm: Option<f64>,
    took_s: f64,
    is_in_order: bool,
}

/// Errors below this are rounding.
const ROUNDING: f64 = 1e-15;
/// Greatest error of an answer that is taken for the best optimum, roughly solved.
const NEAR: f64 = 1e-4;
/// Repeats of a solve, of which the fastest counts, until they take this long together \[s\].
pub const REPEATS: usize = 5;
const ENOUGH_S: f64 = 0.02;

/// A method on all performances: those that end well, and the last solve of the others.
pub struct Solves {
    pub well: Vec<Vec<Point>>,
    elsewhere: Vec<Point>,
}

impl Solves {
    /// All of them with every setting.
    pub fn of(posings: &[Posing], settings: &[Setting], quick: bool) -> Self {
        let (mut well, mut elsewhere) = (Vec::new(), Vec::new());
        for posing in posings {
            let points = settings.iter().map(|setting| point(posing, setting, quick));
            let mut points: Vec<Point> = points.collect();
            match points.last() {
                Some(last) if last.error < NEAR && last.is_in_order => well.push(points),
                _ => elsewhere.extend(points.pop()),
            }
        }
        Self { well, elsewhere }
    }

    /// Index of the tightest setting among the marks, if any ends well.
    pub fn last(&self) -> usize {
        self.well.first().map_or(0, |points| points.len() - 1)
    }

    /// Points of a curve, by what stands across.
    pub fn marks(&self, settings: &[Setting], across: impl Fn(&Point) -> f64) -> Vec<Mark> {
        let mut marks = Vec::new();
        for (index, setting) in settings.iter().enumerate() {
            if self.well.is_empty() {
                break;
            }
            let times_s: Vec<f64> = self
                .well
                .iter()
                .map(|points| points[index].took_s)
                .collect();
            let errors: Vec<f64> = self
                .well
                .iter()
                .map(|points| across(&points[index]))
                .collect();
            marks.push(Mark {
                spread: Some([quantile(&times_s, 0.25), quantile(&times_s, 0.75)]),
                setting: Some(match setting.method {
                    Method::Sampling(evaluations) => format!("{evaluations} evaluations"),
                    _ if setting.tolerances.steps == 0 => "no finish".into(),
                    _ => format!("{:.0e}", setting.tolerances.violation),
                }),
                ..Mark::at(quantile(&errors, 0.5), quantile(&times_s, 0.5))
            });
        }
        marks.extend(self.elsewhere.iter().map(|last| Mark {
            failed: true,
            ..Mark::at(across(last), last.took_s)
        }));
        marks
    }
}

fn point(posing: &Posing, setting: &Setting, quick: bool) -> Point {
    let task = &posing.task;
    let answer = || task.answer(setting.method, &setting.tolerances);
    let first: Answer = answer();
    let mut took_s = first.took_s;
    let mut together_s = took_s;
    for _ in 1..REPEATS {
        if quick || together_s > ENOUGH_S {
            break;
        }
        let again_s = answer().took_s;
        took_s = took_s.min(again_s);
        together_s += again_s;
    }
    let best = task.best.unwrap_or(f64::NAN);
    let error = first.error(best).max(ROUNDING);
    Point {
        // What is not even a motion has no error: far right.
        error: if error.is_finite() {
            error.min(1e6)
        } else {
            1e6
        },
        off_mm: posing.off_mm(&first),
        took_s,
        is_in_order: first.is_in_order,
    }
}
