//! Whether errors are as large as the estimate says.
//!
//! With white noise of known size and weights set to just that, the normalised square of the
//! errors has the number of independent unknowns for its expectation, and an interval of 1.96
//! reported standard deviations holds the truth in 95 of 100 cases. An estimate that reaches the
//! predicted standard deviation is efficient: no unbiased one does better (Cramér–Rao).

use std::ops::Range;

use anyhow::Result;
use enact::math::Pose;
use enact::motion::{Estimate, Timing, Verdict};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{mean, rms};
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::dense::Uncertainty;
use enact_tools::errors::has_converged;
use enact_tools::perform::{Acting, Style, Truth};

/// A 95 % interval of a normal distribution [standard deviations].
const INTERVAL: f64 = 1.96;
/// Kinds of unknown.
pub const KINDS: [&str; 5] = [
    "position",
    "orientation",
    "velocity",
    "angular velocity",
    "event time",
];

/// White noise and nothing else, of the size of one unit of residual.
pub fn white_noise() -> Acting {
    Acting {
        distortion: 0.0,
        resolution_m: 0.0,
        resolution_quaternion: 0.0,
        mark_error_s: 0.0,
        rate_hz: 125.0,
        ..Acting::timing_known()
    }
}

/// A pencil tracked at its centre of mass, so that both kinds of noise stay what they are, and
/// weighed by that noise.
pub fn weighed(style: Style, acting: &Acting) -> Truth {
    let mut scene = style.truth().scene;
    scene.bodies[0].body_from_tracker = Pose::identity();
    scene.weights.position_m = acting.noise_position_m;
    scene.weights.orientation_rad = acting.noise_orientation_rad;
    style.truth_in(&scene).expect("the style's own scene")
}

/// A way of acting.
#[derive(Serialize)]
struct Row {
    style: &'static str,
    way: &'static str,
    runs: usize,
    physical: usize,
    converged: usize,
    without_covariance: usize,
    rank: usize,
    /// Of every run, by the dense covariance and by the library's.
    squares_exact: Vec<f64>,
    squares_library: Vec<f64>,
    variance_factors: Vec<f64>,
    /// Of every run: errors over predicted standard deviations, rms, kind by kind.
    ratios_exact: Vec<[f64; 5]>,
    ratios_library: Vec<[f64; 5]>,
    /// Event times whose interval holds the truth, by event.
    covered: Vec<usize>,
    /// Errors of event times \[s\] and their reported standard deviations \[s\], run by run.
    event_errors: Vec<Vec<(f64, Option<f64>)>>,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let mut rows = Vec::new();
    for style in Style::ALL {
        let acting = white_noise();
        rows.push(row(
            style,
            "white noise",
            &weighed(style, &acting),
            &acting,
            options.range(),
        ));
        // The same with the weights that scenes have by default: the unit of the residuals is
        // found from the residuals, but position and orientation are weighed otherwise.
        let mut truth = weighed(style, &acting);
        truth.scene.weights = style.truth().scene.weights;
        rows.push(row(
            style,
            "white noise, default weights",
            &truth,
            &acting,
            options.range(),
        ));
        let mut truth = weighed(style, &acting);
        truth.scene.timing = Timing::Unknown {
            tempo_sd_per_sqrt_s: 0.5,
        };
        let slow = Acting {
            slowdown: 2.5,
            tempo_variation: 0.3,
            ..white_noise()
        };
        rows.push(row(
            style,
            "white noise, timing unknown",
            &truth,
            &slow,
            options.range(),
        ));
        let acting = Acting::timing_known();
        rows.push(row(
            style,
            "wandering hand, timing known",
            &style.truth(),
            &acting,
            options.range(),
        ));
        let acting = Acting::default();
        rows.push(row(
            style,
            "wandering hand, timing unknown",
            &style.truth(),
            &acting,
            options.range(),
        ));
    }
    options.show(squares(&rows));
    options.show(efficiency(&rows));
    options.show(coverage(&rows));
    options.write_json("covariance", &rows)
}

fn row(style: Style, way: &'static str, truth: &Truth, acting: &Acting, seeds: Range<u64>) -> Row {
    let mut row = Row {
        style: style.as_str(),
        way,
        runs: 0,
        physical: 0,
        converged: 0,
        without_covariance: 0,
        rank: 0,
        squares_exact: Vec::new(),
        squares_library: Vec::new(),
        variance_factors: Vec::new(),
        ratios_exact: Vec::new(),
        ratios_library: Vec::new(),
        covered: vec![0; truth.scene.events.len()],
        event_errors: Vec::new(),
    };
    let is_white = way.starts_with("white noise") && acting.is_timing_known();
    for seed in seeds {
        let case = Case::new(truth, acting, seed);
        let Ok(outcome) = case.estimated(&mut ()) else {
            continue;
        };
        row.runs += 1;
        row.physical += usize::from(outcome.estimate.verdict == Verdict::Physical);
        row.converged += usize::from(has_converged(&outcome.estimate));
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        row.add_events(&case, &outcome.estimate, offset_s);
        if !is_white {
            continue;
        }
        match Uncertainty::of(&case, &posed, offset_s) {
            Some(uncertainty) => row.add(&posed, &uncertainty),
            None => row.without_covariance += 1,
        }
    }
    row
}

