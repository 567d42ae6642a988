//! The free turn in elliptic functions: angular velocity by Jacobi's (arithmetic-geometric
//! mean), the precession about the angular momentum by Legendre's third integral in Carlson's
//! form (van Zon and Schofield, "Numerical implementation of the exact dynamics of free rigid
//! bodies", Journal of Computational Physics 225, 2007; Carlson, "Numerical computation of real
//! or complex elliptic integrals", Numerical Algorithms 10, 1995).
//!
//! Axes are renamed so that the body circulates about the third and the second is the
//! intermediate one; invariants are written as sums that do not cancel.

use nalgebra::{Matrix3, Vector3};

use super::dual::{Dual, Number};

/// One turn, for many durations.
pub struct Elliptic<N> {
    axes: Axes,
    moments: [f64; 3],
    amplitudes: [N; 3],
    /// `du/ds`.
    rate: N,
    /// `u` at the epoch.
    phase: N,
    /// `1 − m`.
    complement: N,
    quarter: N,
    /// `κ` of the third integral's `1 + κ sn²`, its complete value and its value at the phase.
    kappa: f64,
    complete: N,
    begin: N,
    momentum: N,
    /// Body to the frame of the angular momentum, at the epoch.
    frame: [[N; 3]; 3],
}

/// New axis → old axis, and whether the second is reversed to keep the order right-handed.
#[derive(Clone, Copy)]
struct Axes {
    from: [usize; 3],
    sign: f64,
}

impl Axes {
    fn vector<N: Number>(&self, v: [N; 3]) -> [N; 3] {
        let [a, b, c] = self.from;
        [v[a], v[b] * self.sign.into(), v[c]]
    }
}

/// Carlson's R_F by duplication.
fn carlson_f<N: Number>(mut x: N, mut y: N, mut z: N) -> N {
    let third = N::from(1.0 / 3.0);
    loop {
        let mean = (x + y + z) * third;
        let [dx, dy, dz] = [x, y, z].map(|v| (mean - v) / mean);
        let largest = [dx, dy, dz]
            .iter()
            .fold(0.0_f64, |a, d| a.max(d.value().abs()));
        if largest < 1e-3 {
            let e2 = dx * dy - dz * dz;
            let e3 = dx * dy * dz;
            let series = N::from(1.0) - e2 * (1.0 / 10.0).into()
                + e3 * (1.0 / 14.0).into()
                + e2 * e2 * (1.0 / 24.0).into()
                - e2 * e3 * (3.0 / 44.0).into()
                - e2 * e2 * e2 * (5.0 / 208.0).into()
                + e3 * e3 * (3.0 / 104.0).into();
            return series / mean.root();
        }
        let (a, b, c) = (x.root(), y.root(), z.root());
        let lambda = a * b + b * c + c * a;
        let quarter = N::from(0.25);
        (x, y, z) = (
            (x + lambda) * quarter,
            (y + lambda) * quarter,
            (z + lambda) * quarter,
        );
    }
}

/// R_C(1, 1 + e).
fn carlson_c<N: Number>(e: N) -> N {
    let one = N::from(1.0);
    carlson_f(one, one + e, one + e)
}

/// Carlson's R_J by duplication, positive arguments.
fn carlson_j<N: Number>(mut x: N, mut y: N, mut z: N, mut p: N) -> N {
    let mut sum = N::from(0.0);
    let mut scale = 1.0;
    loop {
        let mean = (x + y + z + p + p) * 0.2.into();
        let [dx, dy, dz, dp] = [x, y, z, p].map(|v| (mean - v) / mean);
        let largest = [dx, dy, dz, dp]
            .iter()
            .fold(0.0_f64, |a, d| a.max(d.value().abs()));
        if largest < 1e-3 {
            let p2 = dp * dp;
            let xyz = dx * dy * dz;
            let e2 = dx * dy + dx * dz + dy * dz - p2 * 3.0.into();
            let e3 = xyz + e2 * dp * 2.0.into() + p2 * dp * 4.0.into();
            let e4 = (xyz * 2.0.into() + e2 * dp + p2 * dp * 3.0.into()) * dp;
            let e5 = xyz * p2;
            let series = N::from(1.0) - e2 * (3.0 / 14.0).into()
                + e3 * (1.0 / 6.0).into()
                + e2 * e2 * (9.0 / 88.0).into()
                - e4 * (3.0 / 22.0).into()
                - e2 * e3 * (9.0 / 52.0).into()
                + e5 * (3.0 / 26.0).into();
            return sum * 6.0.into() + series * scale.into() / (mean * mean.root());
        }
        let (a, b, c, d) = (x.root(), y.root(), z.root(), p.root());
        let lambda = a * b + b * c + c * a;
        let product = (d + a) * (d + b) * (d + c);
        let e = (p - x) * (p - y) * (p - z) / (product * product);
        sum = sum + carlson_c(e) * scale.into() / product;
        scale *= 0.25;
        let quarter = N::from(0.25);
        (x, y) = ((x + lambda) * quarter, (y + lambda) * quarter);
        (z, p) = ((z + lambda) * quarter, (p + lambda) * quarter);
    }
}

