//! What keeps a body on a plane after an impact or from the start, and how it moves there.

use nalgebra::Vector3;

/// A plane on which a body stays, with the law of friction between them.
///
/// The normal force is what keeps the centre of mass at its height: `g_n = −p·n` per mass, of the pull
/// `p = g + f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Unit normal `n` of the plane, away from it \[world\].
    pub normal: Vector3<f64>,
    /// How the body moves on it.
    pub sustained: Sustained,
    /// Coefficient of friction `μ` of what slides, or of rolling friction of what rolls; no other has one.
    pub friction: f64,
    /// Radius of a ball \[m\]; `None` of what lies flat.
    pub radius_m: Option<f64>,
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
