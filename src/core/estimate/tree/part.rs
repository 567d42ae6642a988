//! How much of a problem counts while a motion is looked for.

use super::problem::RATE_SD_RAD_S;

/// What of a problem counts.
#[derive(Clone, Debug)]
pub struct Part {
    /// Samples and goals later than this do not \[s\].
    pub until_s: f64,
    /// Standard deviation of the rates at the start [rad/s].
    pub rate_sd_rad_s: f64,
    /// Of an unknown tempo the standard deviation of the first log-pace from its guess, if any.
    pub log_pace_sd: Option<f64>,
}

impl Part {
    /// All.
    pub fn whole() -> Self {
        Self {
            until_s: f64::INFINITY,
            rate_sd_rad_s: RATE_SD_RAD_S,
            log_pace_sd: None,
        }
    }
}
