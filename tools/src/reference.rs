//! Free rotations to thirty digits for tests, sharing no formula with the flow: Euler's equations
//! and the quaternion's kinematics by extrapolation of the modified midpoint rule (Gragg, Bulirsch
//! and Stoer) in double-double arithmetic.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A double-double number: the unevaluated sum of two numbers, the second below the rounding of the
/// first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair(pub f64, pub f64);

/// Sum and its rounding error (Knuth).
fn sum(a: f64, b: f64) -> Pair {
    let s = a + b;
    let t = s - a;
    Pair(s, (a - (s - t)) + (b - t))
}

/// Product and its rounding error (Dekker).
fn product(a: f64, b: f64) -> Pair {
    let split = |x: f64| {
        let t = 134_217_729.0 * x;
        let high = t - (t - x);
        (high, x - high)
    };
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    let p = a * b;
    Pair(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl From<f64> for Pair {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Add for Pair {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let first = sum(high.0, high.1 + low.0);
        sum(first.0, first.1 + low.1)
    }
}

impl Neg for Pair {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Pair {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Pair {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = product(self.0, other.0);
        sum(p.0, p.1 + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Pair {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * first.into();
        let second = rest.0 / other.0;
        let last = (rest - other * second.into()).0 / other.0;
        sum(first, second) + last.into()
    }
}

/// Quaternion `w, x, y, z` of the rotation since the start, then `ω` [rad/s, body].
pub type Motion = [Pair; 7];

/// The start of the motion with the initial angular velocity `omega` [rad/s, body].
pub fn epoch(omega: [Pair; 3]) -> Motion {
    let zero = Pair(0.0, 0.0);
    let [x, y, z] = omega;
    [1.0.into(), zero, zero, zero, x, y, z]
}

fn slope(couplings: &[Pair; 3], motion: &Motion) -> Motion {
    let [w, x, y, z, a, b, c] = *motion;
    let half = Pair(0.5, 0.0);
    [
        -half * (x * a + y * b + z * c),
        half * (w * a + y * c - z * b),
        half * (w * b + z * a - x * c),
        half * (w * c + x * b - y * a),
        couplings[0] * b * c,
        couplings[1] * c * a,
        couplings[2] * a * b,
    ]
}

/// Columns of the extrapolation: order 28.
const COLUMNS: usize = 14;

/// One step.
fn step(couplings: &[Pair; 3], start: &Motion, h: Pair) -> Motion {
    let advance = |from: &Motion, along: &Motion, h: Pair| -> Motion {
        std::array::from_fn(|i| from[i] + h * along[i])
    };
    let mut previous: Vec<Motion> = Vec::new();
    for row in 0..COLUMNS {
        let count = |row: usize| (2 * (row + 1)) as f64;
        let small = h / count(row).into();
        let (mut last, mut now) = (*start, advance(start, &slope(couplings, start), small));
        for _ in 1..2 * (row + 1) {
            let next = advance(&last, &slope(couplings, &now), small + small);
            (last, now) = (now, next);
        }
        let beyond = advance(&now, &slope(couplings, &now), small);
        let smoothed = std::array::from_fn(|i| Pair(0.5, 0.0) * (last[i] + beyond[i]));
        // Aitken–Neville extrapolation in the square of the substep.
        let mut entries: Vec<Motion> = vec![smoothed];
        for (column, before) in previous.iter().enumerate() {
            let ratio = Pair::from(count(row)) / count(row - column - 1).into();
            let weight = ratio * ratio - 1.0.into();
            let entry = entries[column];
            entries.push(std::array::from_fn(|i| {
                entry[i] + (entry[i] - before[i]) / weight
            }));
        }
        previous = entries;
    }
    previous[COLUMNS - 1]
}

/// The motion of a body with these moments after `duration_s`.
pub fn turn(moments_kg_m2: [f64; 3], start: &Motion, duration_s: f64) -> Motion {
    let moment = moments_kg_m2.map(Pair::from);
    let couplings = [0, 1, 2].map(|i| (moment[(i + 1) % 3] - moment[(i + 2) % 3]) / moment[i]);
    let (mut motion, mut left) = (*start, Pair::from(duration_s));
    while left.0 != 0.0 {
        let speed = motion[4..].iter().map(|w| w.0 * w.0).sum::<f64>().sqrt();
        let h = 0.5 / speed;
        let h = if h < left.0.abs() {
            Pair::from(h.copysign(left.0))
        } else {
            left
        };
        motion = step(&couplings, &motion, h);
        left = left - h;
    }
    motion
}
