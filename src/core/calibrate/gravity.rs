//! Gravity by objects that fall.

use nalgebra::{DMatrix, DVector, Vector3};

use super::error::CalibrateError;
use super::flights::ALIKE;
use super::spread::{Measured, jackknife};
use super::stream::Reading;
use crate::math::so3::matrix;

/// With so many flights they are compared with each other.
const FLIGHTS: usize = 5;

/// First-order correlations of noise that are weighed against each other.
const CORRELATIONS: usize = 50;
const STRONGEST: f64 = 0.98;

/// How far the size of gravity may be off a unit's \[relative\].
const UNIT_TOLERANCE: f64 = 0.06;

/// Gravity in the mean \[m/s²\].
const STANDARD_M_S2: f64 = 9.806_65;

/// A free flight of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Its poses, in order of time.
    pub readings: Vec<Reading>,
}

/// The unit in which lengths come, by the size of gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Metres, as they should.
    Metre,
    /// Hundredths of metres.
    Centimetre,
    /// Thousandths of metres.
    Millimetre,
    /// 0.0254 m.
    Inch,
    /// 0.3048 m.
    Foot,
}

impl LengthUnit {
    const ALL: [(Self, f64); 5] = [
        (Self::Metre, 1.0),
        (Self::Centimetre, 100.0),
        (Self::Millimetre, 1000.0),
        (Self::Inch, 1.0 / 0.0254),
        (Self::Foot, 1.0 / 0.3048),
    ];

    /// Its name.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Inch => "inch",
            Self::Foot => "foot",
        }
    }
}

/// Gravity in the tracker's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct GravityFit {
    /// Gravity [length/s², world axes as the tracker has them].
    pub gravity: Measured,
    /// Its size, likewise.
    pub size: Measured,
    /// The centre of mass in the tracker's axes, where it was estimated too. A direction about which
    /// the object did not turn has an infinite interval.
    pub centre: Option<Measured>,
    /// Root mean square residual per axis.
    pub residual: f64,
    /// Correlation of the noise from sample to sample, the mean of what flights allow.
    pub correlation: f64,
    /// Whether the interval is that of how flights differ; otherwise it is that of the noise in them.
    pub is_between_flights: bool,
    /// Samples in flights.
    pub samples: usize,
    /// Axis that points up, `0` to `2`, and its sign.
    pub up_axis: (usize, f64),
    /// Angle between that axis and up \[rad\].
    pub tilt_rad: f64,
    /// Unit of length; `None`: of none that is known, so that stamps or flights are wrong.
    pub unit: Option<LengthUnit>,
}

