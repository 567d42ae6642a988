//! Free parameters of the estimation (paper §6).

use super::quantity::Quantity;

/// A free parameter `u`: a quantity that the estimation may change, within bounds (paper §6).
#[derive(Clone, Debug, PartialEq)]
pub struct FreeParameter {
    /// Unique name, as in the scene file: `gravity.z`, `bounce.restitution`.
    pub name: String,
    /// The quantity.
    pub quantity: Quantity,
    /// Value to start from, in the quantity's unit.
    pub initial: f64,
    /// Least value allowed (may be −∞).
    pub lower: f64,
    /// Greatest value allowed (may be +∞).
    pub upper: f64,
    /// Standard deviation of a prior about `initial`, if there is one.
    pub prior_sd: Option<f64>,
}

impl FreeParameter {
    /// A typical change of it: its prior's standard deviation or the width of its bounds, whichever
    /// is less; where it has neither, a typical change of its quantity.
    pub fn length(&self) -> f64 {
        let width = self.upper - self.lower;
        let width = if width > 0.0 && width.is_finite() {
            width
        } else {
            self.quantity.typical()
        };
        self.prior_sd.unwrap_or(width).min(width)
    }
}

/// Two parameters within a circle about zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Indices into `Scene::parameters`.
    pub parameters: [usize; 2],
    /// Radius of the circle, in the parameters' unit.
    pub limit: f64,
}
