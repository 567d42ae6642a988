//! Numbers and vectors that carry their derivatives by `N` variables (forward mode); with `N = 0` they are
//! plain numbers and vectors.

use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::{Matrix3, RowSVector, SMatrix, Vector3};

use super::so3;

/// A number with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub by: RowSVector<f64, N>,
}

/// A vector with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet3<const N: usize> {
    /// The vector.
    pub value: Vector3<f64>,
    /// Its derivatives, a column for each variable.
    pub by: SMatrix<f64, 3, N>,
}

impl<const N: usize> Jet<N> {
    /// A number that depends on nothing.
    pub fn constant(value: f64) -> Self {
        Self {
            value,
            by: RowSVector::zeros(),
        }
    }

    /// The `at`th variable; a constant where there are not so many.
    pub fn variable(value: f64, at: usize) -> Self {
        Self {
            value,
            by: RowSVector::from_fn(|_, column| f64::from(u8::from(column == at))),
        }
    }

    /// A function of it, of the given value and slope.
    fn through(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            by: self.by * slope,
        }
    }

    /// `√a`.
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.through(root, 0.5 / root)
    }

    /// `1/a`.
    pub fn recip(self) -> Self {
        let inverse = self.value.recip();
        self.through(inverse, -inverse * inverse)
    }
}

impl<const N: usize> Jet3<N> {
    /// A vector that depends on nothing.
    pub fn constant(value: Vector3<f64>) -> Self {
        Self {
            value,
            by: SMatrix::zeros(),
        }
    }

    /// Three variables, from the `at`th on.
    pub fn variable(value: Vector3<f64>, at: usize) -> Self {
        Self {
            value,
            by: SMatrix::from_fn(|row, column| f64::from(u8::from(column == at + row))),
        }
    }

    /// `|a|`; the least where it is no greater, of which no direction is told.
    pub fn norm(self, least: f64) -> Jet<N> {
        match self.value.norm() {
            norm if norm > least => self.dot(self).sqrt(),
            _ => Jet::constant(least),
        }
    }

    /// `a·b`.
    pub fn dot(self, other: Self) -> Jet<N> {
        Jet {
            value: self.value.dot(&other.value),
            by: self.value.transpose() * other.by + other.value.transpose() * self.by,
        }
    }

    /// `a × b`.
    pub fn cross(self, other: Self) -> Self {
        Self {
            value: self.value.cross(&other.value),
            by: so3::hat(&self.value) * other.by - so3::hat(&other.value) * self.by,
        }
    }

    /// `a` times `b`, component by component.
    pub fn times(self, other: Self) -> Self {
        let by_self = Matrix3::from_diagonal(&other.value);
        let by_other = Matrix3::from_diagonal(&self.value);
        Self {
            value: self.value.component_mul(&other.value),
            by: by_self * self.by + by_other * other.by,
        }
    }

    /// One of its components.
    pub fn component(self, axis: usize) -> Jet<N> {
        Jet {
            value: self.value[axis],
            by: self.by.row(axis).into_owned(),
        }
    }

    /// `M a` with a given matrix.
    pub fn through(self, matrix: &Matrix3<f64>) -> Self {
        Self {
            value: matrix * self.value,
            by: matrix * self.by,
        }
    }
}

macro_rules! linear {
    ($of:ident) => {
        impl<const N: usize> Add for $of<N> {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self {
                    value: self.value + other.value,
                    by: self.by + other.by,
                }
            }
        }

        impl<const N: usize> Sub for $of<N> {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self {
                    value: self.value - other.value,
                    by: self.by - other.by,
                }
            }
        }

        impl<const N: usize> Neg for $of<N> {
            type Output = Self;
            fn neg(self) -> Self {
                self * -1.0
            }
        }

        impl<const N: usize> Mul<f64> for $of<N> {
            type Output = Self;
            fn mul(self, factor: f64) -> Self {
                Self {
                    value: self.value * factor,
                    by: self.by * factor,
                }
            }
        }

        impl<const N: usize> Mul<Jet<N>> for $of<N> {
            type Output = Self;
            fn mul(self, factor: Jet<N>) -> Self {
                Self {
                    value: self.value * factor.value,
                    by: self.by * factor.value + self.value * factor.by,
                }
            }
        }
    };
}

linear!(Jet);
linear!(Jet3);
