//! The free rotation's derivative by the body's principal moments.
//!
//! Euler's equations `ω̇_i = c_i ω_j ω_k` know the moments by `c_i = (I_j − I_k)/I_i` only, so that
//! ratios matter and the three derivatives by `μ = ln I` have the sum zero. With `Z = ∂ω/∂μ` and `η`
//! the right perturbation of the rotation by `μ`, both zero at the start,
//!
//! ```text
//! Ż_i = c_i (ω_j Z_k + ω_k Z_j) + (∂c_i/∂μ) ω_j ω_k,   η̇_i = Z_i + ω_k η_j − ω_j η_k
//! ∂c_i/∂μ_i = −c_i,   ∂c_i/∂μ_j = I_j/I_i,   ∂c_i/∂μ_k = −I_k/I_i
//! ```
//!
//! By Taylor series, step after step, as the rotation itself ([`super`]). They know no classes:
//! where two or three moments are equal they give the limits.

use nalgebra::{Matrix3, Vector3};

use super::{FlowMotion, FlowValues, GridPoint};
use crate::physics::body::Body;
use crate::physics::flow::series::{self, Columns, ORDER, Series};

/// Changes of a free rotation by the logarithms of the principal moments, a column for each of
/// `ln I_0`, `ln I_1`, `ln I_2`; the state at the start is fixed. Only ratios of moments matter: the
/// three columns have the sum zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnByMoments {
    /// Of `R(s)`, right perturbation [rad, body].
    pub orientation: Matrix3<f64>,
    /// Of `ω(s)` [rad/s, body].
    pub angular_velocity: Matrix3<f64>,
}

/// Two columns of a 3 × 3 matrix, `[row][column]`.
type Pair = [[f64; 2]; 3];

/// The motion between two steps in units of the speed, with its derivatives by `μ_0` and `μ_1`.
#[derive(Clone, Debug)]
struct SeriesNode {
    grid: GridPoint,
    /// `Z`.
    spin: Pair,
    /// `η`.
    turn: Pair,
}

/// One step: the derivatives near a node, to both sides.
#[derive(Clone, Debug)]
struct SeriesStep {
    /// Distance of the node from the start.
    from: f64,
    reach: f64,
    spin: Columns,
    turn: Columns,
}

/// The derivatives by the moments along the rotation from one initial angular velocity, for many
/// durations: steps are computed when first needed.
#[derive(Clone, Debug)]
pub struct SpinByMoments {
    motion: FlowMotion,
    /// `c`, and `∂c_i/∂μ` by `μ_0` and `μ_1`.
    couplings: [f64; 3],
    by_moments: Pair,
    /// Steps after the start and before it, each with the node behind the last.
    sides: [(Vec<SeriesStep>, SeriesNode); 2],
}