/// sn, cn, dn for `|u|` up to the quarter period, by descending means.
fn jacobi<N: Number>(u: N, complement: N) -> [N; 3] {
    let one = N::from(1.0);
    let (mut means, mut a, mut rest) = (Vec::with_capacity(12), one, complement);
    let mut c;
    loop {
        let root = rest.root();
        means.push((a, root));
        c = (a + root) * 0.5.into();
        if (a - root).value().abs() <= 1e-12 * a.value() || means.len() == 12 {
            break;
        }
        rest = root * a;
        a = c;
    }
    let (sine, cosine) = (u * c).sine_and_cosine();
    if sine.value() == 0.0 {
        return [u, cosine, one];
    }
    let mut a = cosine / sine;
    c = c * a;
    let mut dn = one;
    for (mean, root) in means.into_iter().rev() {
        a = a * c;
        c = c * dn;
        dn = (root + a) / (mean + a);
        a = c / mean;
    }
    let sn = one / (c * c + one).root() * sine.value().signum().into();
    [sn, c * sn, dn]
}

/// `∫ du/(1 + κ sn²)` from zero, for `|u|` up to the quarter period.
fn third<N: Number>(u: N, [sn, cn, dn]: [N; 3], kappa: f64) -> N {
    let square = sn * sn;
    let p = N::from(1.0) + square * kappa.into();
    u - square * sn * carlson_j(cn * cn, dn * dn, 1.0.into(), p) * (kappa / 3.0).into()
}

/// Rows: the third axis across the angular momentum, its normal, the angular momentum.
fn frame<N: Number>(momentum: [N; 3]) -> ([[N; 3]; 3], N) {
    let [a, b, c] = momentum;
    let across = a * a + b * b;
    let length = (across + c * c).root();
    let sine = across.root();
    let z = [a / length, b / length, c / length];
    let x = [
        -(a * c) / (sine * length),
        -(b * c) / (sine * length),
        sine / length,
    ];
    let y = [b / sine, -(a / sine), N::from(0.0)];
    ([x, y, z], length)
}

