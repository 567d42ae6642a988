//! Spatial vectors and inertias (Featherstone, "Rigid Body Dynamics Algorithms", 2008), in axes and
//! about an origin that all bodies of a tree share: nothing is transformed on the way from link to
//! link.

use std::ops::{Add, AddAssign, Mul, Sub};

use nalgebra::{Matrix3, Vector3};

use crate::math::so3;

/// Motion: a velocity, an acceleration, or a joint's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// `ω`.
    pub angular: Vector3<f64>,
    /// Velocity of the point of the body that is at the origin.
    pub linear: Vector3<f64>,
}

/// Force, or a momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// Moment about the origin.
    pub moment: Vector3<f64>,
    /// Force.
    pub force: Vector3<f64>,
}

impl Motion {
    /// None.
    pub const ZERO: Self = Self {
        angular: Vector3::new(0.0, 0.0, 0.0),
        linear: Vector3::new(0.0, 0.0, 0.0),
    };

    /// `a × b`: the change of `b`, fixed in a body that moves with `a`.
    #[inline(always)]
    pub fn cross(&self, other: &Self) -> Self {
        Self {
            angular: self.angular.cross(&other.angular),
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
        }
    }

    /// `a ×* f`: the change of a force fixed in a body that moves with `a`.
    #[inline(always)]
    pub fn cross_force(&self, other: &Force) -> Force {
        Force {
            moment: self.angular.cross(&other.moment) + self.linear.cross(&other.force),
            force: self.angular.cross(&other.force),
        }
    }

    /// Power of a force.
    #[inline(always)]
    pub fn dot(&self, other: &Force) -> f64 {
        self.angular.dot(&other.moment) + self.linear.dot(&other.force)
    }

    /// Velocity of the point at `position`.
    pub fn at(&self, position: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(position)
    }
}

impl Force {
    /// None.
    pub const ZERO: Self = Self {
        moment: Vector3::new(0.0, 0.0, 0.0),
        force: Vector3::new(0.0, 0.0, 0.0),
    };
}

macro_rules! linear {
    ($kind:ident, $first:ident, $second:ident) => {
        impl Add for $kind {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self {
                    $first: self.$first + other.$first,
                    $second: self.$second + other.$second,
                }
            }
        }
        impl Sub for $kind {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self {
                    $first: self.$first - other.$first,
                    $second: self.$second - other.$second,
                }
            }
        }
        impl Mul<f64> for $kind {
            type Output = Self;
            #[inline(always)]
            fn mul(self, scale: f64) -> Self {
                Self {
                    $first: self.$first * scale,
                    $second: self.$second * scale,
                }
            }
        }
        impl AddAssign for $kind {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                self.$first += other.$first;
                self.$second += other.$second;
            }
        }
    };
}
linear!(Motion, angular, linear);
linear!(Force, moment, force);

/// Inertia of a rigid body, or of several that move as one, about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass \[kg\].
    pub mass: f64,
    /// Mass times centre of mass [kg m].
    pub first: Vector3<f64>,
    /// Moments about the origin [kg m²].
    pub second: Matrix3<f64>,
}

impl Inertia {
    /// None.
    pub const ZERO: Self = Self {
        mass: 0.0,
        first: Vector3::new(0.0, 0.0, 0.0),
        second: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// From mass, centre and moments about the centre.
    #[inline(always)]
    pub fn new(mass: f64, centre: &Vector3<f64>, about_centre: &Matrix3<f64>) -> Self {
        let first = centre * mass;
        let mut second = *about_centre;
        let square = first.dot(centre);
        for i in 0..3 {
            second[(i, i)] += square;
            for j in 0..3 {
                second[(i, j)] -= first[i] * centre[j];
            }
        }
        Self {
            mass,
            first,
            second,
        }
    }

    /// Momentum of a motion, `I v`.
    #[inline(always)]
    pub fn of(&self, motion: &Motion) -> Force {
        Force {
            moment: self.second * motion.angular + self.first.cross(&motion.linear),
            force: motion.linear * self.mass - self.first.cross(&motion.angular),
        }
    }

    /// The inertia of the same body with its frame turned and moved from the origin.
    #[inline(always)]
    pub fn placed(&self, rotation: &Matrix3<f64>, position: &Vector3<f64>) -> Self {
        let first = rotation * self.first;
        // `h pᵀ + p hᵀ + m p pᵀ` as one symmetric pair
        let half = first + position * (0.5 * self.mass);
        let mut second = rotation * self.second * rotation.transpose();
        let twice = 2.0 * position.dot(&half);
        for i in 0..3 {
            second[(i, i)] += twice;
            for j in 0..3 {
                second[(i, j)] -= position[i] * half[j] + half[i] * position[j];
            }
        }
        Self {
            mass: self.mass,
            first: first + position * self.mass,
            second,
        }
    }

    /// Centre of mass.
    pub fn centre(&self) -> Vector3<f64> {
        self.first / self.mass
    }
}

impl AddAssign for Inertia {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.first += other.first;
        self.second += other.second;
    }
}

/// How the force `I a + v ×* I v` changes with the velocity:
/// `G = (v×*) I − I (v×) + (I v) ×̄*` (Echeandia and Wensing, "Numerical methods to compute the
/// Coriolis matrix and Christoffel symbols for rigid-body systems", 2021: twice their `B`).
///
/// For a rigid body most of it cancels. With the momentum `(L, P) = I v` and the first moment `h`,
///
/// ```text
/// G (α, β) = (S α + α × L, 2 α × P),
/// S = [ω]×Ī − Ī[ω]× − h v₀ᵀ − v₀ hᵀ + 2 (h·v₀) 1
/// ```
///
/// so that twelve numbers are all of it, and they add over bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gyration {
    /// `S`.
    pub stretch: Matrix3<f64>,
    /// `(L, P)`.
    pub momentum: Force,
}

impl Gyration {
    /// None.
    pub const ZERO: Self = Self {
        stretch: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        momentum: Force::ZERO,
    };

    /// That of a body that moves with `velocity` and has `momentum`.
    #[inline(always)]
    pub fn new(inertia: &Inertia, velocity: &Motion, momentum: &Force) -> Self {
        let turned = so3::hat(&velocity.angular) * inertia.second;
        let dyad = inertia.first * velocity.linear.transpose();
        let mut stretch = turned + turned.transpose() - dyad - dyad.transpose();
        let twice = 2.0 * inertia.first.dot(&velocity.linear);
        for i in 0..3 {
            stretch[(i, i)] += twice;
        }
        Self {
            stretch,
            momentum: *momentum,
        }
    }

    /// `G m`, of which only the angular part of `m` counts.
    #[inline(always)]
    pub fn of(&self, angular: &Vector3<f64>) -> Force {
        Force {
            moment: self.stretch * angular + angular.cross(&self.momentum.moment),
            force: angular.cross(&self.momentum.force) * 2.0,
        }
    }

    /// `Gᵀ s`, whose linear part is zero.
    #[inline(always)]
    pub fn transposed_of(&self, axis: &Motion) -> Vector3<f64> {
        let Force { moment, force } = &self.momentum;
        self.stretch * axis.angular + moment.cross(&axis.angular) + force.cross(&axis.linear) * 2.0
    }
}

impl AddAssign for Gyration {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.stretch += other.stretch;
        self.momentum += other.momentum;
    }
}
