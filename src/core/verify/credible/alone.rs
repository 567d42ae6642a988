//! Residuals of flights when each is fitted by itself, by linear least squares:
//!
//! ```text
//! free         min over x, v      Σ |p_i − x − v s_i − ½ g s_i²|²
//! accelerated  min over x, v, a   Σ |p_i − x − v s_i − ½ a s_i²|²
//! ```
//!
//! A flight with drag is fitted to first order about the estimated one.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::flights::CredibleFlight;
use crate::motion::{Estimate, Scene};
use crate::physics::Body;
use crate::physics::flow::Fall;

/// Sums over flights that have enough samples.
#[derive(Clone, Debug, Default)]
pub(super) struct FlightsAlone {
    /// Number of readings.
    pub(super) samples: f64,
    /// Residual sum of squares of the whole motion \[m²\].
    pub(super) joint_m2: f64,
    /// Residual sum of squares of free flights alone \[m²\].
    pub(super) alone_m2: f64,
    /// Residual sum of squares of flights with a free acceleration \[m²\].
    pub(super) pulled_m2: f64,
    /// Degrees of freedom of the last two.
    pub(super) alone_freedom: f64,
    pub(super) pulled_freedom: f64,
    /// Sum of products of successive residuals of free flights alone \[m²\].
    product_m2: f64,
    /// Sum of the accelerations `a`, each weighted by its information.
    pull: Vector3<f64>,
    pull_weight: f64,
}

/// Least number of readings of a flight.
pub(super) const LEAST: usize = 6;

impl FlightsAlone {
    pub(super) fn new(scene: &Scene, estimate: &Estimate, flights: &[CredibleFlight]) -> Self {
        let mut sums = Self::default();
        for flight in flights.iter().filter(|f| f.readings.len() >= LEAST) {
            if let Some(fit) = fitted(scene, estimate, flight) {
                sums.add(flight, &estimate.gravity_m_s2, &fit);
            }
        }
        sums
    }

    /// Correlation of successive residuals of free flights alone: that of white noise is zero.
    pub(super) fn correlation(&self) -> f64 {
        self.product_m2 / self.alone_m2
    }

    /// Weighted mean of the accelerations `a` [m/s²].
    pub(super) fn pull_m_s2(&self) -> Vector3<f64> {
        self.pull / self.pull_weight
    }

    fn add(&mut self, flight: &CredibleFlight, gravity_m_s2: &Vector3<f64>, fit: &AloneFit) {
        let count = flight.readings.len() as f64;
        let readings = flight.readings.iter();
        let alone_m2: f64 = fit.left.iter().map(Vector3::norm_squared).sum();
        let pairs = fit.left.windows(2);
        self.samples += count;
        self.joint_m2 += readings
            .map(|r| (r.position_m - r.estimated_m).norm_squared())
            .sum::<f64>();
        self.alone_m2 += alone_m2;
        self.pulled_m2 += (alone_m2 - fit.gain_m2).max(0.0);
        self.alone_freedom += 3.0 * (count - 2.0);
        self.pulled_freedom += 3.0 * (count - 3.0);
        self.product_m2 += pairs.map(|pair| pair[0].dot(&pair[1])).sum::<f64>();
        self.pull += (gravity_m_s2 + fit.pull) * fit.weight;
        self.pull_weight += fit.weight;
    }
}

/// One flight fitted alone.
pub(super) struct AloneFit {
    /// Residuals of the free flight \[m\], reading by reading.
    pub(super) left: Vec<Vector3<f64>>,
    /// Acceleration beyond that of the free flight that fits best [m/s²].
    pull: Vector3<f64>,
    /// By how much that lowers the sum of squares \[m²\].
    pub(super) gain_m2: f64,
    /// Its information: the mean of that per (m/s²)² over all directions.
    weight: f64,
}

/// Fits a flight alone; `None` where the readings' times do not determine it.
pub(super) fn fitted(
    scene: &Scene,
    estimate: &Estimate,
    flight: &CredibleFlight,
) -> Option<AloneFit> {
    // What a surface carries does not fall.
    let body = scene.body_on(flight.arc);
    if body.support().is_some() {
        return None;
    }
    if body.is_ballistic() {
        ballistic(flight, &body.pull_m_s2(&estimate.gravity_m_s2))
    } else {
        dragged(flight, &body, &estimate.gravity_m_s2)
    }
}

