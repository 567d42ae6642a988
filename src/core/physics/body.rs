//! A rigid body: its mass and principal moments at the centre of mass, and what acts on it in
//! flight, or on what supports it, beside gravity.

use nalgebra::{Matrix3, Vector3};
use thiserror::Error;

use super::drag::Drag;
use super::support::Support;
use crate::math::so3;

/// Moments closer than this, relative to the largest, are one moment: further apart than
/// rounding leaves them, and so close that a turn of a hundred radians with the mean of two
/// differs by less than 2e-13 rad.
const EQUAL_MOMENTS: f64 = 8.0 * f64::EPSILON;
/// By how much the largest moment may exceed the sum of the others, relative: a flat body's
/// moments are typed with few digits.
const TRIANGLE_SLACK: f64 = 1e-9;

/// Mass and principal moments of inertia at the centre of mass; constant force, drag and lift in flight and a support,
/// all none unless given ([`Body::with_force`], [`Body::with_drag`], [`Body::with_lift`], [`Body::with_support`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    mass_kg: f64,
    moments_kg_m2: Vector3<f64>,
    symmetry: Symmetry,
    force_m_s2: Vector3<f64>,
    drag: Drag,
    lift: f64,
    support: Option<Support>,
}

/// How many of the moments are equal: which flow is exact for the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Three equal: die, box.
    Spherical,
    /// Two equal: pencil, hat. The axis of the third is 0, 1 or 2.
    Axial {
        /// Body axis of symmetry.
        axis: usize,
    },
    /// All different: an asymmetric top, such as a brick or a phone.
    Asymmetric,
}

/// Why a body is refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BodyError {
    /// Mass is not positive.
    #[error("mass is {mass_kg} kg, expected a positive number")]
    Mass {
        /// As given.
        mass_kg: f64,
    },
    /// A moment is not positive.
    #[error("moment {axis} is {moment_kg_m2} kg m², expected a positive number")]
    Moment {
        /// Body axis: 0, 1 or 2.
        axis: usize,
        /// As given.
        moment_kg_m2: f64,
    },
    /// No distribution of mass has such moments.
    #[error("moments {0} + {1} < {2} kg m²: the sum of any two is at least the third")]
    Triangle(f64, f64, f64),
    /// A component of the force per mass is not finite.
    #[error("force per mass along axis {axis} is {force_m_s2} m/s², expected a finite number")]
    Force {
        /// World axis: 0, 1 or 2.
        axis: usize,
        /// As given.
        force_m_s2: f64,
    },
    /// The linear drag is negative or not finite.
    #[error("linear drag is {linear_per_s} 1/s, expected zero or more")]
    LinearDrag {
        /// As given.
        linear_per_s: f64,
    },
    /// The quadratic drag is negative or not finite.
    #[error("quadratic drag is {quadratic_per_m} 1/m, expected zero or more")]
    QuadraticDrag {
        /// As given.
        quadratic_per_m: f64,
    },
    /// The lift is not finite.
    #[error("lift is {lift}, expected a finite number")]
    Lift {
        /// As given.
        lift: f64,
    },
    /// The lift of a body of which moments differ.
    #[error("a lift of a body of which moments differ, expected one whose three moments are equal")]
    LiftOfOther,
}

impl Body {
    /// What no impact deflects: a body in the hand. Its mass and moments are infinite.
    pub const IMMOVABLE: Self = Self {
        mass_kg: f64::INFINITY,
        moments_kg_m2: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        symmetry: Symmetry::Spherical,
        force_m_s2: Vector3::new(0.0, 0.0, 0.0),
        drag: Drag {
            linear_per_s: 0.0,
            quadratic_per_m: 0.0,
        },
        lift: 0.0,
        support: None,
    };

    /// A body from its mass \[kg\] and principal moments [kg m²] about body axes 0, 1, 2.
    ///
    /// Fails where no distribution of mass has these moments.
    pub fn new(mass_kg: f64, moments_kg_m2: Vector3<f64>) -> Result<Self, BodyError> {
        if !(mass_kg > 0.0 && mass_kg.is_finite()) {
            return Err(BodyError::Mass { mass_kg });
        }
        for axis in 0..3 {
            let moment_kg_m2 = moments_kg_m2[axis];
            if !(moment_kg_m2 > 0.0 && moment_kg_m2.is_finite()) {
                return Err(BodyError::Moment { axis, moment_kg_m2 });
            }
        }
        let largest = moments_kg_m2.max();
        for axis in 0..3 {
            let (a, b, c) = (
                moments_kg_m2[(axis + 1) % 3],
                moments_kg_m2[(axis + 2) % 3],
                moments_kg_m2[axis],
            );
            if a + b < c * (1.0 - TRIANGLE_SLACK) {
                return Err(BodyError::Triangle(a, b, c));
            }
        }
        let equal = |i: usize, j: usize| {
            (moments_kg_m2[i] - moments_kg_m2[j]).abs() <= EQUAL_MOMENTS * largest
        };
        let mut moments_kg_m2 = moments_kg_m2;
        let symmetry = if equal(0, 1) && equal(1, 2) && equal(0, 2) {
            moments_kg_m2.fill(moments_kg_m2.mean());
            Symmetry::Spherical
        } else if let Some(axis) = (0..3).find(|axis| equal((axis + 1) % 3, (axis + 2) % 3)) {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let mean = 0.5 * (moments_kg_m2[i] + moments_kg_m2[j]);
            moments_kg_m2[i] = mean;
            moments_kg_m2[j] = mean;
            Symmetry::Axial { axis }
        } else {
            Symmetry::Asymmetric
        };
        Ok(Self {
            mass_kg,
            moments_kg_m2,
            symmetry,
            force_m_s2: Vector3::zeros(),
            drag: Drag::default(),
            lift: 0.0,
            support: None,
        })
    }

