//! Where the time of one estimate goes, over many performances, and beside the floor of evaluating
//! every sample once per iteration.

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use enact::estimate::problem::ArcSample;
use enact::estimate::terms::samples::{self, TimeTerms};
use enact::estimate::unknowns::point::Point;
use enact::motion::Phase;
use enact::physics::flow::Spin;
use serde::Serialize;

use super::bouncing;
use super::size::{PHASES, Size};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number};
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Style, hat_box};

/// Performances of each pencil, and runs of each.
const SEEDS: u64 = 100;
const RUNS: usize = 5;

/// Pencils acted in one way.
#[derive(Serialize)]
struct Row {
    style: &'static str,
    timing: &'static str,
    sizes: Vec<Size>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = Vec::new();
    for (timing, acting) in [
        ("known", Acting::timing_known()),
        ("unknown", Acting::default()),
    ] {
        for style in Style::ALL {
            let cases = options
                .seeds(SEEDS)
                .map(|seed| Case::pencil(style, &acting, seed));
            rows.push(Row {
                style: style.as_str(),
                timing,
                sizes: cases.filter_map(|case| Size::of(&case, RUNS)).collect(),
            });
        }
    }
    record.table(medians(&rows));
    record.numbers("phases", &rows)?;
    profile(options, record);
    Ok(())
}

fn medians(rows: &[Row]) -> Table {
    let mut header = vec!["style", "timing", "samples", "iterations"];
    header.extend(PHASES.map(Phase::as_str));
    header.push("total");
    let mut table = Table::new(
        "phases",
        "Medians over pencils at 1× [ms], one thread",
        &header,
    );
    for row in rows {
        let of = |value: &dyn Fn(&Size) -> f64| {
            median(&row.sizes.iter().map(value).collect::<Vec<f64>>())
        };
        let head = [
            row.style.to_owned(),
            row.timing.to_owned(),
            format!("{:.0}", of(&|size| size.samples as f64)),
            format!("{:.0}", of(&|size| size.iterations as f64)),
        ];
        let phases = (0..PHASES.len()).map(|phase| number(of(&|size| 1e3 * size.phases_s[phase])));
        let total = number(of(&|size| 1e3 * size.fastest_s));
        table.row(head.into_iter().chain(phases).chain([total]));
    }
    table
}

/// Where the time of four estimates goes.
fn profile(options: &Options, record: &mut Record) {
    let known = Acting::timing_known();
    let cases = [
        ("pencil, timing known", Case::pencil(Style::Tip, &known, 1)),
        (
            "pencil, timing unknown",
            Case::pencil(Style::Tip, &Acting::default(), 1),
        ),
        (
            "hat and box, timing known",
            Case::new(&hat_box::truth(), &known, 1),
        ),
        (
            "cube, 8 bounces",
            bouncing(8).expect("a motion with 8 bounces"),
        ),
    ];
    let runs = options.either(5, 51);
    let mut names: Vec<String> = PHASES.map(|phase| phase.as_str().to_owned()).to_vec();
    names.extend(["all".to_owned(), "floor".to_owned()]);
    let header = [
        "scene",
        "samples",
        "iterations",
        "whole estimate",
        "floor",
        "whole over floor",
        "iterating phases over floor",
    ];
    let mut table = Table::new("profile", "", &header);
    let mut curves = Vec::new();
    for (name, case) in &cases {
        let Some(size) = Size::of(case, runs) else {
            continue;
        };
        let floor_s = floor_s(case, options.quick) * size.iterations as f64;
        let all = size.phases_s.into_iter().chain([size.total_s, floor_s]);
        let marks = all.enumerate().map(|(at, s)| Mark::at(at as f64, 1e3 * s));
        curves.push(Curve::new(
            *name,
            marks.filter(|mark| mark.y > 0.0).collect(),
        ));
        table.row([
            (*name).to_owned(),
            size.samples.to_string(),
            size.iterations.to_string(),
            format!("{:.3} ms", 1e3 * size.total_s),
            format!("{:.3} ms", 1e3 * floor_s),
            format!("{:.1}", size.total_s / floor_s),
            format!("{:.1}", size.solver_s / floor_s),
        ]);
    }
    record.figure(Figure {
        name: "cost_profile".to_owned(),
        title: "Where the time of one estimate goes, beside the floor of evaluating every sample once per iteration"
            .to_owned(),
        note: format!(
            "Medians of {runs} runs. The floor: residual and derivative of every sample by state and time, \
             times the iterations that the estimate took."
        ),
        x: Axis::named("phase", names),
        y: Axis::logarithmic("time [ms]"),
        curves,
    });
    record.table(table);
}

/// Residuals and derivatives of all samples, once, at the estimate's own first guess \[s\].
fn floor_s(case: &Case, quick: bool) -> f64 {
    let outcome = case.estimated(&mut ()).expect("it was estimated before");
    let posed = Posed::without_marks(case.scene(), &outcome.sketch);
    let (problem, guess) = (&posed.problem, &posed.guesses[0]);
    let point = Point::new(problem, guess);
    let gravity = problem.gravity(&point.parameters);
    let evaluate = || {
        for (index, view) in problem.views() {
            let body = problem.body_of(index);
            let flight = (&point.arcs[index], guess.arcs[index].epoch_s);
            let time_s = |sample: &ArcSample| sample.time_s(&point.node_times_s);
            let each = |sample: &ArcSample, terms: &TimeTerms| {
                black_box((sample, terms));
            };
            let spin = &mut Spin::new(body, &flight.0.angular_velocity_rad_s);
            let terms =
                samples::unknown_times(body, (view, 1), flight, spin, &gravity, time_s, each);
            black_box(&terms);
        }
    };
    let repeats = if quick { 20 } else { 200 };
    let mut fastest_s = f64::INFINITY;
    for _ in 0..repeats {
        let begin = Instant::now();
        evaluate();
        fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
    }
    fastest_s
}
