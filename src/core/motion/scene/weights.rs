//! How residuals are weighed.

/// Units of residuals: the objective (paper eq. 1) is the sum of squared residuals in these units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Position \[m\].
    pub position_m: f64,
    /// Orientation \[rad\].
    pub orientation_rad: f64,
}

/// Whether a hand acted what trackers saw: a hand wanders, by much more than a tracker's noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Performer {
    /// Somebody acted the motion, whose errors are a process in time: they change slowly.
    Hand,
    /// Nobody did: the motion itself was measured, and residuals are a tracker's errors.
    Nobody,
    /// The scene does not say; the flights' own residuals may show it.
    Unsaid,
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
