//! Numbers that carry their derivatives by three variables.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the closed form computes with.
pub trait Number:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The value alone.
    fn value(self) -> f64;
    /// Square root.
    fn root(self) -> Self;
    /// Sine and cosine.
    fn sine_and_cosine(self) -> (Self, Self);
}

impl Number for f64 {
    fn value(self) -> f64 {
        self
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn sine_and_cosine(self) -> (Self, Self) {
        self.sin_cos()
    }
}

/// A value and its gradient.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    /// Value.
    pub value: f64,
    /// Derivatives.
    pub gradient: [f64; 3],
}

impl Dual {
    /// The variable of this number.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut gradient = [0.0; 3];
        gradient[index] = 1.0;
        Self { value, gradient }
    }

    /// `value`, whose derivative by `self` is `slope`.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            gradient: self.gradient.map(|g| g * slope),
        }
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; 3],
        }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: std::array::from_fn(|i| self.gradient[i] + other.gradient[i]),
        }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

#[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let gradient = |i: usize| self.gradient[i] * other.value + self.value * other.gradient[i];
        Self {
            value: self.value * other.value,
            gradient: std::array::from_fn(gradient),
        }
    }
}

#[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let gradient = |i: usize| (self.gradient[i] - value * other.gradient[i]) / other.value;
        Self {
            value,
            gradient: std::array::from_fn(gradient),
        }
    }
}

impl Number for Dual {
    fn value(self) -> f64 {
        self.value
    }
    fn root(self) -> Self {
        let root = self.value.sqrt();
        // Of the roots that become zero only squares are used.
        let slope = if root > 0.0 { 0.5 / root } else { 0.0 };
        self.chain(root, slope)
    }
    fn sine_and_cosine(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
}
