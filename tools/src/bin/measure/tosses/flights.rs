//! The first flights alone, gravity free.

use anyhow::Result;
use enact::motion::{Scene, Verdict};
use nalgebra::Vector3;
use serde::Serialize;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::record::Record;
use crate::statistics::{INTERVALS, mean, median, quantile, robust_sd};
use crate::table::{Table, number};
use enact_tools::tosses::{RATES_HZ, Toss};

/// What became of a toss at a rate.
#[derive(Serialize)]
struct Flight {
    /// In the manifest.
    number: usize,
    rate_hz: f64,
    samples: usize,
    flight_is_given: bool,
    /// What it says, or why nothing.
    result: Result<Fit, String>,
}

/// What a flight says.
#[derive(Serialize)]
struct Fit {
    /// All three free.
    gravity_m_s2: Vector3<f64>,
    /// Reported standard deviation of the vertical part.
    sd_m_s2: Option<f64>,
    /// Per axis, the degrees of freedom of a parabola or a constant spin taken off.
    position_mm: f64,
    orientation_deg: f64,
    /// Of the whole displacement and angle.
    position_total_mm: f64,
    orientation_total_deg: f64,
}

/// Runs it.
pub fn run(scene: &Scene, tosses: &[Toss], record: &mut Record) -> Result<()> {
    let at_rate = |rate_hz: f64| tosses.iter().map(move |toss| flight(scene, toss, rate_hz));
    let flights: Vec<Flight> = RATES_HZ.into_iter().flat_map(at_rate).collect();
    let real = flights
        .iter()
        .filter(|flight| flight.rate_hz == RATES_HZ[0]);
    let fits: Vec<&Fit> = real
        .filter_map(|flight| flight.result.as_ref().ok())
        .collect();
    record.figure(residuals(&fits));
    record.figure(gravity(&fits));
    record.table(table(&flights));
    record.table(failures(&flights));
    record.numbers("flights", &flights)
}

fn flight(scene: &Scene, toss: &Toss, rate_hz: f64) -> Flight {
    Flight {
        number: toss.number,
        rate_hz,
        samples: toss.flight,
        flight_is_given: toss.flight_is_given,
        result: fit(scene, toss, rate_hz),
    }
}

fn fit(scene: &Scene, toss: &Toss, rate_hz: f64) -> Result<Fit, String> {
    let outcome = toss
        .first_flight(scene, rate_hz)
        .map_err(|error| error.to_string())?;
    let estimate = &outcome.estimate;
    if estimate.verdict != Verdict::Physical {
        return Err(format!(
            "{}: {}",
            estimate.verdict.as_str(),
            enact::report::reason_text(scene, &estimate.reason)
        ));
    }
    let residual = &estimate.residuals[0];
    let samples = residual.samples as f64;
    let per_axis = |unknowns: f64| (3.0 * (1.0 - unknowns / samples)).sqrt().recip();
    let vertical = estimate.parameters.iter().find(|p| p.name == "gravity.z");
    let (position_mm, orientation_deg) = (
        1e3 * residual.position_rms_m.expect("poses"),
        residual.orientation_rms_rad.expect("poses").to_degrees(),
    );
    Ok(Fit {
        gravity_m_s2: estimate.gravity_m_s2,
        sd_m_s2: vertical.and_then(|parameter| parameter.sd),
        position_mm: position_mm * per_axis(3.0),
        orientation_deg: orientation_deg * per_axis(2.0),
        position_total_mm: position_mm,
        orientation_total_deg: orientation_deg,
    })
}

fn table(flights: &[Flight]) -> Table {
    let header = [
        "rate Hz",
        "tosses",
        "estimated",
        "gravity m/s²",
        "its vertical part",
        "median reported sd of that",
        "robust sd of its error over reported sd",
        "tilt from −z deg",
        "mean gravity's tilt deg",
        "residual mm per axis",
        "residual deg per axis",
        "residual mm",
        "residual deg",
    ];
    let title =
        "Real tosses of a cube, first flight, gravity free: median (robust sd over the tosses)";
    let mut table = Table::new("flights", title, &header);
    for rate_hz in RATES_HZ {
        let at_rate: Vec<&Flight> = flights.iter().filter(|f| f.rate_hz == rate_hz).collect();
        let fits = at_rate.iter().filter_map(|f| f.result.as_ref().ok());
        let fits: Vec<&Fit> = fits.collect();
        let of = |value: &dyn Fn(&Fit) -> f64, decimals: usize| {
            let values: Vec<f64> = fits.iter().map(|fit| value(fit)).collect();
            format!(
                "{:.decimals$} ({:.decimals$})",
                median(&values),
                robust_sd(&values)
            )
        };
        let tilt_deg = |g: &Vector3<f64>| g.angle(&-Vector3::z()).to_degrees();
        let axis = |axis: usize| {
            mean(
                &fits
                    .iter()
                    .map(|f| f.gravity_m_s2[axis])
                    .collect::<Vec<f64>>(),
            )
        };
        let sds: Vec<f64> = fits.iter().filter_map(|fit| fit.sd_m_s2).collect();
        let verticals: Vec<f64> = fits.iter().map(|fit| fit.gravity_m_s2.z).collect();
        let middle = median(&verticals);
        let normalised = fits
            .iter()
            .filter_map(|fit| Some((fit.gravity_m_s2.z - middle) / fit.sd_m_s2?));
        let normalised: Vec<f64> = normalised.collect();
        table.row([
            rate_hz.to_string(),
            at_rate.len().to_string(),
            fits.len().to_string(),
            of(&|fit| fit.gravity_m_s2.norm(), 3),
            of(&|fit| fit.gravity_m_s2.z, 3),
            format!(
                "{} ({} to {})",
                number(median(&sds)),
                number(quantile(&sds, 0.05)),
                number(quantile(&sds, 0.95))
            ),
            number(robust_sd(&normalised)),
            of(&|fit| tilt_deg(&fit.gravity_m_s2), 2),
            format!("{:.2}", tilt_deg(&Vector3::from_fn(|i, _| axis(i)))),
            of(&|fit| fit.position_mm, 4),
            of(&|fit| fit.orientation_deg, 4),
            of(&|fit| fit.position_total_mm, 4),
            of(&|fit| fit.orientation_total_deg, 4),
        ]);
    }
    table
}

