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

/// Difference of Schwarz's criterion below which two things are not told apart: odds of twenty (Kass
/// and Raftery, Journal of the American Statistical Association 90, 1995).
const TOLD: f64 = 6.0;

impl Suspect {
    /// Whether another thing explains the performance as well, so that it does not tell which of the
    /// two is wrong.
    pub fn is_rivalled_by(&self, other: &Self) -> bool {
        let shares = |(quantity, _): &(Quantity, f64)| {
            let mut values = self.values.iter();
            values.any(|(own, _)| own == quantity)
        };
        self.gain - other.gain < TOLD && !other.values.iter().any(shares)
    }
}
