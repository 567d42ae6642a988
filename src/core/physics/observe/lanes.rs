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
use crate::math::lanes::{LANES, Vectors};
use crate::math::so3;
use crate::physics::Body;
use crate::physics::flow::{Precession, Spin};

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

/// The free rotation of a body from one start, at four durations at a time.
pub struct Turner {
    kind: LaneKind,
    /// Body from the axes by which a change of the angular velocity is told.
    pub axes: Matrix3<f64>,
}

enum LaneKind {
    Closed(LaneFrame),
    /// One after the other, where three moments differ.
    Steps {
        spin: Spin,
        orientation: UnitQuaternion<f64>,
        from_epoch: Matrix3<f64>,
    },
}

/// Orientations at four durations.
pub struct Turned {
    /// World from body as `(i, j, k, w)`.
    pub orientation: [f64x4; 4],
    /// By how much a change of the initial angular velocity turns them, over the duration: `R(0) K`
    /// in world axes, a column for each of [`Turner::axes`].
    pub by_spin: [Vectors; 3],
}

impl Turner {
    /// The rotation from an orientation and an angular velocity `ω` [rad/s, body].
    pub fn new(
        body: &Body,
        orientation: &UnitQuaternion<f64>,
        angular_velocity_rad_s: &Vector3<f64>,
    ) -> Self {
        let spin = Spin::new(body, angular_velocity_rad_s);
        if let Some(precession) = spin.precession() {
            let frame = LaneFrame::new(precession, orientation);
            return Self {
                axes: frame.body,
                kind: LaneKind::Closed(frame),
            };
        }
        Self {
            axes: Matrix3::identity(),
            kind: LaneKind::Steps {
                spin,
                orientation: *orientation,
                from_epoch: so3::matrix(orientation),
            },
        }
    }

    /// Orientations and their derivatives at four durations \[s\].
    #[inline]
    pub fn at(&mut self, s: f64x4) -> Turned {
        match &mut self.kind {
            LaneKind::Closed(frame) => {
                let h = s * frame.half_rates[0];
                let (sin, cos) = h.sin_cos();
                Turned {
                    orientation: frame.orientation(s, sin, cos),
                    by_spin: frame.by_spin(h, sin, cos),
                }
            }
            LaneKind::Steps {
                spin,
                orientation,
                from_epoch,
            } => {
                let all = s.to_array().map(|s| {
                    let (turn, k) = spin.turn_and_derivative(s);
                    (*orientation * turn, *from_epoch * k)
                });
                Turned {
                    orientation: [0, 1, 2, 3].map(|part| f64x4::from(all.map(|of| of.0[part]))),
                    by_spin: [0, 1, 2].map(|column| {
                        Vectors([0, 1, 2].map(|row| f64x4::from(all.map(|of| of.1[(row, column)]))))
                    }),
                }
            }
        }
    }
}

