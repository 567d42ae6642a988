//! What may be wrong in a scene whose motion does not fit.

use super::scene::Quantity;

/// Quantities that a scene keeps fixed and that would explain some of a misfit if they were free.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// The quantities, with their likely values: those at which the motion fits best.
    pub values: Vec<(Quantity, f64)>,
    /// The share of the misfit that goes with them, 0 to 1: of what the residuals are beyond the
    /// samples' white noise.
    pub explains: f64,
    /// Decrease of Schwarz's criterion (BIC): positive where the gain outweighs the number of quantities.
    pub gain: f64,
    /// Probability that a right value scores as high (Rao's test): under white noise, or a hand's
    /// wander where the flights show one.
    pub probability: f64,
}
