//! What a smoothing filter has done to positions, seen in the samples alone.
//!
//! A Savitzky–Golay filter (Analytical Chemistry 36, 1964) puts at every sample the value of the
//! polynomial that fits the window about it; at both ends, where no window fits, the values of the polynomial of the
//! first and the last window. So as many samples as half a window and one lie on one polynomial. (A free flight does so too, on
//! gravity's parabola, where it is seen without noise.)

use nalgebra::{DMatrix, DVector, Vector3};
use serde::Serialize;

use crate::tosses::Pose;

/// Orders of polynomials that are looked for.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=3;
/// Greatest difference of values on a polynomial beyond its order: sixteen rounding errors of seven
/// digits \[m\].
const ROUNDING_M: f64 = 3e-6;

/// A Savitzky–Golay filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Filter {
    /// Order of its polynomials.
    pub order: usize,
    /// Samples of a window.
    pub window: usize,
}

/// Number of leading values on one polynomial of that order: those that always are, and more.
pub fn run(values: &[f64], order: usize) -> usize {
    let is_on_it = |next: &&[f64]| {
        let mut differences = next.to_vec();
        while differences.len() > 1 {
            differences = differences
                .windows(2)
                .map(|pair| pair[1] - pair[0])
                .collect();
        }
        differences[0].abs() < ROUNDING_M
    };
    let more = values.windows(order + 2).take_while(is_on_it).count();
    (order + 1 + more).min(values.len())
}

/// The filter that the first positions show; `None` where they show none.
pub fn filter(poses: &[Pose]) -> Option<Filter> {
    let run = |order: usize, axis: usize| {
        let values: Vec<f64> = poses.iter().map(|pose| pose.0[axis]).collect();
        run(&values, order)
    };
    ORDERS.into_iter().find_map(|order| {
        let run = (0..3).map(|axis| run(order, axis)).min()?;
        // One window over the whole toss puts all of it on one polynomial.
        let window = (2 * run - 1).min(poses.len());
        (run > order + 1).then_some(Filter { order, window })
    })
}

impl Filter {
    /// The values after it; `None` where there are fewer than a window.
    pub fn smoothed(&self, values: &[f64]) -> Option<Vec<f64>> {
        let last_start = values.len().checked_sub(self.window)?;
        let half = self.window / 2;
        let unknowns = self.order + 1;
        let power = |at: f64, j: usize| (at / half.max(1) as f64).powi(j as i32);
        let columns = DMatrix::from_fn(self.window, unknowns, |i, j| {
            power(i as f64 - half as f64, j)
        });
        let fit = columns.pseudo_inverse(1e-12).ok()?;
        let at = |index: usize| {
            let start = index.saturating_sub(half).min(last_start);
            let seen = DVector::from_column_slice(&values[start..start + self.window]);
            let place = index as f64 - (start + half) as f64;
            let found = &fit * seen;
            (0..unknowns).map(|j| found[j] * power(place, j)).sum()
        };
        Some((0..values.len()).map(at).collect())
    }

    /// Positions after it.
    pub fn smoothed_positions(&self, positions_m: &[Vector3<f64>]) -> Option<Vec<Vector3<f64>>> {
        let along = |axis: usize| {
            let values: Vec<f64> = positions_m.iter().map(|position| position[axis]).collect();
            self.smoothed(&values)
        };
        let (x, y, z) = (along(0)?, along(1)?, along(2)?);
        let positions = x.into_iter().zip(y).zip(z);
        Some(positions.map(|((x, y), z)| Vector3::new(x, y, z)).collect())
    }
}

/// Residual sum of squares of positions about the best free flight with that acceleration, with its
/// degrees of freedom; and the acceleration of the best parabola, where there are enough.
pub struct Fall {
    /// Sum of squares \[m²\].
    pub squares_m2: f64,
    /// Degrees of freedom.
    pub freedom: usize,
    /// Of the best parabola [m/s²].
    pub acceleration_m_s2: Option<Vector3<f64>>,
}

/// How positions at that rate fall.
pub fn fall(
    positions_m: &[Vector3<f64>],
    rate_hz: f64,
    gravity_m_s2: &Vector3<f64>,
) -> Option<Fall> {
    let count = positions_m.len();
    let time_s = |index: usize| (index as f64 - 0.5 * (count as f64 - 1.0)) / rate_hz;
    let power = |i: usize, j: usize| time_s(i).powi(j as i32);
    let fitted = |unknowns: usize, values: &DVector<f64>| {
        let columns = DMatrix::from_fn(count, unknowns, power);
        let found = columns.clone().svd(true, true).solve(values, 1e-14).ok()?;
        let left = values - columns * &found;
        Some((found, left.norm_squared()))
    };
    let (mut squares_m2, mut acceleration_m_s2) = (0.0, Vector3::zeros());
    for axis in 0..3 {
        let free = |i: usize, _: usize| {
            positions_m[i][axis] - 0.5 * gravity_m_s2[axis] * time_s(i).powi(2)
        };
        let values = DVector::from_fn(count, free);
        squares_m2 += fitted(2, &values)?.1;
        if count > 2 {
            acceleration_m_s2[axis] = gravity_m_s2[axis] + 2.0 * fitted(3, &values)?.0[2];
        }
    }
    Some(Fall {
        squares_m2,
        freedom: 3 * count.saturating_sub(2),
        acceleration_m_s2: (count > 2).then_some(acceleration_m_s2),
    })
}
