//! What takes share.

use nalgebra::DVector;

use crate::motion::{FreeParameter, TakeShare};

/// A quantity that takes share, in its SI unit.
#[derive(Clone, Debug, PartialEq)]
pub struct JointParameter {
    /// Its name in scenes.
    pub name: String,
    /// What the scene says of it: the mean of its prior.
    pub initial: f64,
    /// Least value.
    pub lower: f64,
    /// Greatest value.
    pub upper: f64,
    /// Standard deviation of its prior, which counts once for all takes.
    pub prior_sd: Option<f64>,
    /// A typical change of it.
    pub length: f64,
    /// Whether each take has its own value, drawn about a mean.
    pub is_drawn: bool,
}

impl JointParameter {
    /// A free parameter of a scene.
    pub fn new(free: &FreeParameter, is_drawn: bool) -> Self {
        Self {
            name: free.name.clone(),
            initial: free.initial,
            lower: free.lower,
            upper: free.upper,
            prior_sd: free.prior_sd,
            length: free.length(),
            is_drawn,
        }
    }

    /// Other values to begin from, nearer to its least value.
    pub fn lesser(&self) -> Vec<f64> {
        let shares = [0.5, 0.25, 0.125].into_iter();
        let values = shares.map(|share| self.lower + share * (self.initial - self.lower));
        values
            .filter(|value| value.is_finite() && *value < self.initial)
            .collect()
    }

    /// Whether a take by itself, where it is, tells nothing of it.
    pub fn is_untold_by(&self, share: &TakeShare, at: usize) -> bool {
        share.curvature[(at, at)] * self.length * self.length < 1.0
    }

    /// Information of its prior, per squared length.
    pub(super) fn prior(&self) -> f64 {
        self.prior_sd.map_or(0.0, |sd| (self.length / sd).powi(2))
    }

    /// Its bounds in lengths.
    pub(super) fn bounds(&self) -> [f64; 2] {
        [self.lower, self.upper].map(|bound| bound / self.length)
    }

    /// A value in lengths, off the bounds: from a bound no step need lead away.
    pub(super) fn inside(&self, scaled: f64) -> f64 {
        const OFF: f64 = 0.01;
        let [lower, upper] = self.bounds();
        let off = OFF * (upper - lower).min(1.0);
        scaled.max(lower + off).min(upper - off)
    }
}

/// Median size of a standard normal number.
pub(super) const NORMAL_MEDIAN: f64 = 0.674_49;

/// Lengths of parameters.
pub(super) fn lengths(parameters: &[JointParameter]) -> DVector<f64> {
    let lengths = parameters.iter().map(|of| of.length);
    DVector::from_iterator(parameters.len(), lengths)
}