    /// The body with a constant force per mass `f` [m/s², world] that acts on its centre of mass
    /// beside gravity.
    pub fn with_force(self, force_m_s2: Vector3<f64>) -> Result<Self, BodyError> {
        match (0..3).find(|axis| !force_m_s2[*axis].is_finite()) {
            Some(axis) => Err(BodyError::Force {
                axis,
                force_m_s2: force_m_s2[axis],
            }),
            None => Ok(Self { force_m_s2, ..self }),
        }
    }

    /// The body with a drag, which acts on its centre of mass and leaves its rotation free.
    pub fn with_drag(self, drag: Drag) -> Result<Self, BodyError> {
        let Drag {
            linear_per_s,
            quadratic_per_m,
        } = drag;
        if !(linear_per_s >= 0.0 && linear_per_s.is_finite()) {
            return Err(BodyError::LinearDrag { linear_per_s });
        }
        if !(quadratic_per_m >= 0.0 && quadratic_per_m.is_finite()) {
            return Err(BodyError::QuadraticDrag { quadratic_per_m });
        }
        Ok(Self { drag, ..self })
    }

    /// The body with a lift `ℓ`, which accelerates a ball that moves with `v` and turns with `ω` by `ℓ ω × v` (Magnus).
    ///
    /// A ball of radius `r` and mass `m` in air of density `ρ` whose coefficient of lift is `C r|ω|/|v|` has
    /// `ℓ = ρ C π r³/(2 m)`: 0.0056 `C` of a table-tennis ball, 0.0058 `C` of a football, with `C` about 1 (of a
    /// baseball: Sawicki, Hubbard and Stronge, "How to hit home runs", American Journal of Physics 71, 2003). It
    /// is negative where a smooth ball swerves the other way.
    ///
    /// Fails where moments differ: only a ball's angular velocity stays as it is in flight.
    pub fn with_lift(self, lift: f64) -> Result<Self, BodyError> {
        if !lift.is_finite() {
            return Err(BodyError::Lift { lift });
        }
        if lift != 0.0 && self.symmetry != Symmetry::Spherical {
            return Err(BodyError::LiftOfOther);
        }
        Ok(Self { lift, ..self })
    }

    /// The body with its mass and, beside it, its moments multiplied: a mass factor alone keeps the
    /// shape of the distribution. Force per mass, drag and lift stay.
    ///
    /// Fails where no distribution of mass has these moments.
    pub fn with_factors(self, mass: f64, moments: &Vector3<f64>) -> Result<Self, BodyError> {
        let moments_kg_m2 = self.moments_kg_m2.component_mul(moments) * mass;
        let body = Self::new(self.mass_kg * mass, moments_kg_m2)?;
        let body = body.with_force(self.force_m_s2)?.with_drag(self.drag)?;
        Ok(body.with_lift(self.lift)?.with_support(self.support))
    }

    /// The body where something supports it: it moves by that, without drag and lift.
    pub fn with_support(self, support: Option<Support>) -> Self {
        Self { support, ..self }
    }

    /// Mass \[kg\].
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Principal moments [kg m²] about body axes 0, 1, 2; equal ones are equal exactly.
    pub fn moments_kg_m2(&self) -> Vector3<f64> {
        self.moments_kg_m2
    }

    /// The principal moments per mass \[m²\]: squares of radii of gyration.
    pub fn gyration_m2(&self) -> Vector3<f64> {
        self.moments_kg_m2 / self.mass_kg
    }

    /// How many of the moments are equal.
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Constant force per mass `f` [m/s², world].
    pub fn force_m_s2(&self) -> Vector3<f64> {
        self.force_m_s2
    }

    /// Drag of the air.
    pub fn drag(&self) -> Drag {
        self.drag
    }

    /// Lift `ℓ` of the air on a ball that spins.
    pub fn lift(&self) -> f64 {
        self.lift
    }

    /// Whether the air does nothing to it.
    pub fn feels_no_air(&self) -> bool {
        self.drag.is_none() && self.lift == 0.0
    }

    /// Acceleration by the air at a velocity and a spin, `ℓ ω × v − k v − c|v| v` [m/s², world].
    pub fn air_m_s2(&self, velocity_m_s: &Vector3<f64>, spin_rad_s: &Vector3<f64>) -> Vector3<f64> {
        let dragged = self.drag.acceleration_m_s2(velocity_m_s);
        if self.lift == 0.0 {
            return dragged;
        }
        dragged + spin_rad_s.cross(velocity_m_s) * self.lift
    }