impl Row {
    fn add(&mut self, posed: &Posed, uncertainty: &Uncertainty) {
        self.rank = uncertainty.rank();
        let (exact, library) = (&uncertainty.exact, &uncertainty.library);
        self.squares_exact
            .push(uncertainty.normalised_square(exact));
        self.squares_library
            .push(uncertainty.normalised_square(library));
        self.variance_factors.push(mean(&uncertainty.white));
        self.ratios_exact.push(ratios(posed, uncertainty, exact));
        self.ratios_library
            .push(ratios(posed, uncertainty, library));
    }

    fn add_events(&mut self, case: &Case, estimate: &Estimate, offset_s: f64) {
        let mut errors = Vec::new();
        for event in &estimate.events {
            let true_s = case.performance.truth.event_times_s[event.event] + offset_s;
            let error_s = event.time_s - true_s;
            let holds = event
                .sd_s
                .is_some_and(|sd_s| error_s.abs() <= INTERVAL * sd_s);
            self.covered[event.event] += usize::from(holds);
            errors.push((error_s, event.sd_s));
        }
        self.event_errors.push(errors);
    }
}

/// Errors over standard deviations, rms over the unknowns of each kind.
fn ratios(posed: &Posed, uncertainty: &Uncertainty, covariance: &DMatrix<f64>) -> [f64; 5] {
    let ratio = |at: usize| uncertainty.error[at] / covariance[(at, at)].sqrt();
    rms_by_kind(posed, ratio)
}

/// The rms of a value of each unknown over the unknowns of each kind.
pub fn rms_by_kind(posed: &Posed, value: impl Fn(usize) -> f64) -> [f64; 5] {
    let layout = &posed.layout;
    std::array::from_fn(|kind| {
        let values: Vec<f64> = if kind == 4 {
            let events = layout.events.iter().flatten();
            events.map(|at| value(*at)).collect()
        } else {
            let arcs = layout.arcs.iter().map(|at| at + 3 * kind);
            arcs.flat_map(|at| (at..at + 3).map(&value)).collect()
        };
        rms(&values)
    })
}

fn squares(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Normalised error squared of all states and event times, over its expectation",
        &[
            "style",
            "acted",
            "runs",
            "physical",
            "converged",
            "independent unknowns",
            "dense covariance",
            "the library's",
            "the same, scaled by the white noise seen",
            "white noise seen, squared units",
            "no covariance",
        ],
    );
    let white = |row: &&Row| !row.squares_exact.is_empty() || row.without_covariance > 0;
    for row in rows.iter().filter(white) {
        let share = |squares: &[f64]| format!("{:.3}", mean(squares) / row.rank as f64);
        let pairs = row.squares_library.iter().zip(&row.variance_factors);
        let scaled: Vec<f64> = pairs.map(|(square, factor)| square / factor).collect();
        table.row([
            row.style.to_owned(),
            row.way.to_owned(),
            row.runs.to_string(),
            percent(row.physical, row.runs),
            percent(row.converged, row.runs),
            row.rank.to_string(),
            share(&row.squares_exact),
            share(&row.squares_library),
            share(&scaled),
            number(mean(&row.variance_factors)),
            row.without_covariance.to_string(),
        ]);
    }
    table
}

fn efficiency(rows: &[Row]) -> Table {
    let mut header = vec!["style", "acted", "covariance"];
    header.extend(KINDS);
    let mut table = Table::new("Rms error over predicted standard deviation", &header);
    // Under other weights than the noise the estimate is not the efficient one, by construction.
    for row in rows.iter().filter(|row| row.way == "white noise") {
        for (name, ratios) in [
            ("dense", &row.ratios_exact),
            ("library's", &row.ratios_library),
        ] {
            let of_kind = |kind: usize| {
                let values: Vec<f64> = ratios.iter().map(|ratios| ratios[kind]).collect();
                format!("{:.3}", rms(&values))
            };
            let head = [row.style.to_owned(), row.way.to_owned(), name.to_owned()];
            table.row(head.into_iter().chain((0..5).map(of_kind)));
        }
    }
    table
}

fn coverage(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Event times: share of reported 95 % intervals that hold the truth; rms error and rms reported sd",
        &[
            "style", "acted", "runs", "bounce", "error ms", "sd ms", "landing", "error ms", "sd ms",
        ],
    );
    for row in rows {
        let of_event = |event: usize| {
            let errors = row.event_errors.iter().map(|run| 1e3 * run[event].0);
            let sds = row
                .event_errors
                .iter()
                .filter_map(|run| Some(1e3 * run[event].1?));
            [
                percent(row.covered[event], row.runs),
                number(rms(&errors.collect::<Vec<f64>>())),
                number(rms(&sds.collect::<Vec<f64>>())),
            ]
        };
        let head = [
            row.style.to_owned(),
            row.way.to_owned(),
            row.runs.to_string(),
        ];
        table.row(head.into_iter().chain(of_event(0)).chain(of_event(1)));
    }
    table
}
