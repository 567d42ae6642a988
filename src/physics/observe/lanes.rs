//! Measured orientations of a body with two or three equal moments, four at a time.
//!
//! With `n` the unit vector of `α`, a vector is written as a complex number across `n` and a real
//! one along it. `Exp(αs)` multiplies the complex part by `e^{2ih}`, `h = ½|α|s`, its left Jacobian
//! by
//!
//! ```text
//! j = (e^{2ih} − 1)/(2ih) = e^{ih} sin h/h
//! ```
//!
//! and neither changes the real part. With `ε = 1 − I_a/I_t` the derivative of [`super::TurnTerms`]
//! is `K = J + ε (Exp(αs) − J) a aᵀ`, so that the sums of `s K` and `s² KᵀK` over samples follow
//! from sums of such numbers: the matrices are formed once for all samples. `j̄ e^{2ih} = j` is
//! used.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use wide::f64x4;

use super::TurnTerms;
use crate::math::so3;
use crate::physics::flow::Precession;

/// Number of samples that are processed at once.
const LANES: usize = 4;

/// Terms of measured orientations, each with its time from the epoch \[s\], at which the body has
/// the orientation and the `precession` begins.
pub(super) fn terms<'m>(
    precession: &Precession,
    orientation: &UnitQuaternion<f64>,
    readings: impl Iterator<Item = (f64, &'m UnitQuaternion<f64>)>,
) -> TurnTerms {
    let frame = LaneFrame::new(precession, orientation);
    let mut sums = LaneSums::default();
    // Every lane holds a rotation: the logarithm of an empty one would be NaN.
    let (mut seconds, mut measured) =
        ([0.0; LANES], [0.0, 0.0, 0.0, 1.0].map(|part| [part; LANES]));
    let mut count = 0;
    for (s, reading) in readings {
        let lane = count % LANES;
        seconds[lane] = s;
        for (part, value) in measured.iter_mut().zip(reading.coords.iter()) {
            part[lane] = *value;
        }
        count += 1;
        if lane + 1 == LANES {
            sums.add(&frame, seconds, measured, LANES);
        }
    }
    let left = count % LANES;
    if left > 0 {
        // The other lanes keep old values; they are weighted by zero.
        seconds[left..].fill(0.0);
        sums.add(&frame, seconds, measured, left);
    }
    frame.gather(&sums, count as f64)
}

/// The part of a vector across `n`.
#[derive(Clone, Copy, Default)]
struct Complex<T> {
    re: T,
    im: T,
}

/// A frame with one axis along `n`, and what all samples share.
struct LaneFrame {
    /// `½|α|` and `½β` [rad/s].
    half_rates: [f64; 2],
    /// `R(0)`, `R(0) n`, `R(0) a`, `R(0) n a` as quaternions: `R(0) R(s)` is a linear combination
    /// of them.
    turned: [Quaternion<f64>; 4],
    /// Body from this frame: the columns are two axes across `n`, and `n`.
    body: Matrix3<f64>,
    /// World from this frame at the epoch: the same axes.
    world: Matrix3<f64>,
    /// `a` in this frame, and `1 − I_a/I_t`.
    axis: Vector3<f64>,
    excess: f64,
}

/// LaneSums over samples, lane by lane; `e` is the residual along the frame's axes.
#[derive(Default)]
struct LaneSums {
    /// `½ Σ |e|²`
    cost: f64x4,
    /// `Σ e`
    error: [f64x4; 3],
    /// `Σ s`, `Σ s²`
    times: [f64x4; 2],
    /// `Σ s j`, `Σ s² j`
    jacobian: [Complex<f64x4>; 2],
    /// `Σ s² |j|²`
    jacobian_square: f64x4,
    /// `Σ s e^{2ih}`
    turn: Complex<f64x4>,
    /// `Σ s j̄ e`, `Σ s e^{−2ih} e`, `Σ s e` along `n`
    pull: Complex<f64x4>,
    turned_pull: Complex<f64x4>,
    axial_pull: f64x4,
}

impl LaneSums {
    fn add(
        &mut self,
        frame: &LaneFrame,
        seconds: [f64; LANES],
        measured: [[f64; LANES]; 4],
        present: usize,
    ) {
        let s = f64x4::from(seconds);
        let h = s * frame.half_rates[0];
        let (sin, cos) = h.sin_cos();
        let error = frame.error(s, (sin, cos), measured.map(f64x4::from), present);
        let [x, y, z] = error;
        self.cost += (x * x + y * y + z * z) * 0.5;
        for (sum, part) in self.error.iter_mut().zip(error) {
            *sum += part;
        }
        self.times[0] += s;
        self.times[1] += s * s;

        // sin h/h is one at zero.
        let still = h.simd_eq(f64x4::ZERO);
        let cardinal = still.select(f64x4::ONE, sin / h);
        let weight = s * cardinal;
        let j = Complex {
            re: weight * cos,
            im: weight * sin,
        };
        let turn = Complex {
            re: s * (cos * cos - sin * sin),
            im: s * (sin * cos * 2.0),
        };
        let add = |sum: &mut Complex<f64x4>, re, im| {
            sum.re += re;
            sum.im += im;
        };
        add(&mut self.jacobian[0], j.re, j.im);
        add(&mut self.jacobian[1], s * j.re, s * j.im);
        self.jacobian_square += weight * weight;
        add(&mut self.turn, turn.re, turn.im);
        add(&mut self.pull, j.re * x + j.im * y, j.re * y - j.im * x);
        add(
            &mut self.turned_pull,
            turn.re * x + turn.im * y,
            turn.re * y - turn.im * x,
        );
        self.axial_pull += s * z;
    }
}

