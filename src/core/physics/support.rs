//! What carries a body between two events: a plane on which it stays, a pivot about which it turns, or a body that it is stuck to.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// What carries a body, and by which law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Support {
    /// A plane.
    Plane(PlaneSupport),
    /// A place that the body does not leave.
    Pivot(Pivot),
    /// Another body, with which it flies as one.
    Stuck(StuckPart),
}

impl Support {
    /// What part of a whole a body is that is stuck to another.
    pub fn stuck(&self) -> Option<StuckPart> {
        match self {
            Self::Stuck(part) => Some(*part),
            Self::Plane(_) | Self::Pivot(_) => None,
        }
    }
}

/// A body that is a rigid part of a greater one, which flies freely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StuckPart {
    /// Centre of mass of the whole [m, body].
    pub centre_m: Vector3<f64>,
    /// The body's axes from the principal axes of the whole.
    pub axes: UnitQuaternion<f64>,
    /// Mass of the whole \[kg\].
    pub mass_kg: f64,
    /// Principal moments of the whole [kg m²].
    pub moments_kg_m2: Vector3<f64>,
}

/// A plane on which a body stays, with the law of friction between them.
///
/// The normal force is what keeps the centre of mass at its height: `g_n = −p·n` per mass, of the pull
/// `p = g + f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSupport {
    /// Unit normal `n` of the plane, away from it \[world\].
    pub normal: Vector3<f64>,
    /// How the body moves on it.
    pub sustained: Sustained,
    /// Coefficient of friction `μ` of what slides, or of rolling friction of what rolls; no other has one.
    pub friction: f64,
    /// What of the body is on it.
    pub touching: OnPlane,
}

/// What of a body is on a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OnPlane {
    /// A ball about its centre of mass.
    Ball {
        /// Its radius \[m\].
        radius_m: f64,
    },
    /// The side of a cylinder about its axis of symmetry.
    Side {
        /// Its radius \[m\].
        radius_m: f64,
        /// A unit vector along the axis \[body\].
        axis: Vector3<f64>,
    },
    /// A flat face.
    Face {
        /// A point of it [m, body].
        point_m: Vector3<f64>,
        /// Its unit normal, out of the body \[body\].
        normal: Vector3<f64>,
    },
}

impl OnPlane {
    /// The radius of what rolls \[m\].
    pub fn radius_m(&self) -> Option<f64> {
        match self {
            Self::Ball { radius_m } | Self::Side { radius_m, .. } => Some(*radius_m),
            Self::Face { .. } => None,
        }
    }
}

/// How a body moves on what supports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sustained {
    /// It slides (Coulomb).
    Slide,
    /// It rolls without slip.
    Roll,
    /// It lies still.
    Rest,
}

impl Sustained {
    /// All, in the order in which friction brings them about.
    pub const ALL: [Self; 3] = [Self::Slide, Self::Roll, Self::Rest];

    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Slide => "slide",
            Self::Roll => "roll",
            Self::Rest => "rest",
        }
    }
}

/// A point of a body that stays where it is, and how the body turns about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pivot {
    /// The point [m, body].
    pub at_m: Vector3<f64>,
    /// About what it turns.
    pub axes: PivotAxes,
    /// Moment against each rate of turning [N m s].
    pub damping_n_m_s: f64,
}

impl Pivot {
    /// Inertia per mass about it, `I/m + |r|² − r rᵀ` \[m²\], of a body with these principal moments per mass \[m²\], whose
    /// centre of mass is at `r` from it.
    pub fn inertia_m2(&self, gyration_m2: &Vector3<f64>) -> Matrix3<f64> {
        let r = -self.at_m;
        Matrix3::from_diagonal(gyration_m2) + Matrix3::identity() * r.norm_squared()
            - r * r.transpose()
    }

    /// What it makes of the motion of such a body that it catches.
    pub fn catch(&self, gyration_m2: &Vector3<f64>) -> Caught {
        Caught {
            lever_m: -self.at_m,
            inertia_m2: *gyration_m2,
            mobility_per_m2: self.axes.mobility(&self.inertia_m2(gyration_m2)),
        }
    }
}

/// What the impulse of a pivot makes of the motion about it.
#[derive(Clone, Copy, Debug)]
pub struct Caught {
    /// The centre of mass from the pivot [m, body].
    pub lever_m: Vector3<f64>,
    /// Moments of inertia per mass about the centre of mass \[m²\].
    pub inertia_m2: Vector3<f64>,
    /// Angular velocity of an angular momentum about the pivot per mass \[1/m²\].
    pub mobility_per_m2: Matrix3<f64>,
}

/// About what a body at a pivot turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PivotAxes {
    /// Any axis, as at a ball joint.
    All,
    /// An axis that stays, a unit vector in body axes, as at a pin.
    One(Vector3<f64>),
    /// None: it is held still.
    None,
}

impl PivotAxes {
    /// The part of an angular velocity that it allows [body axes].
    pub fn allowed(&self) -> Matrix3<f64> {
        match self {
            Self::All => Matrix3::identity(),
            Self::One(axis) => axis * axis.transpose(),
            Self::None => Matrix3::zeros(),
        }
    }

    /// What a moment about the pivot makes of a body whose inertia about that is this one: its angular acceleration,
    /// without what the pivot itself bears.
    ///
    /// # Panics
    /// Where the inertia is not positive definite.
    pub fn mobility(&self, inertia: &Matrix3<f64>) -> Matrix3<f64> {
        match self {
            Self::All => inertia.try_inverse().expect("an inertia"),
            Self::One(axis) => self.allowed() / axis.dot(&(inertia * axis)),
            Self::None => Matrix3::zeros(),
        }
    }
}