fn failures(flights: &[Flight]) -> Table {
    let title = "Tosses without an estimate, or whose flight the manifest does not give";
    let mut table = Table::new("failures", title, &["toss", "rate Hz", "samples", "what"]);
    for flight in flights {
        let what = match &flight.result {
            Err(reason) => reason.clone(),
            Ok(_) if flight.flight_is_given => continue,
            Ok(fit) => format!(
                "flight until 3 mm above the table: gravity {:.3} m/s², {:.4} mm, {:.4}° per axis",
                fit.gravity_m_s2.norm(),
                fit.position_mm,
                fit.orientation_deg
            ),
        };
        table.row([
            flight.number.to_string(),
            flight.rate_hz.to_string(),
            flight.samples.to_string(),
            what,
        ]);
    }
    table
}

/// Shares of tosses below a value.
fn shares(values: impl Iterator<Item = f64>) -> Vec<Mark> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let ranked = values.into_iter().enumerate();
    ranked
        .map(|(rank, value)| Mark::at(value, 100.0 * (rank + 1) as f64 / count))
        .collect()
}

fn residuals(fits: &[&Fit]) -> Figure {
    let ends = vec![Mark::at(1.0, 0.0), Mark::at(1.0, 100.0)];
    let position = fits.iter().map(|fit| fit.position_mm / 0.02);
    let orientation = fits.iter().map(|fit| fit.orientation_deg / 0.025);
    Figure {
        name: "tosses_residuals".to_owned(),
        title: "Residuals of real first flights are as large as the cameras' noise".to_owned(),
        note: format!(
            "{} tosses of a cube, gravity free; rms per axis, the degrees of freedom taken off, over the \
             documented noise of 0.02 mm and 0.025°.",
            fits.len()
        ),
        x: Axis::logarithmic("residual over the documented noise"),
        y: Axis::linear("tosses with less [%]"),
        curves: vec![
            Curve::new("position", shares(position)),
            Curve::new("orientation", shares(orientation)),
            Curve::bound("as documented", ends),
        ],
    }
}

fn gravity(fits: &[&Fit]) -> Figure {
    let mut sorted: Vec<&&Fit> = fits.iter().collect();
    sorted.sort_by(|a, b| b.gravity_m_s2.z.total_cmp(&a.gravity_m_s2.z));
    let width = INTERVALS[2].1;
    let marks = sorted.iter().enumerate().map(|(rank, fit)| {
        let value = -fit.gravity_m_s2.z;
        Mark {
            spread: fit
                .sd_m_s2
                .map(|sd| [value - width * sd, value + width * sd]),
            ..Mark::at((rank + 1) as f64, value)
        }
    });
    let values: Vec<f64> = fits.iter().map(|fit| -fit.gravity_m_s2.z).collect();
    let sds: Vec<f64> = fits.iter().filter_map(|fit| fit.sd_m_s2).collect();
    let ends = |value: f64| vec![Mark::at(1.0, value), Mark::at(fits.len() as f64, value)];
    let middle = median(&values);
    Figure {
        name: "tosses_gravity".to_owned(),
        title: "Gravity from 10 to 22 samples of each real toss, with the reported 95 % intervals"
            .to_owned(),
        note: format!(
            "Sorted. Median {middle:.3} m/s², robust spread over the tosses {:.3}, median reported standard \
             deviation {:.3}: lengths are some 2 % short, by place and camera, and that is no noise.",
            robust_sd(&values),
            median(&sds)
        ),
        x: Axis::linear("toss, by gravity"),
        y: Axis::linear("vertical gravity [m/s²]"),
        curves: vec![
            Curve::ours("estimated", marks.collect()),
            Curve::bound(format!("median {middle:.3}"), ends(middle)),
            Curve::bound("true 9.81", ends(9.81)),
        ],
    }
}