/// Estimates `g`, and the centre of mass `c` in the tracker's axes where it is not known, by
/// `x_i + R_i c = x₀ + v₀ t + g t²/2`, with `x₀` and `v₀` of each flight.
///
/// The noise of a flight is a first-order autoregression of unknown strength, marginalised over (restricted
/// likelihood on a grid). Of five flights and more the interval is that of how they differ.
///
/// Fails where flights have too few samples for their unknowns.
pub fn gravity(
    flights: &[Flight],
    centre: Option<&Vector3<f64>>,
) -> Result<GravityFit, CalibrateError> {
    let samples: usize = flights.iter().map(|flight| flight.readings.len()).sum();
    let unknowns = if centre.is_some() { 3 } else { 6 };
    let least = 2 * flights.len() + unknowns / 3 + 2;
    if flights.is_empty() || samples < least || flights.iter().any(|f| f.readings.len() < 4) {
        return Err(CalibrateError::TooFew {
            usable: samples,
            least: least.max(4 * flights.len()).max(4),
        });
    }
    let too_few = || CalibrateError::TooFew {
        usable: samples,
        least: samples + 1,
    };
    let grid: Vec<WeighedFlight> = (0..CORRELATIONS)
        .filter_map(|at| {
            let correlation = STRONGEST * at as f64 / (CORRELATIONS - 1) as f64;
            weighed(flights, centre, correlation)
        })
        .collect();
    let most = grid
        .iter()
        .map(|of| of.log_likelihood)
        .fold(f64::NEG_INFINITY, f64::max);
    let weight = |of: &WeighedFlight| (of.log_likelihood - most).exp();
    let total: f64 = grid.iter().map(weight).sum();
    if !(total > 0.0) {
        return Err(too_few());
    }
    let mean = grid.iter().fold(DVector::zeros(unknowns), |sum, of| {
        sum + &of.unknowns * (weight(of) / total)
    });
    let correlation: f64 = grid
        .iter()
        .map(|of| of.correlation * weight(of) / total)
        .sum();
    let mut covariance = DMatrix::zeros(unknowns, unknowns);
    for of in &grid {
        let off = &of.unknowns - &mean;
        covariance += (&of.covariance + &off * off.transpose()) * (weight(of) / total);
    }
    let freedom_within = (3 * samples - 6 * flights.len() - unknowns) as f64;
    let best = grid
        .iter()
        .max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood));
    let residual = best.map_or(0.0, |of| of.sd);
    let is_between_flights = flights.len() >= FLIGHTS;
    let mut freedom = freedom_within;
    if is_between_flights {
        let parts: Vec<FlightPart> = flights
            .iter()
            .map(|f| part(f, centre, correlation))
            .collect();
        let whole = solved(&parts, usize::MAX).ok_or_else(too_few)?;
        let without = (0..parts.len()).map(|left_out| solved(&parts, left_out));
        let without = without.collect::<Option<Vec<_>>>().ok_or_else(too_few)?;
        covariance = jackknife(&whole, &without);
        freedom = (flights.len() - 1) as f64;
    }
    let sd = |of: usize| covariance[(of, of)].max(0.0).sqrt();
    let value = Vector3::new(mean[0], mean[1], mean[2]);
    let size = value.norm();
    let along = value / size;
    let size_sd = (along.transpose() * covariance.fixed_view::<3, 3>(0, 0) * along)[0];
    let axis = value.iamax();
    let up_axis = (axis, -value[axis].signum());
    let measured = |range: std::ops::Range<usize>| {
        let (values, sds) = range.map(|of| (mean[of], sd(of))).unzip();
        Measured::new(values, sds, freedom)
    };
    Ok(GravityFit {
        gravity: measured(0..3),
        size: Measured::new(vec![size], vec![size_sd.max(0.0).sqrt()], freedom),
        centre: (unknowns == 6).then(|| measured(3..6)),
        residual,
        correlation,
        is_between_flights,
        samples,
        up_axis,
        tilt_rad: (value[axis].abs() / size).min(1.0).acos(),
        unit: LengthUnit::ALL
            .into_iter()
            .find(|(_, factor)| (size / (factor * STANDARD_M_S2) - 1.0).abs() < UNIT_TOLERANCE)
            .map(|(unit, _)| unit),
    })
}

/// Indices of flights whose gravity by themselves differs by more than a fifth from the median of all: hands and
/// slides that were taken for flights. None of fewer than three.
pub fn unlike(flights: &[Flight], centre: &Vector3<f64>) -> Vec<usize> {
    if flights.len() < 3 {
        return Vec::new();
    }
    let alone: Vec<Option<Vector3<f64>>> = flights
        .iter()
        .map(|flight| {
            let fit = gravity(std::slice::from_ref(flight), Some(centre)).ok()?;
            Some(Vector3::from_column_slice(&fit.gravity.value))
        })
        .collect();
    let median = Vector3::from_fn(|axis, _| {
        let mut numbers: Vec<f64> = alone.iter().flatten().map(|of| of[axis]).collect();
        numbers.sort_by(f64::total_cmp);
        numbers.get(numbers.len() / 2).copied().unwrap_or(0.0)
    });
    let differs = |of: &Option<Vector3<f64>>| {
        of.is_none_or(|of| !((of - median).norm() <= ALIKE * median.norm()))
    };
    (0..flights.len())
        .filter(|at| differs(&alone[*at]))
        .collect()
}

/// What one correlation of the noise makes of the flights.
struct WeighedFlight {
    correlation: f64,
    unknowns: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Standard deviation of the noise per axis.
    sd: f64,
    /// Restricted log-likelihood.
    log_likelihood: f64,
}

/// A flight's normal equations, without its own unknowns.
struct FlightPart {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    log_determinant: f64,
}

