//! Readings on their way through cleaning.

use nalgebra::Vector3;

use crate::motion::{Covariance, Holds, OpenTime, PoseSample, SampleSource, Stamp, TakeEvent};

/// A reading as cleaning sorts, changes and leaves it out. What only a few readings come with stays in
/// the take, so that all others are moved without it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// See [`PoseSample::stamp`]; in an edited sketch, where it is on the joined time line.
    pub(super) stamp: Stamp,
    /// See [`PoseSample::position_m`].
    pub(super) position_m: Vector3<f64>,
    /// See [`PoseSample::quaternion_xyzw`].
    pub(super) quaternion_xyzw: [f64; 4],
    /// See [`PoseSample::holds`].
    pub(super) holds: Holds,
    /// Whether its true time is not known.
    pub(super) is_open: bool,
    /// The event of the take that delivered it.
    event: usize,
}

impl Reading {
    /// The reading that an event of the take delivered.
    pub(super) fn new(event: usize, sample: &PoseSample) -> Self {
        Self {
            stamp: sample.stamp,
            position_m: sample.position_m,
            quaternion_xyzw: sample.quaternion_xyzw,
            holds: sample.holds,
            is_open: sample.open.is_some(),
            event,
        }
    }

    /// The same at another time.
    pub(super) fn at(self, stamp: Stamp) -> Self {
        Self { stamp, ..self }
    }

    /// The covariance that came with it.
    pub(super) fn covariance<'e>(&self, events: &'e [TakeEvent]) -> Option<&'e Covariance> {
        self.delivered(events)?.covariance.as_ref()
    }

    /// How far its true time may be from its stamp, where that is not known.
    pub(super) fn open(&self, events: &[TakeEvent]) -> Option<OpenTime> {
        if !self.is_open {
            return None;
        }
        self.delivered(events)?.open
    }

    /// Whether somebody wrote it as a keyframe.
    pub(super) fn is_written(&self, events: &[TakeEvent]) -> bool {
        let delivered = self.delivered(events);
        delivered.is_some_and(|sample| sample.from == SampleSource::Keyframe)
    }

    fn delivered<'e>(&self, events: &'e [TakeEvent]) -> Option<&'e PoseSample> {
        match &events[self.event] {
            TakeEvent::Pose { sample, .. } => Some(sample),
            TakeEvent::Mark(_) => None,
        }
    }
}
