//! Taylor series in time of a free rotation. The right sides of Euler's equations, of the
//! quaternion's kinematics and of their derivatives are products of two functions, so that each
//! coefficient is one convolution of earlier ones: for `ḟ = a b`,
//! `f_{n+1} = Σ_l a_l b_{n−l}/(n + 1)`.
//!
//! With `c_i = (I_j − I_k)/I_i` for `i, j, k` in cyclic order, `W = ∂ω(t)/∂ω(0)` and `η` the
//! right perturbation of the rotation by `ω(0)`:
//!
//! ```text
//! ω̇_i = c_i ω_j ω_k,          q̇ = ½ q ω,
//! Ẇ_i = c_i (ω_j W_k + ω_k W_j),   η̇_i = W_i + ω_k η_j − ω_j η_k
//! ```

use std::ops::{Add, Mul, Sub};

use nalgebra::{Matrix3, Vector3};

/// Order of the series: number of terms after the constant one.
pub const ORDER: usize = 20;

/// Greatest relative size of the last terms at the ends of a step. The truncation error is a fifth
/// of it or less and grows as a power of the time, so that it adds no more than rounding over a
/// whole rotation (`tools/results`: a smaller value costs steps and gains nothing, 2⁻⁴² loses a
/// digit of derivatives).
pub const TRUNCATION: f64 = 1.0 / (1u64 << 46) as f64;

/// Lengths of steps are multiples of this, so that their sums are exact in floating point.
const QUANTUM: f64 = 1.0 / (1u64 << 20) as f64;

/// Taylor coefficients of `N` functions, `[power of time][function]`.
pub type Series<const N: usize> = [[f64; N]; ORDER + 1];

/// Taylor coefficients of two columns of a 3 × 3 matrix, `[power of time][row][column]`.
pub type Columns = [[[f64; 2]; 3]; ORDER + 1];

/// Value of a series of columns at a time.
#[inline]
pub fn columns(series: &Columns, time: f64) -> [Vector3<f64>; 2] {
    let mut sum = series[ORDER];
    for coefficients in series[..ORDER].iter().rev() {
        for i in 0..3 {
            for j in 0..2 {
                sum[i][j] = sum[i][j] * time + coefficients[i][j];
            }
        }
    }
    [0, 1].map(|j| Vector3::new(sum[0][j], sum[1][j], sum[2][j]))
}

/// `(add + Σ_l product(a_l, b_{n−l})) scale/(n + 1)`, row by row: the next coefficient.
#[inline(always)]
fn next(
    a: &Series<3>,
    b: &Columns,
    n: usize,
    add: [[f64; 2]; 3],
    scale: [f64; 3],
    product: impl Fn([Lanes; 3], [Lanes; 3]) -> [Lanes; 3],
) -> [[f64; 2]; 3] {
    // Three names rather than an array, which would live in memory.
    let (mut x, mut y, mut z) = (Lanes(add[0]), Lanes(add[1]), Lanes(add[2]));
    for ([a, b, c], [p, q, r]) in a.iter().zip(b[..=n].iter().rev()) {
        let factors = [Lanes([*a, *a]), Lanes([*b, *b]), Lanes([*c, *c])];
        let [dx, dy, dz] = product(factors, [Lanes(*p), Lanes(*q), Lanes(*r)]);
        (x, y, z) = (x + dx, y + dy, z + dz);
    }
    let reciprocal = 1.0 / (n + 1) as f64;
    let scaled =
        |Lanes([a, b]): Lanes, scale: f64| [a * (scale * reciprocal), b * (scale * reciprocal)];
    [
        scaled(x, scale[0]),
        scaled(y, scale[1]),
        scaled(z, scale[2]),
    ]
}

/// Two numbers in one vector register.
#[derive(Clone, Copy)]
struct Lanes([f64; 2]);

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }
}

/// Value of a series at a time, by Horner's rule.
#[inline]
pub fn value<const N: usize>(series: &Series<N>, time: f64) -> [f64; N] {
    let mut sum = series[ORDER];
    for coefficients in series[..ORDER].iter().rev() {
        for (entry, coefficient) in sum.iter_mut().zip(coefficients) {
            *entry = *entry * time + coefficient;
        }
    }
    sum
}

/// The variables in which Euler's equations are integrated.
///
/// Let `j` be the axis of the intermediate moment and `u_i`, `u_k` the other two components of `ω`,
/// scaled so that `u̇_i = −κ ω_j u_k` and `u̇_k = −κ ω_j u_i`. Near a separatrix the time until the
/// next flip depends on `u_i² − u_k²`, a difference of numbers that may be a million times larger.
/// Its factors `p, m = u_i ± u_k` obey
///
/// ```text
/// ṗ = −κ ω_j p,   ṁ = κ ω_j m,   ω̇_j = ¼ κ (p² − m²)
/// ```
///
/// and keep all their digits however small one of them is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variables {
    /// The components of `ω`.
    Components,
    /// `p, ω_j, m`.
    Factors {
        /// Axis of the intermediate moment, `j`; `i` and `k` follow it and each other.
        middle: usize,
        /// `κ`, with the sign of the axes' order.
        rate: f64,
        /// The scales `ω_i/u_i` and `ω_k/u_k`.
        scale: [f64; 2],
    },
}