    /// Derivative of that by the velocity, `ℓ [ω]× − (k + c|v|) 1 − c v vᵀ/|v|` \[1/s\].
    pub fn air_by_velocity_per_s(
        &self,
        velocity_m_s: &Vector3<f64>,
        spin_rad_s: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let dragged = self.drag.acceleration_by_velocity_per_s(velocity_m_s);
        dragged + so3::hat(spin_rad_s) * self.lift
    }

    /// What supports it; `None` in flight.
    pub fn support(&self) -> Option<Support> {
        self.support
    }

    /// Constant part of the acceleration in flight, `p = g + f` [m/s², world].
    pub fn pull_m_s2(&self, gravity_m_s2: &Vector3<f64>) -> Vector3<f64> {
        gravity_m_s2 + self.force_m_s2
    }

    /// Acceleration in flight at a velocity and a spin, `g + f + ℓ ω × v − k v − c|v| v` [m/s², world].
    pub fn acceleration_m_s2(
        &self,
        gravity_m_s2: &Vector3<f64>,
        velocity_m_s: &Vector3<f64>,
        spin_rad_s: &Vector3<f64>,
    ) -> Vector3<f64> {
        let pull_m_s2 = self.pull_m_s2(gravity_m_s2);
        if self.is_ballistic() {
            return pull_m_s2;
        }
        pull_m_s2 + self.air_m_s2(velocity_m_s, spin_rad_s)
    }

    /// Whether its centre of mass flies on a parabola: without drag and lift, and nothing supports it.
    pub fn is_ballistic(&self) -> bool {
        self.feels_no_air() && self.support.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symmetry_is_told_to_rounding() {
        let symmetry = |moments: [f64; 3]| Body::new(1.0, moments.into()).unwrap().symmetry();
        assert_eq!(symmetry([1.0, 2.0, 2.5]), Symmetry::Asymmetric);
        assert_eq!(symmetry([1.0, 2.0, 2.0 + 1e-14]), Symmetry::Asymmetric);
        let last = 2.0 + f64::EPSILON;
        assert_eq!(symmetry([1.0, 2.0, last]), Symmetry::Axial { axis: 0 });
        assert_eq!(symmetry([2.0, last, 2.0]), Symmetry::Spherical);
        let body = Body::new(1.0, Vector3::new(1.0, 2.0, last)).unwrap();
        assert_eq!(body.moments_kg_m2().y, body.moments_kg_m2().z);
    }

    #[test]
    fn flat_bodies_may_miss_the_triangle_by_rounding() {
        assert!(Body::new(1.0, Vector3::new(1.0, 2.0, 3.0 + 1e-10)).is_ok());
        let refused = Body::new(1.0, Vector3::new(1.0, 2.0, 3.001));
        assert!(matches!(refused, Err(BodyError::Triangle(..))));
    }

    #[test]
    fn forces_are_finite_and_drag_does_not_push() {
        let body = Body::new(1.0, Vector3::repeat(1.0)).unwrap();
        assert!(body.is_ballistic() && body.force_m_s2() == Vector3::zeros());
        let refused = body.with_force(Vector3::new(0.0, f64::NAN, 1.0));
        assert!(matches!(refused, Err(BodyError::Force { axis: 1, .. })));
        for wrong in [-1e-3, f64::NAN, f64::INFINITY] {
            let linear = body.with_drag(Drag {
                linear_per_s: wrong,
                quadratic_per_m: 0.0,
            });
            assert!(matches!(linear, Err(BodyError::LinearDrag { .. })));
            let quadratic = body.with_drag(Drag {
                linear_per_s: 0.0,
                quadratic_per_m: wrong,
            });
            assert!(matches!(quadratic, Err(BodyError::QuadraticDrag { .. })));
        }
        let drag = Drag {
            linear_per_s: 0.0,
            quadratic_per_m: 0.13,
        };
        let ball = body.with_drag(drag).unwrap();
        assert!(!ball.is_ballistic() && ball.drag() == drag);
        let lifted = body.with_lift(-0.01).unwrap();
        assert!(!lifted.is_ballistic() && lifted.drag().is_none());
        let heavier = lifted.with_factors(2.0, &Vector3::repeat(1.5)).unwrap();
        assert_eq!(heavier.lift(), -0.01);
        let refused = body.with_lift(f64::NAN);
        assert!(matches!(refused, Err(BodyError::Lift { .. })));
        let rod = Body::new(1.0, Vector3::new(1.0, 2.0, 2.0)).unwrap();
        assert_eq!(rod.with_lift(0.01), Err(BodyError::LiftOfOther));
        assert!(rod.with_lift(0.0).is_ok());
        let pushed = ball.with_force(Vector3::x()).unwrap();
        assert_eq!(pushed.pull_m_s2(&-Vector3::x()), Vector3::zeros());
        assert_eq!(pushed.drag(), drag);
    }
}