impl SpinByMoments {
    /// Those of the rotation with the initial angular velocity `ω` [rad/s, body].
    pub fn new(body: &Body, angular_velocity_rad_s: &Vector3<f64>) -> Self {
        let motion = FlowMotion::new(body, angular_velocity_rad_s);
        let moments = body.moments_kg_m2();
        let couplings = motion.couplings;
        let by_moments = [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let mut by = [0.0; 3];
            by[i] = -couplings[i];
            by[j] = moments[j] / moments[i];
            by[k] = -moments[k] / moments[i];
            [by[0], by[1]]
        });
        let start = SeriesNode {
            grid: motion.start.clone(),
            spin: Pair::default(),
            turn: Pair::default(),
        };
        Self {
            motion,
            couplings,
            by_moments,
            sides: [(Vec::new(), start.clone()), (Vec::new(), start)],
        }
    }

    /// The derivatives after `duration_s` (negative: before); NaN where the rotation is longer than
    /// [`super::ANGLE_MAX_RAD`]. They do not depend on the order in which durations are asked for.
    pub fn at(&mut self, duration_s: f64) -> TurnByMoments {
        let Some(angle) = self.motion.angle(duration_s) else {
            return TurnByMoments {
                orientation: Matrix3::repeat(f64::NAN),
                angular_velocity: Matrix3::repeat(f64::NAN),
            };
        };
        let (side, distance) = (usize::from(angle < 0.0), angle.abs());
        let end = |steps: &[SeriesStep]| steps.last().map_or(0.0, |last| last.from + last.reach);
        while self.sides[side].0.is_empty() || end(&self.sides[side].0) < distance {
            self.extend(side);
        }
        let steps = &self.sides[side].0;
        let step = &steps[steps.partition_point(|step| step.from < distance).max(1) - 1];
        let time = (distance - step.from).copysign(angle);
        let all = |series: &Columns| {
            let [first, second] = series::columns(series, time);
            Matrix3::from_columns(&[first, second, -(first + second)])
        };
        TurnByMoments {
            orientation: all(&step.turn),
            angular_velocity: all(&step.spin) * self.motion.speed_rad_s,
        }
    }

    /// Adds a step to a side.
    fn extend(&mut self, side: usize) {
        let (steps, node) = &self.sides[side];
        let values = FlowValues::new(&self.motion, &node.grid);
        let (spin, turn) = self.series(&values.omega, node);
        let reach = reach(&spin).min(reach(&turn)).min(values.reach);
        let reach = reach.min(super::ANGLE_MAX_RAD);
        let from = steps.last().map_or(0.0, |last| last.from + last.reach);
        let time = if side == 0 { reach } else { -reach };
        let after = |series: &Columns| {
            let [first, second] = series::columns(series, time);
            [0, 1, 2].map(|row| [first[row], second[row]])
        };
        let node = SeriesNode {
            spin: after(&spin),
            turn: after(&turn),
            grid: values.node(&self.motion, &node.grid, time),
        };
        let step = SeriesStep {
            from,
            reach,
            spin,
            turn,
        };
        let (steps, behind) = &mut self.sides[side];
        steps.push(step);
        *behind = node;
    }

    /// Series of `Z` and `η` from a node, given that of `ω`.
    fn series(&self, omega: &Series<3>, node: &SeriesNode) -> (Columns, Columns) {
        let mut spin = [Pair::default(); ORDER + 1];
        let mut turn = [Pair::default(); ORDER + 1];
        (spin[0], turn[0]) = (node.spin, node.turn);
        for n in 0..ORDER {
            let per = 1.0 / (n + 1) as f64;
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let product: f64 = (0..=n).map(|l| omega[l][j] * omega[n - l][k]).sum();
                for column in 0..2 {
                    let (mut spun, mut turned) = (0.0, 0.0);
                    for l in 0..=n {
                        let (w, m) = (&omega[l], n - l);
                        spun += w[j] * spin[m][k][column] + w[k] * spin[m][j][column];
                        turned += w[k] * turn[m][j][column] - w[j] * turn[m][k][column];
                    }
                    let pushed = self.by_moments[i][column] * product;
                    spin[n + 1][i][column] = (self.couplings[i] * spun + pushed) * per;
                    turn[n + 1][i][column] = (spin[n][i][column] + turned) * per;
                }
            }
        }
        (spin, turn)
    }
}

/// Derivatives of a free rotation for `duration_s` by the moments; for many durations, see
/// [`SpinByMoments`].
pub fn turn_by_moments(
    body: &Body,
    angular_velocity_rad_s: &Vector3<f64>,
    duration_s: f64,
) -> TurnByMoments {
    SpinByMoments::new(body, angular_velocity_rad_s).at(duration_s)
}

/// Greatest step at which the last terms are below [`series::TRUNCATION`] times the first ones.
fn reach(columns: &Columns) -> f64 {
    let size = |n: usize| {
        let entries = columns[n].as_flattened().iter();
        entries.fold(0.0_f64, |a, b| a.max(b.abs()))
    };
    let first = (0..3).map(size).fold(0.0, f64::max);
    let reach = [ORDER - 1, ORDER]
        .into_iter()
        .filter(|n| first > 0.0 && size(*n) > 0.0)
        .map(|n| (series::TRUNCATION * first / size(n)).powf(1.0 / n as f64))
        .fold(f64::INFINITY, f64::min);
    series::quantised(reach)
}

#[cfg(test)]
mod tests;