impl<N: Number> Elliptic<N> {
    /// The turn that begins with `omega` [rad/s, body].
    pub fn new(moments_kg_m2: [f64; 3], omega: [N; 3]) -> Self {
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| moments_kg_m2[*a].total_cmp(&moments_kg_m2[*b]));
        let [a, b, c] = order;
        let moment = |i: usize| moments_kg_m2[i];
        let square = |i: usize| omega[i].value() * omega[i].value();
        // L² − 2TB, which tells the extreme axis that is circulated.
        let about_largest = moment(c) * (moment(c) - moment(b)) * square(c)
            > moment(a) * (moment(b) - moment(a)) * square(a);
        let from = if about_largest { [a, b, c] } else { [c, b, a] };
        let even = (from[0] + 1) % 3 == from[1];
        let axes = Axes {
            from,
            sign: if even { 1.0 } else { -1.0 },
        };
        let [i1, i2, i3] = from.map(moment);
        let w = axes.vector(omega);
        let squares = w.map(|w| w * w);
        let one = N::from(1.0);
        let first = squares[0] + squares[1] * (i2 * (i2 - i3) / (i1 * (i1 - i3))).into();
        let last = squares[2] + squares[1] * (i2 * (i2 - i1) / (i3 * (i3 - i1))).into();
        let ratio = (i1 * (i1 - i3) / (i2 * (i2 - i3))).sqrt();
        let sign = if w[2].value() < 0.0 { -1.0 } else { 1.0 };
        let a1 = first.root();
        let a3 = last.root() * sign.into();
        let a2 = a1 * (ratio * (i3 - i1).signum() * sign).into();
        let rate = a3 * (sign * (i3 - i1).abs() / (i2 * ratio)).into();
        let middle = squares[0] * (i1 * (i1 - i2)).into() + squares[2] * (i3 * (i3 - i2)).into();
        let complement = middle / (last * (i3 * (i3 - i2)).into());
        let quarter = carlson_f(N::from(0.0), complement, one);
        let start = [w[1] / a2, w[0] / a1, w[2] / a3];
        let [sn, cn, dn] = start;
        let inner = sn * carlson_f(cn * cn, dn * dn, one);
        let kappa = i3 * (i2 - i1) / (i1 * (i3 - i2));
        let complete = quarter
            - carlson_j(N::from(0.0), complement, one, N::from(1.0 + kappa)) * (kappa / 3.0).into();
        let inner_third = third(inner, start, kappa);
        let two = N::from(2.0);
        let (phase, begin) = if cn.value() < 0.0 {
            (quarter * two - inner, complete * two - inner_third)
        } else {
            (inner, inner_third)
        };
        let (frame, momentum) = frame([w[0] * i1.into(), w[1] * i2.into(), w[2] * i3.into()]);
        Self {
            axes,
            moments: [i1, i2, i3],
            amplitudes: [a1, a2, a3],
            rate,
            phase,
            complement,
            quarter,
            kappa,
            complete,
            begin,
            momentum,
            frame,
        }
    }

    /// `R(0)⁻¹R(s)` and `ω(s)`, in the old axes.
    pub fn at(&self, duration_s: f64) -> ([[N; 3]; 3], [N; 3]) {
        let u = self.phase + self.rate * duration_s.into();
        let halves = (u.value() / (2.0 * self.quarter.value())).round();
        let inner = u - self.quarter * (2.0 * halves).into();
        let [sn, cn, dn] = jacobi(inner, self.complement);
        let integral =
            third(inner, [sn, cn, dn], self.kappa) + self.complete * (2.0 * halves).into();
        let parity: N = if halves.rem_euclid(2.0) == 0.0 {
            1.0
        } else {
            -1.0
        }
        .into();
        let [a1, a2, a3] = self.amplitudes;
        let w = [a1 * cn * parity, a2 * sn * parity, a3 * dn];
        let [i1, i2, i3] = self.moments;
        let (there, _) = frame([w[0] * i1.into(), w[1] * i2.into(), w[2] * i3.into()]);
        let precession = self.momentum
            * (1.0 / i3).into()
            * (N::from(duration_s) - (integral - self.begin) * ((i1 - i3) / i1).into() / self.rate);
        let (sin, cos) = precession.sine_and_cosine();
        let [x, y, z] = there;
        let turned: [[N; 3]; 3] = [
            std::array::from_fn(|j| cos * x[j] - sin * y[j]),
            std::array::from_fn(|j| sin * x[j] + cos * y[j]),
            z,
        ];
        let mut rotation = [[N::from(0.0); 3]; 3];
        let sign = [1.0, self.axes.sign, 1.0];
        let mut omega = [N::from(0.0); 3];
        for i in 0..3 {
            omega[self.axes.from[i]] = w[i] * sign[i].into();
            for j in 0..3 {
                let entry =
                    (0..3).fold(N::from(0.0), |sum, k| sum + self.frame[k][i] * turned[k][j]);
                rotation[self.axes.from[i]][self.axes.from[j]] = entry * (sign[i] * sign[j]).into();
            }
        }
        (rotation, omega)
    }
}

/// Rotation, `ω`, left perturbation of the rotation and change of `ω` by `ω(0)`.
pub fn with_derivatives(
    turn: &Elliptic<Dual>,
    duration_s: f64,
) -> (Matrix3<f64>, Vector3<f64>, Matrix3<f64>, Matrix3<f64>) {
    let (rotation, omega) = turn.at(duration_s);
    let value = Matrix3::from_fn(|i, j| rotation[i][j].value);
    let mut by_spin = Matrix3::zeros();
    for column in 0..3 {
        let change = Matrix3::from_fn(|i, j| rotation[i][j].gradient[column]) * value.transpose();
        by_spin[(0, column)] = 0.5 * (change[(2, 1)] - change[(1, 2)]);
        by_spin[(1, column)] = 0.5 * (change[(0, 2)] - change[(2, 0)]);
        by_spin[(2, column)] = 0.5 * (change[(1, 0)] - change[(0, 1)]);
    }
    (
        value,
        Vector3::from_fn(|i, _| omega[i].value),
        by_spin,
        Matrix3::from_fn(|i, j| omega[i].gradient[j]),
    )
}
