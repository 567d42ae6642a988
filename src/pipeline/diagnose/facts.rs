//! What is known of a take before remedies are tried.

use super::fall::Fall;
use super::motion::Flight;
use crate::motion::{Scene, TakeEvent, Timing};

/// What is known of a take.
pub(super) struct Facts<'a> {
    pub(super) scene: &'a Scene,
    pub(super) events: &'a [TakeEvent],
    /// Ways in which the flights may fall.
    pub(super) falls: Vec<Fall>,
    /// The flights with physical times, if they are known.
    pub(super) flights: Vec<Flight>,
}

impl Facts<'_> {
    /// An acceleration of the flights over gravity; `None` where there is none to compare.
    pub(super) fn pull(&self, fall: &Fall) -> Option<f64> {
        let gravity_m_s2 = self.scene.gravity_m_s2.norm();
        let pull_m_s2 = fall.acceleration_m_s2.norm();
        (gravity_m_s2 > 0.0 && pull_m_s2 > 0.0).then(|| pull_m_s2 / gravity_m_s2)
    }

    /// Whether stamps are said to be physical times.
    pub(super) fn is_timed(&self) -> bool {
        !matches!(self.scene.timing, Timing::Unknown { .. })
    }
}
