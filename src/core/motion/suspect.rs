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
    /// Probability that one of all right values scores as high (Rao's test, Bonferroni): under white
    /// noise and such a wander of the hand as the flights may have.
    pub probability: f64,
}

/// Difference of the shares that gravity and a clock's rate explain below which they are not told
/// apart, to a motion they are the same, whatever the criterion says of how marks were made; and of those that a
/// surface's height and the duration of a contact explain, for what touches for long also goes deeper than the surface.
const ALIKE: f64 = 0.2;
/// Difference of Schwarz's criterion below which two things are not told apart: odds of twenty (Kass
/// and Raftery, Journal of the American Statistical Association 90, 1995).
const TOLD: f64 = 6.0;

impl Suspect {
    /// Whether another thing explains the performance as well, so that it does not tell which of the
    /// two is wrong.
    pub fn is_rivalled_by(&self, other: &Self) -> bool {
        let is_rate = |of: &Self| matches!(of.quantity(), Some(Quantity::ClockRate { .. }));
        let is_gravity = |of: &Self| matches!(of.quantity(), Some(Quantity::Gravity { .. }));
        let is_tempo = is_rate(self) && is_gravity(other) || is_gravity(self) && is_rate(other);
        let is_height = |of: &Self| matches!(of.quantity(), Some(Quantity::SurfaceHeight { .. }));
        let lasts = |of: &Self| matches!(of.quantity(), Some(Quantity::ContactDuration { .. }));
        let is_late = is_height(self) && lasts(other) || lasts(self) && is_height(other);
        let is_alike = (is_tempo || is_late) && (self.explains - other.explains).abs() < ALIKE;
        (self.gain - other.gain < TOLD || is_alike) && !self.is_same_as(other)
    }

    /// Whether both are of one thing: a vector and a component of it, or both laws of a drag.
    pub fn is_same_as(&self, other: &Self) -> bool {
        let (Some(a), Some(b)) = (self.quantity(), other.quantity()) else {
            return false;
        };
        match (a, b) {
            (Quantity::LinearDrag { link: a }, Quantity::QuadraticDrag { link: b })
            | (Quantity::QuadraticDrag { link: a }, Quantity::LinearDrag { link: b }) => a == b,
            _ => a.is_of_one_thing_with(b),
        }
    }

    /// Its first quantity; all are of one thing.
    pub fn quantity(&self) -> Option<Quantity> {
        self.values.first().map(|(quantity, _)| *quantity)
    }
}
