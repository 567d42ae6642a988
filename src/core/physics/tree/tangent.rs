//! How changes of a tree's angular state run along its vector field.
//!
//! Changes are stored by rows, one per coordinate and rate, with a number per direction. A quaternion
//! is a point of R⁴ here, `Q̇ = ½ Q ω` and `δQ̇ = ½ (δQ ω + Q δω)`; what counts for the accelerations is
//! the rotation of its direction, whose right perturbation is `2 Im(Q⁻¹ δQ)`.

use super::articulated::LANES;
use super::change::Change;
use super::model::{Motor, Tree};

/// `Q ω` for `Q = (i, j, k, w)`.
#[inline(always)]
pub fn times_rate(q: &[f64; 4], omega: &[f64; 3]) -> [f64; 4] {
    let [i, j, k, w] = *q;
    let [x, y, z] = *omega;
    [
        w * x + j * z - k * y,
        w * y + k * x - i * z,
        w * z + i * y - j * x,
        -(i * x + j * y + k * z),
    ]
}

/// Derivatives of the angular coordinates by time, of coordinates and rates one after the other.
pub fn coordinates_by_time(tree: &Tree, state: &[f64], slope: &mut [f64]) {
    let (coordinates, rates) = state.split_at(tree.coordinates);
    for node in &tree.nodes {
        let (at, from) = (node.coordinate, node.column);
        match node.motor {
            Motor::Pin | Motor::Slide => slope[at] = rates[from],
            Motor::Ball => {
                let omega = [rates[from], rates[from + 1], rates[from + 2]];
                let product = times_rate(&four(&coordinates[at..]), &omega);
                for part in 0..4 {
                    slope[at + part] = 0.5 * product[part];
                }
            }
        }
    }
}

pub fn four(numbers: &[f64]) -> [f64; 4] {
    [numbers[0], numbers[1], numbers[2], numbers[3]]
}

/// Room for the changes that the accelerations see.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// Numbers per row.
    stride: usize,
    /// Per number in a row of [`Change`]: right perturbations, then rates.
    seen: Vec<f64>,
}

impl Tangent {
    /// Room for a tree.
    pub fn new(tree: &Tree, stride: usize) -> Self {
        let width = 2 * tree.columns - tree.first_turned();
        Self {
            stride,
            seen: vec![0.0; width * stride],
        }
    }

    /// Slopes of the changes where `change` was evaluated.
    pub fn slope(
        &mut self,
        tree: &Tree,
        state: &[f64],
        change: &Change,
        z: &[f64],
        slope: &mut [f64],
    ) {
        let (stride, turned) = (self.stride, tree.first_turned());
        let by_rate = tree.columns - turned;
        let of_rates = &z[tree.coordinates * stride..];
        for node in &tree.nodes {
            let (at, column) = (node.coordinate * stride, node.column);
            match node.motor {
                Motor::Pin | Motor::Slide => {
                    slope[at..at + stride]
                        .copy_from_slice(&of_rates[column * stride..(column + 1) * stride]);
                    let to = (column - turned) * stride;
                    self.seen[to..to + stride].copy_from_slice(&z[at..at + stride]);
                }
                Motor::Ball => {
                    let rate = tree.coordinates + column;
                    let omega = [state[rate], state[rate + 1], state[rate + 2]];
                    let q = four(&state[node.coordinate..]);
                    let of_q = &z[at..at + 4 * stride];
                    let of_omega = &of_rates[column * stride..(column + 3) * stride];
                    quaternion(stride, &q, &omega, of_q, of_omega, &mut slope[at..]);
                    if column >= turned {
                        let to = (column - turned) * stride;
                        perturbation(stride, &q, of_q, &mut self.seen[to..]);
                    }
                }
            }
        }
        self.seen[by_rate * stride..].copy_from_slice(&of_rates[..tree.columns * stride]);
        let result = &mut slope[tree.coordinates * stride..];
        let rows = change.rows.chunks_exact(change.stride);
        for (row, out) in rows.zip(result.chunks_exact_mut(stride)) {
            product(stride, row, &self.seen, out);
        }
    }
}

/// `Σ_c row_c seen_c`, four directions at a time.
#[inline(always)]
fn product(stride: usize, row: &[f64], seen: &[f64], out: &mut [f64]) {
    for (from, out) in out.chunks_exact_mut(LANES).enumerate() {
        let mut sum = [0.0; LANES];
        for (weight, numbers) in row.iter().zip(seen.chunks_exact(stride)) {
            let numbers = &numbers[from * LANES..from * LANES + LANES];
            for lane in 0..LANES {
                sum[lane] += weight * numbers[lane];
            }
        }
        out.copy_from_slice(&sum);
    }
}

/// `½ (δQ ω + Q δω)`.
#[inline(always)]
fn quaternion(
    stride: usize,
    q: &[f64; 4],
    omega: &[f64; 3],
    of_q: &[f64],
    of_omega: &[f64],
    out: &mut [f64],
) {
    for lane in 0..stride {
        let moved = [0, 1, 2, 3].map(|part| of_q[part * stride + lane]);
        let faster = [0, 1, 2].map(|part| of_omega[part * stride + lane]);
        let (first, second) = (times_rate(&moved, omega), times_rate(q, &faster));
        for part in 0..4 {
            out[part * stride + lane] = 0.5 * (first[part] + second[part]);
        }
    }
}

/// `2 Im(Q⁻¹ δQ)`: right perturbation of the rotation.
#[inline(always)]
pub fn perturbation(stride: usize, q: &[f64; 4], of_q: &[f64], out: &mut [f64]) {
    let [i, j, k, w] = *q;
    let scale = 2.0 / (i * i + j * j + k * k + w * w);
    for lane in 0..stride {
        let [di, dj, dk, dw] = [0, 1, 2, 3].map(|part| of_q[part * stride + lane]);
        out[lane] = scale * (w * di - dw * i - (j * dk - k * dj));
        out[stride + lane] = scale * (w * dj - dw * j - (k * di - i * dk));
        out[2 * stride + lane] = scale * (w * dk - dw * k - (i * dj - j * di));
    }
}
