//! Vectors and symmetric matrices of four samples at a time.

use nalgebra::{Matrix3, Vector3};
use wide::f64x4;

/// Number of samples at a time.
pub const LANES: usize = 4;

/// As many numbers, at most four, with zeros where they are fewer.
#[inline]
pub fn loaded(numbers: &[f64]) -> f64x4 {
    // By length, since copies of unknown length are calls.
    f64x4::from(match *numbers {
        [a, b, c, d] => [a, b, c, d],
        [a, b, c] => [a, b, c, 0.0],
        [a, b] => [a, b, 0.0, 0.0],
        [a] => [a, 0.0, 0.0, 0.0],
        _ => [0.0; LANES],
    })
}

/// Puts the first of them into as many places, at most four.
#[inline]
pub fn store(lanes: f64x4, numbers: &mut [f64]) {
    let [a, b, c, d] = lanes.to_array();
    match numbers {
        [x, y, z, w] => (*x, *y, *z, *w) = (a, b, c, d),
        [x, y, z] => (*x, *y, *z) = (a, b, c),
        [x, y] => (*x, *y) = (a, b),
        [x] => *x = a,
        _ => (),
    }
}

/// Four vectors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vectors(pub [f64x4; 3]);

impl Vectors {
    /// The same vector four times.
    #[inline]
    pub fn splat(vector: &Vector3<f64>) -> Self {
        Self([0, 1, 2].map(|axis| f64x4::splat(vector[axis])))
    }

    /// Four vectors.
    #[inline]
    pub fn of(vectors: [&Vector3<f64>; LANES]) -> Self {
        Self([0, 1, 2].map(|axis| f64x4::from(vectors.map(|vector| vector[axis]))))
    }

    /// `a·b`.
    #[inline]
    pub fn dot(&self, other: &Self) -> f64x4 {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    /// `a × b`.
    #[inline]
    pub fn cross(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    /// `a + b`.
    #[inline]
    pub fn plus(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }

    /// `a − b`.
    #[inline]
    pub fn minus(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }

    /// `a s`.
    #[inline]
    pub fn times(&self, scale: f64x4) -> Self {
        let [x, y, z] = self.0;
        Self([x * scale, y * scale, z * scale])
    }

    /// `Σ c a` over three vectors `a` with one coefficient each: a matrix of those columns times `c`.
    #[inline]
    pub fn combined(columns: &[Self; 3], coefficients: &Self) -> Self {
        let [a, b, c] = coefficients.0;
        let of =
            |axis: usize| columns[0].0[axis] * a + columns[1].0[axis] * b + columns[2].0[axis] * c;
        Self([of(0), of(1), of(2)])
    }

    /// The products with each of three vectors: the transpose of a matrix of those columns times this.
    #[inline]
    pub fn along(&self, columns: &[Self; 3]) -> Self {
        let [a, b, c] = columns;
        Self([a.dot(self), b.dot(self), c.dot(self)])
    }

    /// Each turned by one matrix.
    #[inline]
    pub fn turned(&self, by: &Matrix3<f64>) -> Self {
        let [x, y, z] = self.0;
        let along = |row: usize| x * by[(row, 0)] + y * by[(row, 1)] + z * by[(row, 2)];
        Self([along(0), along(1), along(2)])
    }

    /// A vector turned by the unit quaternions `(i, j, k, w)`.
    #[inline]
    pub fn rotated(&self, [i, j, k, w]: [f64x4; 4]) -> Self {
        let imaginary = Self([i, j, k]);
        let twice = imaginary.cross(self).times(f64x4::splat(2.0));
        self.plus(&twice.times(w)).plus(&imaginary.cross(&twice))
    }

    /// Adds others with weights.
    #[inline]
    pub fn add(&mut self, other: &Self, weight: f64x4) {
        for (sum, part) in self.0.iter_mut().zip(other.0) {
            *sum += part * weight;
        }
    }

    /// One of the four.
    #[inline]
    pub fn lane(parts: &[[f64; LANES]; 3], lane: usize) -> Vector3<f64> {
        Vector3::new(parts[0][lane], parts[1][lane], parts[2][lane])
    }

    /// All numbers, axis by axis.
    #[inline]
    pub fn to_arrays(self) -> [[f64; LANES]; 3] {
        self.0.map(f64x4::to_array)
    }

    /// The sum of the four.
    pub fn sum(self) -> Vector3<f64> {
        Vector3::from(self.0.map(f64x4::reduce_add))
    }
}

/// The sum of the four matrices of columns.
pub fn sum_of_columns(columns: [Vectors; 3]) -> Matrix3<f64> {
    Matrix3::from_columns(&columns.map(Vectors::sum))
}

/// The place of entry `(row, column)` of a symmetric matrix, `column ≤ row`, among its six.
pub const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// The matrix of six entries in the order of [`SYMMETRIC`].
pub fn symmetric(entries: [f64; 6]) -> Matrix3<f64> {
    let mut matrix = Matrix3::zeros();
    for ((row, column), value) in SYMMETRIC.into_iter().zip(entries) {
        matrix[(row, column)] = value;
        matrix[(column, row)] = value;
    }
    matrix
}