/// Fits position and velocity, then the acceleration, which is orthogonal to them. `None` where the
/// readings' times do not determine them.
fn ballistic(flight: &CredibleFlight, pull_m_s2: &Vector3<f64>) -> Option<AloneFit> {
    let readings = &flight.readings;
    let count = readings.len() as f64;
    let middle_s = readings.iter().map(|r| r.time_s).sum::<f64>() / count;
    let since_s: Vec<f64> = readings.iter().map(|r| r.time_s - middle_s).collect();
    let square_s2: f64 = since_s.iter().map(|s| s * s).sum();
    // Residuals of a series of vectors from its best straight line.
    let straightened = |series: Vec<Vector3<f64>>| -> Vec<Vector3<f64>> {
        let mean = series.iter().sum::<Vector3<f64>>() / count;
        let slope = series
            .iter()
            .zip(&since_s)
            .map(|(x, s)| x * *s)
            .sum::<Vector3<f64>>();
        let slope = slope / square_s2;
        let left = series.iter().zip(&since_s);
        left.map(|(x, s)| x - mean - slope * *s).collect()
    };
    let fallen = readings.iter().zip(&since_s);
    let fallen = fallen.map(|(r, s)| r.position_m - pull_m_s2 * (0.5 * s * s));
    let left = straightened(fallen.collect());
    let bows = since_s
        .iter()
        .map(|s| Vector3::repeat(0.5 * s * s))
        .collect();
    let bows: Vec<f64> = straightened(bows).iter().map(|bow| bow.x).collect();
    let weight: f64 = bows.iter().map(|bow| bow * bow).sum();
    if !(square_s2 > 0.0 && weight > 0.0) {
        return None;
    }
    let pulled = left
        .iter()
        .zip(&bows)
        .map(|(x, bow)| x * *bow)
        .sum::<Vector3<f64>>();
    let pull = pulled / weight;
    Some(AloneFit {
        left,
        pull,
        gain_m2: pull.norm_squared() * weight,
        weight,
    })
}

/// The same with drag, by the derivatives of the estimated flight: an orthogonal factor of their
/// columns by position, velocity and pull.
fn dragged(flight: &CredibleFlight, body: &Body, gravity_m_s2: &Vector3<f64>) -> Option<AloneFit> {
    let readings = &flight.readings;
    let mut fall = Fall::new(body, gravity_m_s2, &flight.arc.state);
    let mut columns = DMatrix::zeros(3 * readings.len(), 9);
    let mut off = DVector::zeros(3 * readings.len());
    for (index, reading) in readings.iter().enumerate() {
        let fallen = fall.fallen(reading.time_s - flight.arc.epoch_s);
        let mut rows = columns.fixed_rows_mut::<3>(3 * index);
        rows.fixed_columns_mut::<3>(0).fill_diagonal(1.0);
        rows.fixed_columns_mut::<3>(3)
            .copy_from(&fallen.position_by_velocity);
        rows.fixed_columns_mut::<3>(6)
            .copy_from(&fallen.position_by_pull);
        off.fixed_rows_mut::<3>(3 * index)
            .copy_from(&(reading.position_m - fallen.position_m));
    }
    let (q, r) = columns.qr().unpack();
    let along = q.tr_mul(&off);
    let left = &off - q.columns(0, 6) * along.rows(0, 6);
    let factor: Matrix3<f64> = r.fixed_view::<3, 3>(6, 6).into_owned();
    let pull = factor.solve_upper_triangular(&along.fixed_rows::<3>(6).into_owned())?;
    let of_axes = left.as_slice().chunks_exact(3);
    Some(AloneFit {
        left: of_axes.map(Vector3::from_column_slice).collect(),
        pull,
        gain_m2: along.rows(6, 3).norm_squared(),
        weight: factor.norm_squared() / 3.0,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::motion::{ArcEstimate, MechanismIndex, SegmentResidual, TrackIndex};
    use crate::physics::{Drag, State, flow};
    use crate::verify::credible::flights::FlightSample;

    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

    #[test]
    fn a_flight_with_drag_alone_shows_what_else_pulls_it() {
        let drag = Drag {
            linear_per_s: 1.0,
            quadratic_per_m: 0.13,
        };
        let body = Body::new(0.0027, Vector3::repeat(7e-7)).unwrap();
        let body = body.with_drag(drag).unwrap();
        let state = State {
            position_m: Vector3::new(0.1, 0.2, 0.3),
            orientation: UnitQuaternion::identity(),
            velocity_m_s: Vector3::new(3.0, 0.5, 4.0),
            angular_velocity_rad_s: Vector3::zeros(),
        };
        let thrown = State {
            velocity_m_s: state.velocity_m_s + Vector3::new(1e-3, -1e-3, 2e-3),
            ..state
        };
        let pull = Vector3::new(2e-3, 0.0, -1e-3);
        let arc = ArcEstimate {
            mechanism: MechanismIndex(0),
            epoch_s: 0.3,
            state,
            start_s: 0.0,
            end_s: 0.8,
            support: None,
            certainty: None,
        };
        let residual = SegmentResidual {
            arc: 0,
            track: TrackIndex(0),
            samples: 30,
            position_rms_m: Some(0.0),
            orientation_rms_rad: Some(0.0),
        };
        let readings = (0..30).map(|index| {
            let time_s = 0.8 * f64::from(index) / 29.0;
            let since_s = time_s - arc.epoch_s;
            FlightSample {
                acted_s: time_s,
                time_s,
                position_m: flow::position(&body, &(GRAVITY + pull), &thrown, since_s),
                estimated_m: flow::position(&body, &GRAVITY, &state, since_s),
            }
        });
        let flight = CredibleFlight {
            arc: &arc,
            residual: &residual,
            times: &[],
            readings: readings.collect(),
        };
        let fit = dragged(&flight, &body, &GRAVITY).unwrap();
        assert!(
            (fit.pull - pull).norm() < 1e-2 * pull.norm(),
            "{}",
            fit.pull
        );
        let left_m2: f64 = fit.left.iter().map(Vector3::norm_squared).sum();
        assert!(left_m2 > 0.0 && (left_m2 - fit.gain_m2) < 1e-4 * left_m2);
        assert!((fit.gain_m2 / fit.pull.norm_squared() / fit.weight - 1.0).abs() < 0.5);
    }
}
