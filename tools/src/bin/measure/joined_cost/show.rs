//! Charts and tables of what grew.

use super::{Evaluated, Whole};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::record::Record;
use crate::statistics::{exponent, largest};
use crate::table::{Table, number, share};

/// What grows: curves, the axis, in words.
const GROWS: [(&str, &[&str], &str); 3] = [
    ("links", &["pins", "universal", "balls"], "links"),
    ("segments", &["segments"], "segments"),
    ("duration", &["duration"], "duration [s]"),
];

/// Figures, tables and a sentence.
pub fn show(evaluated: &[Evaluated], whole: &[Whole], record: &mut Record) {
    for (name, curves, label) in GROWS {
        record.figure(evaluations(name, curves, label, evaluated));
        if name != "segments" {
            record.figure(answers(name, curves, label, whole));
        }
    }
    record.table(parts(evaluated));
    record.table(whole_answers(whole));
    let powers = GROWS[0].1.iter().map(|curve| {
        let power = power(&of(evaluated, curve), |of| of.whole_s);
        format!("{power:.2} with {curve}")
    });
    let powers: Vec<String> = powers.collect();
    let [segments, duration] =
        ["segments", "duration"].map(|curve| power(&of(evaluated, curve), |of| of.whole_s));
    record.say(format!(
        "One evaluation of a pendulum with all derivatives grows with the power {} of the links (upper half of 1 to 64), {segments:.2} of the \
         segments and {duration:.2} of the duration.",
        powers.join(", "),
    ));
}

fn of<'e>(evaluated: &'e [Evaluated], curve: &str) -> Vec<&'e Evaluated> {
    evaluated.iter().filter(|of| of.curve == curve).collect()
}

/// Over the upper half, where what does not grow no longer hides what does.
fn power(all: &[&Evaluated], value: impl Fn(&Evaluated) -> f64) -> f64 {
    let upper = &all[all.len() / 2..];
    let sizes: Vec<f64> = upper.iter().map(|of| of.size).collect();
    let values: Vec<f64> = upper.iter().map(|of| value(of)).collect();
    exponent(&sizes, &values)
}

fn evaluations(name: &str, curves: &[&str], label: &str, all: &[Evaluated]) -> Figure {
    let mut drawn = Vec::new();
    for curve in curves {
        let own = of(all, curve);
        let points = |value: fn(&Evaluated) -> f64| {
            own.iter().map(|of| Mark::at(of.size, value(of))).collect()
        };
        let of_whole = format!(
            "{curve}: evaluation, power {:.2}",
            power(&own, |of| of.whole_s)
        );
        drawn.push(Curve::ours(of_whole, points(|of| of.whole_s)));
        if name != "segments" {
            let of_plain = format!(
                "{curve}: motion alone, power {:.2}",
                power(&own, |of| of.plain_s)
            );
            drawn.push(Curve::new(of_plain, points(|of| of.plain_s)));
        }
    }
    Figure {
        name: format!("joined_cost_{name}"),
        title: format!("How one evaluation with derivatives grows with {name} of a pendulum"),
        note:
            "Least of several runs, on a core. Powers are fitted over the upper half of the sizes."
                .to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("time [s]"),
        curves: drawn,
    }
}

fn answers(name: &str, curves: &[&str], label: &str, all: &[Whole]) -> Figure {
    let curve = |curve: &&str| {
        let own = all.iter().filter(|of| of.curve == *curve);
        let points = own.map(|of| Mark {
            failed: of.has_failed(),
            ..Mark::at(of.size, of.middle(|of| of.seconds))
        });
        Curve::new(format!("{curve}: whole answer"), points.collect())
    };
    Figure {
        name: format!("joined_cost_answers_{name}"),
        title: format!("How a whole answer's time grows with {name} of a pendulum"),
        note: "Medians of three performances, on a core. A cross: fewer than half are motions."
            .to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("time [s]"),
        curves: curves.iter().map(curve).collect(),
    }
}

fn parts(all: &[Evaluated]) -> Table {
    let header = [
        "what grows",
        "size",
        "directions",
        "steps",
        "motion alone, ms",
        "with derivatives, ms",
        "over motion alone",
        "evaluation, ms",
        "over motion alone",
        "power to here",
    ];
    let mut table = Table::new("evaluations", "", &header);
    let mut last: Option<&Evaluated> = None;
    for one in all {
        let before = last.filter(|last| last.curve == one.curve);
        let slope = before.map_or(f64::NAN, |last| {
            exponent(&[last.size, one.size], &[last.whole_s, one.whole_s])
        });
        // Of several segments the motion alone is that of one.
        let is_cut = one.curve == "segments";
        let over = |time_s: f64| {
            number(if is_cut {
                f64::NAN
            } else {
                time_s / one.plain_s
            })
        };
        table.row([
            one.curve.clone(),
            format!("{}", one.size),
            one.directions.to_string(),
            one.steps.to_string(),
            number(1e3 * one.plain_s),
            number(1e3 * one.derived_s),
            over(one.derived_s),
            number(1e3 * one.whole_s),
            over(one.whole_s),
            number(slope),
        ]);
        last = Some(one);
    }
    table
}

fn whole_answers(all: &[Whole]) -> Table {
    let header = [
        "what grows",
        "size",
        "answers",
        "motions",
        "iterations",
        "evaluations",
        "time, ms",
        "longest, ms",
    ];
    let mut table = Table::new("answers", "", &header);
    for whole in all {
        let times_s: Vec<f64> = whole.all.iter().map(|of| of.seconds).collect();
        table.row([
            whole.curve.clone(),
            format!("{}", whole.size),
            whole.all.len().to_string(),
            share(&whole.all, |of| of.is_motion),
            number(whole.middle(|of| of.iterations as f64)),
            number(whole.middle(|of| of.evaluations as f64)),
            number(1e3 * whole.middle(|of| of.seconds)),
            number(1e3 * largest(&times_s)),
        ]);
    }
    table
}
