//! Residuals of flights when each is fitted by itself, by linear least squares:
//!
//! ```text
//! free         min over x, v      Σ |p_i − x − v s_i − ½ g s_i²|²
//! accelerated  min over x, v, a   Σ |p_i − x − v s_i − ½ a s_i²|²
//! ```

use nalgebra::Vector3;

use super::flights::Flight;

/// Sums over flights that have enough samples.
#[derive(Clone, Debug, Default)]
pub(super) struct Alone {
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
const LEAST: usize = 6;

impl Alone {
    pub(super) fn new(flights: &[Flight], gravity_m_s2: &Vector3<f64>) -> Self {
        let mut sums = Self::default();
        for flight in flights.iter().filter(|f| f.readings.len() >= LEAST) {
            sums.add(flight, gravity_m_s2);
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

    /// Adds a flight: fits position and velocity, then the acceleration, which is orthogonal to
    /// them.
    fn add(&mut self, flight: &Flight, gravity_m_s2: &Vector3<f64>) {
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
        let fallen = fallen.map(|(r, s)| r.position_m - gravity_m_s2 * (0.5 * s * s));
        let left = straightened(fallen.collect());
        let bows = since_s
            .iter()
            .map(|s| Vector3::repeat(0.5 * s * s))
            .collect();
        let bows: Vec<f64> = straightened(bows).iter().map(|bow| bow.x).collect();
        let weight: f64 = bows.iter().map(|bow| bow * bow).sum();
        if !(square_s2 > 0.0 && weight > 0.0) {
            return;
        }
        let pulled = left
            .iter()
            .zip(&bows)
            .map(|(x, bow)| x * *bow)
            .sum::<Vector3<f64>>();
        let pull = pulled / weight;
        let alone_m2: f64 = left.iter().map(Vector3::norm_squared).sum();
        self.samples += count;
        self.joint_m2 += readings
            .iter()
            .map(|r| (r.position_m - r.estimated_m).norm_squared())
            .sum::<f64>();
        self.alone_m2 += alone_m2;
        self.pulled_m2 += (alone_m2 - pull.norm_squared() * weight).max(0.0);
        self.alone_freedom += 3.0 * (count - 2.0);
        self.pulled_freedom += 3.0 * (count - 3.0);
        self.product_m2 += left
            .windows(2)
            .map(|pair| pair[0].dot(&pair[1]))
            .sum::<f64>();
        self.pull += (gravity_m_s2 + pull) * weight;
        self.pull_weight += weight;
    }
}
