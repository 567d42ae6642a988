//! Charts and tables of how often each number of segments leads to the best known motion.

use super::{DURATIONS_S, From, SEGMENTS, Shot, Shots};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent, share};

/// Growths of errors between which performances are counted together.
const GROWTHS: [f64; 7] = [1.0, 10.0, 100.0, 1e3, 1e4, 1e6, f64::INFINITY];
/// Share of performances below which a method is said to have stopped converging.
const MOST: f64 = 0.5;
/// From where, and how that is called.
const STARTS: [(From, &str, &str); 2] = [
    (From::Grown, "grown", "a growing part of the sketch"),
    (From::Plain, "plain", "states read off the sketch"),
];

/// Figures, tables and a sentence.
pub fn show(all: &[Shots], record: &mut Record) {
    for start in STARTS {
        record.figure(by_growth(start, all));
        record.figure(by_duration(start, all));
    }
    record.table(of_segments(all));
    record.table(of_growths(all));
    record.table(of_kinds(all));
    let stops = |from: From| {
        let lost = bins(all).find(|(_, of)| found(of, (from, 1)) < MOST);
        lost.map_or("at no growth".to_owned(), |(growth, _)| {
            format!("where errors grow by {}", between(growth))
        })
    };
    record.say(format!(
        "Single shooting of joined bodies leads to the best known motion in less than half {} from a growing part of the sketch, {} from \
         inverse kinematics.",
        stops(From::Grown),
        stops(From::Plain),
    ));
}

/// Performances by the growth of errors: the least growth, and those from it on.
fn bins(all: &[Shots]) -> impl Iterator<Item = ([f64; 2], Vec<&Shots>)> {
    let pairs = GROWTHS.windows(2).map(|ends| [ends[0], ends[1]]);
    let bins = pairs.map(|[from, to]| {
        let within = |of: &&Shots| (from..to).contains(&of.growth.max(1.0));
        ([from, to], all.iter().filter(within).collect::<Vec<_>>())
    });
    bins.filter(|(_, of)| !of.is_empty())
}

fn between([from, to]: [f64; 2]) -> String {
    match to.is_finite() {
        true => format!("{from:.0} to {to:.0}"),
        false => format!("more than {from:.0}"),
    }
}

fn shots<'s>(all: &[&'s Shots], (from, segments): (From, usize)) -> Vec<&'s Shot> {
    let shots = all.iter().flat_map(|of| &of.all);
    let own = shots.filter(|shot| (shot.from, shot.segments) == (from, segments));
    own.collect()
}

/// The share that leads to the best known motion.
fn found(all: &[&Shots], of: (From, usize)) -> f64 {
    let shots = shots(all, of);
    shots.iter().filter(|shot| shot.is_best).count() as f64 / shots.len() as f64
}

fn curves(points: impl Fn(usize) -> Vec<Mark>) -> Vec<Curve> {
    let curve = |segments: &usize| match segments {
        1 => Curve::ours("1 segment (single shooting)", points(1)),
        _ => Curve::new(format!("{segments} segments"), points(*segments)),
    };
    SEGMENTS.iter().map(curve).collect()
}

fn by_growth((from, name, words): (From, &str, &str), all: &[Shots]) -> Figure {
    let points = |segments: usize| {
        let points = bins(all).map(|(_, of)| {
            let growths: Vec<f64> = of.iter().map(|of| of.growth.max(1.0)).collect();
            Mark::at(median(&growths), 100.0 * found(&of, (from, segments)))
        });
        points.collect()
    };
    Figure {
        name: format!("joined_shooting_growth_{name}"),
        title: format!("Best known motions from {words}, by how much errors grow"),
        note: format!(
            "{} performances; a point: those between two growths.",
            all.len()
        ),
        x: Axis::logarithmic("growth of errors from start to end"),
        y: Axis::linear("best known motion found [%]"),
        curves: curves(points),
    }
}

