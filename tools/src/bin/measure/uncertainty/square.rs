//! Whether errors are as large as the estimate says.
//!
//! With white noise of known size and weights set to just that, the normalised square of the
//! errors has the number of independent unknowns for its expectation. An estimate that reaches the
//! predicted standard deviation is efficient: no unbiased one does better (Cramér–Rao).

use anyhow::Result;
use enact::motion::Verdict;
use nalgebra::DMatrix;
use serde::Serialize;

use super::{KINDS, rms_by_kind, weighed, white_noise};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{mean, rms};
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::dense::Uncertainty;
use enact_tools::errors::has_converged;
use enact_tools::perform::Style;

/// Performances of a row.
const SEEDS: u64 = 200;

/// Pencils with white noise.
#[derive(Default, Serialize)]
struct Row {
    style: &'static str,
    way: &'static str,
    runs: usize,
    physical: usize,
    converged: usize,
    without_covariance: usize,
    rank: usize,
    /// Of every run, by the dense covariance and by the library's.
    squares: [Vec<f64>; 2],
    variance_factors: Vec<f64>,
    /// Of every run: errors over predicted standard deviations, rms, kind by kind.
    ratios: [Vec<[f64; 5]>; 2],
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = Vec::new();
    for style in Style::ALL {
        rows.push(row(style, "white noise", options));
        // The unit of the residuals is found from the residuals, but position and orientation are
        // weighed otherwise.
        rows.push(row(style, "white noise, default weights", options));
    }
    record.table(squares(&rows));
    record.table(efficiency(&rows));
    record.numbers("squares", &rows)
}

fn row(style: Style, way: &'static str, options: &Options) -> Row {
    let acting = white_noise();
    let mut truth = weighed(style, &acting);
    if way.ends_with("default weights") {
        truth.scene.weights = style.truth().scene.weights;
    }
    let mut row = Row {
        style: style.as_str(),
        way,
        ..Row::default()
    };
    for seed in options.seeds(SEEDS) {
        let case = Case::new(&truth, &acting, seed);
        let Ok(outcome) = case.estimated(&mut ()) else {
            continue;
        };
        row.runs += 1;
        row.physical += usize::from(outcome.estimate.verdict == Verdict::Physical);
        row.converged += usize::from(has_converged(&outcome.estimate));
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
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
        self.variance_factors.push(mean(&uncertainty.white));
        for (index, covariance) in [&uncertainty.exact, &uncertainty.library]
            .into_iter()
            .enumerate()
        {
            self.squares[index].push(uncertainty.normalised_square(covariance));
            self.ratios[index].push(ratios(posed, uncertainty, covariance));
        }
    }
}

/// Errors over standard deviations, rms over the unknowns of each kind.
fn ratios(posed: &Posed, uncertainty: &Uncertainty, covariance: &DMatrix<f64>) -> [f64; 5] {
    rms_by_kind(posed, |at| {
        uncertainty.error[at] / covariance[(at, at)].sqrt()
    })
}

fn squares(rows: &[Row]) -> Table {
    let header = [
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
    ];
    let title = "Normalised error squared of all states and event times, over its expectation";
    let mut table = Table::new("squares", title, &header);
    for row in rows {
        let share = |squares: &[f64]| format!("{:.3}", mean(squares) / row.rank as f64);
        let pairs = row.squares[1].iter().zip(&row.variance_factors);
        let scaled: Vec<f64> = pairs.map(|(square, factor)| square / factor).collect();
        table.row([
            row.style.to_owned(),
            row.way.to_owned(),
            row.runs.to_string(),
            percent(row.physical, row.runs),
            percent(row.converged, row.runs),
            row.rank.to_string(),
            share(&row.squares[0]),
            share(&row.squares[1]),
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
    let mut table = Table::new(
        "efficiency",
        "Rms error over predicted standard deviation",
        &header,
    );
    // Under other weights than the noise the estimate is not the efficient one, by construction.
    for row in rows.iter().filter(|row| row.way == "white noise") {
        for (name, ratios) in ["dense", "library's"].into_iter().zip(&row.ratios) {
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