impl LaneFrame {
    fn new(precession: &Precession, orientation: &UnitQuaternion<f64>) -> Self {
        let rate = precession.alpha.norm();
        let n = if rate > 0.0 {
            precession.alpha / rate
        } else {
            Vector3::z()
        };
        let across = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
        let body = Matrix3::from_columns(&[across, n.cross(&across), n]);
        let turning = &precession.turning;
        let (r, pure) = (orientation.into_inner(), Quaternion::from_imag);
        Self {
            half_rates: [0.5 * rate, 0.5 * precession.beta],
            turned: [
                r,
                r * pure(n),
                r * pure(turning.axis),
                r * pure(n) * pure(turning.axis),
            ],
            body,
            world: so3::matrix(orientation) * body,
            axis: body.tr_mul(&turning.axis),
            excess: turning.excess,
        }
    }

    /// The residual `Log(R(0) R(s) R_i⁻¹)` in world axes, expressed in this frame.
    fn error(
        &self,
        s: f64x4,
        (sin, cos): (f64x4, f64x4),
        [i, j, k, w]: [f64x4; 4],
        present: usize,
    ) -> [f64x4; 3] {
        let [r, rn, ra, rna] = &self.turned;
        let (x, y, z, u);
        if self.excess == 0.0 {
            let at = |part: usize| cos * r[part] + sin * rn[part];
            (x, y, z, u) = (at(0), at(1), at(2), at(3));
        } else {
            let (sin_b, cos_b) = (s * self.half_rates[1]).sin_cos();
            let weights = [cos * cos_b, sin * cos_b, cos * sin_b, sin * sin_b];
            let at = |part: usize| {
                weights[0] * r[part]
                    + weights[1] * rn[part]
                    + weights[2] * ra[part]
                    + weights[3] * rna[part]
            };
            (x, y, z, u) = (at(0), at(1), at(2), at(3));
        }
        // Times the inverse of what was measured.
        let scalar = u * w + x * i + y * j + z * k;
        let vector = [
            w * x - u * i - (y * k - z * j),
            w * y - u * j - (z * i - x * k),
            w * z - u * k - (x * j - y * i),
        ];
        let scale = logarithm_scale(scalar, vector);
        let is_there = f64x4::from([0, 1, 2, 3].map(|lane| f64::from(u8::from(lane < present))));
        let [p, q, t] = vector.map(|part| part * scale * is_there);
        [0, 1, 2].map(|axis| {
            let along = self.world.column(axis);
            p * along[0] + q * along[1] + t * along[2]
        })
    }

    /// The terms that follow from the sums.
    fn gather(&self, sums: &LaneSums, count: f64) -> TurnTerms {
        let one = |lanes: f64x4| lanes.reduce_add();
        let complex = |z: Complex<f64x4>| Vector3::new(one(z.re), one(z.im), 0.0);
        let (s1, s2) = (one(sums.times[0]), one(sums.times[1]));
        let [j1, j2] = sums.jacobian.map(complex);
        let turn = complex(sums.turn);
        let square = one(sums.jacobian_square);
        let (axis, excess) = (&self.axis, self.excess);
        let across = Vector3::new(axis.x, axis.y, 0.0);
        // Complex products with a: by z as a matrix.
        let by = |z: &Vector3<f64>| Matrix3::new(z.x, -z.y, 0.0, z.y, z.x, 0.0, 0.0, 0.0, 0.0);

        let mut cross = by(&j1);
        cross[(2, 2)] = s1;
        cross += by(&(turn - j1)) * across * axis.transpose() * excess;

        let mixed = (by(&(j2 - Vector3::x() * square)) * across) * axis.transpose() * excess;
        let beyond = excess * excess * across.norm_squared() * (s2 + square - 2.0 * j2.x);
        let squared = Matrix3::from_diagonal(&Vector3::new(square, square, s2))
            + mixed
            + mixed.transpose()
            + axis * axis.transpose() * beyond;

        let (pull, turned_pull) = (complex(sums.pull), complex(sums.turned_pull));
        let spin = pull
            + Vector3::z() * one(sums.axial_pull)
            + axis * (excess * across.dot(&(turned_pull - pull)));
        let frame = &self.body;
        TurnTerms {
            cost: one(sums.cost),
            gradient_orientation: frame * Vector3::from(sums.error.map(one)),
            gradient_spin: frame * spin,
            count,
            cross: frame * cross * frame.transpose(),
            square: frame * squared * frame.transpose(),
        }
    }
}

/// What `Log` multiplies the vector part of a unit quaternion by; see [`so3::log`].
fn logarithm_scale(scalar: f64x4, vector: [f64x4; 3]) -> f64x4 {
    let [x, y, z] = vector;
    let square = x * x + y * y + z * z;
    // q and −q are one rotation; take the one of smaller angle.
    let w = scalar.abs();
    let sign = scalar.simd_lt(f64x4::ZERO).select(-f64x4::ONE, f64x4::ONE);
    let ratio = square / (w * w);
    let series = (f64x4::ONE - ratio * (1.0 / 3.0) + ratio * ratio * 0.2
        - ratio * ratio * ratio * (1.0 / 7.0))
        * 2.0
        / w;
    let sine = square.sqrt();
    let angle = sine.atan2(w) * 2.0 / sine;
    let is_small = square.simd_lt(f64x4::from(0.25 * so3::SERIES_BELOW));
    is_small.select(series, angle) * sign
}
