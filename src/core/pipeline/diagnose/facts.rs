//! What is known of a take before remedies are tried.

use super::fall::SeenFall;
use super::motion::TriedFlight;
use crate::motion::{SampleSource, Scene, TakeEvent, Timing, TrackIndex};

/// What is known of a take.
pub(super) struct Facts<'a> {
    pub(super) scene: &'a Scene,
    pub(super) events: &'a [TakeEvent],
    /// Ways in which the flights may fall.
    pub(super) falls: Vec<SeenFall>,
    /// The flights with physical times, if they are known.
    pub(super) flights: Vec<TriedFlight>,
    /// The flights at their stamps, whatever these mean.
    pub(super) seen: Vec<TriedFlight>,
}

impl Facts<'_> {
    /// An acceleration of the flights over gravity; `None` where there is none to compare.
    pub(super) fn pull(&self, fall: &SeenFall) -> Option<f64> {
        let gravity_m_s2 = self.scene.gravity_m_s2.norm();
        let pull_m_s2 = fall.acceleration_m_s2.norm();
        (gravity_m_s2 > 0.0 && pull_m_s2 > 0.0).then(|| pull_m_s2 / gravity_m_s2)
    }

    /// Whether a tracker says something of a track; keyframes of it are of the body itself.
    pub(super) fn is_tracked(&self, of: TrackIndex) -> bool {
        !self.scene.sees_apart(of)
            && self.events.iter().any(|event| match event {
                TakeEvent::Pose { track, sample, .. } => {
                    *track == of && sample.from == SampleSource::Tracker
                }
                TakeEvent::Mark(_) => false,
            })
    }

    /// Who says how the bodies move: somebody who wrote it down only where no tracker does.
    pub(super) fn source(&self) -> SampleSource {
        match self.scene.tracks.keys().any(|track| self.is_tracked(track)) {
            true => SampleSource::Tracker,
            false => SampleSource::Keyframe,
        }
    }

    /// Whether stamps are said to be physical times.
    pub(super) fn is_timed(&self) -> bool {
        !matches!(self.scene.timing, Timing::Unknown { .. })
    }
}