impl Variables {
    /// The variables that lose no digits for the initial angular velocity `omega`.
    ///
    /// Factors are used where the greatest `u_i` and `u_k` of the rotation differ by a factor of
    /// less than two. Further from the separatrix no difference of theirs is small; and with two
    /// nearly equal moments the smaller would be lost in the larger.
    pub fn of(couplings: &[f64; 3], omega: &[f64; 3]) -> Self {
        let Some(middle) = (0..3).find(|j| {
            let c = couplings[*j];
            c * couplings[(j + 1) % 3] < 0.0 && c * couplings[(j + 2) % 3] < 0.0
        }) else {
            return Self::Components;
        };
        let (k, i) = ((middle + 1) % 3, (middle + 2) % 3);
        let scale = [i, k].map(|axis| (couplings[axis] / couplings[middle]).abs().sqrt());
        let square = |axis: usize, scale: f64| {
            (omega[axis] / scale) * (omega[axis] / scale) + omega[middle] * omega[middle]
        };
        let (a, b) = (square(i, scale[0]), square(k, scale[1]));
        if a.max(b) < 4.0 * a.min(b) {
            let rate = (couplings[i] * couplings[k])
                .sqrt()
                .copysign(couplings[middle]);
            Self::Factors {
                middle,
                rate,
                scale,
            }
        } else {
            Self::Components
        }
    }

    /// The variables of an `ω`.
    pub fn with_omega(&self, omega: &[f64; 3]) -> [f64; 3] {
        match *self {
            Self::Components => *omega,
            Self::Factors { middle, scale, .. } => {
                let (k, i) = ((middle + 1) % 3, (middle + 2) % 3);
                let (a, b) = (omega[i] / scale[0], omega[k] / scale[1]);
                [a + b, omega[middle], a - b]
            }
        }
    }

    /// The `ω` of values of the variables.
    pub fn omega(&self, variables: &[f64; 3]) -> [f64; 3] {
        match *self {
            Self::Components => *variables,
            Self::Factors { middle, scale, .. } => {
                let [p, along, m] = *variables;
                let mut omega = [along; 3];
                omega[(middle + 1) % 3] = 0.5 * scale[1] * (p - m);
                omega[(middle + 2) % 3] = 0.5 * scale[0] * (p + m);
                omega
            }
        }
    }

    /// `∂ω/∂z`, with `z` the variables.
    pub fn omega_by_variables(&self) -> Matrix3<f64> {
        let units = [0, 1, 2].map(|axis| {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            Vector3::from(self.omega(&unit))
        });
        Matrix3::from_columns(&units)
    }

    /// `∂z/∂ω`, with `z` the variables.
    pub fn variables_by_omega(&self) -> Matrix3<f64> {
        let units = [0, 1, 2].map(|axis| {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            Vector3::from(self.with_omega(&unit))
        });
        Matrix3::from_columns(&units)
    }

    /// Series of `Z = ∂z(t)/∂z(0)` and of `W = ∂ω(t)/∂z(0)`, for two of the variables `z` at the
    /// start.
    pub fn derivatives(
        &self,
        couplings: &[f64; 3],
        series: &Series<3>,
        by: [usize; 2],
    ) -> (Columns, Columns) {
        let mut z = [[[0.0; 2]; 3]; ORDER + 1];
        for (column, axis) in by.into_iter().enumerate() {
            z[0][axis][column] = 1.0;
        }
        let zero = [[0.0; 2]; 3];
        match *self {
            Self::Components => {
                for n in 0..ORDER {
                    z[n + 1] = next(series, &z, n, zero, *couplings, |a, b| {
                        [
                            a[1] * b[2] + a[2] * b[1],
                            a[2] * b[0] + a[0] * b[2],
                            a[0] * b[1] + a[1] * b[0],
                        ]
                    });
                }
                (z, z)
            }
            Self::Factors { rate, .. } => {
                let scale = [-rate, 0.5 * rate, rate];
                for n in 0..ORDER {
                    z[n + 1] = next(series, &z, n, zero, scale, |a, b| {
                        [
                            a[1] * b[0] + a[0] * b[1],
                            a[0] * b[0] - a[2] * b[2],
                            a[1] * b[2] + a[2] * b[1],
                        ]
                    });
                }
                let mut w = z;
                for rows in &mut w {
                    for column in 0..2 {
                        let change = [rows[0][column], rows[1][column], rows[2][column]];
                        let change = self.omega(&change);
                        for row in 0..3 {
                            rows[row][column] = change[row];
                        }
                    }
                }
                (z, w)
            }
        }
    }

    /// A sum of squares that is constant along the motion: twice the energy `Σ I_i ω_i²`, or with
    /// factors `¼(p² + m²) + ω_j²`.
    pub fn invariant(&self, moments: &[f64; 3], variables: &[f64; 3]) -> f64 {
        let [a, b, c] = variables.map(|variable| variable * variable);
        match *self {
            Self::Components => moments[0] * a + moments[1] * b + moments[2] * c,
            Self::Factors { .. } => 0.25 * (a + c) + b,
        }
    }