/// Whitens with an autoregression, `e_i − ρ e_{i−1}`, and eliminates `x₀` and `v₀`.
fn part(flight: &Flight, centre: Option<&Vector3<f64>>, correlation: f64) -> FlightPart {
    let readings = &flight.readings;
    let count = readings.len();
    let middle_s = 0.5 * (readings[0].time_s + readings[count - 1].time_s);
    let unknowns = if centre.is_some() { 3 } else { 6 };
    let origin_m = readings[0].world_from_tracker.translation.vector;
    let mut own = DMatrix::zeros(3 * count, 6);
    let mut shared = DMatrix::zeros(3 * count, unknowns);
    let mut observed = DVector::zeros(3 * count);
    for (at, reading) in readings.iter().enumerate() {
        let time_s = reading.time_s - middle_s;
        let turn = matrix(&reading.world_from_tracker.rotation);
        let place_m = reading.world_from_tracker.translation.vector - origin_m
            + centre.map_or(Vector3::zeros(), |centre| turn * centre);
        for axis in 0..3 {
            let row = 3 * at + axis;
            own[(row, axis)] = 1.0;
            own[(row, 3 + axis)] = time_s;
            shared[(row, axis)] = 0.5 * time_s * time_s;
            if unknowns == 6 {
                for column in 0..3 {
                    shared[(row, 3 + column)] = -turn[(axis, column)];
                }
            }
            observed[row] = place_m[axis];
        }
    }
    let whiten = |of: &DMatrix<f64>| {
        DMatrix::from_fn(of.nrows(), of.ncols(), |row, column| {
            if row < 3 {
                of[(row, column)] * (1.0 - correlation * correlation).sqrt()
            } else {
                of[(row, column)] - correlation * of[(row - 3, column)]
            }
        })
    };
    let (own, shared) = (whiten(&own), whiten(&shared));
    let observed = whiten(&DMatrix::from_columns(&[observed]))
        .column(0)
        .into_owned();
    let normal = own.tr_mul(&own);
    // A flight has at least four samples at different times: the matrix is positive definite.
    let inverse = normal
        .clone()
        .try_inverse()
        .unwrap_or_else(|| DMatrix::zeros(6, 6));
    let project = |of: DMatrix<f64>| {
        let along = &own * (&inverse * own.tr_mul(&of));
        of - along
    };
    let shared = project(shared);
    let observed = project(DMatrix::from_columns(&[observed]))
        .column(0)
        .into_owned();
    let whitening = 1.5 * (1.0 - correlation * correlation).ln();
    FlightPart {
        matrix: shared.tr_mul(&shared),
        right: shared.tr_mul(&observed),
        square: observed.norm_squared(),
        log_determinant: whitening - 0.5 * normal.determinant().max(f64::MIN_POSITIVE).ln(),
    }
}

/// Makes the directions of the centre that no turn shows stay at zero, in squared radians.
const RIDGE: f64 = 1e-10;

fn sum(parts: &[FlightPart], left_out: usize) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let mut used = parts.iter().enumerate().filter(|(at, _)| *at != left_out);
    let (_, first) = used.next()?;
    let start = (first.matrix.clone(), first.right.clone());
    let (mut matrix, right) = used.fold(start, |(matrix, right), (_, part)| {
        (matrix + &part.matrix, right + &part.right)
    });
    for of in 3..matrix.nrows() {
        matrix[(of, of)] += RIDGE;
    }
    Some((matrix, right))
}

fn solved(parts: &[FlightPart], left_out: usize) -> Option<DVector<f64>> {
    let (matrix, right) = sum(parts, left_out)?;
    Some(matrix.cholesky()?.solve(&right))
}

fn weighed(
    flights: &[Flight],
    centre: Option<&Vector3<f64>>,
    correlation: f64,
) -> Option<WeighedFlight> {
    let parts: Vec<FlightPart> = flights
        .iter()
        .map(|f| part(f, centre, correlation))
        .collect();
    let (matrix, right) = sum(&parts, usize::MAX)?;
    let square: f64 = parts.iter().map(|part| part.square).sum();
    let cholesky = matrix.clone().cholesky()?;
    let unknowns = cholesky.solve(&right);
    let samples: usize = flights.iter().map(|flight| flight.readings.len()).sum();
    let freedom = (3 * samples - 6 * flights.len()).checked_sub(matrix.nrows())? as f64;
    let rest = (square - right.dot(&unknowns)).max(1e-24);
    let variance = rest / freedom;
    let log_determinant: f64 = parts.iter().map(|part| part.log_determinant).sum();
    Some(WeighedFlight {
        correlation,
        covariance: cholesky.inverse() * variance,
        sd: (variance / (1.0 - correlation * correlation)).sqrt(),
        log_likelihood: log_determinant
            - 0.5 * matrix.determinant().max(f64::MIN_POSITIVE).ln()
            - 0.5 * freedom * rest.ln(),
        unknowns,
    })
}
