//! How residuals are weighed.

/// Units of residuals: the objective (paper eq. 1) is the sum of squared residuals in these units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Position \[m\].
    pub position_m: f64,
    /// Orientation \[rad\].
    pub orientation_rad: f64,
}

/// How samples are weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighing {
    /// By the scene's weights.
    Scene,
    /// By weights of the track's own.
    Own(Weights),
    /// By the covariances in its messages, where these have one; by the scene's weights otherwise.
    Messages,
}
