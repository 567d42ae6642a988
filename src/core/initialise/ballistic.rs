//! A ballistic curve through the centres of mass of one segment, by linear least squares.
//!
//! With `a` the acted time from the segment's middle and physical time running `c` times as
//! fast,
//!
//! ```text
//! min over x, v', c²   Σ |x + v' a_i + ½ c² g a_i² − x_i|²,   v' = c v
//! ```
//!
//! is linear: an unknown duration (paper §6.2.1) costs one more column, not a search.

use nalgebra::Vector3;

/// Least and greatest accepted rate of physical against acted time.
const RATES: (f64, f64) = (0.02, 5.0);

/// Position and velocity at the middle of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ballistic {
    /// Position [m, world].
    pub position_m: Vector3<f64>,
    /// Change of position per acted time [m/s, world].
    pub acted_velocity_m_s: Vector3<f64>,
    /// Rate `c` of physical time against acted time; `None` where the fit does not fall.
    pub rate: Option<f64>,
    /// Sum of squared distances \[m²\].
    pub square_m2: f64,
}

/// A place of the centre of mass at an acted time \[s, m world\].
pub type Place = (f64, Vector3<f64>);

/// Fits `places` about acted time `middle_s` to a fall with gravity and constant force `pull_m_s2`,
/// without drag, which is small in a flight of one hand's breadth and left to the estimation. `rate` is the known rate, or `None` to estimate it.
pub fn fit(
    places: &[Place],
    middle_s: f64,
    pull_m_s2: &Vector3<f64>,
    rate: Option<f64>,
) -> Ballistic {
    let along = pull_m_s2.try_normalize(1e-9);
    let known_fall = rate.map_or(Vector3::zeros(), |c| pull_m_s2 * (0.5 * c * c));
    let target = |(acted_s, position_m): &Place| {
        let a = acted_s - middle_s;
        (a, position_m - known_fall * (a * a))
    };
    let count = places.len() as f64;
    let mean_a = places.iter().map(|place| target(place).0).sum::<f64>() / count;
    let mean_p = places
        .iter()
        .map(|place| target(place).1)
        .sum::<Vector3<f64>>()
        / count;
    let (mut first_norm, mut first) = (0.0, Vector3::zeros());
    for (a, p) in places.iter().map(target) {
        first_norm += (a - mean_a) * (a - mean_a);
        first += (p - mean_p) * (a - mean_a);
    }
    let slope = if first_norm > 0.0 {
        first / first_norm
    } else {
        Vector3::zeros()
    };

    // The quadratic orthogonal to 1 and a, only along the pull.
    let quadratic = FallQuadratic::new(places, middle_s, mean_a, first_norm);
    let mut curvature = Vector3::zeros();
    let mut found = rate;
    if let (None, Some(along)) = (rate, along) {
        let pull: f64 = places
            .iter()
            .map(|place| {
                let (a, p) = target(place);
                quadratic.at(a) * (p - mean_p).dot(&along)
            })
            .sum();
        let size = pull / quadratic.norm.max(f64::MIN_POSITIVE);
        let square = 2.0 * size / pull_m_s2.norm();
        let (least, most) = (RATES.0 * RATES.0, RATES.1 * RATES.1);
        if square.is_finite() && square > least && square < most {
            found = Some(square.sqrt());
            curvature = along * size;
        }
    }
    let at = |a: f64| mean_p + slope * (a - mean_a) + curvature * quadratic.at(a);
    let square_m2 = places
        .iter()
        .map(target)
        .map(|(a, p)| (p - at(a)).norm_squared())
        .sum();
    Ballistic {
        position_m: at(0.0),
        acted_velocity_m_s: slope - curvature * (quadratic.slope + 2.0 * mean_a),
        rate: found,
        square_m2,
    }
}

/// The constant acceleration that fits places best \[m/s² of acted time, world\]; zero of fewer than three.
pub fn acceleration_m_s2(places: &[Place], middle_s: f64) -> Vector3<f64> {
    let count = places.len() as f64;
    let mean_a = places.iter().map(|(a, _)| a - middle_s).sum::<f64>() / count;
    let norm = places
        .iter()
        .map(|(a, _)| (a - middle_s - mean_a).powi(2))
        .sum();
    let quadratic = FallQuadratic::new(places, middle_s, mean_a, norm);
    let all = places.iter().map(|(a, p)| p * quadratic.at(a - middle_s));
    match places.len() {
        0..3 => Vector3::zeros(),
        _ => all.sum::<Vector3<f64>>() * (2.0 / quadratic.norm.max(f64::MIN_POSITIVE)),
    }
}

/// `q(a) = a² − mean(a²) − slope (a − mean a) …`, orthogonal to lines over the samples.
struct FallQuadratic {
    mean_a: f64,
    mean_square: f64,
    slope: f64,
    norm: f64,
}

impl FallQuadratic {
    fn new(places: &[Place], middle_s: f64, mean_a: f64, first_norm: f64) -> Self {
        let centred = || {
            places
                .iter()
                .map(move |(acted_s, _)| acted_s - middle_s - mean_a)
        };
        let count = places.len() as f64;
        let mean_square = centred().map(|b| b * b).sum::<f64>() / count;
        let slope = centred().map(|b| b * b * b).sum::<f64>() / first_norm.max(f64::MIN_POSITIVE);
        let mut quadratic = Self {
            mean_a,
            mean_square,
            slope,
            norm: 0.0,
        };
        quadratic.norm = centred().map(|b| quadratic.at(b + mean_a).powi(2)).sum();
        quadratic
    }

    /// Value at `a`, with curvature 2.
    fn at(&self, a: f64) -> f64 {
        let b = a - self.mean_a;
        b * b - self.mean_square - self.slope * b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.3, -9.8);

    fn places(rate: f64) -> Vec<Place> {
        let (x, v) = (Vector3::new(0.1, -0.2, 0.9), Vector3::new(0.5, 1.5, -2.0));
        (0..30)
            .map(|i| {
                // Uneven on purpose.
                let acted_s = 2.0 + 0.013 * f64::from(i) + 0.002 * f64::from(i % 3);
                let s = rate * (acted_s - 2.2);
                (acted_s, x + v * s + GRAVITY * (0.5 * s * s))
            })
            .collect()
    }

    #[test]
    fn finds_flight_and_rate_of_exact_data() {
        for rate in [0.2, 0.4, 1.0, 2.5] {
            for known in [None, Some(rate)] {
                let fit = fit(&places(rate), 2.2, &GRAVITY, known);
                assert!((fit.rate.unwrap() - rate).abs() < 1e-9 * rate);
                assert!((fit.position_m - Vector3::new(0.1, -0.2, 0.9)).norm() < 1e-12);
                let velocity = fit.acted_velocity_m_s / rate;
                assert!((velocity - Vector3::new(0.5, 1.5, -2.0)).norm() < 1e-10);
                assert!(fit.square_m2 < 1e-20);
            }
        }
    }

    #[test]
    fn what_rises_instead_of_falling_has_no_rate() {
        let mut rising = places(1.0);
        rising
            .iter_mut()
            .for_each(|(_, position_m)| position_m.z *= -1.0);
        assert_eq!(
            fit(&rising, 2.2, &Vector3::new(0.0, 0.0, -9.8), None).rate,
            None
        );
    }
}