fn by_duration((from, name, words): (From, &str, &str), all: &[Shots]) -> Figure {
    let points = |segments: usize| {
        let points = DURATIONS_S.iter().filter_map(|duration_s| {
            let of = all.iter().filter(|of| of.duration_s == *duration_s);
            let of: Vec<&Shots> = of.collect();
            let share = 100.0 * found(&of, (from, segments));
            (!of.is_empty()).then(|| Mark::at(*duration_s, share))
        });
        points.collect()
    };
    Figure {
        name: format!("joined_shooting_duration_{name}"),
        title: format!("Best known motions from {words}, by duration"),
        note: format!("{} performances, all kinds together.", all.len()),
        x: Axis::logarithmic("duration [s]"),
        y: Axis::linear("best known motion found [%]"),
        curves: curves(points),
    }
}

fn of_segments(all: &[Shots]) -> Table {
    let header = [
        "start",
        "segments",
        "solves",
        "motions",
        "best known",
        "stopped",
        "evaluations",
        "time, ms",
        "longest, ms",
    ];
    let mut table = Table::new("segments", "", &header);
    let every: Vec<&Shots> = all.iter().collect();
    for (from, _, words) in STARTS {
        for segments in SEGMENTS {
            let shots = shots(&every, (from, segments));
            let times_s: Vec<f64> = shots.iter().map(|of| of.seconds).collect();
            let evaluations: Vec<f64> = shots.iter().map(|of| of.evaluations as f64).collect();
            table.row([
                words.to_owned(),
                segments.to_string(),
                shots.len().to_string(),
                share(&shots, |of| of.objective.is_some()),
                share(&shots, |of| of.is_best),
                share(&shots, |of| of.is_stopped),
                number(median(&evaluations)),
                number(1e3 * median(&times_s)),
                number(1e3 * largest(&times_s)),
            ]);
        }
    }
    table
}

/// A row's shares, start by start and by numbers of segments.
fn shares(all: &[&Shots]) -> Vec<String> {
    let starts = STARTS.into_iter();
    let each = starts.flat_map(|(from, ..)| SEGMENTS.map(|segments| (from, segments)));
    let shares = each.map(|of| share(&shots(all, of), |shot| shot.is_best));
    shares.collect()
}

fn header(first: &[&str]) -> Vec<String> {
    let mut header: Vec<String> = first.iter().map(|cell| (*cell).to_owned()).collect();
    for (_, name, _) in STARTS {
        header.extend(SEGMENTS.map(|segments| format!("{name}, {segments}")));
    }
    header
}

fn of_growths(all: &[Shots]) -> Table {
    let header = header(&["errors grow by", "performances", "any"]);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = Table::new("growths", "", &header);
    for (growth, of) in bins(all) {
        let mut row = vec![between(growth), of.len().to_string(), known(&of)];
        row.extend(shares(&of));
        table.row(row);
    }
    table
}

/// The share of performances of which any motion is known.
fn known(all: &[&Shots]) -> String {
    let has = |of: &&&Shots| of.all.iter().any(|shot| shot.is_best);
    percent(all.iter().filter(has).count(), all.len())
}

fn of_kinds(all: &[Shots]) -> Table {
    let header = header(&["kind", "duration, s", "errors grow by", "any"]);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = Table::new("kinds", "", &header);
    let mut rows: Vec<(&str, f64)> = Vec::new();
    for one in all {
        if !rows.contains(&(&one.kind, one.duration_s)) {
            rows.push((&one.kind, one.duration_s));
        }
    }
    for (kind, duration_s) in rows {
        let own = all.iter();
        let own = own.filter(|of| of.kind == kind && of.duration_s == duration_s);
        let own: Vec<&Shots> = own.collect();
        let growths: Vec<f64> = own.iter().map(|of| of.growth).collect();
        let mut row = vec![
            kind.to_owned(),
            format!("{duration_s}"),
            number(median(&growths)),
            known(&own),
        ];
        row.extend(shares(&own));
        table.row(row);
    }
    table
}
