//! Tables and figures of steps.

use super::rungs::Rung;
use super::step::{Against, Held, Step};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::statistics::{median, quantile};
use crate::table::{Table, percent};

/// A table with a row per rung and a column per kind of scene.
pub fn by_kind(
    (name, title): (&str, &str),
    kinds: &[Vec<Step>],
    cell: impl Fn(&Step) -> String,
) -> Table {
    let wrongs = kinds.iter().map(|steps| steps[0].wrong.as_str());
    let header: Vec<&str> = ["freed in addition"].into_iter().chain(wrongs).collect();
    let mut table = Table::new(name, title, &header);
    for row in 0..kinds[0].len() {
        let cells = kinds.iter().map(|steps| cell(&steps[row]));
        table.row([kinds[0][row].freed.clone()].into_iter().chain(cells));
    }
    table
}

/// Errors; how many takes have no motion, if there are such.
pub fn errors_and_failures(step: &Step, against: Against) -> String {
    let errors = step.errors(against);
    match step.failed {
        0 => errors,
        failed => format!("{errors}; {failed} of {} failed", step.takes),
    }
}

/// How often intervals hold the truth: as reported, and of white noise alone.
pub fn intervals(step: &Step) -> String {
    let [reported, stated] = [&step.truth, &step.stated].map(|held| step.widths(held));
    format!("{reported}; {stated}")
}

/// The table of real tosses, a row per rung.
pub fn tosses(steps: &[Step]) -> Table {
    let are_everywhere = have_motions_everywhere(steps);
    let header = [
        "freed in addition",
        "tosses",
        "failed",
        "error: median (ninth decile)",
        "95 % intervals that hold",
        "components with an interval",
        "set free beside",
        "error of the tosses with a motion on every rung",
    ];
    let title = "Real tosses, the later half of the flight after the impact held out";
    let mut table = Table::new("tosses", title, &header);
    for step in steps {
        let common = step.of_takes(&are_everywhere);
        table.row([
            step.freed.clone(),
            step.takes.to_string(),
            step.failed.to_string(),
            step.errors(Against::Samples),
            step.coverage(&step.samples),
            percent(step.intervals, step.intervals + step.undetermined),
            set_free(step),
            common.errors(Against::Samples),
        ]);
    }
    table
}

fn set_free(step: &Step) -> String {
    let all = step.set_free.iter();
    let all = all.map(|(names, count)| format!("{names} {count}"));
    all.collect::<Vec<_>>().join(", ")
}

/// Which takes have a motion on every rung.
pub fn have_motions_everywhere(steps: &[Step]) -> Vec<bool> {
    let mut all = vec![true; steps[0].takes];
    for step in &steps[..steps.len() - 1] {
        for (is_in, has_motion) in all.iter_mut().zip(step.has_motion()) {
            *is_in &= has_motion;
        }
    }
    all
}

/// Names below an axis for those rungs, and `auto`.
fn axis(rungs: &[Rung]) -> Axis {
    let names = rungs.iter().map(|rung| rung.short_name().to_owned());
    let all = ["nothing".to_owned()].into_iter().chain(names);
    Axis::steps(
        "freed one after another",
        all.chain(["auto".to_owned()]).collect(),
    )
}

/// A curve over the rungs for each kind of scene; `auto` stands beside them.
fn curves(kinds: &[Vec<Step>], mark: impl Fn(usize, &Step) -> Mark) -> Vec<Curve> {
    let curve = |steps: &Vec<Step>| {
        let marks = steps.iter().enumerate().map(|(at, step)| mark(at, step));
        Curve::new(steps[0].wrong.clone(), marks.collect())
    };
    kinds.iter().map(curve).collect()
}

/// Errors of position, medians and quartiles.
pub fn errors(
    (name, title, note): (&str, &str, String),
    (rungs, kinds): (&[Rung], &[Vec<Step>]),
    against: Against,
) -> Figure {
    let mark = |at: usize, step: &Step| {
        let values = step.positions_mm(against);
        Mark {
            spread: Some([quantile(&values, 0.25), quantile(&values, 0.75)]),
            ..Mark::at(at as f64, median(&values))
        }
    };
    Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        note,
        x: axis(rungs),
        y: Axis::logarithmic("error where samples are held out [mm]"),
        curves: curves(kinds, mark),
    }
}

/// How often intervals hold.
pub fn coverage(
    (name, title, note): (&str, &str, &str),
    (rungs, kinds): (&[Rung], &[Vec<Step>]),
    held: fn(&Step) -> &Held,
) -> Figure {
    let mark = |at: usize, step: &Step| Mark::at(at as f64, step.covered(held(step)));
    let mut curves = curves(kinds, mark);
    let last = (rungs.len() + 1) as f64;
    let ends = vec![Mark::at(0.0, 95.0), Mark::at(last, 95.0)];
    curves.push(Curve::bound("as they say", ends));
    Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        note: note.to_owned(),
        x: axis(rungs),
        y: Axis::linear("intervals of 95 % that hold [%]"),
        curves,
    }
}