    /// Time derivative of the variables.
    pub fn rate(&self, couplings: &[f64; 3], variables: &[f64; 3]) -> [f64; 3] {
        let [a, b, c] = *variables;
        match *self {
            Self::Components => [
                couplings[0] * b * c,
                couplings[1] * c * a,
                couplings[2] * a * b,
            ],
            Self::Factors { rate, .. } => {
                [-rate * b * a, 0.25 * rate * (a * a - c * c), rate * b * c]
            }
        }
    }

    /// Series of the variables and of `ω`.
    pub fn series(&self, couplings: &[f64; 3], start: &[f64; 3]) -> (Series<3>, Series<3>) {
        let mut series = [[0.0; 3]; ORDER + 1];
        series[0] = *start;
        for n in 0..ORDER {
            let (mut x, mut y, mut z) = (0.0, 0.0, 0.0);
            let scale = match self {
                Self::Components => {
                    for (a, b) in series.iter().zip(series[..=n].iter().rev()) {
                        x += a[1] * b[2];
                        y += a[2] * b[0];
                        z += a[0] * b[1];
                    }
                    *couplings
                }
                Self::Factors { rate, .. } => {
                    for (a, b) in series.iter().zip(series[..=n].iter().rev()) {
                        x += a[1] * b[0];
                        y += a[0] * b[0] - a[2] * b[2];
                        z += a[1] * b[2];
                    }
                    [-rate, 0.25 * rate, *rate]
                }
            };
            let reciprocal = 1.0 / (n + 1) as f64;
            series[n + 1] = [
                x * (scale[0] * reciprocal),
                y * (scale[1] * reciprocal),
                z * (scale[2] * reciprocal),
            ];
        }
        let mut omega = series;
        if *self != Self::Components {
            for coefficients in &mut omega {
                *coefficients = self.omega(coefficients);
            }
        }
        (series, omega)
    }
}

/// Series of the rotation from its start, as a quaternion `x, y, z, w`.
pub fn turn(omega: &Series<3>) -> Series<4> {
    let mut series = [[0.0; 4]; ORDER + 1];
    series[0][3] = 1.0;
    for n in 0..ORDER {
        let (mut x, mut y, mut z, mut w) = (0.0, 0.0, 0.0, 0.0);
        for ([a, b, c], q) in omega.iter().zip(series[..=n].iter().rev()) {
            x += q[3] * a + q[1] * c - q[2] * b;
            y += q[3] * b + q[2] * a - q[0] * c;
            z += q[3] * c + q[0] * b - q[1] * a;
            w -= q[0] * a + q[1] * b + q[2] * c;
        }
        let half = 0.5 / (n + 1) as f64;
        series[n + 1] = [x * half, y * half, z * half, w * half];
    }
    series
}

/// Series of `η`, from those of `ω` and `W`.
pub fn turn_derivatives(omega: &Series<3>, w: &Columns) -> Columns {
    let mut eta = [[[0.0; 2]; 3]; ORDER + 1];
    for n in 0..ORDER {
        eta[n + 1] = next(omega, &eta, n, w[n], [1.0; 3], |a, b| {
            [
                a[2] * b[1] - a[1] * b[2],
                a[0] * b[2] - a[2] * b[0],
                a[1] * b[0] - a[0] * b[1],
            ]
        });
    }
    eta
}

/// Greatest step, to both sides of the start, at which the last terms are below [`TRUNCATION`].
pub fn reach(variables: &Variables, series: &Series<3>, turn: &Series<4>) -> f64 {
    let start = &series[0];
    let largest = start.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let scale = match variables {
        Variables::Components => [largest; 3],
        Variables::Factors { .. } => [start[0].abs(), largest, start[2].abs()],
    };
    let size = |n: usize| {
        let relative = (0..3)
            .filter(|i| scale[*i] > 0.0)
            .map(|i| series[n][i].abs() / scale[i]);
        turn[n]
            .iter()
            .map(|q| q.abs())
            .chain(relative)
            .fold(0.0, f64::max)
    };
    let reach = [ORDER - 1, ORDER]
        .into_iter()
        .map(|n| (TRUNCATION / size(n)).powf(1.0 / n as f64))
        .fold(f64::INFINITY, f64::min);
    quantised(reach)
}

/// [`reach`] for `η`, relative to the time, of whose size it is.
pub fn derivatives_reach(eta: &Columns) -> f64 {
    let size = |n: usize| {
        eta[n]
            .as_flattened()
            .iter()
            .fold(0.0_f64, |a, b| a.max(b.abs()))
    };
    let reach = [ORDER - 1, ORDER]
        .into_iter()
        .map(|n| (TRUNCATION / size(n)).powf(1.0 / (n - 1) as f64))
        .fold(f64::INFINITY, f64::min);
    quantised(reach)
}

/// A step as a multiple of [`QUANTUM`].
pub fn quantised(reach: f64) -> f64 {
    if reach < QUANTUM {
        return reach;
    }
    (reach / QUANTUM).floor() * QUANTUM
}