/// Residuals `Log(R R_i⁻¹)` of four orientations in world axes \[rad\], and the columns of `J_l⁻¹` of
/// them: of a residual's change by a turn of `R` in world axes.
#[inline]
pub fn turn_errors(orientation: [f64x4; 4], measured: [f64x4; 4]) -> (Vectors, [Vectors; 3]) {
    let [x, y, z, scalar] = between(orientation, measured);
    let scale = logarithm_scale(scalar, [x, y, z]);
    let error = Vectors([x, y, z]).times(scale);
    // With the half angle's cosine |w| and sine |v|, of which `e = v·scale`: `1/θ² − cot(θ/2)/2θ`.
    let square = error.dot(&error);
    let series = square * (1.0 / 720.0) + square * square * (1.0 / 30240.0) + 1.0 / 12.0;
    let closed = (f64x4::ONE - scalar * scale * 0.5) / square;
    let b = square
        .simd_lt(f64x4::splat(so3::SERIES_BELOW))
        .select(series, closed);
    let [e0, e1, e2] = error.0;
    let diagonal = f64x4::ONE - b * square;
    let half = error.times(f64x4::splat(0.5)).0;
    let [be0, be1, be2] = error.times(b).0;
    let columns = [
        Vectors([diagonal + be0 * e0, be0 * e1 - half[2], be0 * e2 + half[1]]),
        Vectors([be0 * e1 + half[2], diagonal + be1 * e1, be1 * e2 - half[0]]),
        Vectors([be0 * e2 - half[1], be1 * e2 + half[0], diagonal + be2 * e2]),
    ];
    (error, columns)
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

/// Sums over samples, lane by lane; `e` is the residual along the frame's axes.
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
        let error = frame.error(s, sin, cos, measured.map(f64x4::from), present);
        let [x, y, z] = error;
        self.cost += (x * x + y * y + z * z) * 0.5;
        for (sum, part) in self.error.iter_mut().zip(error) {
            *sum += part;
        }
        self.times[0] += s;
        self.times[1] += s * s;

        let cardinal = cardinal_sine(h, sin);
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

    /// `R(0) R(s)` as `(i, j, k, w)`.
    #[inline]
    fn orientation(&self, s: f64x4, sin: f64x4, cos: f64x4) -> [f64x4; 4] {
        let [r, rn, ra, rna] = &self.turned;
        if self.excess == 0.0 {
            let at = |part: usize| cos * r[part] + sin * rn[part];
            return [at(0), at(1), at(2), at(3)];
        }
        let (sin_b, cos_b) = (s * self.half_rates[1]).sin_cos();
        let weights = [cos * cos_b, sin * cos_b, cos * sin_b, sin * sin_b];
        let at = |part: usize| {
            weights[0] * r[part]
                + weights[1] * rn[part]
                + weights[2] * ra[part]
                + weights[3] * rna[part]
        };
        [at(0), at(1), at(2), at(3)]
    }

    /// `R(0) K` in world axes, by the axes of this frame.
    #[inline]
    fn by_spin(&self, h: f64x4, sin: f64x4, cos: f64x4) -> [Vectors; 3] {
        let cardinal = cardinal_sine(h, sin);
        let (re, im) = (cardinal * cos, cardinal * sin);
        let axes = [0, 1, 2].map(|axis| Vectors::splat(&self.world.column(axis).into()));
        let [u, v, n] = &axes;
        let mut columns = [
            u.times(re).plus(&v.times(im)),
            v.times(re).minus(&u.times(im)),
            *n,
        ];
        if self.excess != 0.0 {
            let beyond = (cos * cos - sin * sin - re, sin * cos * 2.0 - im);
            let (x, y) = (self.excess * self.axis.x, self.excess * self.axis.y);
            let of_axis = u
                .times(beyond.0 * x - beyond.1 * y)
                .plus(&v.times(beyond.0 * y + beyond.1 * x));
            for (column, along) in columns.iter_mut().zip(self.axis.iter()) {
                column.add(&of_axis, f64x4::splat(*along));
            }
        }
        columns
    }

    /// The residual `Log(R(0) R(s) R_i⁻¹)` in world axes, expressed in this frame.
    #[inline]
    fn error(
        &self,
        s: f64x4,
        sin: f64x4,
        cos: f64x4,
        measured: [f64x4; 4],
        present: usize,
    ) -> [f64x4; 3] {
        let error = logarithm(between(self.orientation(s, sin, cos), measured));
        let is_there = f64x4::from([0, 1, 2, 3].map(|lane| f64::from(u8::from(lane < present))));
        let [p, q, t] = error.times(is_there).0;
        let world = &self.world;
        let at = |axis: usize| p * world[(0, axis)] + q * world[(1, axis)] + t * world[(2, axis)];
        [at(0), at(1), at(2)]
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

/// `sin h/h`, one at zero.
#[inline]
fn cardinal_sine(h: f64x4, sin: f64x4) -> f64x4 {
    h.simd_eq(f64x4::ZERO).select(f64x4::ONE, sin / h)
}

/// `R Q⁻¹`.
#[inline]
fn between([x, y, z, u]: [f64x4; 4], [i, j, k, w]: [f64x4; 4]) -> [f64x4; 4] {
    [
        w * x - u * i - (y * k - z * j),
        w * y - u * j - (z * i - x * k),
        w * z - u * k - (x * j - y * i),
        u * w + x * i + y * j + z * k,
    ]
}

/// `Log`, see [`so3::log`].
#[inline]
fn logarithm([x, y, z, scalar]: [f64x4; 4]) -> Vectors {
    Vectors([x, y, z]).times(logarithm_scale(scalar, [x, y, z]))
}

/// What `Log` multiplies the vector part of a unit quaternion by; see [`so3::log`].
#[inline]
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
